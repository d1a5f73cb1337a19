//! Lines of Abaqus and CalculiX files: keywords with their options, the data behind them, and sets of nodes and elements.

use super::cursor::{Cursor, Fault, Result, number, text_of};
use crate::Refusal;
use sinew_num::ascending;
use std::cell::Cell;
use std::collections::BTreeMap;

/// Most members of all sets together, per byte of the file: twenty sets of all nodes need less than one.
const MEMBERS_PER_BYTE: usize = 16;

/// Whether a name belongs to the part or to the assembly; a flat file is all part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Scope {
    Part,
    Assembly,
}

/// A keyword with its options and lines of data.
pub(super) struct Block<'a> {
    /// Byte at which the keyword's line begins.
    pub at: usize,
    /// Byte of the line that is being read, which errors point to; one for all blocks.
    pub place: &'a Cell<usize>,
    /// Level of its names.
    pub scope: Scope,
    /// Keyword in capitals, without its asterisk.
    pub keyword: String,
    /// Options in capitals, each with its value.
    options: Vec<(String, &'a [u8])>,
    /// Lines of data, each with the byte at which it begins.
    lines: Vec<(usize, &'a [u8])>,
}

/// A name as it is compared and as it is shown: capitals matter in quotation marks only.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Name {
    pub key: String,
    pub shown: String,
}

impl Name {
    pub(super) fn new(word: &[u8]) -> Self {
        let quoted = word.strip_prefix(b"\"").and_then(|word| word.strip_suffix(b"\""));
        let shown = text_of(quoted.unwrap_or(word));
        Self { key: if quoted.is_some() { shown.clone() } else { shown.to_uppercase() }, shown }
    }
}

/// Flags that may stand alone on a line that continues a keyword.
const FLAGS: [&[u8]; 3] = [b"GENERATE", b"INTERNAL", b"UNSORTED"];

/// All blocks of a file.
pub(super) fn blocks<'a>(
    cursor: &mut Cursor<'a>,
    place: &'a Cell<usize>,
) -> Result<Vec<Block<'a>>, Fault> {
    let mut blocks: Vec<Block<'a>> = Vec::new();
    // Whether the last line was a keyword's that ends with a comma.
    let mut open = false;
    loop {
        let at = cursor.position;
        let Some(line) = cursor.line() else { return Ok(blocks) };
        if line.is_empty() || line.starts_with(b"**") {
            continue;
        }
        let ends_open = line.ends_with(b",");
        if let Some(keyword) = line.strip_prefix(b"*") {
            blocks.push(Block::new(at, place, keyword));
            open = ends_open;
            continue;
        }
        let Some(block) = blocks.last_mut() else {
            let found = "a line without a keyword before it";
            return Err(cursor.fault(Refusal::expected("a keyword such as *NODE", found)));
        };
        if open && continues(line) {
            block.options.extend(options(fields(line)));
            open = ends_open;
        } else {
            block.lines.push((at, line));
            open = false;
        }
    }
}

/// Whether a line behind a keyword that ends with a comma has more options; some programs end all lines with one.
fn continues(line: &[u8]) -> bool {
    let first = fields(line).next().unwrap_or_default().to_ascii_uppercase();
    first.contains(&b'=') || FLAGS.contains(&first.as_slice())
}

/// Words between commas, without blanks around them; commas in quotation marks do not count.
pub(super) fn fields(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut quoted = false;
    let separates = move |&byte: &u8| {
        quoted ^= byte == b'"';
        byte == b',' && !quoted
    };
    line.split(separates).map(<[u8]>::trim_ascii)
}

/// A word in capitals with single blanks.
fn capitals(word: &[u8]) -> String {
    text_of(word).to_uppercase().split_whitespace().collect::<Vec<_>>().join(" ")
}

fn options<'a>(fields: impl Iterator<Item = &'a [u8]>) -> impl Iterator<Item = (String, &'a [u8])> {
    fields.filter(|field| !field.is_empty()).map(|field| {
        let mut parts = field.splitn(2, |&byte| byte == b'=');
        let key = capitals(parts.next().unwrap_or_default());
        (key, parts.next().unwrap_or_default().trim_ascii())
    })
}

impl<'a> Block<'a> {
    fn new(at: usize, place: &'a Cell<usize>, line: &'a [u8]) -> Self {
        let mut words = fields(line);
        let keyword = capitals(words.next().unwrap_or_default());
        let options = options(words).collect();
        Self { at, place, scope: Scope::Part, keyword, options, lines: Vec::new() }
    }

    /// Number of lines of data.
    pub(super) fn len(&self) -> usize {
        self.lines.len()
    }

    /// The lines of data, to which errors point meanwhile; then to the keyword again.
    pub(super) fn lines(&self) -> impl Iterator<Item = &'a [u8]> {
        let mut lines = self.lines.iter();
        std::iter::from_fn(move || {
            let next = lines.next();
            self.place.set(next.map_or(self.at, |line| line.0));
            next.map(|line| line.1)
        })
    }

    /// The value of an option; empty where it stands alone.
    pub(super) fn option(&self, key: &str) -> Option<&'a [u8]> {
        self.options.iter().find(|(known, _)| known == key).map(|&(_, value)| value)
    }

    /// The name that an option gives.
    pub(super) fn name(&self, key: &str) -> Option<Name> {
        self.option(key).filter(|value| !value.is_empty()).map(Name::new)
    }

    /// The name that an option must give.
    pub(super) fn required(&self, key: &str, expected: &'static str) -> Result<Name> {
        self.name(key).ok_or_else(|| Refusal::missing(expected))
    }

    /// Begins to read the block. Refuses options beside these, which might change what the lines mean.
    pub(super) fn allow(&self, known: &[&str]) -> Result<()> {
        self.place.set(self.at);
        let unknown = self.options.iter().find(|(key, _)| !known.contains(&key.as_str()));
        unknown.map_or(Ok(()), |(key, _)| {
            let value = format!("{key} of *{}", self.keyword);
            Err(Refusal::unsupported("the option", value, "write the mesh without it"))
        })
    }
}

/// A real number, as Fortran may write it (`1.5D-3`) too; one that is left out is zero.
pub(super) fn real(word: &[u8]) -> Result<f64> {
    if word.is_empty() {
        return Ok(0.0);
    }
    let text = String::from_utf8_lossy(word).replace(['d', 'D'], "e");
    text.parse().map_err(|_| Refusal::expected("a coordinate", word))
}

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
            return Err(Refusal::unsupported("the set", &name.shown, advice));
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
        let (ascends, found) = (first <= last && step >= 1, format!("{first}, {last}, {step}"));
        Refusal::require(ascends, "a range that ascends by a positive step", found)?;
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
            let found = self.ids.get(&id).ok_or_else(|| Refusal::expected(expected, word))?;
            return Ok(std::slice::from_ref(found));
        }
        let key = Name::new(bare).key;
        let sets = scopes.iter().find_map(|&scope| self.sets.get(&(scope, key.clone())));
        let expected = "a number, or the name of a set that stands further up";
        Ok(&sets.ok_or_else(|| Refusal::expected(expected, word))?.1)
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
                return Err(Refusal::expected(expected, shown));
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
