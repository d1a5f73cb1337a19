//! Circles of imports inside each crate: files that reach each other by the names they take, names taken through the
//! crate root counted. `use crate::Name` leads to the file that defines `Name`, however often it is passed on.

use crate::imports::{File, read};
use anyhow::{Context, Result, bail};
use cargo_metadata::MetadataCommand;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Two files that share a type and its method are read together; three no longer are.
const LARGEST: usize = 2;
/// Passings-on of one name that are followed, so that a name passed on in a ring ends.
const LONGEST_CHAIN: usize = 16;

type Module = Vec<String>;
type Files = BTreeMap<Module, File>;
/// Names by the file that takes them and the file that defines them.
type Arrows = BTreeMap<Module, BTreeMap<Module, BTreeSet<String>>>;

/// Fails with every circle of more than two files, and the names that close it.
pub(crate) fn check() -> Result<()> {
    let metadata = MetadataCommand::new().no_deps().exec().context("cargo metadata failed")?;
    let (mut wrong, mut count) = (Vec::new(), 0);
    for package in metadata.workspace_packages() {
        let folder = package.manifest_path.with_file_name("src");
        if !folder.is_dir() {
            continue;
        }
        let mut files = Files::new();
        collect(folder.as_std_path(), &[], &mut files)?;
        count += files.len();
        let arrows = arrows(&files);
        let circles = circles(&arrows).into_iter().filter(|circle| circle.len() > LARGEST);
        wrong.extend(circles.map(|circle| described(&package.name, &circle, &arrows)));
    }
    if !wrong.is_empty() {
        let advice = "move what they share into a file below them, or what calls into one above";
        bail!(
            "imports run in circles of more than {LARGEST} files; {advice}:\n{}",
            wrong.join("\n")
        );
    }
    eprintln!("circles of imports: none of more than {LARGEST} files among {count}");
    Ok(())
}

/// Files of a crate by module; programs under `bin` are crates of their own.
fn collect(folder: &Path, module: &[String], files: &mut Files) -> Result<()> {
    let unreadable = || format!("{} is unreadable", folder.display());
    for entry in folder.read_dir().with_context(unreadable)? {
        let path = entry.with_context(unreadable)?.path();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut inner = module.to_vec();
        if path.is_dir() {
            if !(module.is_empty() && stem == "bin") {
                inner.push(stem);
                collect(&path, &inner, files)?;
            }
            continue;
        }
        let beside_library = stem == "main" && folder.join("lib.rs").is_file();
        if path.extension().is_none_or(|extension| extension != "rs") || beside_library {
            continue;
        }
        let root = module.is_empty() && (stem == "lib" || stem == "main");
        if !root && stem != "mod" {
            inner.push(stem);
        }
        let text = std::fs::read_to_string(&path)
            .with_context(|| format!("{} is unreadable", path.display()))?;
        let file = read(&text).with_context(|| format!("{} is not Rust", path.display()))?;
        files.insert(inner, file);
    }
    Ok(())
}

/// Imports: file, names, and the file that they come from.
fn arrows(files: &Files) -> Arrows {
    let mut arrows = Arrows::new();
    for (module, file) in files {
        let from = arrows.entry(module.clone()).or_default();
        let taken = file.imports.iter().map(|import| (import.public, &import.path));
        for (public, path) in taken.chain(file.paths.iter().map(|path| (false, path))) {
            let Some(target) = definer(files, module, path, 0) else { continue };
            // Passing on what a file below defines is what a module is for.
            let passed_on = public && target.starts_with(module);
            if target != *module && !passed_on {
                // Of `Type::function` the type is what is taken.
                let kind = path.iter().find(|word| word.starts_with(char::is_uppercase));
                let name = kind.or(path.last()).cloned().unwrap_or_default();
                from.entry(target).or_default().insert(name);
            }
        }
    }
    arrows
}

/// The file that defines what `path`, written in `module`, names; none for other crates.
fn definer(files: &Files, module: &[String], path: &[String], depth: usize) -> Option<Module> {
    let mut at = module.to_vec();
    let mut rest = path;
    match rest.first()?.as_str() {
        "crate" => (at, rest) = (Module::new(), &rest[1..]),
        "self" => rest = &rest[1..],
        "super" => {
            while rest.first().is_some_and(|word| word == "super") {
                at.pop();
                rest = &rest[1..];
            }
        }
        // A bare name is a module below or an import, or nothing of this crate.
        _ => {
            let below = [&at[..], &rest[..1]].concat();
            let imported = || files[module].imports.iter().any(|import| import.name == rest[0]);
            if !files.contains_key(&below) && (rest.len() == 1 || !imported()) {
                return None;
            }
        }
    }
    while let Some((name, after)) = rest.split_first() {
        let below = [&at[..], std::slice::from_ref(name)].concat();
        if files.contains_key(&below) {
            (at, rest) = (below, after);
            continue;
        }
        let file = files.get(&at)?;
        let passed_on = file.imports.iter().find(|i| i.name == *name && i.path != path);
        if let (Some(import), true) = (passed_on, depth < LONGEST_CHAIN) {
            let further = [&import.path[..], after].concat();
            return definer(files, &at, &further, depth + 1);
        }
        let mut opened = file.imports.iter().filter(|i| i.name == "*" && depth < LONGEST_CHAIN);
        if !file.defined.contains(name) {
            let found = opened.find_map(|import| {
                let source = &import.path[..import.path.len() - 1];
                let target = definer(files, &at, source, depth + 1)?;
                let path = [&["self".to_string()], rest].concat();
                let found = definer(files, &target, &path, depth + 1)?;
                files[&found].defined.contains(name).then_some(found)
            });
            return found.or(Some(at));
        }
        break;
    }
    files.contains_key(&at).then_some(at)
}

/// Groups of files each of which reaches every other.
fn circles(arrows: &Arrows) -> Vec<Vec<Module>> {
    let reached: BTreeMap<_, _> = arrows.keys().map(|from| (from, reached(arrows, from))).collect();
    let mut grouped = BTreeSet::new();
    let mut circles = Vec::new();
    for (from, there) in &reached {
        let back = |to: &&Module| reached.get(to).is_some_and(|back| back.contains(*from));
        let circle: Vec<Module> = there.iter().filter(back).cloned().collect();
        if !circle.is_empty() && !grouped.contains(*from) {
            grouped.extend(circle.iter().cloned());
            circles.push(circle);
        }
    }
    circles
}

/// Files that `from` takes names of, and so on from each.
fn reached(arrows: &Arrows, from: &Module) -> BTreeSet<Module> {
    let mut seen = BTreeSet::new();
    let mut open = vec![from];
    while let Some(module) = open.pop() {
        for to in arrows.get(module).into_iter().flat_map(BTreeMap::keys) {
            if seen.insert(to.clone()) {
                open.push(to);
            }
        }
    }
    seen
}

/// The files of a circle and the names that close it.
fn described(package: &str, circle: &[Module], arrows: &Arrows) -> String {
    let shown = |module: &Module| match &module[..] {
        [] => "the crate root".to_string(),
        words => words.join("/"),
    };
    let files: Vec<_> = circle.iter().map(shown).collect();
    let mut lines = vec![format!("  {package}, {} files: {}", circle.len(), files.join(", "))];
    for from in circle {
        for (to, names) in arrows[from].iter().filter(|(to, _)| circle.contains(to)) {
            let names: Vec<_> = names.iter().map(String::as_str).collect();
            lines.push(format!("    {} -> {}: {}", shown(from), shown(to), names.join(", ")));
        }
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Circles of a crate of files given by module and text.
    fn of(texts: &[(&str, &str)]) -> Vec<Vec<String>> {
        let module =
            |name: &str| name.split('/').filter(|w| !w.is_empty()).map(Into::into).collect();
        let files = texts.iter().map(|(name, text)| (module(name), read(text).unwrap())).collect();
        let circles = circles(&arrows(&files)).into_iter();
        circles.map(|circle| circle.iter().map(|module| module.join("/")).collect()).collect()
    }

    #[test]
    fn names_through_the_crate_root_lead_to_the_file_that_defines_them() {
        let root = ("", "mod a; mod b; mod c; pub use a::A; pub use {b::B, c::{C, D as E}};");
        let a = ("a", "use crate::B; pub struct A;");
        let b = ("b", "use crate::{E, other}; pub struct B;");
        let c = ("c", "pub struct C; pub struct D; fn f() { crate::A::new() }");
        assert_eq!(of(&[root, a, b, c]), [["a", "b", "c"]]);
        assert!(of(&[root, a, b, ("c", "pub struct C; pub struct D;")]).is_empty());
    }

    #[test]
    fn names_opened_by_a_star_lead_to_the_file_that_defines_them() {
        let root = ("", "mod a; mod b; pub use a::*; pub use b::*;");
        let a = ("a", "use crate::B; pub struct A;");
        assert_eq!(of(&[root, a, ("b", "use crate::A; pub struct B;")]), [["a", "b"]]);
        assert!(of(&[root, a, ("b", "pub struct B;")]).is_empty());
    }

    #[test]
    fn a_module_may_pass_on_what_lies_below_but_not_use_it_both_ways() {
        let below = ("a/b", "use super::T; pub fn f(_: T) {}");
        assert!(of(&[("a", "mod b; pub use b::f; pub struct T;"), below]).is_empty());
        let above = ("a", "mod b; pub struct T; fn g() { b::f(T) }");
        assert_eq!(of(&[above, below]), [["a", "a/b"]]);
    }

    #[test]
    fn macros_count_and_tests_comments_and_strings_do_not() {
        let a = ("a", "use crate::b; fn f() { b::g() }");
        let used = |text| !of(&[("", "mod a; mod b;"), a, ("b", text)]).is_empty();
        assert!(used("fn g() { each!(n, crate::a::f()) }"));
        assert!(!used("// crate::a::f\n/// crate::a::f\nfn g() { \"crate::a::f\"; }"));
        assert!(!used("#[cfg(test)]\nmod tests { use crate::a::f; }\nfn g() {}"));
        assert!(!used("#[cfg(test)]\n#[allow(x)]\nuse crate::a::f;\nfn g() {}"));
        assert!(used("#[cfg(test)]\nuse other::a;\nuse crate::a::f;"));
    }

    #[test]
    fn paths_in_strings_of_attributes_count() {
        let a = ("a", "use crate::b; fn f() { b::g() }");
        let used = |text| !of(&[("", "mod a; mod b;"), a, ("b", text)]).is_empty();
        assert!(used("#[derive(T)]\nstruct G { #[serde(default, with = \"super::a\")] g: u8 }"));
        assert!(used("#[serde(try_from = \"crate::a::F\")]\nstruct G;"));
        assert!(!used("#[expect(x, reason = \"super::a is above\")]\nstruct G;"));
        assert!(!used("/// `crate::a`\n#[doc = \"crate::a::F\"]\nstruct G;"));
    }

    #[test]
    fn a_circle_is_described_by_its_names() {
        let files = [("a", "use crate::b::{y, x};"), ("b", "use super::a::z;")];
        let module = |name: &str| vec![name.to_string()];
        let files = files.map(|(name, text)| (module(name), read(text).unwrap()));
        let arrows = arrows(&[(vec![], read("").unwrap())].into_iter().chain(files).collect());
        let text = described("sinew-x", &circles(&arrows)[0], &arrows);
        assert_eq!(text, "  sinew-x, 2 files: a, b\n    a -> b: x, y\n    b -> a: z");
    }
}
