//! What a plan will cost, before anything is built.
//!
//! Counts and rates were fitted to settled packings of 1,000 to 135,000 spheres of similar
//! size on two cores of a server of 2022; they are right within a factor of two or so on
//! other machines and packings. Where exact counts are known, they are used.

use serde::Serialize;

use crate::coupling::{OnFailure, RemeshMode, TimeStepBounds, Update, viscous_time_step};
use crate::scene::*;

/// What is known about the spheres and pores of a plan.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Specimen {
    /// Number of spheres.
    pub spheres: usize,
    /// Smallest radius (m).
    pub smallest_radius: f64,
    /// Number of pores, if the packing has been triangulated.
    pub pores: Option<usize>,
    /// Number of unknown pressures, if the network is known.
    pub unknowns: Option<usize>,
    /// Entries of the Cholesky factor, if the matrix has been analysed.
    pub factor_entries: Option<usize>,
    /// Bounds on the time step, if they were computed for the packing itself.
    pub bounds: Option<TimeStepBounds>,
}

impl Specimen {
    /// A packing with these radii (m).
    pub fn of_radii(radii: &[f64]) -> Specimen {
        Specimen {
            spheres: radii.len(),
            smallest_radius: radii.iter().copied().fold(f64::INFINITY, f64::min),
            ..Specimen::default()
        }
    }

    /// The cloud of a plan, with its radii grown to a porosity of 0.4 when the plan
    /// compacts it; `None` when the plan starts from a packing file.
    pub fn of_cloud(plan: &Plan) -> Option<Specimen> {
        let ParticleSource::Cloud(cloud) = &plan.particles.source else { return None };
        let compacted = plan.stages.iter().any(|s| matches!(s.kind, StageKind::Compact(_)));
        let growth = match &plan.bounds {
            Some(bounds) if compacted => {
                let solid = f64::from(cloud.count) * cloud.sizes.mean_volume();
                (0.6 * bounds.volume() / solid).cbrt()
            }
            _ => 1.0,
        };
        Some(Specimen {
            spheres: cloud.count as usize,
            smallest_radius: growth * cloud.sizes.smallest(),
            ..Specimen::default()
        })
    }
}

/// The bounds on the time step for the smallest sphere of a specimen, where
/// its contacts and pores are not known: √2 √(m / k), k for six contacts of
/// random direction, and eq. A.11 of Caulk 2020 where a stage couples the
/// fluid.
///
/// With k_n = E r between equal spheres and contacts of random direction, the
/// diagonal of the summed stiffness is 6 (k_n + 2 k_s) / 3.
fn estimated_bounds(plan: &Plan, smallest_radius: f64) -> TimeStepBounds {
    let material = &plan.particles.material;
    let r = smallest_radius;
    let mass = 4.0 / 3.0 * std::f64::consts::PI * r.powi(3) * material.density;
    let stiffness = 2.0 * material.young * r * (1.0 + 2.0 * material.stiffness_ratio);
    let coupled = plan.stages.iter().any(|s| s.kind.is_coupled());
    let fluid = plan.fluid.as_ref().filter(|_| coupled);
    TimeStepBounds {
        contact: (2.0 * mass / stiffness).sqrt(),
        viscous_estimate: fluid.map(|f| viscous_time_step(r, material.density, f.fluid.viscosity)),
        viscous: None,
    }
}

/// Sizes, memory and times that a plan can be expected to need.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Number of spheres.
    pub spheres: usize,
    /// Number of pores; 0 when no stage has flow.
    pub pores: usize,
    /// Number of unknown pressures.
    pub unknowns: usize,
    /// Entries of the Cholesky factor.
    pub factor_entries: usize,
    /// False where `pores` and `unknowns` are estimates.
    pub counted: bool,
    /// Peak memory (bytes).
    pub memory: f64,
    /// Bounds on the time step; `None` when nothing moves. Where the viscous
    /// bound of the network is not known, estimates from the smallest sphere.
    pub bounds: Option<TimeStepBounds>,
    /// Time step (s); `None` when nothing moves.
    pub dt: Option<f64>,
    /// Time of a dry step (s); `None` when nothing moves.
    pub dry_step: Option<f64>,
    /// Time of a coupled step with its share of remeshing (s); `None` when nothing couples.
    pub coupled_step: Option<f64>,
    /// Time of one remesh: triangulation, network, ordering, factorization (s); `None`
    /// without flow.
    pub remesh: Option<f64>,
}

impl Estimate {
    /// What `plan` needs for `specimen`.
    pub fn of(plan: &Plan, specimen: &Specimen) -> Estimate {
        let any = |holds: fn(&StageKind) -> bool| plan.stages.iter().any(|s| holds(&s.kind));
        let measured = any(|k| matches!(k, StageKind::Permeability(_)));
        let coupled = any(StageKind::is_coupled);
        let fluid = plan.fluid.as_ref().filter(|_| coupled || measured);
        let flow = fluid.map(|fluid| {
            let drained = if coupled { fluid.pressure_walls().count() } else { 2 };
            Flow::of(specimen, drained)
        });
        let dem = plan.dem.as_ref().filter(|_| any(StageKind::moves));
        let estimated = || estimated_bounds(plan, specimen.smallest_radius);
        let bounds = dem.map(|_| specimen.bounds.unwrap_or_else(estimated));
        let dt = dem.zip(bounds).map(|(dem, bounds)| match dem.dt {
            TimeStep::Fixed(dt) => dt,
            TimeStep::Auto => bounds.automatic(dem.safety),
        });
        let dry = DRY_STEP * specimen.spheres as f64;
        let remesh = flow.as_ref().map(Flow::remesh);
        let coupled_step = flow.as_ref().zip(remesh).filter(|_| coupled).map(|(flow, remesh)| {
            // With the strain rule alone, remeshes are as rare as the motion is slow; in
            // the background they take another core's time.
            let interval = fluid
                .filter(|f| f.acceleration.remesh != RemeshMode::Background)
                .and_then(|f| f.remesh.interval);
            let step = if fluid.is_some_and(follows) { flow.followed() } else { flow.solve() };
            dry + step + interval.map_or(0.0, |steps| remesh / steps as f64)
        });
        Estimate {
            spheres: specimen.spheres,
            pores: flow.as_ref().map_or(0, |f| f.pores as usize),
            unknowns: flow.as_ref().map_or(0, |f| f.unknowns as usize),
            factor_entries: flow.as_ref().map_or(0, |f| f.factor_entries as usize),
            counted: specimen.pores.is_some() && specimen.unknowns.is_some(),
            memory: BASE_MEMORY
                + SPHERE_MEMORY * specimen.spheres as f64
                + flow.as_ref().map_or(0.0, Flow::memory) * networks_at_once(fluid)
                + flow.as_ref().filter(|_| fluid.is_some_and(follows)).map_or(0.0, Flow::scratch),
            bounds,
            dt,
            dry_step: dem.map(|_| dry),
            coupled_step,
            remesh,
        }
    }
}

/// Whether networks follow the spheres between remeshes.
fn follows(fluid: &Fluid) -> bool {
    fluid.acceleration.update == Update::EveryStep
}

/// Networks that stand beside each other: the one in use while the next is built, except
/// where it makes room first.
fn networks_at_once(fluid: Option<&Fluid>) -> f64 {
    let how = fluid.map(|f| f.acceleration).unwrap_or_default();
    match how.remesh {
        RemeshMode::Background => 2.0,
        RemeshMode::Ahead if how.on_failure == OnFailure::Retry => 2.0,
        RemeshMode::Ahead | RemeshMode::AtOnce => 1.0,
    }
}

/// Dry step (s per sphere): a twentieth of a microsecond for the forces of its three
/// contacts, as much again for memory, motion and the neighbour list.
const DRY_STEP: f64 = 1e-7;
/// The program and its libraries (bytes).
const BASE_MEMORY: f64 = 30e6;
/// State, contacts, neighbour list (bytes per sphere).
const SPHERE_MEMORY: f64 = 1200.0;

/// Pores and unknowns of a packing.
struct Flow {
    pores: f64,
    unknowns: f64,
    factor_entries: f64,
}

impl Flow {
    fn of(specimen: &Specimen, drained_walls: usize) -> Flow {
        let n = specimen.spheres as f64;
        let surface = n.powf(2.0 / 3.0);
        // 5,685 pores in 1,000 spheres, 29,319 in 5,000, 119,578 in 20,000, 822,396 in
        // 135,000: a bulk value less what the walls cut off. One sphere in a box has 8.
        let pores = specimen.pores.map_or((6.15 * n - 4.6 * surface).max(8.0), |p| p as f64);
        // A drained wall takes the pores that touch it out: 1,379 of 20,000 spheres.
        let drained = 1.85 * surface * drained_walls as f64;
        let unknowns = specimen.unknowns.map_or((pores - drained).max(1.0), |u| u as f64);
        // 1.48e7 entries at 118,199 unknowns, 6.9e8 at 1,950,557 (METIS).
        let fitted = 1.48e7 * (unknowns / 118_199.0).powf(1.37);
        let factor_entries = specimen.factor_entries.map_or(fitted.max(unknowns), |e| e as f64);
        Flow { pores, unknowns, factor_entries }
    }

    /// Time of one solve, volumes and forces (s). Both triangular solves stream the factor
    /// through memory (27 ms for 1.48e7 entries); E and F cost some 20 ns a pore.
    fn solve(&self) -> f64 {
        1.82e-9 * self.factor_entries + 2e-8 * self.pores
    }

    /// The same where the network follows the spheres (s): pores and throats anew, 0.4 µs
    /// a pore, and some four solves.
    fn followed(&self) -> f64 {
        4.0 * self.solve() + 4e-7 * self.pores
    }

    /// Bytes that following takes: what a network was built as, throats, pushes.
    fn scratch(&self) -> f64 {
        500.0 * self.pores
    }

    /// Time of one remesh (s): 0.76 µs a pore to triangulate, 2 µs to build the network,
    /// 6.3 µs an unknown to order, and the factorization: 0.65 s at 118,199 unknowns,
    /// nearly as the square.
    fn remesh(&self) -> f64 {
        2.8e-6 * self.pores + 6.3e-6 * self.unknowns + 0.65 * (self.unknowns / 118_199.0).powf(1.75)
    }

    /// Bytes: the factor with a tenth of padding in its supernodes; network, operators and
    /// matrix; ordering and analysis.
    fn memory(&self) -> f64 {
        8.8 * self.factor_entries + 900.0 * self.pores + 400.0 * self.unknowns
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coupling::TimeStepRule;

    fn near(value: f64, expected: f64, tolerance: f64) {
        assert!((value / expected - 1.0).abs() < tolerance, "{value} against {expected}");
    }

    /// Measured on settled packings; unknowns and factor with one drained wall, METIS.
    #[test]
    fn counts_follow_the_packings_they_were_fitted_to() {
        for (spheres, pores, unknowns, entries) in [
            (1_000, 5_685.0, None, None),
            (5_000, 29_319.0, None, None),
            (20_000, 119_578.0, Some(118_199.0), Some(1.48e7)),
            (40_000, 241_321.0, Some(239_227.0), Some(3.92e7)),
            (135_000, 822_396.0, Some(817_690.0), Some(2.11e8)),
        ] {
            let flow = Flow::of(&Specimen { spheres, ..Specimen::default() }, 1);
            near(flow.pores, pores, 0.01);
            if let (Some(unknowns), Some(entries)) = (unknowns, entries) {
                near(flow.unknowns, unknowns, 0.01);
                near(flow.factor_entries, entries, 0.1);
            }
        }
    }

    #[test]
    fn exact_counts_replace_the_estimates() {
        let known = Specimen {
            spheres: 1000,
            pores: Some(5685),
            unknowns: Some(5500),
            factor_entries: Some(123_456),
            ..Specimen::default()
        };
        let flow = Flow::of(&known, 1);
        assert_eq!((flow.pores, flow.unknowns, flow.factor_entries), (5685.0, 5500.0, 123_456.0));
    }

    /// Two π ρ d² / (8000 μ) and √(2 m / k) by hand, for ρ = 2600, d = 1.5 mm, μ = 1e-3,
    /// E = 1e6, k_s/k_n = 0.5: m = 4.595e-6 kg, k = 2·1e6·0.75e-3·2 = 3000 N/m.
    #[test]
    fn step_bounds_by_hand() {
        let scene = r#"
            [box]
            min = [0, 0, 0]
            max = [1, 1, 1]
            [particles]
            cloud = { count = 10, radius = 0.75e-3 }
            [dem]
            [fluid]
            viscosity = 1e-3
            pressure = { y_max = 0 }
            [[stage]]
            kind = "run"
            steps = 1
        "#;
        let plan = Plan::from_toml(scene, None).unwrap();
        let smallest = Specimen::of_cloud(&plan).unwrap().smallest_radius;
        let bounds = estimated_bounds(&plan, smallest);
        near(bounds.contact, (2.0 * 4.595e-6 / 3000.0f64).sqrt(), 1e-3);
        near(bounds.viscous_estimate.unwrap(), 4.594e-3, 1e-3);
        assert_eq!(bounds.rule(), TimeStepRule::Contacts);
    }
}
