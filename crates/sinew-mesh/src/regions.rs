//! Regions of a mesh by sets and labels of its cells: what they hold, the facets between them, and parts cut out.

use crate::field::are_labels;
use crate::topology::{FacetKey, facet_key, facets};
use crate::{Defect, Facet, Mesh, SelectionError, boundary_facets, remove_unused_nodes};
use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap, HashSet};

/// Begins the names of the facet sets behind which a region was cut away.
const CUT: &str = "cut:";

/// Stands for the space around a mesh.
const OUTSIDE: &str = "outside";

/// Cells of a region, and facets of others behind which it was cut away.
struct Region {
    inside: Vec<bool>,
    behind: HashSet<Facet>,
}

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
    fn labels(&self) -> impl Iterator<Item = (&String, Cow<'_, [i64]>)> {
        self.cell_fields.iter().filter_map(|(name, field)| Some((name, field.to_labels()?)))
    }

    /// A name of cells, with the field of a bare label.
    fn full_name(&self, name: &str) -> String {
        let fields: Vec<&String> = self.labels().map(|(field, _)| field).collect();
        let field = fields.iter().find(|field| *field == &"region" || fields.len() == 1);
        match (field, name.parse::<i64>()) {
            (Some(field), Ok(label)) if !self.cell_sets.contains_key(name) => {
                format!("{field}:{label}")
            }
            _ => name.to_string(),
        }
    }

    fn unknown_cells(&self, name: &str) -> SelectionError {
        SelectionError::UnknownCells { name: name.into(), known: self.names_of_cells() }
    }

    /// Cuts all cells away but those of these sets and labels ([`Mesh::cells_of`]). Sets and fields keep what is left; a facet between
    /// both sides becomes one of the cell that stays. Facet sets such as `cut:region:3` hold the facets behind which cells of that name
    /// were, for [`Selection::between`](crate::Selection::between).
    ///
    /// # Errors
    /// [`SelectionError::UnknownCells`], no names, a mesh that violates [`Mesh::check`].
    pub fn keep<S: AsRef<str>>(&mut self, names: &[S]) -> Result<(), SelectionError> {
        self.check()?;
        let mut stays = vec![false; self.cells.len()];
        for name in names.iter().map(AsRef::as_ref) {
            let cells = self.cells_of(name).ok_or_else(|| self.unknown_cells(name))?;
            cells.into_iter().for_each(|cell| stays[cell] = true);
        }
        let kept: Vec<usize> = (0..stays.len()).filter(|&cell| stays[cell]).collect();
        if kept.is_empty() {
            return Err(Defect::NoCells { wanted: Self::ELEMENT.plural }.into());
        }
        let (staying, going): (Vec<Facet>, Vec<Facet>) =
            facets(self).partition(|facet| stays[facet.cell]);
        let behind: HashMap<FacetKey, Facet> =
            going.into_iter().map(|facet| (facet_key(self, facet), facet)).collect();
        let twin = |facet: Facet| Some((*behind.get(&facet_key(self, facet))?, facet));
        let cut: HashMap<Facet, Facet> = staying.into_iter().filter_map(twin).collect();

        let mut sets = std::mem::take(&mut self.facet_sets);
        for set in sets.values_mut() {
            set.iter_mut().for_each(|facet| *facet = *cut.get(facet).unwrap_or(facet));
        }
        let mut add = |name: &str, facet: Facet| {
            sets.entry(format!("{CUT}{name}")).or_default().push(facet);
        };
        for (gone, &facet) in &cut {
            let of = |set: &[usize]| set.binary_search(&gone.cell).is_ok();
            let named = self.cell_sets.iter().filter(|(_, set)| of(set));
            named.for_each(|(name, _)| add(name, facet));
        }
        for (name, labels) in self.labels() {
            let own: BTreeSet<i64> = cut.keys().map(|gone| labels[gone.cell]).collect();
            for (gone, &facet) in cut.iter().filter(|_| are_labels(own.len(), cut.len())) {
                add(&format!("{name}:{}", labels[gone.cell]), facet);
            }
        }

        let mut place = vec![0; stays.len()];
        kept.iter().enumerate().for_each(|(new, &old)| place[old] = new);
        for set in sets.values_mut() {
            set.retain(|facet| stays[facet.cell]);
            set.iter_mut().for_each(|facet| facet.cell = place[facet.cell]);
            set.sort_unstable();
            set.dedup();
        }
        for set in self.cell_sets.values_mut() {
            set.retain(|&cell| stays[cell]);
            set.iter_mut().for_each(|cell| *cell = place[*cell]);
        }
        self.cells = kept.iter().map(|&cell| self.cells[cell]).collect();
        self.cell_fields.values_mut().for_each(|field| *field = field.select(&kept));
        self.facet_sets = sets;
        remove_unused_nodes(self);
        self.facet_sets.retain(|_, set| !set.is_empty());
        self.cell_sets.retain(|_, set| !set.is_empty());
        self.node_sets.retain(|_, set| !set.is_empty());
        Ok(())
    }

    /// See [`Selection::between`](crate::Selection::between).
    pub(crate) fn facets_between(
        &self,
        [one, other]: &[String; 2],
    ) -> Result<Vec<Facet>, SelectionError> {
        let (one, other) = (self.region(one)?, self.region(other)?);
        let of = |a: &Region, b: &Region, facet: &Facet| {
            a.inside[facet.cell] && !b.inside[facet.cell] && !a.behind.contains(facet)
        };
        let ours = facets(self).filter(|facet| of(&one, &other, facet));
        let ours: HashMap<FacetKey, Facet> =
            ours.map(|facet| (facet_key(self, facet), facet)).collect();
        let theirs = facets(self).filter(|facet| of(&other, &one, facet));
        let shared = theirs.filter_map(|facet| ours.get(&facet_key(self, facet)).copied());
        let beyond = other.behind.iter().filter(|facet| of(&one, &other, facet));
        let before = one.behind.iter().filter(|facet| of(&other, &one, facet));
        Ok(shared.chain(beyond.copied()).chain(before.copied()).collect())
    }

    fn region(&self, name: &str) -> Result<Region, SelectionError> {
        let behind = self.facet_sets.get(&format!("{CUT}{}", self.full_name(name)));
        let cells = self.cells_of(name);
        let behind: HashSet<Facet> = match (behind, &cells) {
            (Some(facets), _) => facets.iter().copied().collect(),
            (None, Some(_)) => HashSet::new(),
            (None, None) if name == OUTSIDE => {
                let cuts = self.facet_sets.iter().filter(|(name, _)| name.starts_with(CUT));
                let cut: HashSet<&Facet> = cuts.flat_map(|(_, facets)| facets).collect();
                boundary_facets(self).into_iter().filter(|facet| !cut.contains(facet)).collect()
            }
            (None, None) => return Err(self.unknown_cells(name)),
        };
        let mut inside = vec![false; self.cells.len()];
        cells.into_iter().flatten().for_each(|cell| inside[cell] = true);
        Ok(Region { inside, behind })
    }
}
