//! Input files of Abaqus and CalculiX: nodes, elements, their sets and surfaces (Abaqus Keywords Reference Guide; G. Dhondt,
//! CalculiX CrunchiX User's Manual). Materials, steps and all other keywords are passed over.

use super::cursor::{Cursor, Fault, number};
use super::grid::UnstructuredGrid;
use super::inp_elements::{Kind, kind};
use super::inp_lines::{Block, Name, Wrong, blocks, fields, real};
use super::inp_sets::{Scope, Sets};
use super::inp_surfaces::Surfaces;
use crate::Problem;
use nalgebra::{Rotation3, Unit, Vector3};
use std::collections::BTreeSet;

/// Keywords that make or move nodes and elements, or bring them from elsewhere.
const UNREAD: [&str; 11] = [
    "INCLUDE",
    "NGEN",
    "NFILL",
    "NCOPY",
    "NMAP",
    "ELGEN",
    "ELCOPY",
    "SYSTEM",
    "SYMMETRIC MODEL GENERATION",
    "IMPORT",
    "PARAMETER",
];

/// Whether a file begins like one: with a keyword or a comment.
pub(crate) fn looks_like_it(content: &[u8]) -> bool {
    matches!(content, [b'*', next, ..] if *next == b'*' || next.is_ascii_alphabetic())
}

/// Reads the nodes, elements, sets and surfaces of a file.
pub(crate) fn parse(bytes: &[u8]) -> Result<UnstructuredGrid, Fault> {
    let mut cursor = Cursor::new(bytes);
    let blocks = blocks(&mut cursor)?;
    let first = blocks.iter().find(|block| block.keyword == "ELEMENT");
    let cells_at = cursor.place(first.map_or(0, |block| block.at));
    let grid = read(&blocks, bytes.len()).map_err(|(at, problem)| (cursor.place(at), problem))?;
    Ok(UnstructuredGrid { cells_at, ..grid })
}

/// Blocks read so far.
pub(super) struct Model {
    pub grid: UnstructuredGrid,
    pub nodes: Sets,
    pub elements: Sets,
    /// Number of each cell of the grid.
    pub kinds: Vec<Kind>,
    /// The instance of the part, in files with an assembly.
    pub instance: Option<Name>,
}

fn read(blocks: &[Block<'_>], bytes: usize) -> Result<UnstructuredGrid, Wrong> {
    let scoped = scopes(blocks)?;
    let (nodes, elements) = (Sets::new(bytes), Sets::new(bytes));
    let grid = UnstructuredGrid::default();
    let mut model = Model { grid, nodes, elements, kinds: Vec::new(), instance: None };
    // Keywords may come in any order, but sets only name what stands further up.
    let each =
        |keyword: &'static str| scoped.iter().filter(move |(_, block)| block.keyword == keyword);
    for (scope, block) in each("NODE") {
        model.read_nodes(*scope, block)?;
    }
    for (scope, block) in each("ELEMENT") {
        model.read_elements(*scope, block)?;
    }
    // gmsh writes the surfaces of a solid as elements of plane stress.
    if model.kinds.iter().any(|kind| kind.is_solid()) {
        model.kinds.iter_mut().for_each(|kind| kind.plane = false);
    }
    for (_, block) in each("INSTANCE") {
        model.place(block)?;
    }
    for (scope, block) in each("ELSET").chain(each("NSET")) {
        model.read_set(*scope, block)?;
    }
    let mut surfaces = Surfaces::default();
    for (_, block) in each("SURFACE") {
        surfaces.read(&model, block)?;
    }
    let end = blocks.last().map_or(0, |block| block.at);
    if model.grid.points.is_empty() {
        return Err((end, Problem::Missing { expected: "*NODE with its nodes" }));
    }
    surfaces.finish(model).map_err(|problem| (end, problem))
}

/// Level of each block. There may be one part, and one instance of it.
fn scopes<'b, 'a>(blocks: &'b [Block<'a>]) -> Result<Vec<(Scope, &'b Block<'a>)>, Wrong> {
    let has = |keyword: &str| blocks.iter().any(|block| block.keyword == keyword);
    let has_assembly = has("ASSEMBLY");
    let [mut parts, mut instances] = [0, 0];
    let mut in_part = false;
    let mut scoped = Vec::with_capacity(blocks.len());
    for block in blocks {
        match block.keyword.as_str() {
            "PART" => (parts, in_part) = (parts + 1, true),
            "END PART" | "END INSTANCE" => in_part = false,
            // A mesh may stand in the instance in place of the part.
            "INSTANCE" => (instances, in_part) = (instances + 1, true),
            unread if UNREAD.contains(&unread) => {
                let (what, value) = ("the keyword", format!("*{unread}"));
                let advice = "write the file with all its nodes and elements in it, as Abaqus/CAE or PrePoMax do";
                return Err((block.at, Problem::unsupported(what, value, advice)));
            }
            _ => {}
        }
        if parts > 1 || instances > 1 {
            let (what, value) = ("an assembly with a second", format!("*{}", block.keyword));
            let advice = "write the body alone: a flat file, or one part with one instance";
            return Err((block.at, Problem::unsupported(what, value, advice)));
        }
        let scope = if in_part || !has_assembly { Scope::Part } else { Scope::Assembly };
        scoped.push((scope, block));
    }
    Ok(scoped)
}

impl Model {
    fn read_nodes(&mut self, scope: Scope, block: &Block<'_>) -> Result<(), Wrong> {
        let head = |problem| (block.at, problem);
        block.allow(&["NSET", "SYSTEM"])?;
        let system = block.option("SYSTEM").unwrap_or(b"R");
        if !system.eq_ignore_ascii_case(b"R") {
            let (what, value) = ("the coordinate system of nodes", String::from_utf8_lossy(system));
            let advice = "write the nodes in Cartesian coordinates";
            return Err(head(Problem::unsupported(what, value, advice)));
        }
        if scope == Scope::Assembly {
            // Reference points.
            return self.leave_out(block, "NSET", "node");
        }
        let first = self.grid.points.len();
        for &(at, line) in &block.lines {
            self.node(line).map_err(|problem| (at, problem))?;
        }
        let added = first..self.grid.points.len();
        block.name("NSET").map_or(Ok(()), |name| self.nodes.add(scope, &name, added)).map_err(head)
    }

    /// Leaves out nodes or elements of the assembly itself; the set of them that their keyword makes is empty.
    fn leave_out(&mut self, block: &Block<'_>, set: &str, what: &str) -> Result<(), Wrong> {
        let (count, s) = (block.lines.len(), if block.lines.len() == 1 { "" } else { "s" });
        let sets = if set == "NSET" { &mut self.nodes } else { &mut self.elements };
        if count > 0 {
            self.grid.left_out.push(format!("{count} {what}{s} of the assembly"));
            sets.assembly_has_own = true;
        }
        let added = block.name(set).map_or(Ok(()), |name| sets.add(Scope::Assembly, &name, []));
        added.map_err(|problem| (block.at, problem))
    }

    /// A node's number and its coordinates; those that are left out are zero.
    fn node(&mut self, line: &[u8]) -> Result<(), Problem> {
        let mut words = fields(line);
        let id = number(words.next().unwrap_or_default(), "the number of a node")?;
        let mut point = [0.0; 3];
        for (x, word) in point.iter_mut().zip(words) {
            *x = real(word)?;
        }
        let before = self.nodes.ids.insert(id, self.grid.points.len());
        Problem::unless_used(before, "the number of a node that is not used yet", id)?;
        self.grid.points.push(point);
        Ok(())
    }

    fn read_elements(&mut self, scope: Scope, block: &Block<'_>) -> Result<(), Wrong> {
        let head = |problem| (block.at, problem);
        block.allow(&["TYPE", "ELSET"])?;
        let name = block.required("TYPE", "TYPE=… of *ELEMENT")?.shown;
        if scope == Scope::Assembly {
            return self.leave_out(block, "ELSET", "element");
        }
        let kind = kind(&name).map_err(head)?;
        let first = self.grid.types.len();
        let mut record: Vec<i64> = Vec::new();
        for &(at, line) in &block.lines {
            for word in fields(line).filter(|word| !word.is_empty()) {
                let expected = "the number of an element and those of its nodes";
                record.push(number(word, expected).map_err(|problem| (at, problem))?);
            }
            // An element may take several lines.
            if record.len() > kind.nodes {
                self.element(&name, kind, &record).map_err(|problem| (at, problem))?;
                record.clear();
            }
        }
        if let (Some(_), Some(&(at, _))) = (record.first(), block.lines.last()) {
            return Err((at, Problem::Missing { expected: "the other nodes of the last element" }));
        }
        let added = first..self.grid.types.len();
        let name = block.name("ELSET");
        name.map_or(Ok(()), |name| self.elements.add(scope, &name, added)).map_err(head)
    }

    /// An element's number and its nodes, which stand in the order of VTK.
    fn element(&mut self, name: &str, kind: Kind, record: &[i64]) -> Result<(), Problem> {
        let (id, nodes) = (record[0], &record[1..]);
        let what = || format!("nodes of element {id}, a {name}");
        Problem::require_count(what, kind.nodes, nodes.len())?;
        let index = |node: &i64| match self.nodes.ids.get(node) {
            Some(&index) => Ok(index as i64),
            None => {
                Err(Problem::expected("the number of a node that the file has", node.to_string()))
            }
        };
        let nodes = nodes.iter().map(index).collect::<Result<Vec<_>, _>>()?;
        let before = self.elements.ids.insert(id, self.grid.types.len());
        Problem::unless_used(before, "the number of an element that is not used yet", id)?;
        self.grid.push(kind.vtk_type, &nodes);
        self.kinds.push(kind);
        Ok(())
    }

    /// Moves and turns the nodes as the instance says: a translation, then two points of an axis and an angle \[degrees\].
    fn place(&mut self, block: &Block<'_>) -> Result<(), Wrong> {
        self.instance = block.name("NAME");
        for (row, &(at, line)) in block.lines.iter().enumerate() {
            let numbers = fields(line).map(real).collect::<Result<Vec<f64>, _>>();
            let numbers = numbers.map_err(|problem| (at, problem))?;
            match (row, numbers.as_slice()) {
                (0, &[x, y, z]) => self.move_points(|point| point + Vector3::new(x, y, z)),
                (1, &[ax, ay, az, bx, by, bz, degrees]) => {
                    let [a, b] = [Vector3::new(ax, ay, az), Vector3::new(bx, by, bz)];
                    let axis = Unit::try_new(b - a, f64::MIN_POSITIVE);
                    let found = "two equal points";
                    let axis = axis.ok_or_else(|| {
                        (at, Problem::expected("an axis of the instance's turn", found))
                    })?;
                    let turn = Rotation3::from_axis_angle(&axis, degrees.to_radians());
                    self.move_points(|point| a + turn * (point - a));
                }
                _ => {
                    let expected =
                        "the instance's translation (3 numbers), then its turn (7 numbers)";
                    return Err((at, Problem::expected(expected, line)));
                }
            }
        }
        Ok(())
    }

    fn move_points(&mut self, place: impl Fn(Vector3<f64>) -> Vector3<f64>) {
        self.grid.points.iter_mut().for_each(|x| *x = place(Vector3::from(*x)).into());
    }

    /// A set of nodes or of elements.
    fn read_set(&mut self, scope: Scope, block: &Block<'_>) -> Result<(), Wrong> {
        let head = |problem| (block.at, problem);
        let of_nodes = block.keyword == "NSET";
        block.allow(&["NSET", "ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"])?;
        let name = match of_nodes {
            true => block.required("NSET", "NSET=… with the name of the set")?,
            false => block.required("ELSET", "ELSET=… with the name of the set")?,
        };
        let is_other =
            |other: &Name| self.instance.as_ref().is_none_or(|name| name.key != other.key);
        if let Some(other) = block.name("INSTANCE").filter(is_other) {
            return Err(head(Problem::expected("the name of the file's instance", other.shown)));
        }
        if let (true, Some(elset)) = (of_nodes, block.option("ELSET")) {
            let cells = self.elements.find(elset, self.instance.as_ref()).map_err(head)?;
            let nodes =
                cells.iter().flat_map(|&cell| self.grid.cell(cell)).map(|&node| node as usize);
            return self.nodes.add(scope, &name, nodes.collect::<BTreeSet<_>>()).map_err(head);
        }
        let sets = if of_nodes { &mut self.nodes } else { &mut self.elements };
        sets.add_lines((scope, &name), block, self.instance.as_ref())
    }
}
