//! The public functions with arguments, as the sources have them.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// `room::Type::function`, or for a free function the path of its module and its name.
pub fn public_functions() -> BTreeSet<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = vec![];
    collect(&root, &mut files);
    let texts: Vec<(PathBuf, String)> =
        files.into_iter().map(|path| (path.clone(), product(&path))).collect();
    let mut exported = BTreeSet::new();
    for (path, text) in &texts {
        let module = module_of(&root, path);
        if open_depth(&root, &module) == module.len() {
            let room = module.first().cloned();
            exported.extend(exported_names(text).into_iter().map(|name| (room.clone(), name)));
        }
    }
    let mut found = BTreeSet::new();
    for (path, text) in &texts {
        let module = module_of(&root, path);
        let Some(room) = module.first() else { continue };
        let depth = open_depth(&root, &module);
        let place = module[..depth.max(1)].join("::");
        let is_exported = |name: &str| {
            let name = name.to_owned();
            let declared = |kind| text.contains(&format!("\npub {kind} {name}"));
            let own =
                depth == module.len() && ["struct", "enum", "trait"].into_iter().any(declared);
            let here = exported.contains(&(Some(room.clone()), name.clone()));
            own || here || (depth == 0 && exported.contains(&(None, name)))
        };
        let mut owner: Option<(String, bool)> = None;
        let mut start = 0;
        for line in text.split_inclusive('\n') {
            let rest = &text[start..];
            start += line.len();
            if let Some(named) = owner_of(line) {
                owner = named;
            }
            let in_trait = owner.as_ref().is_some_and(|(_, is_trait)| *is_trait);
            let Some(name) = function_of(line, in_trait) else { continue };
            if !has_arguments(rest) {
                continue;
            }
            match &owner {
                Some((owner, _)) if line.starts_with(' ') => {
                    if is_exported(owner) {
                        found.insert(format!("{place}::{owner}::{name}"));
                    }
                }
                _ if line.starts_with(' ') => {}
                _ => {
                    if depth == module.len() || is_exported(name) {
                        found.insert(format!("{place}::{name}"));
                    }
                }
            }
        }
    }
    assert!(found.len() > 120, "the sources of the library are not where they were");
    found
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
}

/// A source without its tests.
fn product(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    text.split("#[cfg(test)]\nmod ").next().unwrap_or_default().to_owned()
}

fn module_of(root: &Path, path: &Path) -> Vec<String> {
    let inner = path.strip_prefix(root).unwrap().with_extension("");
    let mut module: Vec<String> = inner.iter().map(|p| p.to_str().unwrap().to_owned()).collect();
    if module.last().is_some_and(|last| last == "mod" || last == "lib") {
        module.pop();
    }
    module
}

/// How many modules of a path, from the crate on, are declared `pub mod`.
fn open_depth(root: &Path, module: &[String]) -> usize {
    let is_open = |depth: &usize| {
        let folder = module[..*depth].iter().fold(root.to_owned(), |path, part| path.join(part));
        let index = if *depth == 0 { root.join("lib.rs") } else { folder.join("mod.rs") };
        let declared = format!("\npub mod {};", module[*depth]);
        fs::read_to_string(index).is_ok_and(|text| text.contains(&declared))
    };
    (0..module.len()).take_while(is_open).count()
}

/// What `pub use` hands out.
fn exported_names(text: &str) -> Vec<String> {
    let uses = text.split("\npub use ").skip(1).filter_map(|rest| rest.split(';').next());
    let names = uses.flat_map(|tree| tree.split(['{', '}', ',', ' ', '\n']));
    let last = names.filter_map(|path| path.rsplit("::").next());
    last.map(str::to_owned).collect()
}

/// Whose functions follow: the type of an `impl` or a trait; `Some(None)` for the `impl` of a
/// trait, whose functions are those of the trait.
fn owner_of(line: &str) -> Option<Option<(String, bool)>> {
    let word = |text: &str| {
        let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(text.len());
        text[..end].to_owned()
    };
    if let Some(name) = line.strip_prefix("pub trait ") {
        return Some(Some((word(name), true)));
    }
    let rest = line.strip_prefix("impl")?;
    let rest = match rest.strip_prefix('<') {
        Some(generic) => generic.split_once("> ").map_or("", |(_, rest)| rest),
        None => rest.trim_start(),
    };
    if line.contains(" for ") {
        return Some(None);
    }
    let last = rest.split(['<', ' ', '{']).next().unwrap_or_default();
    Some(Some((word(last.rsplit("::").next().unwrap_or_default()), false)))
}

/// The public function that a line begins.
fn function_of(line: &str, in_trait: bool) -> Option<&str> {
    let inner = line.strip_prefix("    ").unwrap_or(line);
    let rest = match inner.strip_prefix("pub ") {
        Some(rest) => rest,
        None if in_trait && line.starts_with("    ") => inner,
        None => return None,
    };
    let rest = rest.strip_prefix("const ").unwrap_or(rest).strip_prefix("fn ")?;
    let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_'))?;
    Some(&rest[..end])
}

/// Whether a function takes anything beside `self`.
fn has_arguments(text: &str) -> bool {
    let Some((_, rest)) = text.split_once("fn ") else { return false };
    // Behind the name and its generic parameters.
    let mut depth = 0;
    let mut begin = None;
    let mut end = 0;
    for (at, c) in rest.char_indices() {
        match c {
            '<' if begin.is_none() => depth += 1,
            '>' if begin.is_none() => depth -= 1,
            '(' if begin.is_none() && depth == 0 => begin = Some(at + 1),
            '(' if begin.is_some() => depth += 1,
            ')' if begin.is_some() && depth > 0 => depth -= 1,
            ')' if begin.is_some() => {
                end = at;
                break;
            }
            _ => {}
        }
    }
    let arguments = rest[begin.unwrap_or(0)..end].trim();
    let receiver = arguments.split(',').next().unwrap_or_default().trim();
    let is_receiver = receiver.ends_with("self") || receiver.starts_with("self:");
    let others = if is_receiver {
        arguments[receiver.len()..].trim_matches([',', ' ', '\n'])
    } else {
        arguments
    };
    !others.trim().is_empty()
}
