//! The files that a run leaves in its folder.

use std::path::Path;

use dempfv::{Error, Result};

/// Beginnings and endings of the files that a run writes.
const RESULTS: [(&str, &[&str]); 14] = [
    ("summary", &["json"]),
    ("history", &["csv"]),
    ("checkpoint", &["dempfv"]),
    ("consolidation", &["csv", "png", "svg"]),
    ("profiles", &["png", "svg"]),
    ("section", &["png", "svg"]),
    ("stress-", &["png", "svg"]),
    ("shear-", &["png", "svg"]),
    ("grading", &["png", "svg"]),
    ("final-packing", &["txt"]),
    ("contacts", &["csv", "pvd", "vtu"]),
    ("cell", &["pvd", "vtu"]),
    ("pores", &["pvd", "vtu"]),
    ("spheres", &["pvd", "vtu"]),
];

/// Removes what an earlier run left in a folder, and nothing else: its files
/// would pass for those of the run that replaces it.
///
/// # Errors
/// [`Error::Io`] when the system refuses.
pub fn remove(folder: &Path) -> Result<()> {
    let entries = std::fs::read_dir(folder).map_err(|e| Error::io(folder, e))?;
    for path in entries.flatten().map(|e| e.path()) {
        let part =
            |p: Option<&std::ffi::OsStr>| p.and_then(|p| p.to_str()).unwrap_or("").to_owned();
        let (stem, ending) = (part(path.file_stem()), part(path.extension()));
        let ours = RESULTS
            .iter()
            .any(|(begin, endings)| stem.starts_with(begin) && endings.contains(&ending.as_str()));
        if ours && path.is_file() {
            std::fs::remove_file(&path).map_err(|e| Error::io(&path, e))?;
        }
    }
    Ok(())
}
