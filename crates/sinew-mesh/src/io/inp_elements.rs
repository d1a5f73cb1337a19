//! Elements of Abaqus and CalculiX: how many nodes they have, how their faces are numbered, and the surfaces of these.

use super::cursor::Result;
use super::grid::{CELL_TYPES, MixedMesh, cell_type};
use super::inp::Model;
use super::inp_lines::{Block, fields};
use crate::topology::{FacetKey, sorted_key};
use crate::{Element, Refusal};
use sinew_num::ascending;
use std::collections::{BTreeMap, HashMap};

/// A type of element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Kind {
    /// VTK's number of its shape.
    pub vtk_type: u8,
    /// Nodes of one element.
    pub nodes: usize,
    /// Whether its sides are edges of a plane body, named S1, S2 and so on.
    pub plane: bool,
}

/// Families of elements: what their names begin with, before the number of nodes.
const SOLIDS: [&str; 3] = ["C3D", "DC3D", "SC"];
const PLANES: [&str; 5] = ["CPS", "CPE", "CPEG", "DC2D", "AC2D"];
const SHELLS: [&str; 6] = ["S", "M3D", "SFM3D", "R3D", "DS", "STRI"];
const LINES: [&str; 5] = ["T3D", "B", "R2D", "T2D", "CONN3D"];

/// Elements without a shape, as points and lines.
const OTHERS: [(&[&str], u8, usize); 2] = [
    (&["MASS", "ROTARYI", "HEATCAP", "SPRING1", "DASHPOT1", "DCOUP3D"], 1, 1),
    (&["SPRINGA", "SPRING2", "DASHPOTA", "DASHPOT2", "GAPUNI", "ITSUNI"], 3, 2),
];

/// Meaning of a type's name, such as `C3D10H`: family, number of nodes, letters of the variant.
pub(super) fn kind(name: &str) -> Result<Kind> {
    let advice = "use C3D4, C3D10 or C3D8 (with any letters behind), or S3, M3D3 and CPS3 for surfaces and plane bodies";
    let unknown = || Refusal::unsupported("the element type", name, advice);
    let upper = name.to_uppercase();
    // Masses, springs and connectors are no cells.
    if let Some((.., vtk_type, nodes)) = OTHERS.iter().find(|(names, ..)| names.contains(&&*upper))
    {
        return Ok(Kind { vtk_type: *vtk_type, nodes: *nodes, plane: false });
    }
    // STRI65 has six nodes with five degrees of freedom each.
    let upper = upper.strip_suffix("65").map_or(upper.clone(), |start| format!("{start}6"));
    let known = [(&SOLIDS[..], 3), (&PLANES[..], 2), (&SHELLS[..], 2), (&LINES[..], 1)];
    let found = known.iter().find_map(|&(families, dimension)| {
        let rest = families.iter().find_map(|family| {
            upper.strip_prefix(family).filter(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
        })?;
        Some((families == PLANES, dimension, rest))
    });
    let (plane, dimension, rest) = found.ok_or_else(unknown)?;
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    let nodes = match (dimension, rest[..digits].parse::<usize>().map_err(|_| unknown())?) {
        // Beams have their nodes in the second digit: B31, B32.
        (1, 2 | 21 | 31 | 33) => 2,
        (1, 3 | 22 | 32) => 3,
        (2, nodes @ (3 | 4 | 6 | 8)) | (3, nodes @ (4..=6 | 8 | 10 | 15 | 20)) => nodes,
        _ => return Err(unknown()),
    };
    // The last, because pixels and voxels stand before quadrilaterals and hexahedra.
    let shape = CELL_TYPES.iter().rfind(|shape| (shape.2, shape.3) == (dimension, Some(nodes)));
    let vtk_type = shape.ok_or_else(unknown)?.0;
    Ok(Kind { vtk_type, nodes, plane })
}

impl Kind {
    pub(super) fn is_solid(self) -> bool {
        cell_type(self.vtk_type).1 == 3
    }

    /// Whether it is a shell, a membrane or a beam: part of the surface of a solid, where there is one.
    fn lies_in_surface(self) -> bool {
        !self.plane && !self.is_solid()
    }

    /// Our element of this shape, where there is one.
    fn element(self) -> Option<&'static Element> {
        let known = [3, 4, 6, 8, 10].map(Element::with_nodes);
        known.into_iter().find(|element| element.vtk_type == self.vtk_type)
    }

    /// Our number of a face such as `S1`, or of an edge `E1` of a surface.
    fn side(self, face: &str) -> Option<usize> {
        let number: usize = face.get(1..)?.parse().ok()?;
        let order: &[usize] = match (self.vtk_type, face.get(..1)?) {
            // 1-2-3, 1-4-2, 2-4-3, 3-4-1.
            (10 | 24, "S") => &[3, 2, 0, 1],
            // 1-2-3-4, 5-8-7-6, 1-5-6-2, 2-6-7-3, 3-7-8-4, 4-8-5-1.
            (12, "S") => &[4, 5, 2, 1, 3, 0],
            // 1-2, 2-3, 3-1.
            (5 | 22, "S") if self.plane => &[2, 0, 1],
            (5 | 22, "E") => &[2, 0, 1],
            _ => return None,
        };
        order.get(number.checked_sub(1)?).copied()
    }
}

/// A surface: faces, elements or nodes.
#[derive(Default)]
pub(super) struct Surface {
    /// Elements with the numbers of their faces.
    sides: Vec<(usize, usize)>,
    /// Elements that lie in the surface, such as shells.
    cells: Vec<usize>,
    nodes: Vec<usize>,
}

/// Options that do not change which faces belong to a surface.
const OPTIONS: [&str; 8] =
    ["NAME", "TYPE", "INTERNAL", "DEFINITION", "MAX RATIO", "NO OFFSET", "NO THICK", "SCALE THICK"];

impl Model {
    pub(super) fn read_surface(&mut self, block: &Block<'_>) -> Result<()> {
        block.allow(&OPTIONS)?;
        let name = block.required("NAME", "NAME=… of *SURFACE")?;
        let of_nodes = match block.name("TYPE").map_or("ELEMENT".into(), |kind| kind.key).as_str() {
            "ELEMENT" => false,
            "NODE" => true,
            other => {
                let advice = "define the surface by TYPE=ELEMENT or TYPE=NODE";
                return Err(Refusal::unsupported("the type of surface", other, advice));
            }
        };
        let mut surface = Surface::default();
        for line in block.lines() {
            let mut words = fields(line);
            let who = words.next().unwrap_or_default();
            if of_nodes {
                surface.nodes.extend(self.nodes.find(who)?);
                continue;
            }
            let face = String::from_utf8_lossy(words.next().unwrap_or_default()).to_uppercase();
            for &cell in self.elements.find(who)? {
                surface.add(self, cell, &face)?;
            }
        }
        let before = self.surfaces.insert(name.shown.clone(), surface);
        let expected = "the name of a surface that is not used yet";
        Refusal::unless_used(before, expected, name.shown)
    }

    /// The grid with all sets and surfaces.
    pub(super) fn finish(self) -> Result<MixedMesh> {
        let Model { mut grid, nodes, elements, kinds, surfaces, .. } = self;
        grid.node_sets = nodes.named()?;
        grid.groups = elements.named()?;
        for (name, Surface { sides, mut cells, nodes }) in surfaces {
            if !nodes.is_empty() {
                let nodes = ascending(nodes);
                give_way(&mut grid.node_sets, &name, &nodes, "nset");
                grid.node_sets.insert(name, nodes);
                continue;
            }
            cells.sort_unstable();
            // An element set of the same name keeps it, unless its shells would become facets of another set.
            let flat = |cell: &usize| kinds[*cell].lies_in_surface();
            let group = grid.groups.get(&name);
            if !cells.is_empty() || group.is_some_and(|group| group.iter().any(flat)) {
                give_way(&mut grid.groups, &name, &cells, "elset");
            }
            if !cells.is_empty() {
                grid.groups.insert(name.clone(), cells);
            }
            if !sides.is_empty() {
                grid.sides.insert(name, sides);
            }
        }
        Ok(grid)
    }
}

impl Surface {
    /// Adds a face of an element, or all its faces that no other shares where none is named.
    fn add(&mut self, model: &Model, cell: usize, face: &str) -> Result<()> {
        let kind = model.kinds[cell];
        if let Some(side) = kind.side(face) {
            self.sides.push((cell, side));
            return Ok(());
        }
        match (kind.element(), face) {
            (_, "" | "SPOS" | "SNEG") if kind.lies_in_surface() => self.cells.push(cell),
            (Some(element), "") => {
                let owners = model.owners.get_or_init(|| owners(model));
                let keys = keys(&model.grid, cell, element).enumerate();
                let free = keys.filter(|(_, key)| owners.get(key) == Some(&1));
                self.sides.extend(free.map(|(side, _)| (cell, side)));
            }
            _ => {
                let expected = "a face that the element has, such as S1";
                return Err(Refusal::expected(expected, face));
            }
        }
        Ok(())
    }
}

/// The corners of the faces of an element.
fn keys(grid: &MixedMesh, cell: usize, element: &Element) -> impl Iterator<Item = FacetKey> {
    let nodes: Vec<usize> = grid.nodes(cell).collect();
    let corners = element.facets.iter().map(|facet| &facet[..element.facet_corners]);
    corners.map(move |locals| sorted_key(locals.iter().map(|&local| nodes[local])))
}

fn owners(model: &Model) -> HashMap<FacetKey, usize> {
    let mut owners = HashMap::new();
    for (cell, kind) in model.kinds.iter().enumerate() {
        let element = kind.element().filter(|_| !kind.lies_in_surface());
        for key in element.into_iter().flat_map(|element| keys(&model.grid, cell, element)) {
            *owners.entry(key).or_insert(0) += 1;
        }
    }
    owners
}

/// Prefixes the name of a set with its kind if a surface of the same name differs.
fn give_way(sets: &mut BTreeMap<String, Vec<usize>>, name: &str, surface: &[usize], what: &str) {
    if let Some(set) = sets.remove(name) {
        let name = if set == surface { name.to_string() } else { format!("{what}:{name}") };
        sets.insert(name, set);
    }
}
