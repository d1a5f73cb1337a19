//! Input files of Abaqus and CalculiX: nodes, elements, their sets and surfaces (Abaqus Keywords Reference Guide; G. Dhondt,
//! CalculiX CrunchiX User's Manual). Materials, steps and all other keywords are passed over.

use super::convert::counted;
use super::cursor::{Cursor, Fault, Result, number};
use super::grid::{MixedMesh, indices};
use super::inp_elements::{Kind, Surface, kind};
use super::inp_lines::{Block, Name, Scope, Sets, blocks, fields, real};
use crate::Refusal;
use crate::topology::FacetKey;
use nalgebra::{Rotation3, Unit, Vector3};
use std::cell::{Cell, OnceCell};
use std::collections::{BTreeMap, BTreeSet, HashMap};

const WHOLE: &str =
    "write the file with all its nodes and elements in it, as Abaqus/CAE or PrePoMax do";
const SHARED: &str =
    "mesh the parts with shared nodes, or take the keyword out if it is not of this body";
/// Keywords that make or move nodes and elements, or bring them from elsewhere; those that join parts of a body, or take some away.
const REFUSED: [(&[&str], &str); 3] = [
    (&["INCLUDE", "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM"], WHOLE),
    (&["SYMMETRIC MODEL GENERATION", "IMPORT", "PARAMETER"], WHOLE),
    (&["TIE", "MPC", "EQUATION", "EMBEDDED ELEMENT", "MODEL CHANGE"], SHARED),
];

/// Reads the nodes, elements, sets and surfaces of a file.
pub(crate) fn parse(bytes: &[u8]) -> Result<MixedMesh, Fault> {
    let (mut cursor, place) = (Cursor::new(bytes), Cell::new(0));
    let mut blocks = blocks(&mut cursor, &place)?;
    let first = blocks.iter().find(|block| block.keyword == "ELEMENT");
    let cells_at = cursor.place(first.map_or(0, |block| block.at));
    let grid = set_scopes(&mut blocks).and_then(|()| read(&blocks, bytes.len()));
    let grid = grid.map_err(|problem| (cursor.place(place.get()), problem))?;
    Ok(MixedMesh { cells_at, ..grid })
}

/// Blocks read so far.
#[derive(Default)]
pub(super) struct Model {
    pub grid: MixedMesh,
    pub nodes: Sets,
    pub elements: Sets,
    /// Number of each cell of the grid.
    pub kinds: Vec<Kind>,
    pub surfaces: BTreeMap<String, Surface>,
    /// Number of elements that share each face, once a surface asks.
    pub owners: OnceCell<HashMap<FacetKey, usize>>,
}

fn read(blocks: &[Block<'_>], bytes: usize) -> Result<MixedMesh> {
    let (nodes, elements) = (Sets::new(bytes), Sets::new(bytes));
    let mut model = Model { nodes, elements, ..Model::default() };
    // Keywords may come in any order, but sets only name what stands further up.
    let each = |keyword: &'static str| blocks.iter().filter(move |block| block.keyword == keyword);
    each("NODE").try_for_each(|block| model.read_nodes(block))?;
    each("ELEMENT").try_for_each(|block| model.read_elements(block))?;
    // gmsh writes the surfaces of a solid as elements of plane stress.
    if model.kinds.iter().any(|kind| kind.is_solid()) {
        model.kinds.iter_mut().for_each(|kind| kind.plane = false);
    }
    each("INSTANCE").try_for_each(|block| model.place(block))?;
    each("ELSET").chain(each("NSET")).try_for_each(|block| model.read_set(block))?;
    each("SURFACE").try_for_each(|block| model.read_surface(block))?;
    if let Some(last) = blocks.last() {
        last.place.set(last.at);
    }
    Refusal::require_part(!model.grid.points.is_empty(), "*NODE with its nodes")?;
    model.finish()
}

/// Gives each block its level. There may be one part, and one instance of it.
fn set_scopes(blocks: &mut [Block<'_>]) -> Result<()> {
    let has_assembly = blocks.iter().any(|block| block.keyword == "ASSEMBLY");
    let [mut parts, mut instances] = [0, 0];
    let mut in_part = false;
    for block in blocks {
        block.place.set(block.at);
        let keyword = block.keyword.as_str();
        // A change of contact pairs takes no cell away.
        let contact = block.name("TYPE").is_some_and(|kind| kind.key.starts_with("CONTACT"));
        let refused = REFUSED.iter().find(|(keywords, _)| keywords.contains(&keyword));
        if let Some((_, advice)) = refused.filter(|_| !(keyword == "MODEL CHANGE" && contact)) {
            return Err(Refusal::unsupported("the keyword", format!("*{keyword}"), advice));
        }
        match keyword {
            "PART" => (parts, in_part) = (parts + 1, true),
            "END PART" | "END INSTANCE" => in_part = false,
            // A mesh may stand in the instance in place of the part.
            "INSTANCE" => (instances, in_part) = (instances + 1, true),
            _ => {}
        }
        if parts > 1 || instances > 1 {
            let (what, value) = ("an assembly with a second", format!("*{}", block.keyword));
            let advice = "write the body alone: a flat file, or one part with one instance";
            return Err(Refusal::unsupported(what, value, advice));
        }
        if has_assembly && !in_part {
            block.scope = Scope::Assembly;
        }
    }
    Ok(())
}

impl Model {
    fn read_nodes(&mut self, block: &Block<'_>) -> Result<()> {
        block.allow(&["NSET", "SYSTEM"])?;
        let system = block.option("SYSTEM").unwrap_or(b"R");
        if !system.eq_ignore_ascii_case(b"R") {
            let (what, value) = ("the coordinate system of nodes", String::from_utf8_lossy(system));
            let advice = "write the nodes in Cartesian coordinates";
            return Err(Refusal::unsupported(what, value, advice));
        }
        if block.scope == Scope::Assembly {
            // Reference points.
            return self.leave_out(block, "NSET", "node");
        }
        let first = self.grid.points.len();
        block.lines().try_for_each(|line| self.node(line))?;
        self.nodes.add_named(block, "NSET", first..self.grid.points.len())
    }

    /// Leaves out nodes or elements of the assembly itself; the set of them that their keyword makes is empty.
    fn leave_out(&mut self, block: &Block<'_>, set: &str, what: &str) -> Result<()> {
        let sets = if set == "NSET" { &mut self.nodes } else { &mut self.elements };
        if block.len() > 0 {
            self.grid.left_out.push(format!("{} of the assembly", counted(block.len(), what)));
            sets.assembly_has_own = true;
        }
        sets.add_named(block, set, [])
    }

    /// A node's number and its coordinates; those that are left out are zero.
    fn node(&mut self, line: &[u8]) -> Result<()> {
        let mut words = fields(line);
        let id = number(words.next().unwrap_or_default(), "the number of a node")?;
        let mut point = [0.0; 3];
        for (x, word) in point.iter_mut().zip(words) {
            *x = real(word)?;
        }
        let before = self.nodes.ids.insert(id, self.grid.points.len());
        Refusal::unless_used(before, "the number of a node that is not used yet", id)?;
        self.grid.points.push(point);
        Ok(())
    }

    fn read_elements(&mut self, block: &Block<'_>) -> Result<()> {
        block.allow(&["TYPE", "ELSET"])?;
        let name = block.required("TYPE", "TYPE=… of *ELEMENT")?.shown;
        if block.scope == Scope::Assembly {
            return self.leave_out(block, "ELSET", "element");
        }
        let kind = kind(&name)?;
        let first = self.grid.types.len();
        let mut record: Vec<i64> = Vec::new();
        for (row, line) in (1..).zip(block.lines()) {
            for word in fields(line).filter(|word| !word.is_empty()) {
                record.push(number(word, "the number of an element and those of its nodes")?);
            }
            // An element may take several lines.
            if record.len() > kind.nodes {
                self.element(&name, kind, &record)?;
                record.clear();
            }
            let is_whole = row < block.len() || record.is_empty();
            Refusal::require_part(is_whole, "the other nodes of the last element")?;
        }
        self.elements.add_named(block, "ELSET", first..self.grid.types.len())
    }

    /// An element's number and its nodes, which stand in the order of VTK.
    fn element(&mut self, name: &str, kind: Kind, record: &[i64]) -> Result<()> {
        let (id, nodes) = (record[0], &record[1..]);
        let what = format_args!("nodes of element {id}, a {name}");
        Refusal::require_count(what, kind.nodes, nodes.len())?;
        let nodes =
            indices(nodes, "the number of a node that the file has", |id| self.nodes.ids.get(id))?;
        let before = self.elements.ids.insert(id, self.grid.types.len());
        Refusal::unless_used(before, "the number of an element that is not used yet", id)?;
        self.grid.push(kind.vtk_type, &nodes);
        self.kinds.push(kind);
        Ok(())
    }

    /// Moves and turns the nodes as the instance says: a translation, then two points of an axis and an angle \[degrees\].
    fn place(&mut self, block: &Block<'_>) -> Result<()> {
        (self.nodes.instance, self.elements.instance) = (block.name("NAME"), block.name("NAME"));
        for (row, line) in block.lines().enumerate() {
            let numbers = fields(line).map(real).collect::<Result<Vec<f64>, _>>()?;
            match (row, numbers.as_slice()) {
                (0, &[x, y, z]) => self.move_points(|point| point + Vector3::new(x, y, z)),
                (1, &[ax, ay, az, bx, by, bz, degrees]) => {
                    let [a, b] = [Vector3::new(ax, ay, az), Vector3::new(bx, by, bz)];
                    let equal =
                        || Refusal::expected("an axis of the instance's turn", "two equal points");
                    let axis = Unit::try_new(b - a, f64::MIN_POSITIVE).ok_or_else(equal)?;
                    let turn = Rotation3::from_axis_angle(&axis, degrees.to_radians());
                    self.move_points(|point| a + turn * (point - a));
                }
                _ => {
                    let expected =
                        "the instance's translation (3 numbers), then its turn (7 numbers)";
                    return Err(Refusal::expected(expected, line));
                }
            }
        }
        Ok(())
    }

    fn move_points(&mut self, place: impl Fn(Vector3<f64>) -> Vector3<f64>) {
        self.grid.points.iter_mut().for_each(|x| *x = place(Vector3::from(*x)).into());
    }

    /// A set of nodes or of elements.
    fn read_set(&mut self, block: &Block<'_>) -> Result<()> {
        let of_nodes = block.keyword == "NSET";
        block.allow(&["NSET", "ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"])?;
        let expected = "NSET=… or ELSET=… with the name of the set";
        let name = block.required(&block.keyword, expected)?;
        let is_other =
            |other: &Name| self.nodes.instance.as_ref().is_none_or(|name| name.key != other.key);
        if let Some(other) = block.name("INSTANCE").filter(is_other) {
            return Err(Refusal::expected("the name of the file's instance", other.shown));
        }
        if let (true, Some(elset)) = (of_nodes, block.option("ELSET")) {
            let cells = self.elements.find(elset)?;
            let nodes = cells.iter().flat_map(|&cell| self.grid.nodes(cell));
            return self.nodes.add(block.scope, &name, nodes.collect::<BTreeSet<_>>());
        }
        let sets = if of_nodes { &mut self.nodes } else { &mut self.elements };
        sets.add_lines(&name, block)
    }
}
