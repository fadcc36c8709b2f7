//! The ordering at a remesh.

use serde::{Deserialize, Serialize};

use super::Contest;
use super::job::{Follow, Followed, Job};
use super::sample::Sample;
use super::sizes::Placed;
use crate::Error;

/// Packings of more spheres are ordered in fewer processes.
const LARGE: usize = 100_000;

/// One packing.
#[derive(Serialize, Deserialize)]
pub struct Case {
    pub spheres: usize,
    pub unknowns: usize,
    /// Share of the pores that were not there before the motion.
    pub new_pores: f64,
    /// An ordering of its own, and one that follows (s).
    pub order_s: Sample,
    pub follow_s: Sample,
    /// Entries of the factor with each.
    pub nnz_own: f64,
    pub nnz_followed: f64,
}

/// Orders a network that has moved, in as many processes as there are runs.
///
/// # Errors
/// The packing is wrong.
pub fn measure(contest: &Contest, placed: &Placed) -> Result<Case, Error> {
    let runs = if placed.spheres > LARGE { 1 } else { contest.runs };
    let mut case = None;
    for run in 0..runs {
        let name = format!("follow-{}-run{run}", placed.spheres);
        let job = Follow { packing: placed.path.clone(), repeats: 3, run };
        let done: Followed = contest.bench.remembered(&name, &job, || {
            contest.bench.job(&name, &Job::Follow(job.clone()), contest.threads)
        })?;
        let case = case.get_or_insert_with(|| Case {
            spheres: placed.spheres,
            unknowns: done.unknowns,
            new_pores: done.new_pores,
            order_s: Sample::default(),
            follow_s: Sample::default(),
            nnz_own: done.nnz_own,
            nnz_followed: done.nnz_followed,
        });
        case.order_s.0.extend(&done.order_s);
        case.follow_s.0.extend(&done.follow_s);
    }
    case.ok_or_else(|| Error::Peer {
        step: "follow".to_owned(),
        what: "there are no runs".to_owned(),
        log: None,
    })
}
