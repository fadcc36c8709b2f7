//! The sparse operators of the coupled problem, built once per remesh:
//! `G` (conductances), `E` (pore volume rates) and `F` (forces).

use rayon::prelude::*;

use super::boundary_flux::BoundaryFlux;
use super::storage::{Storage, sealed_and_closed};
use super::{Derivatives, NONE, Network, PoreConditions, SealedPores, Tessellation};
use crate::Vec3;
use crate::parallel::{TASK, for_each, in_tasks, parts, prefetch, runs};
use crate::solver::SymmetricCsc;

/// Below this many rows of forces one thread is faster; a task takes so many of them. Fewer than
/// [`SERIAL`](crate::parallel::SERIAL) and [`TASK`]: a sphere is a vertex of 24 pores or so.
const SERIAL_ROWS: usize = 2_048;
const ROWS_PER_TASK: usize = 256;

/// How many vectors of space ahead of a loop memory is asked for, at most: 1.5 kB.
const PREFETCH_VECTORS: isize = 64;

/// `G`, `E` and `F` for one network and its boundary conditions.
#[derive(Clone, Debug)]
pub struct Operators {
    /// Conductance matrix over the free pores (m³/(Pa·s)), lower triangle.
    pub matrix: SymmetricCsc,
    /// Pore of each unknown.
    pub pore_of: Vec<u32>,
    /// Unknown of each pore, or [`NONE`] where the pressure is imposed.
    pub unknown_of: Vec<u32>,
    conditions: PoreConditions,
    sealed: SealedPores,
    /// For each unknown what its pore is joined to.
    pub(super) stencil: Vec<Stencil>,
    /// Where a term stores fluid.
    pub(super) storage: Option<Box<Storage>>,
    pub(super) boundary_flux: BoundaryFlux,
    pub(super) volume: VolumeRate,
    pub(super) forces: Forces,
}

/// What depends on which pressures are unknown.
struct Parts {
    matrix: SymmetricCsc,
    pore_of: Vec<u32>,
    unknown_of: Vec<u32>,
    boundary_flux: BoundaryFlux,
    forces: Forces,
    stencil: Vec<Stencil>,
}

impl Parts {
    fn new(network: &Network, derivatives: &Derivatives, conditions: &PoreConditions) -> Parts {
        let mut unknown_of = vec![NONE; network.pores()];
        let mut pore_of = Vec::with_capacity(network.pores());
        for (i, unknown) in unknown_of.iter_mut().enumerate() {
            if conditions.set_of(i).is_none() {
                *unknown = pore_of.len() as u32;
                pore_of.push(i as u32);
            }
        }
        let assemble = || assemble(network, &unknown_of, &pore_of);
        let boundary_flux = || BoundaryFlux::new(network, conditions);
        let forces = || Forces::new(&network.tessellation, &derivatives.force_coefficient);
        let stencil = || pore_of.par_iter().map(|&i| Stencil::of(network, i)).collect();
        let last = || rayon::join(forces, stencil);
        let (matrix, (boundary_flux, (forces, stencil))) =
            rayon::join(assemble, || rayon::join(boundary_flux, last));
        Parts { matrix, pore_of, unknown_of, boundary_flux, forces, stencil }
    }
}

/// What all pores together swallow (m³/s): the sum of their volume rates, and that of
/// the sizes of these.
#[derive(Clone, Copy)]
pub(super) struct NetVolumeRate {
    sum: f64,
    moved: f64,
    least: f64,
}

impl NetVolumeRate {
    pub fn of(volume_rate: &[f64]) -> NetVolumeRate {
        let sums = |part: &[f64]| part.iter().fold((0.0, 0.0), |(g, m), v| (g + v, m + v.abs()));
        let (sum, moved): (f64, f64) =
            parts(volume_rate, sums, (0.0, 0.0), |(g, m), (v, w)| (g + v, m + w));
        NetVolumeRate { sum, moved, least: 0.0 }
    }

    /// The same, measured by no less than this flow (m³/s).
    pub fn at_least(self, least: f64) -> NetVolumeRate {
        NetVolumeRate { least, ..self }
    }

    /// The flow (m³/s) that it is measured by at least.
    pub fn least(self) -> f64 {
        self.least
    }

    /// See [`Operators::imbalance`], for the flux from each set.
    pub fn imbalance(self, flux: &[f64]) -> f64 {
        let (net, through) = flux.iter().fold((0.0, 0.0f64), |(n, t), q| (n + q, t + q.abs()));
        let larger = through.max(self.sum.abs()).max(0.01 * self.moved).max(self.least);
        if larger > 0.0 { (net - self.sum).abs() / larger } else { 0.0 }
    }
}

/// A pore's throats: the pores beyond, and the conductances (m³/(Pa·s)). Where there is
/// none, the pore itself and zero.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stencil {
    pore: [u32; 4],
    pub conductance: [f64; 4],
}

impl Stencil {
    fn of(network: &Network, pore: u32) -> Stencil {
        let mut around = network.tessellation.neighbors[pore as usize];
        let mut conductance = network.conductances_of(pore as usize);
        for (j, g) in around.iter_mut().zip(&mut conductance) {
            if *j == NONE {
                (*j, *g) = (pore, 0.0);
            }
        }
        Stencil { pore: around, conductance }
    }
}

/// `E`: per pore the vertices and the volume's derivative.
#[derive(Clone, Debug)]
pub(super) struct VolumeRate {
    vertices: Vec<[u32; 4]>,
    pub gradient: Vec<[Vec3; 4]>,
}

/// `F` by rows: for each sphere, then each wall, the pores that it is a vertex of, and the force
/// per unit of their pressure (m²).
#[derive(Clone, Debug)]
pub(super) struct Forces {
    pub pores: Incidence,
    pub coefficient: Vec<Vec3>,
}

/// For each sphere, then each wall, the pores that it is a vertex of.
#[derive(Clone, Debug)]
pub(super) struct Incidence {
    start: Vec<u32>,
    /// Pore of each entry.
    pub pore: Vec<u32>,
}

impl Incidence {
    /// The entries of a vertex.
    pub(super) fn range(&self, vertex: usize) -> std::ops::Range<usize> {
        self.start[vertex] as usize..self.start[vertex + 1] as usize
    }

    /// The pores around a vertex.
    pub(super) fn of(&self, vertex: usize) -> &[u32] {
        &self.pore[self.range(vertex)]
    }
}

impl Operators {
    /// [`Operators::with_conditions`] of what is known to fit together.
    pub(super) fn assemble(
        network: &Network,
        derivatives: Derivatives,
        mut conditions: PoreConditions,
        mut storage: Option<Storage>,
    ) -> Operators {
        // The search is serial: the other parts keep the other threads busy.
        let find = || sealed_and_closed(network, &conditions, storage.as_mut());
        let build = || Parts::new(network, &derivatives, &conditions);
        let ((sealed, closed), mut parts) = rayon::join(find, build);
        if !sealed.is_empty() {
            conditions.pin(sealed.pinned());
            parts = Parts::new(network, &derivatives, &conditions);
        }
        let Parts { matrix, pore_of, unknown_of, boundary_flux, forces, stencil } = parts;
        if let Some(storage) = &mut storage {
            storage.close(closed, &unknown_of);
        }
        let mut operators = Operators {
            matrix,
            pore_of,
            unknown_of,
            boundary_flux,
            conditions,
            sealed,
            stencil,
            storage: storage.map(Box::new),
            volume: VolumeRate {
                vertices: network.tessellation.cells.clone(),
                gradient: derivatives.volume_gradient,
            },
            forces,
        };
        operators.write_diagonal();
        operators
    }

    /// What outlives operators that are no longer needed.
    pub(super) fn retire(self) -> (Incidence, SymmetricCsc) {
        (self.forces.pores, self.matrix)
    }

    /// Number of unknown pressures.
    pub fn unknowns(&self) -> usize {
        self.pore_of.len()
    }

    /// Number of spheres; rows of `F` are theirs and the walls'.
    pub(super) fn spheres(&self) -> usize {
        self.forces.pores.start.len() - 7
    }

    /// The condition of each pore.
    pub fn conditions(&self) -> &PoreConditions {
        &self.conditions
    }

    /// The condition of each pore, whose pressures may change.
    pub(super) fn conditions_mut(&mut self) -> &mut PoreConditions {
        &mut self.conditions
    }

    /// Writes the imposed pressures (Pa) of their pores.
    pub(super) fn write_imposed(&self, reference: f64, pressure: &mut [f64]) {
        for_each(pressure, &|i, p| *p = self.imposed(i).map_or(*p, |imposed| imposed - reference));
    }

    /// The pores without a path to an imposed pressure.
    pub fn sealed_pores(&self) -> &SealedPores {
        &self.sealed
    }

    /// Pressure imposed on a pore (Pa); `None` for a free one, and for a number that no pore has.
    pub fn imposed(&self, pore: usize) -> Option<f64> {
        self.conditions.pressure_of(pore)
    }

    /// `V̇ = E v`: the rate at which each pore grows (m³/s), from the velocities
    /// of spheres and walls (m/s; a wall's along its axis).
    pub(super) fn evaluate_volume_rate(
        &self,
        velocity: &[Vec3],
        wall_velocity: &[f64; 6],
        out: &mut [f64],
    ) {
        let spheres = velocity.len();
        let rate = |i: usize| {
            prefetch(&self.volume.gradient[i], PREFETCH_VECTORS / 4);
            let mut sum = 0.0;
            for (&v, g) in self.volume.vertices[i].iter().zip(&self.volume.gradient[i]) {
                sum += match velocity.get(v as usize) {
                    Some(u) => g.dot(u),
                    None => {
                        let wall = v as usize - spheres;
                        g[wall / 2] * wall_velocity[wall]
                    }
                };
            }
            sum
        };
        for_each(out, &|i, v| *v = rate(i));
    }

    /// Spreads the solution over all pores, imposed ones included (Pa): all of them above the
    /// reference.
    pub(super) fn evaluate_pressures(&self, solution: &[f64], reference: f64, out: &mut [f64]) {
        for_each(out, &|i, p| {
            *p = match self.unknown_of[i] {
                NONE => self.imposed(i).map_or(0.0, |imposed| imposed - reference),
                u => solution[u as usize],
            }
        });
    }

    /// `f = F p`: the fluid's force on each sphere and each wall (N).
    pub(super) fn evaluate_forces(
        &self,
        pressure: &[f64],
        spheres: &mut [Vec3],
        walls: &mut [Vec3; 6],
    ) {
        let n = spheres.len();
        let row = |i: usize, f: &mut Vec3| *f = self.forces.row(i, pressure);
        in_tasks(spheres, SERIAL_ROWS, ROWS_PER_TASK, &row);
        for (w, f) in walls.iter_mut().enumerate() {
            *f = self.forces.row(n + w, pressure);
        }
    }

    /// Writes the flux from each set of pores with an imposed pressure, positive into the box
    /// (m³/s): through the walls, then from the sets beside them
    /// ([`PoreConditions`]); as many as `flux` has room for.
    pub(super) fn evaluate_flux(&self, pressure: &[f64], volume_rate: &[f64], flux: &mut [f64]) {
        self.boundary_flux.write(pressure, volume_rate, flux);
    }

    /// What each free pore gains through its throats less what it swallows
    /// (m³/s), throat by throat: the difference of pressures comes first, so
    /// that a wide throat between pores of nearly one pressure does not drown
    /// the narrow ones, as it does in the rows of the assembled matrix.
    pub(super) fn evaluate_residual(&self, pressure: &[f64], volume_rate: &[f64], out: &mut [f64]) {
        match self.storage() {
            None => self.residual_with(pressure, |i| volume_rate[i], out),
            Some(storage) => {
                let taken = |i: usize| volume_rate[i] + storage.uptake(i, pressure[i]);
                self.residual_with(pressure, taken, out);
            }
        }
    }

    /// The same for pores that take up so much (m³/s).
    #[inline(always)]
    fn residual_with(
        &self,
        pressure: &[f64],
        taken: impl Fn(usize) -> f64 + Sync,
        out: &mut [f64],
    ) {
        for_each(out, &|u, residual| {
            let i = self.pore_of[u] as usize;
            let Stencil { pore, conductance } = self.stencil_of(u);
            let here = pressure[i];
            let mut sum = -taken(i);
            for (&j, g) in pore.iter().zip(conductance) {
                sum += g * (pressure[j as usize] - here);
            }
            *residual = sum;
        });
    }

    /// `G d` throat by throat (see [`Operators::residual`]), for `d` spread over
    /// all pores.
    pub(super) fn conduct(&self, spread: &[f64], out: &mut [f64]) {
        match self.storage() {
            None => self.conduct_with(spread, |_, _| 0.0, out),
            Some(storage) => self.conduct_with(spread, |i, d| storage.rate(i) * d, out),
        }
    }

    #[inline(always)]
    fn conduct_with(
        &self,
        spread: &[f64],
        stored: impl Fn(usize, f64) -> f64 + Sync,
        out: &mut [f64],
    ) {
        for_each(out, &|u, product| {
            let i = self.pore_of[u] as usize;
            let Stencil { pore, conductance } = self.stencil_of(u);
            let here = spread[i];
            let mut sum = stored(i, here);
            for (&j, g) in pore.iter().zip(conductance) {
                sum += g * (here - spread[j as usize]);
            }
            *product = sum;
        });
    }

    #[inline(always)]
    fn stencil_of(&self, u: usize) -> &Stencil {
        let stencil = &self.stencil[u];
        prefetch(std::slice::from_ref(stencil), PREFETCH_VECTORS / 2);
        stencil
    }

    /// Takes over conductances that have changed.
    pub(super) fn update_stencils(&mut self, network: &Network) {
        let pore_of = &self.pore_of;
        for_each(&mut self.stencil, &|u, stencil| *stencil = Stencil::of(network, pore_of[u]));
    }
}

impl Forces {
    fn new(tessellation: &Tessellation, coefficients: &[[Vec3; 4]]) -> Forces {
        let cells = &tessellation.cells;
        let rows = tessellation.spheres + 6;
        let mut start = vec![0u32; rows + 1];
        for &v in cells.as_flattened() {
            start[v as usize + 1] += 1;
        }
        for row in 0..rows {
            start[row + 1] += start[row];
        }
        let mut next = start.clone();
        let (mut pore, mut corner) = (vec![0; cells.len() * 4], vec![0u8; cells.len() * 4]);
        for (i, cell) in cells.iter().enumerate() {
            for (k, &v) in cell.iter().enumerate() {
                let at = next[v as usize] as usize;
                next[v as usize] += 1;
                pore[at] = i as u32;
                corner[at] = k as u8;
            }
        }
        let entries = (&pore, &corner).into_par_iter();
        let coefficient = entries.map(|(&i, &k)| coefficients[i as usize][k as usize]).collect();
        Forces { pores: Incidence { start, pore }, coefficient }
    }

    fn row(&self, row: usize, pressure: &[f64]) -> Vec3 {
        let coefficients = &self.coefficient[self.pores.range(row)];
        prefetch(coefficients, PREFETCH_VECTORS);
        self.pores
            .of(row)
            .iter()
            .zip(coefficients)
            .fold(Vec3::zeros(), |sum, (&p, per_pa)| sum + pressure[p as usize] * per_pa)
    }
}

fn assemble(network: &Network, unknown_of: &[u32], pore_of: &[u32]) -> SymmetricCsc {
    let column = |u: usize| Column::new(network, unknown_of, u as u32, pore_of[u] as usize);
    let unknowns = pore_of.len();
    let counts = (0..unknowns).into_par_iter().map(|u| 1 + below(network, unknown_of, pore_of, u));
    let mut col_ptr: Vec<i64> = counts.collect();
    let mut entries = 0;
    for count in &mut col_ptr {
        entries += std::mem::replace(count, entries);
    }
    col_ptr.push(entries);
    let (mut row_idx, mut values) = (vec![0; entries as usize], vec![0.0; entries as usize]);
    let start = |u: usize| col_ptr[u] as usize;
    (runs(&mut row_idx, unknowns, start), runs(&mut values, unknowns, start))
        .into_par_iter()
        .enumerate()
        .for_each(|(task, (row_idx, values))| {
            let mut at = 0;
            for u in task * TASK..unknowns.min((task + 1) * TASK) {
                let column = column(u);
                row_idx[at] = u as i64;
                values[at] = column.diagonal;
                for &(row, g) in &column.below[..column.count] {
                    at += 1;
                    row_idx[at] = i64::from(row);
                    values[at] = -g;
                }
                at += 1;
            }
        });
    SymmetricCsc { n: unknowns, col_ptr, row_idx, values }
}

/// How many entries of a column lie below the diagonal.
fn below(network: &Network, unknown_of: &[u32], pore_of: &[u32], u: usize) -> i64 {
    let around = network.tessellation.neighbors[pore_of[u] as usize];
    let unknowns = around.into_iter().filter(|&j| j != NONE).map(|j| unknown_of[j as usize]);
    unknowns.filter(|&row| row != NONE && row > u as u32).count() as i64
}

/// One column of `G`: at most four neighbours.
struct Column {
    diagonal: f64,
    below: [(u32, f64); 4],
    count: usize,
}

impl Column {
    fn new(network: &Network, unknown_of: &[u32], u: u32, i: usize) -> Column {
        let mut column = Column { diagonal: 0.0, below: [(0, 0.0); 4], count: 0 };
        for (j, g) in network.tessellation.neighbors[i].into_iter().zip(network.conductances_of(i))
        {
            if j == NONE {
                continue;
            }
            column.diagonal += g;
            let row = unknown_of[j as usize];
            if row != NONE && row > u {
                column.below[column.count] = (row, g);
                column.count += 1;
            }
        }
        column.below[..column.count].sort_unstable_by_key(|(row, _)| *row);
        column
    }
}
