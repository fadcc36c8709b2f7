//! LAMMPS on dry spheres: its data, its start, what it prints.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::Command;

use dempfv::io::packing::Packing;
use dempfv::{Aabb, Vec3};

use super::Contest;
use super::job::Stepped;
use super::others::Lammps;
use crate::Error;

/// What a run of LAMMPS reads.
pub struct Input<'a> {
    /// Its commands.
    pub commands: &'a str,
    /// Its spheres.
    pub data: String,
    /// Variables of the commands.
    pub variables: &'a [(&'a str, String)],
}

/// Runs it to its end with so many processes; returns its log.
///
/// # Errors
/// [`Error::Peer`] when it fails; its log is kept.
pub fn run(
    contest: &Contest,
    (lammps, processes): (&Lammps, usize),
    name: &str,
    input: &Input,
) -> Result<PathBuf, Error> {
    let data = contest.bench.write(&format!("jobs/{name}.data"), &input.data)?;
    let commands = contest.bench.write(&format!("jobs/{name}.in"), input.commands)?;
    let mut command = Command::new(&lammps.starter);
    // Some containers have root alone, which Open MPI refuses unless it is told twice.
    command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
    command.env("OMP_NUM_THREADS", "1");
    command.args(["-np", &processes.to_string()]).arg(&lammps.program);
    command.args(["-log", "none", "-in"]).arg(&commands).args(["-var", "data"]).arg(&data);
    for (name, value) in input.variables {
        command.args(["-var", name, value]);
    }
    contest.bench.run_logged(name, "LAMMPS", &mut command)
}

/// The same, timed: what it printed of its last run.
///
/// # Errors
/// Also when it printed something else.
pub fn time(
    contest: &Contest,
    by: (&Lammps, usize),
    name: &str,
    input: &Input,
    steps: u64,
) -> Result<Stepped, Error> {
    let log = run(contest, by, name, input)?;
    let text = std::fs::read_to_string(&log).map_err(|e| dempfv::Error::io(&log, e))?;
    read_log(&text, steps).ok_or_else(|| Error::Peer {
        step: name.to_owned(),
        what: "LAMMPS printed neither its time nor its contacts".to_owned(),
        log: Some(log),
    })
}

/// The packing as LAMMPS reads it, at rest.
pub fn data(packing: &Packing, bounds: &Aabb, density: f64) -> String {
    let mut text = format!("spheres\n\n{} atoms\n1 atom types\n\n", packing.len());
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let [low, high] = [bounds.min, bounds.max].map(|corner| corner[axis]);
        text += &format!("{low:e} {high:e} {name}lo {name}hi\n");
    }
    text += "\nAtoms # sphere\n\n";
    for (i, (x, r)) in packing.position.iter().zip(&packing.radius).enumerate() {
        let diameter = 2.0 * r;
        text += &format!("{} 1 {diameter:e} {density:e} {:e} {:e} {:e}\n", i + 1, x.x, x.y, x.z);
    }
    text
}

/// The section of the data that makes the spheres move.
pub fn motion(velocity: &[Vec3], spin: &[Vec3]) -> String {
    let mut text = "\nVelocities # sphere\n\n".to_owned();
    for (i, (v, w)) in velocity.iter().zip(spin).enumerate() {
        let numbers = v.iter().chain(w.iter());
        text += &numbers.fold(format!("{}", i + 1), |mut line, x| {
            // Writing to a string cannot fail.
            let _ = write!(line, " {x:e}");
            line
        });
        text.push('\n');
    }
    text
}

/// Time per step and contacts from what LAMMPS prints: the run of so many steps, and the
/// last number of contacts of a sphere.
fn read_log(text: &str, steps: u64) -> Option<Stepped> {
    let (mut time, mut contacts, mut in_table) = (None, None, false);
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if let ["Loop", "time", "of", seconds, "on", _, "procs", "for", count, ..] = words[..] {
            in_table = false;
            if count.parse() == Ok(steps) {
                time = seconds.parse::<f64>().ok();
            }
        }
        if let (true, [_, spheres, _, each]) = (in_table, &words[..]) {
            let (spheres, each): (Option<f64>, Option<f64>) =
                (spheres.parse().ok(), each.parse().ok());
            // Each of two spheres counts a contact.
            contacts = spheres.zip(each).map(|(n, each)| 0.5 * n * each);
        }
        in_table |= words == ["Step", "Atoms", "KinEng", "c_mean"];
    }
    Some(Stepped { step_s: time? / steps as f64, contacts: contacts? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_log_of_lammps_is_read() {
        let text = "Step Atoms KinEng c_mean \n 0 5 0 3.2 \n 100 5 0 5.0 \n\
                    Loop time of 9 on 2 procs for 100 steps with 5 atoms\n\
                    Step Atoms KinEng c_mean \n 100 5 0 5.0 \n 600 5 1e-9 5.6 \n\
                    Loop time of 1.5 on 2 procs for 500 steps with 5 atoms\n 1 2 3 4\n";
        let read = read_log(text, 500).unwrap();
        assert_eq!((read.step_s, read.contacts), (0.003, 14.0));
        assert!(read_log(text, 600).is_none());
        assert!(read_log("Loop time of 1.5 on 2 procs for 500 steps", 500).is_none());
    }
}
