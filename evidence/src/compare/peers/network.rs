//! Networks from positions to operators, beside what YADE takes.

use serde::{Deserialize, Serialize};

use super::Contest;
use super::job::{Build, Built, Job};
use super::sizes::Placed;
use crate::Error;
use crate::bench::sample::Sample;

/// One packing.
#[derive(Serialize, Deserialize)]
pub struct Case {
    pub spheres: usize,
    pub pores: f64,
    pub throats: f64,
    /// Triangulation, pores and throats (s).
    pub network_s: Sample,
    /// The same with the operators G, E and F (s).
    pub all_s: Sample,
}

/// Builds it, in as many processes as there are runs.
///
/// # Errors
/// The packing is wrong.
pub fn measure(contest: &Contest, placed: &Placed) -> Result<Case, Error> {
    let mut case = Case {
        spheres: placed.spheres,
        pores: 0.0,
        throats: 0.0,
        network_s: Sample::default(),
        all_s: Sample::default(),
    };
    for run in 0..contest.runs {
        let name = format!("network-{}-run{run}", placed.spheres);
        let job = Build { packing: placed.path.clone(), repeats: 5, run };
        let built: Built = contest.bench.remembered(&name, &job, || {
            contest.bench.job(&name, &Job::Build(job.clone()), contest.threads)
        })?;
        (case.pores, case.throats) = (built.pores, built.throats);
        // The first of a process finds its memory.
        case.network_s.0.extend(&built.network_s[1..]);
        case.all_s.0.extend(&built.all_s[1..]);
    }
    Ok(case)
}
