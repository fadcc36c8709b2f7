//! Cubic arrays of spheres against the Stokes flow of Zick and Homsy (1982), from dilute to touching:
//! where the scheme holds, and where it does not.

mod cell_support;

use std::f64::consts::PI;

use cell_support::{lattice, permeability};
use dempfv::Tensor;

/// Drag of a sphere over Stokes's: F = 6 π μ a K U, with F the mean gradient on its share of the cell
/// and U the mean velocity. From the permeability k = V / (6 π a K) of a volume V a sphere.
fn drag_factor(basis: usize, solid: f64) -> f64 {
    let volume = 1.0 / basis as f64;
    let a = (3.0 * solid * volume / (4.0 * PI)).cbrt();
    let (x, cell) = lattice(basis, 4, 1.0);
    let k = permeability(&x, &vec![a; x.len()], &cell);
    let mean = k.trace() / 3.0;
    assert!(
        (k - mean * Tensor::identity()).norm() < 1e-5 * mean,
        "a cubic array is isotropic: {k}"
    );
    volume / (6.0 * PI * a * mean)
}

/// Simple cubic arrays (Zick and Homsy 1982, table 2), and how many times their drag is found. The
/// hydraulic radius of a throat knows nothing of the distance over which a lone sphere drags: dilute
/// arrays are far too permeable. The scheme is for packings whose spheres touch.
#[test]
fn simple_cubic_arrays_from_dilute_to_touching() {
    let theory = [
        (0.027, 2.008, 0.284),
        (0.064, 2.810, 0.129),
        (0.125, 4.292, 0.218),
        (0.216, 7.442, 0.334),
        (0.343, 15.4, 0.506),
        (0.45, 28.1, 0.730),
        (PI / 6.0 - 1e-6, 42.1, 1.021),
    ];
    for (solid, expected, ratio) in theory {
        let found = drag_factor(1, solid) / expected;
        println!("simple cubic, {solid}: {found}");
        assert!((found - ratio).abs() < 2e-3, "{solid}: {found}, not {ratio}");
    }
}

/// Where spheres touch the scheme holds: within 3 % of simple and body-centred cubic arrays, within 9 %
/// of the face-centred one, the densest there is.
#[test]
fn arrays_that_touch() {
    let touching = [
        ("simple", 1, PI / 6.0, 42.1, 0.03),
        ("body-centred", 2, PI * 3f64.sqrt() / 8.0, 163.0, 0.03),
        ("face-centred", 4, PI * 2f64.sqrt() / 6.0, 435.0, 0.09),
    ];
    for (name, basis, solid, expected, error) in touching {
        let found = drag_factor(basis, solid - 1e-6) / expected;
        println!("{name}, touching: {found}");
        assert!((found - 1.0).abs() < error, "{name}: {found}");
    }
}
