//! What a plan says of its spheres and pores, before anything is built.

use serde::Serialize;

use crate::Aabb;
use crate::coupling::TimeStepBounds;
use crate::scene::{ParticleSource, Plan, StageKind};
use crate::theory::sauter_diameter;

/// Porosity that growth is expected to end at.
const COMPACTED: f64 = 0.4;

/// What is known about the spheres and pores of a plan.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Specimen {
    /// Number of spheres.
    pub spheres: usize,
    /// Smallest radius (m); 0 where it is not known, which leaves the time step open.
    pub smallest_radius: f64,
    /// Diameter with the mean ratio of volume to surface (m); 0 where it is not known.
    pub diameter: f64,
    /// Share of the box that no sphere fills (1); 0 where it is not known.
    pub porosity: f64,
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
            diameter: sauter_diameter(radii),
            ..Specimen::default()
        }
    }

    /// The same spheres in this box, grown to a porosity of 0.4 when the plan compacts them.
    #[must_use]
    pub fn in_box(mut self, radii: &[f64], bounds: &Aabb, plan: &Plan) -> Specimen {
        let solid = 4.0 / 3.0 * std::f64::consts::PI * radii.iter().map(|r| r.powi(3)).sum::<f64>();
        self.porosity = 1.0 - solid / bounds.volume();
        if plan.stages.iter().any(|s| matches!(s.kind, StageKind::Compact(_))) {
            self.diameter *= ((1.0 - COMPACTED) / (1.0 - self.porosity)).cbrt();
            self.porosity = COMPACTED;
        }
        self
    }

    /// The cloud of a plan, with its radii grown to a porosity of 0.4 when the plan
    /// compacts it; `None` when the plan starts from a packing file.
    pub fn of_cloud(plan: &Plan) -> Option<Specimen> {
        let ParticleSource::Cloud(cloud) = &plan.particles.source else { return None };
        let compacts = |keeps: bool| {
            let stage =
                |kind: &StageKind| matches!(kind, StageKind::Compact(c) if c.keep_radii == keeps);
            plan.stages.iter().any(|s| stage(&s.kind))
        };
        let growth = match &plan.room() {
            Some(bounds) if compacts(false) => {
                let solid = f64::from(cloud.count) * cloud.sizes.mean_volume();
                ((1.0 - COMPACTED) * bounds.volume() / solid).cbrt()
            }
            _ => 1.0,
        };
        let porosity = plan.bounds.map_or(0.0, |bounds| {
            if compacts(true) {
                return COMPACTED;
            }
            let solid = f64::from(cloud.count) * cloud.sizes.mean_volume() * growth.powi(3);
            1.0 - solid / bounds.volume()
        });
        // Of clumps each member counts, and the smallest sets the time step.
        let (members, share) = plan.particles.clump.as_ref().map_or((1, 1.0), |clump| {
            let radii = clump.members.iter().map(|(_, radius)| *radius);
            (clump.members.len(), radii.fold(1.0, f64::min))
        });
        Some(Specimen {
            spheres: cloud.count as usize * members,
            smallest_radius: growth * cloud.sizes.smallest() * share,
            diameter: growth * cloud.sizes.sauter_diameter(),
            porosity,
            ..Specimen::default()
        })
    }
}
