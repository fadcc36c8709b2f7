//! Profiles of pressure at the walls of one network.

use super::PressureProfile;
use crate::{PerWall, Vec3, WallId};

/// What the pores at walls have beside the pressures of these.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WallProfiles {
    /// Of each pore (Pa); 0 away from walls with a profile.
    of_pore: Vec<f64>,
    /// Lowest, mean and highest of each wall (Pa).
    ranges: PerWall<[f64; 3]>,
}

impl WallProfiles {
    /// Profiles at pores with these centres (m) that belong to walls.
    pub fn new(
        center: &[Vec3],
        wall_of: impl Fn(usize) -> Option<WallId>,
        profiles: &PerWall<Option<PressureProfile>>,
    ) -> WallProfiles {
        let mut of_pore = vec![0.0; center.len()];
        let mut ranges = PerWall([[0.0; 3]; 6]);
        let mut count = PerWall([0.0; 6]);
        for (i, p) in of_pore.iter_mut().enumerate() {
            let of_wall = wall_of(i).and_then(|wall| Some((wall, profiles[wall].as_ref()?)));
            let Some((wall, profile)) = of_wall else { continue };
            let value = profile.value(center[i][profile.along.index()]);
            let [low, sum, high] = ranges[wall];
            let first = count[wall] == 0.0;
            let ends = if first { [value; 2] } else { [value.min(low), value.max(high)] };
            ranges[wall] = [ends[0], sum + value, ends[1]];
            *p = value;
            count[wall] += 1.0;
        }
        for (wall, [_, mean, _]) in ranges.iter_mut() {
            *mean /= f64::max(count[wall], 1.0);
        }
        WallProfiles { of_pore, ranges }
    }

    /// The pressure that a pore has beside that of its wall (Pa).
    pub fn of_pore(&self, pore: usize) -> f64 {
        self.of_pore[pore]
    }

    /// Lowest, mean and highest of a set; 0 of one that is no wall.
    pub fn range(&self, set: usize) -> [f64; 3] {
        WallId::ALL.get(set).map_or([0.0; 3], |wall| self.ranges[*wall])
    }
}
