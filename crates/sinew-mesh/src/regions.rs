//! Regions of a mesh by sets and labels of its cells: what they hold, the facets between them, and parts cut out.

use crate::mesh::are_labels;
use crate::selection::others;
use crate::{Facet, Mesh, Refusal, boundary_facets, remove_unused_nodes};
use sinew_num::ascending;
use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap, HashSet};

/// Begins the names of the facet sets behind which a region was cut away, and names all of them together.
const CUT: &str = "cut:";

/// Cells of a region, and facets of others behind which it was cut away.
type Region = (HashSet<usize>, HashSet<Facet>);

impl<const N: usize> Mesh<N> {
    /// The cells of a named set, or of a label: `region:3` are those at which the cell field `region` of whole numbers is 3. The field
    /// may be left out, `3`, where it is called `region` or is the only one. `None` where the mesh has neither, or no cell has the label.
    pub fn cells_of(&self, name: &str) -> Option<Vec<usize>> {
        if let Some(cells) = self.cell_sets.get(name) {
            return Some(cells.clone());
        }
        let name = self.full_name(name);
        let (field, label) = name.rsplit_once(':')?;
        let (labels, label) = (self.cell_fields.get(field)?.to_labels()?, label.parse().ok()?);
        let cells: Vec<usize> = (0..labels.len()).filter(|&cell| labels[cell] == label).collect();
        (!cells.is_empty()).then_some(cells)
    }

    /// Names that [`Mesh::cells_of`] knows, but for those of fields that number the cells.
    pub fn names_of_cells(&self) -> Vec<String> {
        let labelled = self.labels().flat_map(|(name, labels)| {
            let all: BTreeSet<i64> = labels.iter().copied().collect();
            let few = are_labels(all.len(), labels.len());
            all.into_iter().filter(move |_| few).map(move |label| format!("{name}:{label}"))
        });
        self.cell_sets.keys().cloned().chain(labelled).collect()
    }

    /// Cell fields of whole numbers.
    fn labels(&self) -> impl Iterator<Item = (&str, Cow<'_, [i64]>)> {
        self.cell_fields
            .iter()
            .filter_map(|(name, field)| Some((name.as_str(), field.to_labels()?)))
    }

    /// A name of cells, with the field of a bare label.
    fn full_name(&self, name: &str) -> String {
        let fields: Vec<&str> = self.labels().map(|(field, _)| field).collect();
        let field = fields.iter().find(|field| **field == "region" || fields.len() == 1);
        let field = field.filter(|_| name.parse::<i64>().is_ok());
        field.map_or(name.into(), |field| format!("{field}:{name}"))
    }

    /// Cuts all cells away but those of these sets and labels ([`Mesh::cells_of`]). Sets and fields keep the remaining cells; a facet between
    /// both sides becomes one of the cell that stays. The facet set `cut:` holds the facets behind which cells were, others such as
    /// `cut:region:3` those behind which cells of that name were, for [`Selection::between`](crate::Selection::between).
    ///
    /// # Errors
    /// Cells that the mesh does not have, no names, a mesh that violates [`Mesh::check`].
    pub fn keep<S: AsRef<str>>(&mut self, names: &[S]) -> Result<(), Refusal> {
        self.check()?;
        let mut kept = BTreeSet::new();
        for name in names {
            let cells = self.cells_of(name.as_ref());
            kept.extend(cells.ok_or_else(|| self.unknown_cells(name.as_ref()))?);
        }
        if kept.is_empty() {
            return Err(Refusal("no cells would stay; name some, or leave it out".into()));
        }
        let cells = self.cell_list();
        let going = cells.by_key(|facet| !kept.contains(&facet.cell));
        let staying = cells.facets().filter(|facet| kept.contains(&facet.cell));
        let behind = |facet: Facet| Some((*going.get(&cells.key(facet))?, facet));
        let cut: HashMap<Facet, Facet> = staying.filter_map(behind).collect();

        let mut sets = std::mem::take(&mut self.facet_sets);
        sets.values_mut().flatten().for_each(|facet| *facet = *cut.get(facet).unwrap_or(facet));
        sets.entry(CUT.into()).or_default().extend(cut.values());
        for name in self.names_of_cells() {
            let cells = self.cells_of(&name).unwrap_or_default();
            let gone = cut.iter().filter(|(gone, _)| cells.binary_search(&gone.cell).is_ok());
            sets.entry(format!("{CUT}{name}")).or_default().extend(gone.map(|(_, facet)| *facet));
        }
        let kept: Vec<usize> = kept.into_iter().collect();
        let place = |cell: usize| kept.binary_search(&cell).ok();
        for set in sets.values_mut() {
            let placed = |facet: &Facet| Some(Facet { cell: place(facet.cell)?, ..*facet });
            *set = ascending(set.iter().filter_map(placed));
        }
        for set in self.cell_sets.values_mut() {
            *set = set.iter().filter_map(|&cell| place(cell)).collect();
        }
        self.cells = kept.iter().map(|&cell| self.cells[cell]).collect();
        self.cell_fields.values_mut().for_each(|field| *field = field.select(&kept));
        remove_unused_nodes(self);
        sets.retain(|_, set| !set.is_empty());
        self.facet_sets = sets;
        self.cell_sets.retain(|_, set| !set.is_empty());
        self.node_sets.retain(|_, set| !set.is_empty());
        Ok(())
    }

    fn unknown_cells(&self, name: &str) -> Refusal {
        let known = others(&self.names_of_cells());
        Refusal(format!("the mesh has no set of cells `{name}`{known}"))
    }

    /// See [`Selection::between`](crate::Selection::between).
    pub(crate) fn facets_between(&self, pair: &[String; 2]) -> Result<Vec<Facet>, Refusal> {
        let (one, other) = (self.region(&pair[0])?, self.region(&pair[1])?);
        let of = |a: &Region, b: &Region, facet: &Facet| {
            a.0.contains(&facet.cell) && !b.0.contains(&facet.cell) && !a.1.contains(facet)
        };
        let cells = self.cell_list();
        let ours = cells.by_key(|facet| of(&one, &other, facet));
        let theirs = cells.facets().filter(|facet| of(&other, &one, facet));
        let shared = theirs.filter_map(|facet| ours.get(&cells.key(facet)).copied());
        let cut = [(&one, &other), (&other, &one)].into_iter();
        let cut = cut.flat_map(|(a, b)| b.1.iter().copied().filter(|facet| of(a, b, facet)));
        Ok(shared.chain(cut).collect())
    }

    fn region(&self, name: &str) -> Result<Region, Refusal> {
        let cells = self.cells_of(name);
        let behind = match self.facet_sets.get(&format!("{CUT}{}", self.full_name(name))) {
            Some(facets) => facets.clone(),
            None if cells.is_some() => Vec::new(),
            // The space around the mesh.
            None if name == "outside" => {
                let cut: HashSet<&Facet> = self.facet_sets.get(CUT).into_iter().flatten().collect();
                boundary_facets(self).into_iter().filter(|facet| !cut.contains(facet)).collect()
            }
            None => return Err(self.unknown_cells(name)),
        };
        Ok((cells.into_iter().flatten().collect(), behind.into_iter().collect()))
    }
}
