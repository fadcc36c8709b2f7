//! The state of the material in the history, against what wall motions and pressures give by
//! hand.

mod coupling_support;

use coupling_support::plan;
use dempfv::io::history::Value;
use dempfv::simulation::{Simulation, history};

/// A number of the row of the moment.
fn number(simulation: &Simulation, name: &str) -> f64 {
    let columns = history::columns(simulation.plan());
    let mut row = vec![];
    history::row(simulation, &mut row);
    assert_eq!(columns.len(), row.len());
    let at = columns.iter().position(|c| c == name).unwrap_or_else(|| panic!("no {name}"));
    match row[at] {
        Value::Float(x) => x,
        Value::Count(n) => n as f64,
        Value::Text(text) => panic!("{name} is {text}"),
    }
}

/// The shipped packing in water under gravity, pressed from above and drawn out along x.
const SCENE: &str = r#"
    [particles]
    packing = "PACKING"
    [dem]
    dt = 1e-5
    gravity = [0.0, -9.81, 0.0]
    [fluid]
    viscosity = 1e-3
    density = 1000.0
    pressure = { y_max = 0.0 }
    [[stage]]
    kind = "run"
    steps = 100
    walls = { y_max = { velocity = -0.01 }, x_min = { velocity = -0.004 }, x_max = { velocity = 0.002 } }
    [output]
    state = true
    energy = false
    probes = [[0.011, 0.01, 0.011]]
    regions = [{ min = [-1, -1, -1], max = [1, 1, 1] }]
"#;

fn scene() -> String {
    let packing = concat!(env!("CARGO_MANIFEST_DIR"), "/../packings/oedometer-1000.txt");
    SCENE.replace("PACKING", packing)
}

/// Walls that move by 1e-5 m at the top, and by 6e-6 m apart along x: ln(L₀/L) each, and their sum. The
/// stress of the contacts is the library's, its invariants are those of its six components; the
/// region is the whole box, with its porosity and its mean pressure; the total pressure at a point
/// is the excess one and ρ_f g h.
#[test]
fn the_state_of_the_material_is_in_the_row() {
    let mut simulation = Simulation::new(plan(&scene())).unwrap();
    let size = simulation.coupled().dem().box_().size();
    while simulation.advance().unwrap() {}
    let of = |name: &str| number(&simulation, name);
    let strain = [(size.x / (size.x + 6e-6)).ln(), (size.y / (size.y - 1e-5)).ln(), 0.0];
    for (name, expected) in ["strain_x", "strain_y", "strain_z"].into_iter().zip(strain) {
        assert!((of(name) - expected).abs() < 1e-12, "{name}: {} {expected}", of(name));
    }
    assert!((of("volumetric_strain") - strain.iter().sum::<f64>()).abs() < 1e-12);

    let dem = simulation.coupled().dem();
    let stress = dem.stress();
    let [xx, yy, zz] = ["xx", "yy", "zz"].map(|c| of(&format!("effective_stress_{c}_pa")));
    let [xy, xz, yz] = ["xy", "xz", "yz"].map(|c| of(&format!("effective_stress_{c}_pa")));
    assert!((yy / stress[(1, 1)] - 1.0).abs() < 1e-12);
    assert!((of("p_effective_pa") / ((xx + yy + zz) / 3.0) - 1.0).abs() < 1e-12);
    // By the textbook's six components: q² = ½ Σ (σ_i − σ_j)² + 3 Σ τ².
    let differences = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
    let q = (0.5 * differences + 3.0 * (xy * xy + xz * xz + yz * yz)).sqrt();
    assert!((of("q_pa") / q - 1.0).abs() < 1e-12);
    let fabric: f64 = ["xx", "yy", "zz"].map(|c| of(&format!("fabric_{c}"))).iter().sum();
    assert!((fabric - 1.0).abs() < 1e-12);
    assert!(
        of("rattlers") > 0.0
            && of("coordination_number_mechanical") > of("coordination_number_spheres")
    );

    let pressure = simulation.coupled().storage_flow().unwrap().pressure();
    let smallest = pressure.iter().copied().fold(f64::INFINITY, f64::min);
    assert_eq!(of("smallest_pressure_pa"), smallest);
    assert!(
        smallest < of("mean_pressure_pa") && of("mean_pressure_pa") < of("largest_pressure_pa")
    );
    // Overlaps with walls, which the region leaves out, are 1e-3 of the spheres at most.
    assert!((of("region_1_porosity") - of("porosity")).abs() < 1e-3);
    assert!((of("region_1_pressure_pa") / of("mean_pressure_pa") - 1.0).abs() < 1e-9);
    let depth = dem.box_().max.y - 0.01;
    let hydrostatic = of("probe_1_total_pressure_pa") - of("probe_1_pressure_pa");
    assert!((hydrostatic / (1000.0 * 9.81 * depth) - 1.0).abs() < 1e-3, "{hydrostatic}");
}

/// What nobody asks for is not there.
#[test]
fn the_state_is_in_no_history_that_does_not_ask() {
    let text = scene();
    let asked = history::columns(&plan(&text));
    let (before, _) = text.split_once("[output]").unwrap();
    let plain = history::columns(&plan(before));
    for name in ["strain_x", "q_pa", "fabric_xx", "region_1_porosity", "probe_1_total_pressure_pa"]
    {
        assert!(asked.iter().any(|c| c == name), "{name}");
        assert!(!plain.iter().any(|c| c == name), "{name}");
    }
}
