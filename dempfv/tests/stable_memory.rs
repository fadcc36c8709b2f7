//! What others look at by its address: arrays of spheres stay where they are, and those of a network
//! as long as they are to be kept.

mod coupling_support;

use coupling_support::{COMPACT, advance, advance_to, finish, scene, start};
use dempfv::simulation::Simulation;

const RUN: &str = r#"
    [[stage]]
    kind = "run"
    name = "load"
    steps = 60
    walls = { y_max = { stress = 1.2e4 } }
"#;

/// Where the arrays of the spheres begin.
fn addresses(simulation: &Simulation) -> [usize; 8] {
    let dem = simulation.coupled().dem();
    let spheres = dem.storage();
    [
        spheres.id.as_ptr() as usize,
        spheres.position.as_ptr() as usize,
        spheres.velocity.as_ptr() as usize,
        spheres.spin.as_ptr() as usize,
        spheres.radius.as_ptr() as usize,
        spheres.mass.as_ptr() as usize,
        dem.storage_forces().as_ptr() as usize,
        dem.storage_torques().as_ptr() as usize,
    ]
}

/// Growth, the sorting at its end, neighbour lists, walls that move, remeshes: none moves an array.
#[test]
fn arrays_of_spheres_stay_where_they_are() {
    let fluid = "remesh_interval = 10";
    let mut simulation = start(&scene(100, fluid, &[COMPACT, RUN].concat()));
    let before = addresses(&simulation);
    let order = simulation.coupled().dem().storage().id.clone();
    assert_eq!(simulation.coupled().dem().storage_order(), 0);
    advance_to(&mut simulation, "load");
    assert_eq!(simulation.coupled().dem().storage_order(), 1);
    assert_ne!(simulation.coupled().dem().storage().id, order);
    assert_eq!(addresses(&simulation), before);
    finish(&mut simulation);
    assert!(simulation.remeshes() > 3);
    assert_eq!(addresses(&simulation), before);
}

/// A network that is to be kept is handed over with its arrays where they were, whatever puts it out of
/// use; the one after it is not, and nothing else changes.
#[test]
fn a_network_that_is_kept_stays_where_it_is() {
    for fluid in [
        "remesh_interval = 10",
        "remesh_interval = 10\nremesh = \"ahead\"",
        "remesh_interval = 10\nremesh = \"background\"",
        "remesh_interval = 10\nupdate = \"every step\"",
    ] {
        let stages = [COMPACT, RUN].concat();
        let mut alone = start(&scene(100, fluid, &stages));
        finish(&mut alone);
        let mut simulation = start(&scene(100, fluid, &stages));
        advance_to(&mut simulation, "load");
        advance(&mut simulation, 3);
        let seen = |simulation: &Simulation| {
            let flow = simulation.coupled().storage_flow().unwrap();
            let (network, pressure) = (flow.network(), flow.pressure());
            let cells = &network.tessellation.cells;
            let arrays = [network.center.as_ptr() as usize, pressure.as_ptr() as usize];
            ([cells.as_ptr() as usize, arrays[0], arrays[1]], cells.clone())
        };
        let (addresses, cells) = seen(&simulation);
        simulation.keep_network_arrays(true);
        assert!(simulation.take_retired_network().is_none());
        finish(&mut simulation);
        assert!(simulation.remeshes() > 4, "{fluid}");
        assert_eq!(simulation.state_hash(), alone.state_hash(), "{fluid}");
        let kept = simulation.take_retired_network().unwrap();
        let network = kept.network();
        assert_eq!(network.tessellation.cells, cells, "{fluid}");
        assert_eq!(
            [
                network.tessellation.cells.as_ptr() as usize,
                network.center.as_ptr() as usize,
                kept.pressure().as_ptr() as usize
            ],
            addresses,
            "{fluid}"
        );
        assert!(simulation.take_retired_network().is_none());
    }
}

/// One that nobody asks for any more is freed as ever.
#[test]
fn a_network_that_is_not_kept_is_not_handed_over() {
    let mut simulation = start(&scene(100, "remesh_interval = 10", &[COMPACT, RUN].concat()));
    advance_to(&mut simulation, "load");
    advance(&mut simulation, 3);
    simulation.keep_network_arrays(true);
    simulation.keep_network_arrays(false);
    finish(&mut simulation);
    assert!(simulation.take_retired_network().is_none());
}
