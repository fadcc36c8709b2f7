//! Conditions of a network beside constant pressures of walls: profiles, points, blocked pores, and
//! conductances that are not what the geometry says.

mod common;

use common::{Spheres, settled};
use dempfv::pfv::terms::{PoreSource, StepTerms};
use dempfv::pfv::{
    Assembled, Boundary, Clamp, ConductanceRegion, ConductanceRules, Flow, Fluid, ImposedPressure,
    NetworkConditions, PfvError, PoreSelection, PressureProfile,
};
use dempfv::solver::SolverKind;
use dempfv::{Aabb, Axis, Vec3, WallId};

const MU: f64 = 1e-3;

/// Pressures (Pa) on walls.
fn fluid(pressures: &[(WallId, f64)]) -> Fluid {
    let mut boundary = Boundary::default();
    for &(wall, pressure) in pressures {
        boundary.pressure[wall] = Some(pressure);
    }
    Fluid { viscosity: MU, slip_walls: true, clamp: Clamp::None, boundary }
}

/// 1 Pa below, none above.
fn upwards() -> Fluid {
    fluid(&[(WallId::YMin, 1.0), (WallId::YMax, 0.0)])
}

fn try_flow(s: &Spheres, fluid: &Fluid, of: NetworkConditions) -> Result<Flow, PfvError> {
    let terms = StepTerms::default();
    let assembled = Assembled::with_conditions(&s.x, &s.r, s.bounds, fluid, of, terms)?;
    assembled.analyze(SolverKind::Cholmod, None)?.factor()
}

/// The static flow under these conditions.
fn flow(s: &Spheres, fluid: &Fluid, conditions: NetworkConditions) -> Flow {
    let mut flow = try_flow(s, fluid, conditions).unwrap();
    flow.solve_static().unwrap();
    flow
}

fn ruled(conductances: ConductanceRules) -> NetworkConditions {
    NetworkConditions { conductances, ..NetworkConditions::default() }
}

fn darcy(k: f64) -> NetworkConditions {
    ruled(ConductanceRules { darcy_permeability: Some(k), ..Default::default() })
}

fn in_box(min: Vec3, max: Vec3) -> PoreSelection {
    PoreSelection::Within { min, max }
}

/// The middle tenth of the box in each direction.
fn core(b: &Aabb) -> PoreSelection {
    in_box(b.center() - 0.1 * b.size(), b.center() + 0.1 * b.size())
}

/// The line between two power centres is normal to their facet, so that a pressure that is linear in
/// space solves the discrete equations of a uniform Darcy medium: its permeability is the one that it
/// is told, along each axis, to round-off (1e-9; short throats between coinciding centres take digits).
#[test]
fn a_darcy_medium_has_its_permeability() {
    let s = settled();
    for axis in Axis::ALL {
        let [low, high] = axis.walls();
        let flow = flow(&s, &fluid(&[(low, 1.0), (high, 0.0)]), darcy(3e-10));
        let found = flow.permeability(low).unwrap();
        assert!((found.value / 3e-10 - 1.0).abs() < 1e-9, "{axis:?}: {}", found.value);
        assert!(found.imbalance < 1e-9, "{axis:?}: {}", found.imbalance);
    }
}

/// The same with a profile: where all six walls have the pressure a + b x, two of them by a number and
/// four by a straight line along x, so has each pore at its power centre, to 1e-9 of the difference.
#[test]
fn a_linear_profile_makes_a_linear_pressure() {
    let s = settled();
    let (low, high) = (s.bounds.min.x, s.bounds.max.x);
    let ends = [50.0, 80.0];
    let at = |x: f64| ends[0] + (ends[1] - ends[0]) * (x - low) / (high - low);
    let mut conditions = darcy(1e-10);
    for wall in [WallId::YMin, WallId::YMax, WallId::ZMin, WallId::ZMax] {
        // Above the wall's own 45 Pa.
        let points = vec![[low, ends[0] - 45.0], [high, ends[1] - 45.0]];
        conditions.profiles[wall] = Some(PressureProfile { along: Axis::X, points });
    }
    let along = WallId::ALL[2..].iter().map(|w| (*w, 45.0));
    let walls: Vec<_> =
        [(WallId::XMin, ends[0]), (WallId::XMax, ends[1])].into_iter().chain(along).collect();
    let flow = flow(&s, &fluid(&walls), conditions);
    for (p, x) in flow.pressure().iter().zip(&flow.network().center) {
        assert!((p - at(x.x.clamp(low, high))).abs() < 1e-9 * 30.0, "{p} at {}", x.x);
    }
    // Nothing is said of a permeability between walls whose pressure varies.
    assert!(flow.permeability(WallId::YMin).is_none());
}

/// A table: pores have what straight lines between its points say, and the first and last value beyond.
#[test]
fn a_table_holds_along_its_wall() {
    let s = settled();
    let (low, high) = (s.bounds.min.z, s.bounds.max.z);
    let [a, b] = [0.3, 0.6].map(|share| low + share * (high - low));
    let mut conditions = NetworkConditions::default();
    let profile = PressureProfile { along: Axis::Z, points: vec![[a, 2.0], [b, -4.0]] };
    conditions.profiles[WallId::XMin] = Some(profile);
    let flow = flow(&s, &fluid(&[(WallId::XMin, 1.0), (WallId::XMax, 0.0)]), conditions);
    let (mut below, mut above) = (0, 0);
    for (i, x) in flow.network().center.iter().enumerate() {
        if flow.operators().conditions().wall_of(i) == Some(WallId::XMin) {
            let share = ((x.z - a) / (b - a)).clamp(0.0, 1.0);
            assert!((flow.pressure()[i] - (3.0 - 6.0 * share)).abs() < 1e-12);
            (below, above) = (below + u32::from(share == 0.0), above + u32::from(share == 1.0));
        }
    }
    assert!(below > 10 && above > 10);
    assert!(flow.imbalance() < 1e-11, "{}", flow.imbalance());
}

/// All conductances times a factor make the flux times that factor from the same pressures: bit for
/// bit with a power of two, by one number or by a region that holds every pore.
#[test]
fn a_factor_of_all_conductances_is_one_of_the_flux() {
    let s = settled();
    let plain = flow(&s, &upwards(), NetworkConditions::default());
    let all = in_box(s.bounds.min - s.bounds.size(), s.bounds.max + s.bounds.size());
    let regions = vec![ConductanceRegion { pores: all, factor: 4.0 }];
    for rules in [
        ConductanceRules { factor: Some(4.0), ..Default::default() },
        ConductanceRules { regions, ..Default::default() },
    ] {
        let scaled = flow(&s, &upwards(), ruled(rules));
        assert_eq!(scaled.pressure(), plain.pressure());
        assert_eq!(scaled.flux(), plain.flux().map(|q| 4.0 * q));
        assert_eq!(scaled.force(), plain.force());
    }
}

/// Halves of a throat are in series: 2 / (1/m + 1) between a pore of a region and one beside it, m
/// within.
#[test]
fn throats_at_the_edge_of_a_region_are_halves_in_series() {
    let s = settled();
    let plain = flow(&s, &upwards(), NetworkConditions::default());
    let pores = core(&s.bounds);
    let chosen = ImposedPressure { pores: pores.clone(), pressure: 0.5 };
    let marked =
        try_flow(&s, &upwards(), NetworkConditions { imposed: vec![chosen], ..Default::default() })
            .unwrap();
    let within = |i: u32| marked.operators().conditions().set_of(i as usize) == Some(6);
    let regions = vec![ConductanceRegion { pores, factor: 0.1 }];
    let ruled = flow(&s, &upwards(), ruled(ConductanceRules { regions, ..Default::default() }));
    let (throats, before) = (&ruled.network().throats, &plain.network().throats);
    let mut seen = [0; 3];
    for ((&[i, j], g), was) in
        throats.pores.iter().zip(&throats.conductance).zip(&before.conductance)
    {
        let inside = usize::from(within(i)) + usize::from(within(j));
        let expected = [1.0, 2.0 / 11.0, 0.1][inside];
        assert!((g / was - expected).abs() < 1e-12 || *was == 0.0, "{inside}: {}", g / was);
        seen[inside] += 1;
    }
    assert!(seen.iter().all(|n| *n > 10), "{seen:?}");
}

/// Nothing flows through blocked pores: the flux around them is that of pores that conduct 1e-9 as
/// well, to 1e-6, and less than without; what enters leaves. A blocked layer stops it altogether, and
/// each side has the pressure of its wall.
#[test]
fn blocked_pores_let_nothing_through() {
    let s = settled();
    let plain = flow(&s, &upwards(), NetworkConditions::default()).flux()[2];
    let blocked = ConductanceRules { blocked: vec![core(&s.bounds)], ..Default::default() };
    let regions = vec![ConductanceRegion { pores: core(&s.bounds), factor: 1e-9 }];
    let nearly = ConductanceRules { regions, ..Default::default() };
    let around = flow(&s, &upwards(), ruled(blocked));
    let flux = around.flux()[2];
    assert!(flux > 0.0 && flux < 0.999 * plain, "{flux} {plain}");
    let limit = flow(&s, &upwards(), ruled(nearly)).flux()[2];
    assert!((flux / limit - 1.0).abs() < 1e-6, "{flux} {limit}");
    assert!(around.imbalance() < 1e-11);
    let held: Vec<usize> =
        (0..around.network().pores()).filter(|&i| around.network().is_blocked(i)).collect();
    assert!(held.len() > 10 && held.iter().all(|&i| around.pressure()[i] == 0.5));

    let Aabb { min, max } = s.bounds;
    let (mut low, mut high) = (min, max);
    (low.y, high.y) = (min.y + 0.4 * (max.y - min.y), min.y + 0.6 * (max.y - min.y));
    let layer = ConductanceRules { blocked: vec![in_box(low, high)], ..Default::default() };
    let stopped = flow(&s, &upwards(), ruled(layer));
    assert_eq!(stopped.flux()[2], 0.0);
    let center = &stopped.network().center;
    for (i, p) in stopped.pressure().iter().enumerate() {
        if !stopped.network().is_blocked(i) && (center[i].y < low.y || center[i].y > high.y) {
            let expected = if center[i].y < low.y { 1.0 } else { 0.0 };
            assert!((p - expected).abs() < 1e-9, "{p} at {}", center[i].y);
        }
    }
}

/// Points stand for the pores that contain them, each once, with a pressure or a source.
#[test]
fn points_stand_for_their_pores() {
    let s = settled();
    let b = s.bounds;
    let points: Vec<Vec3> = [0.3, 0.5, 0.7]
        .iter()
        .map(|y| b.min + Vec3::new(0.5, *y, 0.5).component_mul(&b.size()))
        .collect();
    let twice: Vec<Vec3> = points.iter().chain(&points).copied().collect();
    let by_points = ImposedPressure { pores: PoreSelection::At(twice), pressure: 7.0 };
    let mut injected =
        flow(&s, &upwards(), NetworkConditions { imposed: vec![by_points], ..Default::default() });
    let network = injected.network();
    let expected: Vec<u32> =
        points.iter().map(|x| network.tessellation.locate(&s.x, x).unwrap()).collect();
    let set = |i: &usize| injected.operators().conditions().set_of(*i) == Some(6);
    let found: Vec<u32> = (0..network.pores()).filter(set).map(|i| i as u32).collect();
    assert!(found.len() == 3 && expected.iter().all(|i| found.contains(i)));
    assert!(expected.iter().all(|&i| injected.pressure()[i as usize] == 7.0));

    // The pressure changes without another factor; the flux goes with it.
    let before = injected.imposed_flux()[0];
    injected.set_imposed_pressure(0, 14.0).unwrap();
    injected.solve_static().unwrap();
    assert!(expected.iter().all(|&i| injected.pressure()[i as usize] == 14.0));
    assert!(injected.imposed_flux()[0] > 2.0 * before);
    assert_eq!(injected.imposed_pressures()[0].pressure, 14.0);
    for (number, pressure) in [(1, 1.0), (usize::MAX, 1.0), (0, f64::NAN)] {
        assert!(injected.set_imposed_pressure(number, pressure).is_err(), "{number} {pressure}");
    }
}

/// A point source between two drained walls: what goes in comes out through both, to 1e-12 of it, at
/// any rate that it is told later.
#[test]
fn a_point_source_leaves_through_both_drained_walls() {
    let s = settled();
    let drained = fluid(&[(WallId::YMin, 0.0), (WallId::YMax, 0.0)]);
    let mut flow = try_flow(&s, &drained, NetworkConditions::default()).unwrap();
    flow.set_tolerance(1e-14).unwrap();
    let pores = PoreSelection::At(vec![s.bounds.center()]);
    flow.set_sources(&s.x, &[PoreSource { pores, rate: 1.0 }]).unwrap();
    for rate in [1e-6, -3e-3, 1e-12] {
        flow.set_source_rate(0, rate).unwrap();
        flow.solve_static().unwrap();
        let flux = flow.flux();
        let (below, above) = (-flux[2] / rate, -flux[3] / rate);
        assert!((below + above - 1.0).abs() < 1e-12, "{rate}: {:e}", below + above - 1.0);
        assert!(below > 0.1 && above > 0.1);
    }
    assert!(flow.set_source_rate(1, 1.0).is_err() && flow.set_source_rate(0, f64::NAN).is_err());
}

/// What cannot be is refused with its place, before anything is factored.
#[test]
fn conditions_that_cannot_be_are_refused() {
    let s = settled();
    let nowhere = PoreSelection::Around { center: Vec3::repeat(-9.0), radius: 0.1 };
    let wall = WallId::YMin;
    let profile = |wall: WallId, along, points| {
        let mut conditions = NetworkConditions::default();
        conditions.profiles[wall] = Some(PressureProfile { along, points });
        conditions
    };
    let rules = |rules: ConductanceRules| ruled(rules);
    let region = |pores: &PoreSelection, factor| {
        let regions = vec![ConductanceRegion { pores: pores.clone(), factor }];
        ruled(ConductanceRules { regions, ..Default::default() })
    };
    let imposed = |pores: PoreSelection| NetworkConditions {
        imposed: vec![ImposedPressure { pores, pressure: 1.0 }],
        ..ruled(ConductanceRules { blocked: vec![core(&s.bounds)], ..Default::default() })
    };
    let line = vec![[0.0, 1.0], [1.0, 2.0]];
    for (wrong, says) in [
        (profile(wall, Axis::Y, line.clone()), "normal to"),
        (profile(wall, Axis::X, vec![]), "no function of the coordinate"),
        (profile(wall, Axis::X, vec![[1.0, 1.0], [0.0, 2.0]]), "no function of the coordinate"),
        (profile(WallId::XMin, Axis::Y, line), "imposes no pressure"),
        (darcy(0.0), "positive"),
        (rules(ConductanceRules { factor: Some(f64::NAN), ..Default::default() }), "positive"),
        (region(&core(&s.bounds), -1.0), "positive"),
        (region(&nowhere, 1.0), "selects no pore"),
        (region(&PoreSelection::Pores(vec![u32::MAX - 1]), 1.0), "of a network of"),
        (
            rules(ConductanceRules { blocked: vec![nowhere.clone()], ..Default::default() }),
            "no pore",
        ),
        (imposed(core(&s.bounds)), "is blocked"),
        (imposed(PoreSelection::At(vec![Vec3::repeat(-9.0)])), "lies in no pore"),
    ] {
        let error = try_flow(&s, &upwards(), wrong).unwrap_err().to_string();
        assert!(error.contains(says), "{says}: {error}");
    }
}
