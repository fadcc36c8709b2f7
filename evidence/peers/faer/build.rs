//! METIS orders for faer as it does for CHOLMOD.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-link-lib=metis");
}
