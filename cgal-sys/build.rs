//! Compiles the shim against the installed CGAL headers. Where docs.rs builds the
//! documentation there are none, and nothing is linked.

use std::path::{Path, PathBuf};
use std::process::exit;

fn main() {
    println!("cargo::rerun-if-changed=src/shim.h");
    println!("cargo::rerun-if-changed=src/shim.cc");
    println!("cargo::rerun-if-env-changed=CGAL_INCLUDE_DIR");
    println!("cargo::rerun-if-env-changed=DOCS_RS");
    if std::env::var_os("DOCS_RS").is_some() {
        println!("cargo::rustc-env=CGAL_SYS_VERSION=unknown");
        return;
    }
    let include = find_headers();
    let version = read_version(&include.join("CGAL/version.h"));
    println!("cargo::rustc-env=CGAL_SYS_VERSION={version}");
    println!("cargo::metadata=version={version}");

    cxx_build::bridge("src/lib.rs")
        .file("src/shim.cc")
        .include(&include)
        .std("c++17")
        // CGAL's interval arithmetic switches the rounding mode; the compiler
        // must not move or fold arithmetic across that, whatever the profile.
        .flag_if_supported("-frounding-math")
        .opt_level(3)
        .define("NDEBUG", None)
        .flag_if_supported("-w")
        .compile("dempfv_cgal_shim");
    println!("cargo::rustc-link-lib=mpfr");
    println!("cargo::rustc-link-lib=gmp");
}

/// The folder that holds `CGAL/`, or one message and the end.
fn find_headers() -> PathBuf {
    let asked = std::env::var_os("CGAL_INCLUDE_DIR").map(PathBuf::from);
    let usual = ["/usr/include", "/usr/local/include", "/opt/homebrew/include"].map(PathBuf::from);
    let found = asked
        .into_iter()
        .chain(usual)
        .find(|dir| dir.join("CGAL/Regular_triangulation_3.h").exists());
    match found {
        Some(dir) => dir,
        None => {
            println!(
                "cargo::error=cgal-sys needs the headers of CGAL (5.5 or newer) with GMP and MPFR, and found none; \
                 on Debian install the package libcgal-dev, elsewhere set CGAL_INCLUDE_DIR to the folder that holds CGAL/"
            );
            exit(1);
        }
    }
}

fn read_version(header: &Path) -> String {
    println!("cargo::rerun-if-changed={}", header.display());
    std::fs::read_to_string(header)
        .unwrap_or_default()
        .lines()
        .find_map(|line| line.strip_prefix("#define CGAL_VERSION ").map(|v| v.trim().to_owned()))
        .unwrap_or_else(|| "unknown".to_owned())
}
