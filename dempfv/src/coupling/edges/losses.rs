//! What the films dissipate, by cause.

use rayon::prelude::*;

use super::film::{Bodies, Film, Relative};
use super::forces::{EDGES_PER_TASK, EdgeForces};
use crate::WallId;
use crate::dem::{Dem, FilmLosses};

impl EdgeForces {
    /// Books what the forces of the step did, whose length was `dt` (s), after the spheres have moved:
    /// each over half the way of the step before and half that of this one, as the leapfrog's kinetic
    /// energy has it.
    pub fn book(&mut self, dem: &mut Dem, dt: f64) {
        let dropped = std::mem::take(&mut self.dropped);
        if !dem.tracks_energy() {
            return;
        }
        let bodies = Bodies::of(dem);
        let (last_dt, pairs) = (self.last_dt, &self.pairs);
        let tasks = self.films.par_chunks(EDGES_PER_TASK).zip(pairs.par_chunks(EDGES_PER_TASK));
        tasks.zip(&mut self.losses).for_each(|((films, pairs), losses)| {
            *losses = FilmLosses::default();
            for (film, &pair) in films.iter().zip(pairs) {
                lose(film, &film.relative(&bodies, pair), [last_dt, dt], losses);
            }
        });
        let mut sum = FilmLosses::default();
        self.losses.iter().for_each(|losses| sum.join(losses));
        sum.normal_lubrication += dropped;
        sum.elastic -= dropped;
        let after = dem.walls().map(|wall| wall.velocity);
        let pushed = WallId::ALL.map(|wall| {
            let way = 0.5 * (last_dt * self.walls_before[wall] + dt * after[wall]);
            -self.wall_force[wall.index()][wall.axis()] * way
        });
        dem.book_films(&sum, pushed.iter().sum());
    }
}

/// Adds what one film took.
fn lose(film: &Film, after: &Relative, [last_dt, dt]: [f64; 2], losses: &mut FilmLosses) {
    let slip = 0.5 * film.slip.dot(&(last_dt * film.slip + dt * after.slip));
    losses.viscous_shear += film.viscous_shear * slip;
    losses.shear_lubrication += film.shear_lubrication * slip;
    let turned = 0.5 * (last_dt * film.turn + dt * after.turn);
    let along = film.turn.dot(&film.normal) * turned.dot(&film.normal);
    losses.pump_torque += film.pump * (film.turn.dot(&turned) - along);
    losses.twist_torque += film.twist * along;
    let way = 0.5 * (last_dt * film.closing + dt * after.closing);
    let elastic = 0.5 * (film.force.powi(2) - film.force_before.powi(2)) / film.stiffness;
    losses.elastic += elastic;
    losses.normal_lubrication += film.force * way - elastic;
}
