//! The rooms of ARCHITECTURE.md: who knows whom. Reads the library's sources.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Each room of the library and the rooms that it may know, lowest first. The files beside
/// `lib.rs` are rooms of their own.
const ROOMS: &[(&str, &[&str])] = &[
    ("excerpt", &[]),
    ("input", &["excerpt"]),
    ("domain", &[]),
    ("effect", &[]),
    ("calls", &[]),
    ("time_function", &[]),
    ("parallel", &[]),
    ("theory", &[]),
    ("solver", &["parallel", "calls"]),
    ("dem", &["parallel", "domain", "effect", "excerpt", "time_function", "calls"]),
    ("pfv", &["solver", "parallel", "domain", "effect", "calls"]),
    ("io", &["excerpt", "input", "domain", "solver", "pfv"]),
    (
        "coupling",
        &["dem", "pfv", "solver", "parallel", "domain", "effect", "excerpt", "time_function"],
    ),
    (
        "scene",
        &[
            "coupling",
            "dem",
            "pfv",
            "solver",
            "io",
            "excerpt",
            "input",
            "domain",
            "error",
            "effect",
            "time_function",
        ],
    ),
    ("stage_error", &[]),
    ("error", &["input", "io", "coupling", "dem", "pfv", "solver", "stage_error"]),
    (
        "simulation",
        &[
            "scene",
            "coupling",
            "dem",
            "pfv",
            "solver",
            "io",
            "parallel",
            "theory",
            "input",
            "domain",
            "error",
            "stage_error",
        ],
    ),
];

/// Names that lib.rs re-exports, and the room that each is from.
const REEXPORTS: &[(&str, &str)] = &[
    ("Aabb", "domain"),
    ("Axis", "domain"),
    ("Cell", "domain"),
    ("CellError", "domain"),
    ("PerWall", "domain"),
    ("Tensor", "domain"),
    ("UnknownWall", "domain"),
    ("Vec3", "domain"),
    ("WallId", "domain"),
    ("Calls", "calls"),
    ("deviatoric_stress", "domain"),
    ("mean_stress", "domain"),
    ("Effect", "effect"),
    ("EffectKey", "effect"),
    ("Family", "effect"),
    ("InputError", "input"),
    ("TimeFunction", "time_function"),
    ("Error", "error"),
    ("Result", "error"),
];

/// The crates of the workspace by their folders, and those that each may know, lowest first.
const CRATES: &[(&str, &[&str])] = &[
    ("cholmod-sys", &[]),
    ("cgal-sys", &[]),
    ("dempfv", &["cholmod-sys", "cgal-sys"]),
    ("report", &["cholmod-sys", "cgal-sys", "dempfv"]),
    ("evidence", &["cholmod-sys", "dempfv", "report"]),
    (".", &["dempfv", "report", "evidence"]),
    ("python", &["dempfv"]),
];

#[test]
fn no_crate_knows_one_above_it() {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let manifest = fs::read_to_string(workspace.join("Cargo.toml")).unwrap();
    let members = manifest.lines().find(|line| line.starts_with("members")).unwrap();
    let mut wrong = vec![];
    for name in members.split('"').skip(1).step_by(2).chain(["."]) {
        let Some((_, may_know)) = CRATES.iter().find(|(folder, _)| *folder == name) else {
            panic!("`{name}` is no crate of this test's table");
        };
        let manifest = fs::read_to_string(workspace.join(name).join("Cargo.toml")).unwrap();
        let paths =
            manifest.lines().filter(|line| !line.starts_with("path =") && !line.starts_with('#'));
        for path in paths.filter_map(|line| line.split_once("path = \"")?.1.split('"').next()) {
            let known = path.trim_start_matches("../");
            if !may_know.contains(&known) {
                wrong.push(format!("{name} -> {known}"));
            }
        }
    }
    assert!(wrong.is_empty(), "arrows that run up: {}", wrong.join(", "));
}

#[test]
fn no_room_knows_one_above_it() {
    let mut wrong = vec![];
    for file in sources() {
        let Some(room) = file.module.first() else { continue };
        let Some((_, may_know)) = ROOMS.iter().find(|(name, _)| name == room) else {
            panic!("{}: `{room}` is no room of this test's table", file.path.display());
        };
        for path in &file.uses {
            let Some(first) = path.first() else { continue };
            let known = REEXPORTS.iter().find(|(name, _)| name == first);
            let other = known.map_or(first.as_str(), |(_, room)| room);
            if other != room && !may_know.contains(&other) {
                wrong.push(format!("{}: {}", file.path.display(), path.join("::")));
            }
        }
    }
    assert!(wrong.is_empty(), "arrows that run up:\n{}", wrong.join("\n"));
}

#[test]
fn no_files_of_the_python_package_know_each_other_in_a_circle() {
    let files = sources_of(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../python/src"));
    assert!(files.len() > 10, "the sources of the Python package are not where they were");
    let circle = circle(&arrows_within(&[], &files));
    assert!(circle.is_none(), "a circle: {}", circle.unwrap_or_default().join(" -> "));
}

#[test]
fn no_files_know_each_other_in_a_circle() {
    let files = sources();
    let folders: BTreeSet<Vec<String>> =
        files.iter().map(|f| f.module[..f.module.len().saturating_sub(1)].to_vec()).collect();
    let mut circles = vec![];
    for folder in folders.iter().filter(|folder| !folder.is_empty()) {
        let arrows = arrows_within(folder, &files);
        if let Some(circle) = circle(&arrows) {
            circles.push(format!("{}: {}", folder.join("::"), circle.join(" -> ")));
        }
    }
    assert!(circles.is_empty(), "circles:\n{}", circles.join("\n"));
}

/// Who knows whom among the files and folders directly within a folder.
fn arrows_within(folder: &[String], files: &[Source]) -> BTreeMap<String, BTreeSet<String>> {
    let depth = folder.len();
    let index = files.iter().find(|f| f.module == folder);
    // Names that the folder's mod.rs hands out, by the file that they come from.
    let mut origin: BTreeMap<&str, &str> = BTreeMap::new();
    for path in index.iter().flat_map(|f| &f.uses) {
        if path.len() >= depth + 2 && path.starts_with(folder) {
            origin.insert(path[path.len() - 1].as_str(), path[depth].as_str());
        }
    }
    let mut arrows: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for file in files.iter().filter(|f| f.module.len() > depth && f.module.starts_with(folder)) {
        let from = &file.module[depth];
        for path in file.uses.iter().filter(|p| p.len() > depth && p.starts_with(folder)) {
            let name = path[depth].as_str();
            let to = origin.get(name).copied().unwrap_or(name);
            let is_module = files.iter().any(|f| f.module.get(depth).is_some_and(|m| m == to));
            if is_module && to != from {
                arrows.entry(from.clone()).or_default().insert(to.to_owned());
            }
        }
    }
    arrows
}

/// A circle among arrows, if there is one.
fn circle(arrows: &BTreeMap<String, BTreeSet<String>>) -> Option<Vec<String>> {
    fn visit<'a>(
        node: &'a str,
        arrows: &'a BTreeMap<String, BTreeSet<String>>,
        way: &mut Vec<&'a str>,
        done: &mut BTreeSet<&'a str>,
    ) -> Option<Vec<String>> {
        if let Some(at) = way.iter().position(|n| *n == node) {
            let mut circle: Vec<String> = way[at..].iter().map(|n| (*n).to_owned()).collect();
            circle.push(node.to_owned());
            return Some(circle);
        }
        if !done.insert(node) {
            return None;
        }
        way.push(node);
        let found =
            arrows.get(node).into_iter().flatten().find_map(|next| visit(next, arrows, way, done));
        way.pop();
        found
    }
    let (mut way, mut done) = (vec![], BTreeSet::new());
    arrows.keys().find_map(|node| visit(node, arrows, &mut way, &mut done))
}

/// A source file of the library.
struct Source {
    path: PathBuf,
    /// Its module, as in `["pfv", "flow"]`; a folder's mod.rs has the folder's.
    module: Vec<String>,
    /// The paths within the crate that it names, without `crate`.
    uses: Vec<Vec<String>>,
}

/// Every source file but lib.rs, without its tests.
fn sources() -> Vec<Source> {
    let found = sources_of(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
    assert!(found.len() > 50, "the sources of the library are not where they were");
    found
}

/// Every source file below a folder but its lib.rs, likewise.
fn sources_of(root: &Path) -> Vec<Source> {
    let mut folders = vec![root.to_owned()];
    let mut found = vec![];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") && path != root.join("lib.rs") {
                found.push(Source::read(root, path));
            }
        }
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    found
}

impl Source {
    fn read(root: &Path, path: PathBuf) -> Source {
        let inner = path.strip_prefix(root).unwrap().with_extension("");
        let mut module: Vec<String> =
            inner.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
        if module.last().is_some_and(|last| last == "mod") {
            module.pop();
        }
        let is_index = path.file_name().is_some_and(|name| name == "mod.rs");
        let text = fs::read_to_string(&path).unwrap();
        let product = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
        let code: String = product
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"))
            .flat_map(|line| [line, "\n"])
            .collect();
        // What `super` is: for mod.rs the folder above, which no file here is in.
        let mut uses = vec![];
        for (start, base) in starts(&code, &module, is_index) {
            expand(&code[start..], &base, &mut uses);
        }
        Source { path, module, uses }
    }
}

/// Where paths within the crate begin, and what they begin with.
fn starts(code: &str, module: &[String], is_index: bool) -> Vec<(usize, Vec<String>)> {
    let parent = module[..module.len().saturating_sub(1)].to_vec();
    let grandparent = parent[..parent.len().saturating_sub(1)].to_vec();
    let mut found = vec![];
    let mut push = |word: &str, base: &[String]| {
        for (at, _) in code.match_indices(word) {
            let before = code[..at].chars().next_back();
            if before.is_none_or(|c| !(c.is_alphanumeric() || c == '_' || c == ':')) {
                found.push((at + word.len(), base.to_vec()));
            }
        }
    };
    push("crate::", &[]);
    push("super::super::", &grandparent);
    push("super::", &parent);
    if is_index {
        // `pub use file::Name` of a mod.rs.
        for line in ["pub use ", "pub(crate) use ", "pub(super) use ", "use "] {
            push(line, module);
        }
    }
    found
}

/// Reads a path, or a tree of paths in braces, and adds each to `uses`.
fn expand(text: &str, base: &[String], uses: &mut Vec<Vec<String>>) -> usize {
    let mut path = base.to_vec();
    let mut at = 0;
    loop {
        let rest = &text[at..];
        let blank = rest.len() - rest.trim_start().len();
        let rest = rest.trim_start();
        at += blank;
        if rest.starts_with('{') {
            at += 1;
            loop {
                at += expand(&text[at..], &path, uses);
                let tail = text[at..].trim_start();
                at = text.len() - tail.len();
                match tail.chars().next() {
                    Some(',') => at += 1,
                    Some('}') => return at + 1,
                    _ => return at,
                }
            }
        }
        let length = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
        match &rest[..length] {
            "" => break,
            "self" => {}
            "super" => {
                path.pop();
            }
            "crate" => path.clear(),
            word => path.push(word.to_owned()),
        }
        at += length;
        if text[at..].starts_with("::") {
            at += 2;
        } else {
            break;
        }
    }
    if path.len() > base.len() {
        uses.push(path);
    }
    // A renamed name: `Name as Other`.
    if let Some(rest) = text[at..].strip_prefix(" as ") {
        at += 4 + rest.find([',', '}', ';']).unwrap_or(0);
    }
    at
}
