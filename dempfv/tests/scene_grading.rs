//! Gradings by mass, and compaction that keeps them.

mod coupling_support;

use coupling_support::{advance, finish, plan, start};
use dempfv::scene::{ParticleSource, Plan, Sizes};
use dempfv::simulation::{Grading, Simulation};

fn scene(cloud: &str, compact: &str) -> String {
    format!(
        "seed = 2\n[box]\nmin = [0, 0, 0]\nmax = [0.01, 0.01, 0.01]\n\
         [particles]\nyoung = 1e7\ncloud = {{ count = 400, {cloud} }}\n[dem]\n\
         [[stage]]\nkind = \"compact\"\nstress = 2e4\nfriction_angle = 5\n{compact}\n"
    )
}

/// Diameters in m of the first state of a scene, ascending.
fn diameters(text: &str) -> Vec<f64> {
    let simulation = Simulation::new(plan(text)).unwrap();
    let mut d: Vec<f64> = simulation.coupled().dem().radii().iter().map(|r| 2.0 * r).collect();
    d.sort_by(f64::total_cmp);
    d
}

/// Two classes with half of the mass each: (r₂/r₁)³ = 8 fine spheres for each coarse one, so 356 and 44
/// of 400, to whole spheres; by number they would be 200 and 200.
#[test]
fn classes_may_be_shares_of_the_mass() {
    let by = |by: &str| {
        diameters(&scene(&format!("sizes = [[3e-4, 0.5], [6e-4, 0.5]], sizes_by = \"{by}\""), ""))
    };
    let fine = |d: &[f64]| d.iter().filter(|d| **d < 1e-3).count();
    let mass = by("mass");
    assert!((fine(&mass) as f64 - 400.0 * 8.0 / 9.0).abs() <= 0.5, "{}", fine(&mass));
    assert_eq!(fine(&by("number")), 200);
    let radii: Vec<f64> = mass.iter().map(|d| 0.5 * d).collect();
    let grading = Grading::of(&radii).unwrap();
    assert_eq!(grading.classes.len(), 2);
    // One coarse sphere more or less is 1/88 of the mass.
    assert!((grading.classes[1].mass_share - 0.5).abs() < 1.0 / 88.0);
}

/// A curve's quantiles by mass come out: d10, d50, d90 lie where the curve has them, to one sphere of the
/// size there.
#[test]
fn a_curve_has_its_quantiles() {
    let d = diameters(&scene("curve = [[5e-4, 0.0], [8e-4, 0.4], [1.2e-3, 1.0]]", ""));
    let radii: Vec<f64> = d.iter().map(|d| 0.5 * d).collect();
    let grading = Grading::of(&radii).unwrap();
    // Straight over ln d.
    let at = |p: f64| match p <= 0.4 {
        true => 5e-4 * (8.0_f64 / 5.0).powf(p / 0.4),
        false => 8e-4 * (12.0_f64 / 8.0).powf((p - 0.4) / 0.6),
    };
    for (found, p) in [(grading.d10_m, 0.1), (grading.d50_m, 0.5), (grading.d90_m, 0.9)] {
        assert!((found / at(p) - 1.0).abs() < 0.01, "{p}: {found} {}", at(p));
    }
    assert!((grading.uniformity / (at(0.6) / at(0.1)) - 1.0).abs() < 0.01);
    let normal = diameters(&scene("log_normal = { median = 7e-4, deviation = 0.2 }", ""));
    let radii: Vec<f64> = normal.iter().map(|d| 0.5 * d).collect();
    let grading = Grading::of(&radii).unwrap();
    assert!((grading.d50_m / 7e-4 - 1.0).abs() < 0.01, "{}", grading.d50_m);
    // Φ(-1.2816) = 0.1; the cut at 2.5 deviations moves it by less than a hundredth.
    assert!((grading.d10_m / (7e-4 * (-0.2 * 1.2816_f64).exp()) - 1.0).abs() < 0.015);
}

/// With `keep_radii` the radii have the very bits that they began with, and the packing is that of growth
/// in a smaller box: at its stress, with its porosity to 0.01, all three edges alike; the walls' ways
/// are those of the box.
#[test]
fn compaction_keeps_diameters_where_it_is_told() {
    let cloud = "curve = [[5e-4, 0.0], [8e-4, 0.4], [1.2e-3, 1.0]]";
    let finished = |compact: &str| {
        let mut simulation = start(&scene(cloud, compact));
        finish(&mut simulation);
        simulation
    };
    let (grown, kept) = (finished(""), finished("keep_radii = true"));
    let first = Simulation::new(plan(&scene(cloud, ""))).unwrap();
    assert_eq!(kept.coupled().dem().radii(), first.coupled().dem().radii());
    let [a, b] = [&grown, &kept].map(|s| s.coupled().dem());
    assert!((b.mean_wall_stress() / 2e4 - 1.0).abs() < 1e-3, "{}", b.mean_wall_stress());
    assert!((a.porosity() - b.porosity()).abs() < 0.01, "{} {}", a.porosity(), b.porosity());
    let (size, before) = (b.box_().size(), a.box_().size());
    assert!(size.max() < 0.99 * before.max() && (size.max() / size.min() - 1.0).abs() < 1e-12);
    assert_eq!(b.box_().min, a.box_().min);
    let moved = b.walls()[dempfv::WallId::YMax].displacement;
    assert!((before.y + moved - size.y).abs() < 1e-12 * before.y);
    // What the radii have grown by, the box has shrunk by, to the packings' scatter.
    let growth = a.radius(0) / b.radius(0);
    assert!((growth * size.x / before.x - 1.0).abs() < 0.02, "{growth} {}", size.x);
}

/// In a periodic cell too; and a restart in the midst of it has the bits of a run that did not stop.
#[test]
fn a_cell_shrinks_and_a_restart_goes_on() {
    let cell = |compact: &str| {
        scene("radius = 5e-4, spread = 0.2", compact).replace(
            "[box]\nmin = [0, 0, 0]\nmax = [0.01, 0.01, 0.01]",
            "[cell]\nsize = [0.012, 0.012, 0.012]",
        )
    };
    for text in [cell("keep_radii = true"), scene("radius = 5e-4", "keep_radii = true")] {
        let mut whole = start(&text);
        let radii = whole.coupled().dem().radii();
        advance(&mut whole, 333);
        let state = whole.state();
        finish(&mut whole);
        assert_eq!(whole.coupled().dem().radii(), radii);
        let mut again = Simulation::restart(plan(&text), state).unwrap();
        finish(&mut again);
        assert_eq!(again.state_hash(), whole.state_hash());
    }
}

/// Clumps stay rigid while the box shrinks: members keep their distance, and the packing its radii.
#[test]
fn clumps_keep_their_shape() {
    let text = scene("radius = 5e-4", "keep_radii = true")
        .replace("count = 400", "count = 100")
        .replace("young = 1e7", "young = 1e7\nclump = [[0.5, 0, 0, 0.5], [-0.5, 0, 0, 0.5]]");
    let lengths = |simulation: &Simulation| -> Vec<f64> {
        let dem = simulation.coupled().dem();
        let members = |k: usize| (dem.position(2 * k), dem.position(2 * k + 1));
        (0..dem.len() / 2).map(members).map(|(a, b)| (a - b).norm()).collect()
    };
    let mut simulation = start(&text);
    assert_eq!(simulation.coupled().dem().clumps().count(), 100);
    let (before, size) = (lengths(&simulation), simulation.coupled().dem().box_().size());
    finish(&mut simulation);
    for (a, b) in lengths(&simulation).iter().zip(&before) {
        assert!((a / 5e-4 - 1.0).abs() < 1e-9 && (a / b - 1.0).abs() < 1e-9, "{a} {b}");
    }
    assert!(simulation.coupled().dem().box_().size().x < 0.9 * size.x);
}

#[test]
fn gradings_survive_a_round_trip_and_wrong_ones_are_refused() {
    for cloud in [
        "curve = [[5e-4, 0.0], [8e-4, 0.4], [1.2e-3, 1.0]]",
        "log_normal = { median = 7e-4, deviation = 0.2 }",
        "sizes = [[3e-4, 0.25], [6e-4, 0.75]], sizes_by = \"mass\"",
    ] {
        let read = plan(&scene(cloud, "keep_radii = true"));
        assert_eq!(plan(&read.to_toml()), read, "{cloud}");
        let ParticleSource::Cloud(cloud) = &read.particles.source else { panic!("no cloud") };
        assert!(cloud.sizes.smallest() < cloud.sizes.largest());
        assert!(!matches!(cloud.sizes, Sizes::Uniform { .. }));
    }
    for (cloud, problem) in [
        ("curve = [[5e-4, 0.0], [4e-4, 1.0]]", "is no grading curve"),
        ("curve = [[5e-4, 0.1], [8e-4, 1.0]]", "from 0.0 at the first"),
        ("curve = [[5e-4, 0.0], [8e-4, 90.0]]", "to 1.0 at the last"),
        ("curve = [[5e-4]]", "no pair"),
        ("log_normal = { median = 7e-4 }", "no `deviation`"),
        ("log_normal = { median = 7e-4, deviation = 2.0 }", "0.001 to 1.0"),
        ("radius = 5e-4, sizes_by = \"mass\"", "stands beside `radius`"),
        ("radius = 5e-4, curve = [[5e-4, 0.0], [8e-4, 1.0]]", "more than one of"),
        ("curve = [[5e-4, 0.0], [8e-4, 1.0]], spread = 0.2", "stands beside `curve`"),
        ("sizes = [[3e-4, 1.0]], sizes_by = \"weight\"", "is \"weight\""),
    ] {
        let error = Plan::from_toml(&scene(cloud, ""), None).unwrap_err();
        let said = format!("{} {}", error.what, error.remedy);
        assert!(said.contains(problem) && error.line.is_some(), "{cloud}: {said}");
    }
}
