//! Names that a source file takes from elsewhere, read from its tokens, so that those inside macros count.

use anyhow::{Result, anyhow};
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::collections::BTreeSet;

/// One name of a `use`, by which the file knows it, and the path it comes from; `*` where it is all of a module.
#[derive(Debug)]
pub(crate) struct Import {
    pub(crate) public: bool,
    pub(crate) name: String,
    pub(crate) path: Vec<String>,
}

/// Imports, paths, words of its code and defined names of a file, those of its tests left out.
#[derive(Debug, Default)]
pub(crate) struct File {
    pub(crate) imports: Vec<Import>,
    pub(crate) paths: Vec<Vec<String>>,
    pub(crate) words: BTreeSet<String>,
    pub(crate) defined: BTreeSet<String>,
}

/// Reads the text of a file.
///
/// # Errors
///
/// When brackets or quotes do not close.
pub(crate) fn read(text: &str) -> Result<File> {
    let tokens: TokenStream = text.parse().map_err(|error| anyhow!("{error}"))?;
    let mut file = File::default();
    walk(&tokens.into_iter().collect::<Vec<_>>(), &mut file);
    Ok(file)
}

/// Words after which the name of an item stands.
const ITEMS: &[&str] =
    &["const", "enum", "fn", "macro_rules", "static", "struct", "trait", "type", "union"];

fn walk(tokens: &[TokenTree], file: &mut File) {
    let (mut at, mut public) = (0, false);
    while let Some(token) = tokens.get(at) {
        if is_test(&tokens[at..]) {
            at += item(&tokens[at..]);
            continue;
        }
        if let Some(group) = attribute(&tokens[at..]) {
            file.paths.extend(quoted(&inside(group)));
        }
        match token {
            TokenTree::Group(group) => walk(&inside(group), file),
            TokenTree::Ident(word) if word == "use" => {
                let length = tokens[at..].iter().position(|token| is(token, ';'));
                let end = at + length.unwrap_or(tokens.len() - at);
                tree(&tokens[at + 1..end], &[], public, &mut file.imports);
                (at, public) = (end, false);
            }
            TokenTree::Ident(word) => {
                let (path, length) = path(&tokens[at..]);
                if ITEMS.contains(&&*word.to_string()) {
                    let name = tokens[at + 1..].iter().find_map(ident);
                    file.defined.extend(name);
                }
                // The scope of `pub(crate) use` is a group of its own.
                public = word == "pub";
                file.words.extend(path.iter().cloned());
                if path.len() > 1 {
                    file.paths.push(path);
                }
                at += length - 1;
            }
            TokenTree::Punct(_) => public = false,
            TokenTree::Literal(_) => {}
        }
        at += 1;
    }
}

/// Whether `#[cfg(test)]` begins here.
fn is_test(tokens: &[TokenTree]) -> bool {
    matches!(tokens, [hash, TokenTree::Group(group), ..]
        if is(hash, '#') && group.stream().to_string().replace(' ', "") == "cfg(test)")
}

/// The brackets of an attribute that begins here, documentation left out.
fn attribute(tokens: &[TokenTree]) -> Option<&proc_macro2::Group> {
    match tokens {
        [hash, TokenTree::Group(group), ..] if is(hash, '#') => {
            let named = group.stream().into_iter().next().as_ref().and_then(ident);
            (named.as_deref() != Some("doc")).then_some(group)
        }
        _ => None,
    }
}

/// Paths in the strings of an attribute, such as `#[serde(with = "super::matrix")]`.
fn quoted(tokens: &[TokenTree]) -> Vec<Vec<String>> {
    let found = |token: &TokenTree| match token {
        TokenTree::Group(group) => quoted(&inside(group)),
        TokenTree::Literal(literal) => {
            let text = literal.to_string();
            let words: Option<TokenStream> = text.trim_matches('"').parse().ok();
            let words: Vec<_> = words.into_iter().flatten().collect();
            let (path, length) = path(&words);
            Vec::from_iter((path.len() > 1 && length == words.len()).then_some(path))
        }
        _ => Vec::new(),
    };
    tokens.iter().flat_map(found).collect()
}

/// Number of tokens of the item here, attributes included: up to its semicolon or braces.
fn item(tokens: &[TokenTree]) -> usize {
    // A `use` may have braces before its semicolon.
    let import = tokens.iter().position(|token| ident(token).is_some_and(|word| word == "use"));
    let end = |token: &TokenTree| match token {
        TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
        token => is(token, ';'),
    };
    let first = tokens.iter().position(end).unwrap_or(tokens.len());
    let semicolon = || tokens.iter().position(|token| is(token, ';')).unwrap_or(tokens.len());
    let last = if import.is_some_and(|import| import < first) { semicolon() } else { first };
    (last + 1).min(tokens.len())
}

/// Names of a `use` tree below `prefix`.
fn tree(tokens: &[TokenTree], prefix: &[String], public: bool, imports: &mut Vec<Import>) {
    for part in tokens.split(|token| is(token, ',')) {
        let (path, length) = path(part);
        let mut path = [prefix, &path].concat();
        let renamed = part.get(length).and_then(ident).filter(|word| word == "as");
        match part[length..].last() {
            Some(TokenTree::Group(group)) => tree(&inside(group), &path, public, imports),
            Some(star) if is(star, '*') => {
                path.push("*".into());
                imports.push(Import { public, name: "*".into(), path });
            }
            last => {
                if path.len() > 1 && path.last().is_some_and(|word| word == "self") {
                    path.pop();
                }
                let name = renamed.and(last).and_then(ident).or(path.last().cloned());
                imports.extend(name.map(|name| Import { public, name, path }));
            }
        }
    }
}

/// Words joined by `::`, and the number of tokens they take, a trailing `::` included.
fn path(tokens: &[TokenTree]) -> (Vec<String>, usize) {
    let (mut words, mut at) = (Vec::new(), 0);
    while let Some(word) = tokens.get(at).and_then(ident) {
        words.push(word);
        at += 1;
        match &tokens[at..] {
            [a, b, ..] if is(a, ':') && is(b, ':') => at += 2,
            _ => break,
        }
    }
    (words, at)
}

fn inside(group: &proc_macro2::Group) -> Vec<TokenTree> {
    group.stream().into_iter().collect()
}

fn ident(token: &TokenTree) -> Option<String> {
    match token {
        TokenTree::Ident(word) => Some(word.to_string()),
        _ => None,
    }
}

fn is(token: &TokenTree, mark: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == mark)
}
