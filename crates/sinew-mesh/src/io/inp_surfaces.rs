//! Surfaces of Abaqus and CalculiX files: faces of elements, or nodes.

use super::cursor::Result;
use super::grid::MixedMesh;
use super::inp::Model;
use super::inp_lines::{Block, fields};
use crate::topology::{FacetKey, sorted_key};
use crate::{Element, Problem};
use sinew_num::ascending;
use std::collections::{BTreeMap, HashMap};

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
                return Err(Problem::unsupported("the type of surface", other, advice));
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
        Problem::unless_used(before.is_some(), expected, name.shown)
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
                return Err(Problem::expected(expected, face));
            }
        }
        Ok(())
    }
}

/// The corners of the faces of an element.
fn keys(grid: &MixedMesh, cell: usize, element: &Element) -> impl Iterator<Item = FacetKey> {
    let nodes = grid.cell(cell);
    let corners = element.facets.iter().map(|facet| &facet[..element.facet_corners]);
    corners.map(|locals| sorted_key(locals.iter().map(|&local| nodes[local] as usize)))
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
