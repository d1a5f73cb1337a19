//! Sets of nodes and elements in Abaqus and CalculiX files.

use super::cursor::{Result, number};
use super::inp_lines::{Block, Name, fields};
use crate::Problem;
use sinew_num::ascending;
use std::collections::BTreeMap;

/// Whether a name belongs to the part or to the assembly; a flat file is all part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Scope {
    Part,
    Assembly,
}

/// Most members of all sets together, per byte of the file: twenty sets of all nodes need less than one.
const MEMBERS_PER_BYTE: usize = 16;

/// Nodes or elements by their number in the file, and the sets of them.
#[derive(Default)]
pub(super) struct Sets {
    /// Index by number.
    pub ids: BTreeMap<i64, usize>,
    /// Whether the assembly has others of its own, which are left out.
    pub assembly_has_own: bool,
    /// The instance of the part, in files with an assembly.
    pub instance: Option<Name>,
    sets: BTreeMap<(Scope, String), (String, Vec<usize>)>,
    /// Members that may still be added.
    room: usize,
}

impl Sets {
    /// Without sets, for a file of so many bytes.
    pub(super) fn new(bytes: usize) -> Self {
        Self { room: bytes.saturating_mul(MEMBERS_PER_BYTE), ..Self::default() }
    }

    /// Adds members to the set that an option of a block names, if it does.
    pub(super) fn add_named(
        &mut self,
        block: &Block<'_>,
        option: &str,
        members: impl IntoIterator<Item = usize>,
    ) -> Result<()> {
        block.name(option).map_or(Ok(()), |name| self.add(block.scope, &name, members))
    }

    /// Adds members to a set, which is made if it does not exist.
    pub(super) fn add(
        &mut self,
        scope: Scope,
        name: &Name,
        members: impl IntoIterator<Item = usize>,
    ) -> Result<()> {
        let entry = self.sets.entry((scope, name.key.clone()));
        let (_, set) = entry.or_insert_with(|| (name.shown.clone(), Vec::new()));
        let before = set.len();
        set.extend(members.into_iter().take(self.room.saturating_add(1)));
        let added = set.len() - before;
        if added > self.room {
            let advice = "all sets together have too many members for a file of this size";
            return Err(Problem::unsupported("the set", &name.shown, advice));
        }
        self.room -= added;
        Ok(())
    }

    /// Adds the numbers, ranges and sets that the lines of a block list. Numbers of the assembly's own nodes or elements are left
    /// out.
    pub(super) fn add_lines(&mut self, name: &Name, block: &Block<'_>) -> Result<()> {
        let of_assembly = block.scope == Scope::Assembly && block.name("INSTANCE").is_none();
        let numbers = !(of_assembly && self.assembly_has_own);
        let is_range = block.option("GENERATE").is_some();
        for line in block.lines().filter(|_| numbers || !is_range) {
            if is_range {
                self.add(block.scope, name, self.range(line)?)?;
                continue;
            }
            for word in fields(line).filter(|word| !word.is_empty()) {
                if numbers || number::<i64>(word, "").is_err() {
                    let members = self.find(word)?.to_vec();
                    self.add(block.scope, name, members)?;
                }
            }
        }
        // A set without members is one all the same.
        self.add(block.scope, name, [])
    }

    /// First, last and step of a range; numbers in it that nothing has are left out.
    fn range(&self, line: &[u8]) -> Result<Vec<usize>> {
        let mut bounds = [0, 0, 1];
        let words = fields(line).filter(|word| !word.is_empty());
        for (bound, word) in bounds.iter_mut().zip(words) {
            *bound = number(word, "the first, the last and the step of a range")?;
        }
        let [first, last, step] = bounds;
        if first > last || step < 1 {
            let found = format!("{first}, {last}, {step}");
            return Err(Problem::expected("a range that ascends by a positive step", found));
        }
        let inside = self.ids.range(first..=last);
        let on_step = |id: i64| id.abs_diff(first) % step.unsigned_abs() == 0;
        Ok(inside.filter(|(id, _)| on_step(**id)).map(|(_, &index)| index).collect())
    }

    /// Members, in any order, of a word: the number of a node or element or the name of a set, optionally after the
    /// name of the part's instance.
    pub(super) fn find(&self, word: &[u8]) -> Result<&[usize]> {
        let bare = self.instance.as_ref().and_then(|name| without_instance(word, name));
        let (scopes, bare) = match bare {
            Some(bare) => (&[Scope::Part][..], bare),
            None => (&[Scope::Assembly, Scope::Part][..], word),
        };
        if let Ok(id) = number::<i64>(bare, "") {
            let expected = "the number of a node or element that the file has";
            let found = self.ids.get(&id).ok_or_else(|| Problem::expected(expected, word))?;
            return Ok(std::slice::from_ref(found));
        }
        let key = Name::new(bare).key;
        let sets = scopes.iter().find_map(|&scope| self.sets.get(&(scope, key.clone())));
        let expected = "a number, or the name of a set that stands further up";
        Ok(&sets.ok_or_else(|| Problem::expected(expected, word))?.1)
    }

    /// All sets by the names that they get in the mesh. A set of the part whose name the assembly has too is named with its
    /// instance, as the file itself does.
    pub(super) fn named(self) -> Result<BTreeMap<String, Vec<usize>>> {
        let mut named = BTreeMap::new();
        let of_assembly = self.sets.keys().filter(|key| key.0 == Scope::Assembly);
        let of_assembly: Vec<String> = of_assembly.map(|key| key.1.clone()).collect();
        for ((scope, key), (mut shown, members)) in self.sets {
            let is_twice = of_assembly.contains(&key);
            if let (Scope::Part, true, Some(instance)) = (scope, is_twice, &self.instance) {
                shown = format!("{}.{shown}", instance.shown);
            }
            if shown.is_empty() || named.insert(shown.clone(), ascending(members)).is_some() {
                let expected = "names of sets that differ in more than capitals";
                return Err(Problem::expected(expected, shown));
            }
        }
        Ok(named)
    }
}

/// A word without the instance's name and a dot.
pub(super) fn without_instance<'a>(word: &'a [u8], instance: &Name) -> Option<&'a [u8]> {
    let end = instance.shown.len();
    let (head, rest) = (word.get(..end)?, word.get(end..)?.strip_prefix(b".")?);
    (Name::new(head).key == instance.key).then_some(rest)
}
