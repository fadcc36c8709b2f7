//! The pore network: cells, pores and throats as flat arrays.

use rayon::prelude::*;

use super::conductances::Conductances;
use super::flat_pores::FlatPores;
use super::frame::{FACETS, Frame};
use super::lanes::LANES;
use super::packing_check::{check_box, check_packing, require_finite, require_length};
use super::pore::Pore;
use super::pore_batch::PoreBatch;
use super::throat::{Throat, ThroatLimit, ThroatRules, throat};
use super::throat_batch::ThroatBatch;
use super::{Fluid, NONE, NetworkRemarks, PeriodicNetwork, PfvError, Tessellation};
use crate::parallel::{TASK, for_each, runs};
use crate::{Aabb, Vec3};

const NAN: Vec3 = Vec3::new(f64::NAN, f64::NAN, f64::NAN);

/// Throats between pores, each once; sorted by first pore.
#[derive(Clone, Debug, Default)]
pub struct Throats {
    /// The two pores, the smaller number first.
    pub pores: Vec<[u32; 2]>,
    /// Conductance (m³/(Pa·s)).
    pub conductance: Vec<f64>,
}

/// The pores of a packing and the throats between them.
///
/// Pore `i` is cell `i` of the tessellation. Coordinates are in metres.
#[derive(Clone, Debug)]
pub struct Network {
    /// Vertices and neighbours of the pores.
    pub tessellation: Tessellation,
    /// The box (m).
    pub bounds: Aabb,
    /// Dynamic viscosity that the conductances were computed with (Pa·s).
    pub viscosity: f64,
    /// Power centre of each pore (m): the point of equal power to its four vertices, where
    /// conductances are measured from. It may lie outside the pore; the middle of its volume
    /// is its centroid ([`Network::centroids`]).
    pub center: Vec<Vec3>,
    /// Signed volume of each pore, solids included (m³); negative where motion
    /// turned a pore inside out.
    pub volume: Vec<f64>,
    /// The throats.
    pub throats: Throats,
    /// Throat across the facet opposite each vertex of a pore, or [`NONE`].
    pub throat_of: Vec<[u32; 4]>,
    /// What is unusual, as the network was built.
    pub remarks: NetworkRemarks,
    /// Pores that spheres fill, as far as they close all throats; sorted.
    pub(super) filled: Vec<u32>,
    pub(super) flat: FlatPores,
    /// Where conductances are not what the geometry says.
    pub(super) conductances: Option<Box<Conductances>>,
    pub(super) periodic: Option<Box<PeriodicNetwork>>,
}

/// What operators are made of, and nothing else needs: 200 bytes a pore.
#[derive(Clone, Debug)]
pub struct Derivatives {
    /// Derivative of each pore's volume with respect to its four vertices (m²).
    pub volume_gradient: Vec<[Vec3; 4]>,
    /// Force per unit of the pore's pressure on each of its vertices (m²).
    pub force_coefficient: Vec<[Vec3; 4]>,
}

impl Network {
    /// Triangulates the packing and evaluates every pore and throat.
    ///
    /// `position` and `radius` have one entry per sphere, in metres; every centre must lie
    /// inside `bounds` or on its surface.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] names the argument that cannot be right, and which of its
    /// entries: arrays of different lengths, a centre outside the box, a radius or
    /// viscosity that is not positive, an inverted box, radii that have no digits in a box so far
    /// from the origin or are a thousand times the box, and whatever is not finite. Further when
    /// there is no sphere, the triangulation fails, or a pore's geometry or conductance is not
    /// finite.
    pub fn new(
        position: &[Vec3],
        radius: &[f64],
        bounds: Aabb,
        fluid: &Fluid,
    ) -> Result<(Network, Derivatives), PfvError> {
        check_packing(position, radius, &bounds, fluid)?;
        let frame = Frame::new(position, radius, &bounds);
        let tessellation = Tessellation::new(&frame)?;
        let mut pores = evaluate_pores(&frame, &tessellation)?;
        let mut flat = FlatPores::of(&frame, &tessellation);
        flat.place(&frame, &tessellation, &mut pores.center);
        let (sites, throat_of) = number_throats(&tessellation);
        let rules = fluid.throat_rules();
        let evaluated = evaluate_throats(&frame, &tessellation, &pores.center, &sites, rules);
        let conductance = conductances(&evaluated, fluid);
        check_finite(&tessellation, &sites, &conductance)?;
        let force_coefficient =
            force_coefficients(&tessellation, &sites, &evaluated, &throat_of, &pores.gradient);
        let remarks = remarks(&tessellation, &pores, &evaluated);
        let filled = match remarks.closed_throats {
            0 => vec![],
            _ => filled_pores(&frame, &tessellation, &pores.center, &throat_of, &conductance),
        };
        let Pores { mut center, volume, gradient: volume_gradient } = pores;
        center.par_iter_mut().for_each(|x| *x += bounds.min);
        let network = Network {
            remarks,
            filled,
            flat,
            conductances: None,
            periodic: None,
            bounds,
            viscosity: fluid.viscosity,
            center,
            volume,
            throats: Throats { pores: sites.par_iter().map(|t| t.pores).collect(), conductance },
            throat_of,
            tessellation,
        };
        Ok((network, Derivatives { volume_gradient, force_coefficient }))
    }

    /// Number of pores.
    pub fn pores(&self) -> usize {
        self.tessellation.cells.len()
    }

    /// Whether spheres fill a pore, so that there is no fluid in it: they close its throats and
    /// cover its centre. False for a number that no pore has.
    pub fn is_filled(&self, pore: usize) -> bool {
        u32::try_from(pore).is_ok_and(|pore| self.filled.binary_search(&pore).is_ok())
    }

    /// Volumes (m³) of the same cells when the vertices have moved to
    /// `position` and the walls to `bounds`: the tessellation is kept.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for positions that are not one per sphere or not finite, and
    /// for an inverted box.
    pub fn volumes_at(&self, position: &[Vec3], bounds: &Aabb) -> Result<Vec<f64>, PfvError> {
        self.check_vertices(position, bounds)?;
        // The volume does not depend on the radii.
        let radius = vec![0.0; position.len()];
        let mut volume = vec![0.0; self.pores()];
        self.write_volumes(&Frame::new(position, &radius, bounds), &mut volume);
        Ok(volume)
    }

    /// The same of positions that are known to fit.
    pub(super) fn write_volumes(&self, frame: &Frame, volume: &mut [f64]) {
        let cells = &self.tessellation.cells;
        for_each(volume, &|i, volume| *volume = Pore::volume(frame, cells[i]));
    }

    /// Refuses what the vertices of this network cannot have moved to.
    pub(super) fn check_vertices(&self, position: &[Vec3], bounds: &Aabb) -> Result<(), PfvError> {
        require_length("position", position.len(), self.tessellation.spheres, "spheres")?;
        require_finite("position", position)?;
        if self.periodic.is_some() {
            let problem = "is given for a network in a periodic cell, which has none".to_owned();
            return Err(PfvError::InvalidInput { argument: "bounds", index: None, problem });
        }
        check_box(bounds)
    }

    /// Conductance across the facet opposite each vertex of a pore; 0 where
    /// there is no throat.
    ///
    /// # Panics
    /// For a number that no pore has, as an index beyond a slice does.
    pub fn conductances_of(&self, pore: usize) -> [f64; 4] {
        self.throat_of[pore]
            .map(|t| if t == NONE { 0.0 } else { self.throats.conductance[t as usize] })
    }
}

/// The pores, in the coordinates of the frame.
pub(super) struct Pores {
    pub center: Vec<Vec3>,
    pub volume: Vec<f64>,
    pub gradient: Vec<[Vec3; 4]>,
}

/// A pore is flat below this share of the volume that its facets would span upright.
const FLAT_VOLUME: f64 = 1e-10;

pub(super) fn remarks(t: &Tessellation, pores: &Pores, throats: &[Throat]) -> NetworkRemarks {
    let limited = |limit: ThroatLimit| {
        throats.par_iter().with_min_len(TASK).filter(|t| t.limit == limit).count() as u32
    };
    let shape = |(i, (v, gradient)): (usize, (&f64, &[Vec3; 4]))| {
        // At walls a pore may be flat, or on the wrong side, by the bulge of the huge spheres.
        let inside = t.cells[i].iter().all(|&v| (v as usize) < t.spheres);
        let facet = gradient.iter().map(Vec3::norm).fold(0.0, f64::max);
        let flat = v.abs() <= FLAT_VOLUME * facet.powf(1.5);
        [inside && flat, inside && !flat && *v < 0.0].map(u32::from)
    };
    let both = (&pores.volume, &pores.gradient).into_par_iter();
    let [flat_pores, inverted_pores] = both
        .with_min_len(TASK)
        .enumerate()
        .map(shape)
        .reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    NetworkRemarks {
        throats: throats.len() as u32,
        closed_throats: limited(ThroatLimit::Closed),
        overlapped_throats: limited(ThroatLimit::Overlap),
        tube_throats: limited(ThroatLimit::Tube),
        flat_pores,
        inverted_pores,
        ..NetworkRemarks::default()
    }
}

/// Pores without an open throat whose centre no sphere leaves free.
pub(super) fn filled_pores(
    frame: &Frame,
    t: &Tessellation,
    center: &[Vec3],
    throat_of: &[[u32; 4]],
    conductance: &[f64],
) -> Vec<u32> {
    let closed =
        |i: usize| throat_of[i].iter().all(|&t| t == NONE || conductance[t as usize] <= 0.0);
    let covered = |i: usize| {
        t.cells[i]
            .iter()
            .filter_map(|&v| Some((frame.x.get(v as usize)?, frame.r[v as usize])))
            .any(
                // The centre has the same power to all of them, but for round-off.
                |(x, r)| (center[i] - x).norm_squared() <= r * r,
            )
    };
    (0..t.cells.len()).filter(|&i| closed(i) && covered(i)).map(|i| i as u32).collect()
}

/// Where a throat is: its pores, and the facet as the first pore numbers it.
#[derive(Clone, Copy, Default)]
pub(super) struct ThroatSite {
    pub pores: [u32; 2],
    pub facet: u32,
}

impl ThroatSite {
    /// The facet's vertices, counterclockwise seen from outside the first pore.
    pub fn facet(&self, cells: &[[u32; 4]]) -> [u32; 3] {
        let cell = &cells[self.pores[0] as usize];
        let [a, b, c] = FACETS[self.facet as usize];
        [cell[a], cell[b], cell[c]]
    }
}

pub(super) fn evaluate_pores(frame: &Frame, t: &Tessellation) -> Result<Pores, PfvError> {
    let blocks = t.cells.par_chunks(LANES).map(|cells| pores_at(frame, cells));
    let (center, (volume, gradient)): (Vec<_>, (Vec<_>, Vec<_>)) = blocks.unzip();
    let mut pores = Pores {
        center: Vec::into_flattened(center),
        volume: Vec::into_flattened(volume),
        gradient: Vec::into_flattened(gradient),
    };
    pores.center.truncate(t.cells.len());
    pores.volume.truncate(t.cells.len());
    pores.gradient.truncate(t.cells.len());
    let finite = |(x, v): (&Vec3, &f64)| x.iter().chain([v]).all(|v| v.is_finite());
    let Some(i) = (&pores.center, &pores.volume).into_par_iter().position_first(|p| !finite(p))
    else {
        return Ok(pores);
    };
    let (pore, vertices) = (i as u32, t.vertices_of(i as u32));
    Err(match Pore::new(frame, t.cells[i]) {
        None => PfvError::BadPore { pore, vertices },
        Some(_) => PfvError::NotFinite { pore, vertices, quantity: "the pore's centre or volume" },
    })
}

pub(super) type Block<T> = [T; LANES];

/// Centres, volumes and gradients.
pub(super) type PoreBlock = (Block<Vec3>, (Block<f64>, Block<[Vec3; 4]>));

/// Centres, volumes and gradients of up to [`LANES`] pores; not a number where
/// there is none. Loops and no closures: these the compiler unrolls.
pub(super) fn pores_at(frame: &Frame, cells: &[[u32; 4]]) -> PoreBlock {
    let mut batch = PoreBatch::new();
    for (l, cell) in cells.iter().enumerate().filter(|(_, cell)| frame.are_spheres(cell)) {
        for (k, &v) in cell.iter().enumerate() {
            batch.set(l, k, &frame.x[v as usize], frame.r[v as usize]);
        }
    }
    batch.evaluate();
    let mut out = ([NAN; LANES], ([f64::NAN; LANES], [[NAN; 4]; LANES]));
    for (l, cell) in cells.iter().enumerate() {
        let inside = frame.are_spheres(cell) && !batch.is_flat(l);
        let pore = if inside { Some(batch.pore(l)) } else { Pore::new(frame, *cell) };
        if let Some(pore) = pore {
            out.0[l] = pore.center;
            out.1.0[l] = pore.volume;
            out.1.1[l] = pore.gradient;
        }
    }
    out
}

/// Numbers each facet between two pores once, by its smaller pore.
pub(super) fn number_throats(t: &Tessellation) -> (Vec<ThroatSite>, Vec<[u32; 4]>) {
    // Throats before each pore's own.
    let mut start = Vec::with_capacity(t.cells.len());
    let mut total = 0;
    for (i, &around) in t.neighbors.iter().enumerate() {
        start.push(total);
        total += owned_before(i as u32, around, 4);
    }
    let throat_of = t.neighbors.par_iter().enumerate().map(|(i, &around)| {
        let i = i as u32;
        let mut numbers = [NONE; 4];
        for (facet, number) in numbers.iter_mut().enumerate() {
            let j = around[facet];
            if owns(i, j) {
                *number = start[i as usize] + owned_before(i, around, facet);
            } else if j != NONE {
                let theirs = t.neighbors[j as usize];
                *number = start[j as usize] + owned_before(j, theirs, index_of(i, theirs));
            }
        }
        numbers
    });
    let throat_of = throat_of.collect();
    let mut sites = vec![ThroatSite::default(); total as usize];
    let first_of = |i: usize| start.get(i).map_or(total as usize, |&first| first as usize);
    runs(&mut sites, t.cells.len(), first_of).into_par_iter().enumerate().for_each(
        |(task, sites)| {
            let pores = t.neighbors.iter().enumerate().skip(task * TASK).take(TASK);
            let facets = pores.flat_map(|(i, around)| {
                (0..4).map(move |facet| ThroatSite {
                    pores: [i as u32, around[facet as usize]],
                    facet,
                })
            });
            let owned = facets.filter(|site| owns(site.pores[0], site.pores[1]));
            sites.iter_mut().zip(owned).for_each(|(site, owned)| *site = owned);
        },
    );
    (sites, throat_of)
}

/// Whether the throat between two pores is numbered by the first.
fn owns(i: u32, j: u32) -> bool {
    j != NONE && j > i
}

/// How many of the facets before this one a pore numbers.
fn owned_before(i: u32, around: [u32; 4], facet: usize) -> u32 {
    (0..4).map(|k| u32::from(k < facet && owns(i, around[k]))).sum()
}

/// Where a number stands among the last three of four; else at the first.
/// Without branches, which would be guessed wrong half the time.
fn index_of(wanted: u32, among: [u32; 4]) -> usize {
    (1..4).map(|k| if among[k] == wanted { k } else { 0 }).sum()
}

pub(super) fn evaluate_throats(
    frame: &Frame,
    t: &Tessellation,
    center: &[Vec3],
    sites: &[ThroatSite],
    rules: ThroatRules,
) -> Vec<Throat> {
    let mut throats = sites
        .par_chunks(LANES)
        .map(|sites| throats_at(frame, &t.cells, center, sites, rules))
        .collect::<Vec<_>>()
        .into_flattened();
    throats.truncate(sites.len());
    throats
}

/// Evaluates up to [`LANES`] throats; those past the sites' end are closed.
pub(super) fn throats_at(
    frame: &Frame,
    cells: &[[u32; 4]],
    center: &[Vec3],
    sites: &[ThroatSite],
    rules: ThroatRules,
) -> [Throat; LANES] {
    let mut batch = ThroatBatch::new();
    let mut out = [Throat::CLOSED; LANES];
    for (l, site) in sites.iter().enumerate() {
        let facet = site.facet(cells);
        if frame.are_spheres(&facet) {
            for (k, &v) in facet.iter().enumerate() {
                batch.set_sphere(l, k, &frame.x[v as usize], frame.r[v as usize]);
            }
            for (k, &p) in site.pores.iter().enumerate() {
                batch.set_pore(l, k, &center[p as usize]);
            }
        }
    }
    batch.evaluate();
    for (l, (site, out)) in sites.iter().zip(&mut out).enumerate() {
        let facet = site.facet(cells);
        if frame.are_spheres(&facet) && !batch.is_special(l, &rules) {
            batch.throat(l, out);
        } else {
            let [i, j] = site.pores;
            // A facet of three walls lies on the hull and separates no pores.
            *out = throat(frame, rules, facet, center[i as usize], center[j as usize])
                .unwrap_or(Throat::CLOSED);
        }
    }
    out
}

pub(super) fn conductances(throats: &[Throat], fluid: &Fluid) -> Vec<f64> {
    let bounds = fluid.clamp.bounds(throats, fluid.viscosity);
    throats.par_iter().map(|t| bounded(t.conductance(fluid.viscosity), bounds)).collect()
}

/// A conductance within bounds. Comparisons that let NaN through, to be named
/// afterwards.
pub(super) fn bounded(g: f64, (low, high): (f64, f64)) -> f64 {
    if g < low {
        low
    } else if g > high {
        high
    } else {
        g
    }
}

pub(super) fn check_finite(
    t: &Tessellation,
    sites: &[ThroatSite],
    conductance: &[f64],
) -> Result<(), PfvError> {
    match conductance.par_iter().position_first(|g| !g.is_finite()) {
        None => Ok(()),
        Some(k) => {
            let pore = sites[k].pores[0];
            Err(PfvError::NotFinite {
                pore,
                vertices: t.vertices_of(pore),
                quantity: "a throat's conductance",
            })
        }
    }
}

pub(super) fn force_coefficients(
    t: &Tessellation,
    sites: &[ThroatSite],
    throats: &[Throat],
    throat_of: &[[u32; 4]],
    gradient: &[[Vec3; 4]],
) -> Vec<[Vec3; 4]> {
    let of = |i: usize| force_coefficients_of(t, sites, throats, &throat_of[i], &gradient[i], i);
    (0..t.cells.len()).into_par_iter().map(of).collect()
}

/// Adds up, for each vertex of pore `i`, the force per unit of its pressure in the pore's
/// throats, and on the wall across the opposite facet (m²).
pub(super) fn force_coefficients_of(
    t: &Tessellation,
    sites: &[ThroatSite],
    throats: &[Throat],
    throat_of: &[u32; 4],
    gradient: &[Vec3; 4],
    i: usize,
) -> [Vec3; 4] {
    let mut coefficients = [Vec3::zeros(); 4];
    for &number in throat_of.iter().filter(|&&number| number != NONE) {
        let (site, throat) = (&sites[number as usize], &throats[number as usize]);
        let sign = if site.pores[0] as usize == i { 1.0 } else { -1.0 };
        for (vertex, force) in site.facet(&t.cells).into_iter().zip(&throat.force_coefficient) {
            coefficients[index_of(vertex, t.cells[i])] += sign * force;
        }
    }
    for (k, &vertex) in t.cells[i].iter().enumerate() {
        if t.wall(vertex).is_some() {
            // The facet's projection on the wall is what the volume gains
            // where the wall moves outward.
            coefficients[k] += gradient[k];
        }
    }
    coefficients
}
