//! Hard case 14: violent motion while the network is out of date. A criterion of strain brings new
//! networks soon enough that the fluid's force does not jump where one comes into use.

use dempfv::WallId;
use dempfv::scene::Plan;
use dempfv::simulation::Simulation;

const PACKING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../packings/oedometer-1000.txt");

fn squeezed(viscosity: f64, wall: &str, remesh: &str) -> Simulation {
    let text = format!(
        r#"
        [particles]
        packing = "{PACKING}"
        young = 1.0e7
        friction_angle = 30.0
        [dem]
        damping = 0.2
        [fluid]
        viscosity = {viscosity:e}
        remesh = "{remesh}"
        remesh_strain = 0.005
        pressure = {{ y_max = 0.0 }}
        [[stage]]
        kind = "run"
        steps = 100_000
        walls = {{ {wall} }}
        "#
    );
    Simulation::new(Plan::from_toml(&text, None).unwrap_or_else(|e| panic!("{e}"))).unwrap()
}

/// The fluid's force on the wall opposite the drained one, step by step, while the drained wall comes
/// in by twice and by forty times the height of the box in a second, in water and in syrup: where a
/// new network comes into use, the force changes by less than 3 % of its largest value.
#[test]
fn the_force_does_not_jump_where_a_network_comes_into_use() {
    let (once, beside) = ("at once", "background");
    for (viscosity, velocity, remesh) in
        [(1e-3, 0.05, once), (1e-3, 1.0, beside), (1.0, 0.05, beside), (1.0, 0.5, once)]
    {
        let wall = format!("y_max = {{ velocity = -{velocity:?} }}");
        let mut simulation = squeezed(viscosity, &wall, remesh);
        let (mut before, mut largest, mut jump, mut swaps) = (0.0, 0.0f64, 0.0f64, 0);
        let mut networks = 0;
        for step in 0..300 {
            simulation.advance().unwrap();
            let coupled = simulation.coupled();
            let force = coupled.observe().fluid_stress[WallId::YMin.index()];
            largest = largest.max(force.abs());
            // In the first steps the walls set the fluid in motion.
            if step > 20 && coupled.remeshes() > networks {
                jump = jump.max((force - before).abs());
                swaps += 1;
            }
            (before, networks) = (force, coupled.remeshes());
        }
        let case = format!("μ = {viscosity}, {velocity} m/s, {remesh}");
        println!("{case}: {swaps} swaps, {:.4}", jump / largest);
        assert!(swaps > 3, "{case}: {swaps} swaps");
        assert!(jump < 0.03 * largest, "{case}: {jump} of {largest}");
    }
}
