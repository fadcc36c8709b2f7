//! What a loading shows, and how far two of them are apart.

use dempfv::WallId;
use serde::{Deserialize, Serialize};

use crate::bench::Run;

/// What one looked at after some of the steps.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Course {
    /// Steps done.
    pub step: Vec<u64>,
    /// Stress on each wall, of spheres and fluid together (Pa, positive in compression).
    pub stress: Vec<[f64; 6]>,
    /// Displacement of the loaded wall along y (m).
    pub displacement: Vec<f64>,
    /// Live contacts, those with walls included.
    pub contacts: Vec<u64>,
    /// Contacts per sphere; a contact of two counts for both.
    pub coordination: Vec<f64>,
    /// Pore pressure at each probe (Pa).
    pub pressure: Vec<Vec<f64>>,
    /// How long the steps took (s).
    pub seconds: f64,
}

impl Course {
    /// The course of a run of ours at the steps asked for; `None` where the history lacks
    /// them.
    pub fn of_run(run: &Run, samples: &[u64], probes: usize) -> Option<Course> {
        let column = |name: &str| run.history.column(name);
        let step = column("step")?;
        let rows: Option<Vec<usize>> = samples
            .iter()
            .map(|&s| step.binary_search_by(|x| x.total_cmp(&(s as f64))).ok())
            .collect();
        let rows = rows?;
        let walls = WallId::ALL.map(|w| {
            let contacts = column(&format!("contact_stress_{w}_pa"))?;
            let fluid = column(&format!("fluid_stress_{w}_pa"))?;
            Some(rows.iter().map(|&i| contacts[i] + fluid[i]).collect::<Vec<f64>>())
        });
        let [Some(a), Some(b), Some(c), Some(d), Some(e), Some(f)] = walls else { return None };
        let picked = |name: &str| -> Option<Vec<f64>> {
            let values = column(name)?;
            Some(rows.iter().map(|&i| values[i]).collect())
        };
        let pressure: Option<Vec<Vec<f64>>> =
            (1..=probes).map(|k| picked(&format!("probe_{k}_pressure_pa"))).collect();
        let pressure = pressure?;
        Some(Course {
            step: samples.to_vec(),
            stress: (0..rows.len()).map(|i| [a[i], b[i], c[i], d[i], e[i], f[i]]).collect(),
            displacement: picked("wall_displacement_y_max_m")?,
            contacts: picked("contacts")?.into_iter().map(|n| n as u64).collect(),
            coordination: picked("coordination_number")?,
            pressure: (0..rows.len()).map(|i| pressure.iter().map(|p| p[i]).collect()).collect(),
            seconds: run.summary["wall_s"].as_f64()?,
        })
    }

    /// Stress on a wall from sample to sample (Pa).
    pub fn stress_on(&self, wall: WallId) -> Vec<f64> {
        self.stress.iter().map(|s| s[wall.index()]).collect()
    }

    /// Settlement of the loaded wall (m), positive downwards.
    pub fn settlement(&self) -> Vec<f64> {
        self.displacement.iter().map(|d| -d).collect()
    }

    /// Pressure at a probe from sample to sample (Pa).
    pub fn pressure_at(&self, probe: usize) -> Vec<f64> {
        self.pressure.iter().map(|p| p.get(probe).copied().unwrap_or(f64::NAN)).collect()
    }

    /// Its first samples.
    pub fn first(&self, count: usize) -> Course {
        Course {
            step: self.step[..count].to_vec(),
            stress: self.stress[..count].to_vec(),
            displacement: self.displacement[..count].to_vec(),
            contacts: self.contacts[..count].to_vec(),
            coordination: self.coordination[..count].to_vec(),
            pressure: self.pressure[..count].to_vec(),
            seconds: self.seconds,
        }
    }
}

/// Largest and median difference of a quantity from sample to sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Apart {
    /// Largest.
    pub largest: f64,
    /// Median.
    pub median: f64,
}

impl Apart {
    fn of(mut values: Vec<f64>) -> Apart {
        // A NaN is the largest difference that there is.
        values.sort_unstable_by(|a, b| a.abs().total_cmp(&b.abs()));
        let at = |i: usize| values.get(i).map_or(f64::NAN, |v| v.abs());
        Apart { largest: at(values.len().wrapping_sub(1)), median: at(values.len() / 2) }
    }
}

/// How far two courses are apart.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// Stress on any wall, over the load.
    pub stress: Apart,
    /// Settlement, over the last settlement.
    pub settlement: Apart,
    /// Pore pressure at any probe, over the load; zero without probes.
    pub pressure: Apart,
    /// Coordination number, relative.
    pub coordination: Apart,
    /// Coordination number at the end, relative.
    pub last_coordination: f64,
}

impl Gap {
    /// The largest of what is judged: stress, settlement and pressure.
    pub fn largest(&self) -> f64 {
        let all = [self.stress, self.settlement, self.pressure].map(|apart| apart.largest);
        all.into_iter().fold(0.0, |a, b| if b.is_nan() { b } else { a.max(b) })
    }

    /// How far `a` is from `b`, which was taken at the same times; `load` is the stress
    /// that was put on (Pa).
    pub fn between(a: &Course, b: &Course, load: f64) -> Gap {
        let pairs = || a.stress.iter().zip(&b.stress);
        let stress = pairs().flat_map(|(a, b)| (0..6).map(move |w| (a[w] - b[w]) / load));
        let last = b.displacement.last().copied().unwrap_or(f64::NAN);
        let settlement =
            a.displacement.iter().zip(&b.displacement).map(|(a, b)| (a - b) / last).collect();
        let pressure: Vec<f64> = (a.pressure.iter().zip(&b.pressure))
            .flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a - b) / load))
            .collect();
        let coordination: Vec<f64> =
            a.coordination.iter().zip(&b.coordination).map(|(a, b)| a / b - 1.0).collect();
        let none = Apart { largest: 0.0, median: 0.0 };
        Gap {
            stress: Apart::of(stress.collect()),
            settlement: Apart::of(settlement),
            pressure: if pressure.is_empty() { none } else { Apart::of(pressure) },
            last_coordination: coordination.last().map_or(f64::NAN, |c| c.abs()),
            coordination: Apart::of(coordination),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn course(stress: f64, displacement: f64) -> Course {
        Course {
            step: vec![1, 2],
            stress: vec![[0.0; 6], [0.0, 0.0, 0.0, stress, 0.0, 0.0]],
            displacement: vec![0.0, displacement],
            contacts: vec![4, 4],
            coordination: vec![4.0, 4.0],
            pressure: vec![vec![], vec![]],
            seconds: 1.0,
        }
    }

    /// 3 Pa of 100 Pa, and 0.1 mm of 2 mm.
    #[test]
    fn differences_are_over_the_load_and_the_last_settlement() {
        let gap = Gap::between(&course(103.0, -1.9e-3), &course(100.0, -2.0e-3), 100.0);
        assert!((gap.stress.largest - 0.03).abs() < 1e-15);
        assert!((gap.settlement.largest - 0.05).abs() < 1e-15);
        assert_eq!(
            (gap.stress.median, gap.pressure.largest, gap.last_coordination),
            (0.0, 0.0, 0.0)
        );
    }

    /// What is no number must not pass for agreement.
    #[test]
    fn a_course_that_is_no_number_is_apart() {
        let gap = Gap::between(&course(f64::NAN, -1.0), &course(100.0, -1.0), 100.0);
        assert!(gap.stress.largest.is_nan());
    }
}
