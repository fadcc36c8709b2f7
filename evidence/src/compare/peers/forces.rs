//! Whether LAMMPS and ours find the same forces in the same contacts.

use std::f64::consts::PI;

use dempfv::dem::{Dem, Particles};
use dempfv::io::packing::Packing;
use dempfv::{Aabb, InputError, Vec3};
use serde::{Deserialize, Serialize};

use super::super::edges::uniform;
use super::Contest;
use super::job::{Contacts, Material};
use super::lammps::{self, Input};
use super::lammps_law::{Effects, Law, SETUP};
use super::others::Lammps;
use crate::Error;
use crate::bench::sample::worst;

/// Equal spheres on a simple cubic lattice of so many a side, and their radius (m).
const SIDE: usize = 8;
const RADIUS: f64 = 1e-3;
/// Their overlap over the radius: small, because the programs do not take the slip at the same place of it.
const OVERLAP: f64 = 1e-7;

/// How equal spheres move, in overlaps.
struct Motion {
    /// How far each is off its place along each axis at most.
    moved: f64,
    /// The way that its velocity would take it, and in how many steps.
    way: f64,
    steps: u64,
}

/// Contacts open and close, and slide.
const SLIDING: Motion = Motion { moved: 0.3, way: 0.2, steps: 20 };
/// Contacts stay, and nothing slides. So are resistances against turning compared: at their limit LAMMPS
/// has spring and dashpot together reach it, by which the spring gives way; ours cuts the spring alone,
/// and then both.
const HELD: Motion = Motion { moved: 0.1, way: 0.05, steps: 5 };
/// What their limits are multiplied with, so that none is reached.
const FIRM: f64 = 10.0;

const DUMP: &str = "
thermo_modify   lost error norm no
dump            forces all custom ${steps} ${forces} id fx fy fz tqx tqy tqz
dump_modify     forces sort id format float %.17g
run             ${steps}
";

/// Largest difference of ours from LAMMPS's, of the mean over all spheres.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Apart {
    /// Force of the normal springs, before anything has slipped.
    pub normal: f64,
    /// Force and torque after some steps.
    pub force: f64,
    pub torque: f64,
}

/// Forces (N) and torques (N m) on all spheres.
#[derive(Default)]
struct Loads {
    force: Vec<Vec3>,
    torque: Vec<Vec3>,
}

pub const INTRODUCTION: &str = "
Whether both compute the same: forces and torques on each sphere, largest difference over the mean. Equal
spheres: 512 of 1 mm on a cubic lattice with overlaps of about 10⁻⁷ of the radius, a random velocity and spin
each; the normal forces before the first step, all after 20 steps without damping of motion, in which contacts
open, close and slide; of rolling and twisting after 5, below their limits. At its limit LAMMPS has spring and
dashpot together reach it, by which the spring gives way; ours cuts the spring alone, then both. LAMMPS takes
the slip at full radii (`gran/hooke/history` the torque, too), ours where the force acts, in the middle of the
overlap: that is a difference of the order of overlap over radius.

The packing: normal forces at its beginning, where it is at rest, over the mean one of a contact. There LAMMPS
has one stiffness of linear springs for all pairs, ours goes with the radii. Its stiffness and damping against
turning do not follow the contact radius, either, which ours do with Hertz: in the last row no constants make
them the same. At a wall this LAMMPS takes E/2(1 − ν) for E* of `hertz/material`, where two spheres have
E/2(1 − ν²); it is given E/(1 + ν) there, so that both have the latter.

| effects | equal spheres: normal force | force | torque | the packing: normal force |
|:--|--:|--:|--:|--:|
";

/// Both programs on equal spheres that move.
///
/// # Errors
/// One of them fails, or the packing is not there.
pub fn on_equal_spheres(
    contest: &Contest,
    lammps: &Lammps,
    effects: &Effects,
) -> Result<Apart, Error> {
    let contacts = effects.contacts.with_limits(FIRM);
    let how = if contacts == effects.contacts { SLIDING } else { HELD };
    let mut random = 1u64;
    let mut vector = |size: f64| Vec3::from_fn(|_, _| size * uniform(&mut random));
    let spacing = RADIUS * (2.0 - OVERLAP);
    let place =
        |k: usize| Vec3::new((k % SIDE) as f64, (k / SIDE % SIDE) as f64, (k / SIDE / SIDE) as f64);
    let position: Vec<Vec3> = (0..SIDE.pow(3))
        .map(|k| spacing * (place(k).add_scalar(0.5)) + vector(how.moved * OVERLAP * RADIUS))
        .collect();
    let bounds = Aabb { min: Vec3::zeros(), max: Vec3::repeat(SIDE as f64 * spacing) };
    let radius = vec![RADIUS; position.len()];
    let packing = Packing { position, radius, bounds: Some(bounds), ..Packing::default() };
    let material = Material { damping: 0.0, ..Material::default() };
    let speed = how.way * OVERLAP * RADIUS / (how.steps as f64 * material.dt);
    let motion =
        [speed, speed / RADIUS].map(|size| (0..packing.len()).map(|_| vector(size)).collect());
    let name = format!("contacts-forces-{}", effects.slug());
    let scene = Scene { packing: &packing, bounds, material, contacts };
    let [first, last] = scene.theirs(contest, lammps, (&name, how.steps), Some(&motion))?;
    let [ours_first, ours_last] = scene.ours(&motion, how.steps).map_err(dempfv::Error::from)?;
    Ok(Apart {
        normal: apart(&ours_first.force, &first.force),
        force: apart(&ours_last.force, &last.force),
        torque: apart(&ours_last.torque, &last.torque),
    })
}

/// How far the normal forces of a packing at rest are apart.
///
/// # Errors
/// One of the programs fails.
pub fn at_rest(
    contest: &Contest,
    lammps: &Lammps,
    effects: &Effects,
    (packing, bounds): (&Packing, Aabb),
) -> Result<f64, Error> {
    let name = format!("contacts-rest-{}", effects.slug());
    let material = Material { damping: 0.0, ..Material::default() };
    let scene = Scene { packing, bounds, material, contacts: effects.contacts };
    let [theirs, _] = scene.theirs(contest, lammps, (&name, 1), None)?;
    let mut dem = scene.dem(&[]).map_err(dempfv::Error::from)?;
    dem.compute_contacts().map_err(dempfv::Error::from)?;
    Ok(apart_of_contacts(&dem, &theirs.force))
}

/// Spheres at one moment.
struct Scene<'a> {
    packing: &'a Packing,
    bounds: Aabb,
    material: Material,
    contacts: Contacts,
}

impl Scene<'_> {
    fn dem(&self, motion: &[Vec<Vec3>]) -> Result<Dem, dempfv::dem::DemError> {
        let Packing { position, radius, .. } = self.packing;
        let mut particles = Particles::new(position.clone(), radius.clone(), self.material.density);
        if let [velocity, spin] = motion {
            particles.velocity.clone_from(velocity);
            particles.spin.clone_from(spin);
        }
        self.contacts.between(&self.material, particles, self.bounds)
    }

    /// Loads before the first step and after the last.
    fn ours(
        &self,
        motion: &[Vec<Vec3>; 2],
        steps: u64,
    ) -> Result<[Loads; 2], dempfv::dem::DemError> {
        let mut dem = self.dem(motion)?;
        dem.compute_contacts()?;
        let first = Loads { force: dem.forces(), torque: dem.torques() };
        // Velocities are half a step behind in ours, and not at the beginning of a run of LAMMPS.
        let (half, [velocity, spin]) = (0.5 * self.material.dt, motion);
        for (k, r) in self.packing.radius.iter().enumerate() {
            let mass = self.material.density * 4.0 / 3.0 * PI * r.powi(3);
            dem.set_velocity(k, velocity[k] - half / mass * first.force[k]);
            dem.set_spin(k, spin[k] - half / (0.4 * mass * r * r) * first.torque[k]);
        }
        dem.integrate(self.material.dt, None, None)?;
        for _ in 1..steps {
            dem.step(self.material.dt)?;
        }
        dem.compute_contacts()?;
        Ok([first, Loads { force: dem.forces(), torque: dem.torques() }])
    }

    fn theirs(
        &self,
        contest: &Contest,
        lammps: &Lammps,
        (name, steps): (&str, u64),
        motion: Option<&[Vec<Vec3>; 2]>,
    ) -> Result<[Loads; 2], Error> {
        let file = contest.bench.folder.join("jobs").join(format!("{name}.dump"));
        let law = Law::new(&self.packing.radius, &self.material, &self.contacts);
        let mut variables = law.variables();
        variables.push(("steps", steps.to_string()));
        variables.push(("forces", file.display().to_string()));
        let mut data = lammps::data(self.packing, &self.bounds, self.material.density);
        if let Some([velocity, spin]) = motion {
            data += &lammps::motion(velocity, spin);
        }
        let commands = format!("{SETUP}{DUMP}");
        let input = Input { commands: &commands, data, variables: &variables };
        lammps::run(contest, (lammps, 1), name, &input)?;
        let text = std::fs::read_to_string(&file).map_err(|e| dempfv::Error::io(&file, e))?;
        read_dump(&text, self.packing.len()).ok_or_else(|| {
            InputError::new("no forces of all spheres at two steps", "look at LAMMPS's log")
                .in_file(&file)
                .into()
        })
    }
}

/// The first and the last step of a dump of forces and torques, each of so many spheres by number.
fn read_dump(text: &str, spheres: usize) -> Option<[Loads; 2]> {
    let steps: Option<Vec<Loads>> = text.split("ITEM: ATOMS").skip(1).map(loads).collect();
    let mut steps = steps?.into_iter().filter(|loads| loads.force.len() == spheres);
    Some([steps.next()?, steps.next_back()?])
}

fn loads(step: &str) -> Option<Loads> {
    let mut loads = Loads::default();
    let lines = step.lines().skip(1).take_while(|line| !line.starts_with("ITEM"));
    for (k, line) in lines.enumerate() {
        let numbers: Option<Vec<f64>> = line.split_whitespace().map(|w| w.parse().ok()).collect();
        let [id, fx, fy, fz, tx, ty, tz] = numbers?[..] else { return None };
        if id != (k + 1) as f64 {
            return None;
        }
        loads.force.push(Vec3::new(fx, fy, fz));
        loads.torque.push(Vec3::new(tx, ty, tz));
    }
    Some(loads)
}

/// Largest difference over the mean of theirs.
fn apart(ours: &[Vec3], theirs: &[Vec3]) -> f64 {
    largest(ours, theirs) / (theirs.iter().map(Vec3::norm).sum::<f64>() / theirs.len() as f64)
}

/// The same over the mean force of a contact: those on spheres at rest are nearly none.
fn apart_of_contacts(dem: &Dem, theirs: &[Vec3]) -> f64 {
    let forces: Vec<f64> = dem.contacts().map(|contact| contact.normal_force).collect();
    largest(&dem.forces(), theirs) / (forces.iter().sum::<f64>() / forces.len() as f64)
}

fn largest(ours: &[Vec3], theirs: &[Vec3]) -> f64 {
    worst(ours.iter().zip(theirs).map(|(a, b)| (a - b).norm()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dump_is_read_by_number() {
        let step = |id: u32| {
            format!(
                "ITEM: ATOMS id fx fy fz tqx tqy tqz \n1 1 2 3 4 5 6 \n{id} 0 0 7 0 0 8 \nITEM: TIMESTEP\n5\n"
            )
        };
        let [first, last] = read_dump(&format!("{}{}", step(2), step(2)), 2).unwrap();
        assert_eq!(
            (first.force[0], last.torque[1]),
            (Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.0, 0.0, 8.0))
        );
        // One step alone, a sphere lost, numbers out of order.
        assert!(read_dump(&step(2), 2).is_none());
        assert!(read_dump(&format!("{}{}", step(2), step(2)), 3).is_none());
        assert!(read_dump(&format!("{}{}", step(3), step(2)), 2).is_none());
    }
}
