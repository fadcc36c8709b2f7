//! Bakes into the program what it was built from: the versions of the native
//! libraries' headers, of the compiler, and the revision of the sources.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // The -sys crates hand their headers' versions up.
    for (name, key) in [
        ("SUITESPARSE", "DEP_CHOLMOD_SUITESPARSE_VERSION"),
        ("CHOLMOD", "DEP_CHOLMOD_CHOLMOD_VERSION"),
        ("METIS", "DEP_CHOLMOD_METIS_VERSION"),
        ("CGAL", "DEP_DEMPFV_CGAL_VERSION"),
    ] {
        println!("cargo::rerun-if-env-changed={key}");
        bake(name, std::env::var(key).ok());
    }
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let version = output(&rustc, &["--version"]);
    bake("RUSTC", version.map(|text| text.trim_start_matches("rustc ").to_owned()));
    bake("GIT", git_revision());
}

fn bake(name: &str, value: Option<String>) {
    println!("cargo::rustc-env=DEMPFV_{name}_VERSION={}", value.as_deref().unwrap_or("unknown"));
}

/// The revision that is checked out; `None` outside of a git checkout of the
/// project, as in a packaged crate.
fn git_revision() -> Option<String> {
    // A package that lies inside some other repository has no revision of its own.
    if !Path::new("../.git").exists() {
        return None;
    }
    // A commit changes the branch's file (or the packed ones), a checkout changes HEAD.
    let branch = output("git", &["symbolic-ref", "--quiet", "HEAD"]);
    for name in ["HEAD", "packed-refs"].into_iter().chain(branch.as_deref()) {
        let file = output("git", &["rev-parse", "--git-path", name])?;
        // Cargo would take a file that does not exist for one that changed.
        if Path::new(&file).exists() {
            println!("cargo::rerun-if-changed={file}");
        }
    }
    output("git", &["rev-parse", "--short=12", "HEAD"])
}

/// What a command prints; `None` if it fails or is not there.
fn output(program: &str, args: &[&str]) -> Option<String> {
    let output = Command::new(program).args(args).output().ok().filter(|o| o.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?.trim().to_owned();
    (!text.is_empty()).then_some(text)
}
