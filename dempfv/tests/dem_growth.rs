//! Packings from random clouds, by growth of the radii.

mod dem_support;

use dem_support::{UNIT, settled, twin};
use dempfv::dem::{
    CloudScale, CloudSpec, DemError, DemOptions, GrowthCompaction, GrowthOptions, SizeDistribution,
    random_cloud,
};
use dempfv::{Vec3, WallId};

const DAMPED: DemOptions = DemOptions { damping: 0.2, gravity: None, rotation: true, skin: 0.2 };

/// The goal of the compaction, and what follows from it: equal forces on
/// opposite walls (equilibrium), the same stress from the walls as from the
/// contacts (Love's formula is exact at rest), a coordination number of a
/// frictional packing under load: 4 is the isostatic one.
#[test]
fn growth_settles_at_its_stress() {
    let mut dem = twin(1000, 1, DAMPED);
    let mut growth = GrowthCompaction::new(GrowthOptions::new(1e4, 1e6)).unwrap();
    let status = growth.run(&mut dem).unwrap();
    assert!(status.done && status.unbalanced < 1e-3);
    assert!((dem.mean_wall_stress() / 1e4 - 1.0).abs() < 1e-3);
    let stress = dem.stress();
    for wall in [WallId::XMin, WallId::YMin, WallId::ZMin] {
        let (a, b) = (dem.wall_stress(wall), dem.wall_stress(wall.opposite()));
        assert!((a - b).abs() < 2e-3 * a, "{wall}: {a} {b}");
        let k = wall.axis();
        assert!((stress[(k, k)] / a - 1.0).abs() < 2e-3, "{wall}: {stress} {a}");
    }
    assert!((4.0..6.5).contains(&dem.coordination_number()), "{}", dem.coordination_number());
    assert!((0.35..0.45).contains(&dem.porosity()), "{}", dem.porosity());
}

/// The growth law by hand: every ten steps the factor 1 + (σ_goal − σ)/σ_goal
/// (m − 1), with the smaller m from the first time on that σ passes the goal.
#[test]
fn growth_follows_its_law() {
    let mut dem = twin(300, 1, DAMPED);
    let options = GrowthOptions::new(1e4, 1e6);
    let mut growth = GrowthCompaction::new(options).unwrap();
    let (mut passed, mut after) = (false, 0);
    while after < 10 {
        let before = dem.radius(0);
        let status = growth.step(&mut dem).unwrap();
        let factor = dem.radius(0) / before;
        if !(status.steps - 1).is_multiple_of(10) {
            assert_eq!(factor, 1.0);
            continue;
        }
        passed |= status.stress > 1e4;
        after += usize::from(passed);
        let m = if passed { 1.0 + 2e3 / 1e6 } else { 1.0 + 2e4 / 1e6 };
        let expected = 1.0 + (1.0 - status.stress / 1e4) * (m - 1.0);
        assert!((factor - expected).abs() < 1e-14, "step {}", status.steps);
    }
}

#[test]
fn the_seed_decides() {
    let [a, b, c] = [(400, 3), (400, 3), (400, 4)]
        .map(|(count, seed)| dem_support::bits(&settled(count, seed, DAMPED)));
    assert!(a == b);
    assert!(a != c);
}

#[test]
fn growth_gives_up_with_a_reason() {
    let mut dem = twin(300, 1, DAMPED);
    let options = GrowthOptions { max_steps: 50, ..GrowthOptions::new(1e4, 1e6) };
    let error = GrowthCompaction::new(options).unwrap().run(&mut dem).unwrap_err();
    assert!(matches!(error, DemError::NotSettled { steps: 50, goal: 1e4, .. }), "{error}");
}

fn spec(sizes: SizeDistribution, scale: CloudScale) -> CloudSpec {
    CloudSpec { box_: UNIT, count: 500, sizes, scale, seed: 7 }
}

#[test]
fn a_cloud_has_no_overlaps_and_its_porosity() {
    let spread = 0.4;
    let cloud =
        random_cloud(&spec(SizeDistribution::Uniform { spread }, CloudScale::Porosity(0.7)))
            .unwrap();
    let mut solid = 0.0;
    for (k, (x, r)) in cloud.iter().enumerate() {
        assert!(x.min() >= *r && x.max() <= 1.0 - r);
        for (y, s) in &cloud[..k] {
            assert!((x - y).norm() >= r + s);
        }
        solid += 4.0 / 3.0 * std::f64::consts::PI * r.powi(3);
    }
    assert!((solid - 0.3).abs() < 1e-12);
    // The mean of 500 uniform numbers is within 4 standard deviations,
    // spread / √(3 · 500), of that of the distribution.
    let mean = cloud.iter().map(|(_, r)| r).sum::<f64>() / 500.0;
    let (low, high) = (cloud[499].1, cloud[0].1);
    let tolerance = 4.0 * spread / 1500f64.sqrt();
    assert!((0.5 * (low + high) / mean - 1.0).abs() < tolerance);
    assert!((high - low) / mean <= 2.0 * spread * (1.0 + tolerance));
}

#[test]
fn a_list_of_radii_is_followed_by_number() {
    let list = SizeDistribution::List(vec![(0.01, 3.0), (0.02, 1.0), (0.03, 1.0)]);
    let count = |cloud: &[(Vec3, f64)], r: f64| {
        cloud.iter().filter(|c| (c.1 / r - 1.0).abs() < 1e-12).count()
    };
    let cloud = random_cloud(&spec(list.clone(), CloudScale::AsListed)).unwrap();
    assert_eq!([0.01, 0.02, 0.03].map(|r| count(&cloud, r)), [300, 100, 100]);
    let cloud = random_cloud(&spec(list, CloudScale::MeanRadius(0.008))).unwrap();
    assert_eq!([0.005, 0.01, 0.015].map(|r| count(&cloud, r)), [300, 100, 100]);
}

#[test]
fn a_cloud_without_room_says_so() {
    let crowded = spec(SizeDistribution::Uniform { spread: 0.2 }, CloudScale::Porosity(0.4));
    let error = random_cloud(&crowded).unwrap_err();
    assert!(matches!(error, DemError::CloudFull { count: 500, .. }), "{error}");
}
