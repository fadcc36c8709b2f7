//! All edges of a network, and what they put on spheres and walls in a step.

use rayon::prelude::*;

use super::adjacency::Adjacency;
use super::effects::EdgeEffects;
use super::film::{Bodies, Film};
use super::normal_lubrication::{self, HELD, SYMMETRIC, squeeze};
use super::{pump_torque, shear_lubrication, twist_torque, viscous_shear};
use crate::coupling::error::Result;
use crate::dem::{Dem, FilmLosses, Material, StiffnessSum};
use crate::parallel::in_tasks;
use crate::pfv::{EdgeList, Network};
use crate::{PerWall, Vec3};

/// Edges that one task takes, and below twice as many one thread takes all.
pub const EDGES_PER_TASK: usize = 2_048;
/// Edges that go through all effects at a time, so that they stay in the first cache.
const BLOCK: usize = 64;

/// The edges of a network in use.
#[derive(Debug)]
pub struct EdgeForces {
    pub(super) effects: EdgeEffects,
    /// Dynamic viscosity (Pa·s), and whether the fluid slips along walls.
    pub(super) viscosity: f64,
    slip_walls: bool,
    pub(super) pairs: Vec<[u32; 2]>,
    pub(super) between_spheres: usize,
    pub(super) films: Vec<Film>,
    adjacency: Adjacency,
    /// Force on each sphere (N), and that with the pores' pressures.
    pub(super) force: Vec<Vec3>,
    total: Vec<Vec3>,
    /// Torque on each sphere (N·m); empty where nothing turns them.
    torque: Vec<Vec3>,
    /// Force on each wall (N), and what it loses at most per speed (N·s/m).
    pub(super) wall_force: [Vec3; 6],
    wall_resistance: PerWall<f64>,
    /// Of the last step: velocities of the walls (m/s), the length of the one before (s).
    pub(super) walls_before: PerWall<f64>,
    pub(super) last_dt: f64,
    /// What each task's edges dissipated, where that is tracked.
    pub(super) losses: Vec<FilmLosses>,
    /// Elastic energy of edges that are no more (J), until it is booked.
    pub(super) dropped: f64,
    /// Scratch of [`EdgeForces::rate`].
    pub(super) sums: [Vec<StiffnessSum>; 2],
}

impl EdgeForces {
    /// The edges of a network that was built of the spheres of `dem` at `position` (m), and between
    /// walls along which its fluid slips or not. `None` where no effect is on.
    ///
    /// # Errors
    /// Constants that make no sense.
    pub fn new(
        effects: &EdgeEffects,
        (network, slip_walls): (&Network, bool),
        position: &[Vec3],
        dem: &Dem,
    ) -> Result<Option<EdgeForces>> {
        effects.check()?;
        if !effects.any() {
            return Ok(None);
        }
        let EdgeList { mut pairs, mut area, between_spheres } = EdgeList::new(network, position);
        // Slip walls drag nothing; of what films at walls do besides there is no formula here.
        let at_walls = effects.normal_lubrication || (effects.viscous_shear && !slip_walls);
        if !at_walls {
            pairs.truncate(between_spheres);
            area.truncate(between_spheres);
        }
        let place = |(&pair, area): (&[u32; 2], f64)| still(dem, effects.stiffness, pair, area);
        let films: Vec<Film> = pairs.iter().zip(area).map(place).collect();
        let n = dem.storage().len();
        Ok(Some(EdgeForces {
            effects: *effects,
            viscosity: network.viscosity,
            slip_walls,
            adjacency: Adjacency::new(n, &pairs),
            pairs,
            between_spheres,
            force: vec![Vec3::zeros(); n],
            total: vec![Vec3::zeros(); n],
            torque: if effects.turns() { vec![Vec3::zeros(); n] } else { vec![] },
            wall_force: [Vec3::zeros(); 6],
            wall_resistance: PerWall::default(),
            walls_before: PerWall::default(),
            last_dt: 0.0,
            losses: vec![FilmLosses::default(); films.len().div_ceil(EDGES_PER_TASK)],
            dropped: 0.0,
            sums: Default::default(),
            films,
        }))
    }

    /// Computes what the edges put on spheres and walls in a step of length `dt` (s), from where these
    /// are and how they move now. `fluid` has the force of the pores' pressures on each sphere (N).
    pub fn act(&mut self, dem: &Dem, fluid: &[Vec3], dt: f64) {
        let bodies = Bodies::of(dem);
        self.walls_before = bodies.wall_velocity;
        self.last_dt = dem.last_dt(dt);
        let (pairs, wall_pairs) = self.pairs.split_at(self.between_spheres);
        let (films, wall_films) = self.films.split_at_mut(self.between_spheres);
        let spheres = Resist { effects: self.effects, viscosity: self.viscosity, dt, wall: None };
        let walls = Resist { wall: Some(self.slip_walls), ..spheres };
        for (films, pairs, resist) in [(films, pairs, spheres), (wall_films, wall_pairs, walls)] {
            let tasks = films.par_chunks_mut(EDGES_PER_TASK).zip(pairs.par_chunks(EDGES_PER_TASK));
            tasks.for_each(|(films, pairs)| {
                for (films, pairs) in films.chunks_mut(BLOCK).zip(pairs.chunks(BLOCK)) {
                    for (film, &pair) in films.iter_mut().zip(pairs) {
                        film.measure(&bodies, pair, resist.effects.roughness);
                    }
                    resist.write(films);
                }
            });
        }
        self.gather(fluid);
        self.push_walls(&bodies, dt);
    }

    /// Adds up the forces on each sphere in the order of its edges.
    fn gather(&mut self, fluid: &[Vec3]) {
        let EdgeForces { adjacency, pairs, films, force, torque, .. } = self;
        let turns = !torque.is_empty();
        let serial = EDGES_PER_TASK / 4;
        in_tasks(force, 2 * serial, serial, &|k, force| {
            let on = |&e: &u32| {
                let film = &films[e as usize];
                let sign = if pairs[e as usize][0] as usize == k { 1.0 } else { -1.0 };
                sign * (film.drag() - film.force * film.normal)
            };
            *force = adjacency.of(k).iter().map(on).fold(Vec3::zeros(), |sum, f| sum + f);
        });
        if turns {
            in_tasks(torque, 2 * serial, serial, &|k, torque| {
                let on = |&e: &u32| {
                    let film = &films[e as usize];
                    let second = usize::from(pairs[e as usize][0] as usize != k);
                    let arm = film.arms[second] * film.normal;
                    arm.cross(&film.drag()) + [1.0, -1.0][second] * film.couple()
                };
                *torque = adjacency.of(k).iter().map(on).fold(Vec3::zeros(), |sum, t| sum + t);
            });
        }
        self.join(fluid);
    }

    /// Adds the force of the pores' pressures on each sphere (N).
    pub fn join(&mut self, fluid: &[Vec3]) {
        for ((total, force), fluid) in self.total.iter_mut().zip(&self.force).zip(fluid) {
            *total = force + fluid;
        }
    }

    fn push_walls(&mut self, bodies: &Bodies, dt: f64) {
        self.wall_force = [Vec3::zeros(); 6];
        self.wall_resistance = PerWall::default();
        let normal = self.effects.normal_lubrication;
        let walls = self.between_spheres..;
        for (film, pair) in self.films[walls.clone()].iter().zip(&self.pairs[walls]) {
            let Some(wall) = bodies.wall(pair[1]) else { continue };
            self.wall_force[wall.index()] += film.force * film.normal - film.drag();
            if normal {
                self.wall_resistance[wall] +=
                    normal_lubrication::resistance(film, self.factor_of(true), self.viscosity, dt);
            }
        }
    }

    /// c h / (μ R²) of the films between spheres, or of those at walls.
    pub(super) fn factor_of(&self, at_wall: bool) -> f64 {
        if at_wall && !self.slip_walls { HELD } else { SYMMETRIC }
    }

    /// Whether a film is that of a wall.
    pub(super) fn is_at_wall(&self, edge: usize) -> bool {
        edge >= self.between_spheres
    }

    /// What resists in a block of films, of spheres or of walls.
    pub(super) fn resist(&self, at_wall: bool) -> Resist {
        let wall = at_wall.then_some(self.slip_walls);
        Resist { effects: self.effects, viscosity: self.viscosity, dt: 0.0, wall }
    }

    /// Force of pressures and edges on each sphere in the last step (N).
    pub fn total(&self) -> &[Vec3] {
        &self.total
    }

    /// Torque of the edges on each sphere in the last step (N·m), where any turns them.
    pub fn torque(&self) -> Option<&[Vec3]> {
        (!self.torque.is_empty()).then_some(&self.torque[..])
    }

    /// Force of the edges on each wall in the last step (N).
    pub fn wall_force(&self) -> &[Vec3; 6] {
        &self.wall_force
    }

    /// What the films take off the outward force on each wall per outward speed (N·s/m).
    pub fn wall_resistance(&self) -> &PerWall<f64> {
        &self.wall_resistance
    }
}

/// The effects that a block of films goes through.
#[derive(Clone, Copy)]
pub struct Resist {
    effects: EdgeEffects,
    viscosity: f64,
    dt: f64,
    /// At walls, whether the fluid slips.
    wall: Option<bool>,
}

impl Resist {
    /// Writes resistances and forces of films that have been measured.
    fn write(&self, films: &mut [Film]) {
        self.write_drags(films);
        if self.effects.normal_lubrication {
            let factor = if self.wall == Some(false) { HELD } else { SYMMETRIC };
            squeeze(films, factor, self.viscosity, self.dt);
        }
    }

    /// Writes all resistances but that to closing.
    pub fn write_drags(&self, films: &mut [Film]) {
        let Resist { effects, viscosity, .. } = *self;
        if effects.viscous_shear && self.wall != Some(true) {
            viscous_shear::resist(films, viscosity);
        }
        if self.wall.is_some() {
            return;
        }
        if effects.shear_lubrication {
            shear_lubrication::resist(films, viscosity);
        }
        if effects.pump_torque {
            pump_torque::resist(films, viscosity);
        }
        if effects.twist_torque {
            twist_torque::resist(films, viscosity);
        }
    }
}

/// A film that has not been measured yet, with what does not change.
fn still(dem: &Dem, modulus: Option<f64>, [i, j]: [u32; 2], area: f64) -> Film {
    let (p, materials) = (dem.storage(), dem.materials());
    let young = |k: u32| p.material.get(k as usize).map_or(0, |&m| usize::from(m));
    let young = |k: u32| materials.get(young(k)).map_or(0.0, |m: &Material| m.young);
    let mean = |a: f64, b: f64| if a == b { a } else { 2.0 * a * b / (a + b) };
    let r = p.radius[i as usize];
    // As linear contacts have it.
    let (radius, smaller, reduced, young) = match p.radius.get(j as usize) {
        Some(&s) => (0.5 * (r + s), r.min(s), 2.0 * r * s / (r + s), mean(young(i), young(j))),
        None => (r, r, r, mean(young(i), dem.wall_material().young)),
    };
    Film { radius, smaller, area, stiffness: modulus.unwrap_or(young) * reduced, ..Film::default() }
}
