//! The pore network: cells, pores and throats as flat arrays.

use rayon::prelude::*;

use super::frame::{FACETS, Frame};
use super::pore::Pore;
use super::throat::{Throat, WallFriction, throat};
use super::{Fluid, NONE, PfvError, Tessellation};
use crate::{Aabb, Vec3};

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
    /// Power centre of each pore (m).
    pub center: Vec<Vec3>,
    /// Signed volume of each pore, solids included (m³); negative where motion
    /// turned a pore inside out.
    pub volume: Vec<f64>,
    /// The throats.
    pub throats: Throats,
    /// Throat across the facet opposite each vertex of a pore, or [`NONE`].
    pub throat_of: Vec<[u32; 4]>,
}

/// What operators are made of, and nothing else needs: 200 bytes a pore.
#[derive(Clone, Debug)]
pub struct Derivatives {
    /// Derivative of each pore's volume with respect to its four vertices (m²).
    pub volume_gradient: Vec<[Vec3; 4]>,
    /// Force per unit of the pore's pressure on each of its vertices (m²).
    pub push: Vec<[Vec3; 4]>,
}

impl Network {
    /// Triangulates the packing and evaluates every pore and throat.
    ///
    /// `position` and `radius` are in metres; every centre must lie inside
    /// `bounds`.
    ///
    /// # Errors
    /// When the triangulation fails, a sphere lies outside the box, or a
    /// pore's geometry or conductance is not finite.
    pub fn new(
        position: &[Vec3],
        radius: &[f64],
        bounds: Aabb,
        fluid: &Fluid,
    ) -> Result<(Network, Derivatives), PfvError> {
        let frame = Frame::new(position, radius, &bounds);
        let tessellation = Tessellation::new(&frame)?;
        let pores = evaluate_pores(&frame, &tessellation)?;
        let (pairs, throat_of) = number_throats(&tessellation);
        let friction = WallFriction::of(fluid);
        let evaluated = evaluate_throats(&frame, &tessellation, &pores, &pairs, friction);
        let conductance = conductances(&evaluated, fluid);
        check_finite(&tessellation, &pairs, &conductance)?;
        let push = gather_push(&tessellation, &pairs, &evaluated, &throat_of, &pores);
        let volume_gradient = pores.par_iter().map(|p| p.gradient).collect();
        let network = Network {
            bounds,
            viscosity: fluid.viscosity,
            center: pores.par_iter().map(|p| p.center + bounds.min).collect(),
            volume: pores.par_iter().map(|p| p.volume).collect(),
            throats: Throats { pores: pairs.iter().map(|t| t.pores).collect(), conductance },
            throat_of,
            tessellation,
        };
        Ok((network, Derivatives { volume_gradient, push }))
    }

    /// Number of pores.
    pub fn pores(&self) -> usize {
        self.tessellation.cells.len()
    }

    /// Volumes (m³) of the same cells when the vertices have moved to
    /// `position` and the walls to `bounds`: the tessellation is kept.
    pub fn volumes_at(&self, position: &[Vec3], bounds: &Aabb) -> Vec<f64> {
        // The volume does not depend on the radii.
        let radius = vec![0.0; position.len()];
        let frame = Frame::new(position, &radius, bounds);
        let cells = &self.tessellation.cells;
        cells
            .par_iter()
            .map(|&cell| Pore::new(&frame, cell).map_or(f64::NAN, |p| p.volume))
            .collect()
    }

    /// Conductance across the facet opposite each vertex of a pore; 0 where
    /// there is no throat.
    pub fn conductances_of(&self, pore: usize) -> [f64; 4] {
        self.throat_of[pore]
            .map(|t| if t == NONE { 0.0 } else { self.throats.conductance[t as usize] })
    }
}

/// A throat's place: its pores, and the facet as the first pore numbers it.
pub(super) struct Place {
    pub pores: [u32; 2],
    pub facet: usize,
}

fn evaluate_pores(frame: &Frame, t: &Tessellation) -> Result<Vec<Pore>, PfvError> {
    let pores: Vec<Option<Pore>> = t.cells.par_iter().map(|&cell| Pore::new(frame, cell)).collect();
    let mut out = Vec::with_capacity(pores.len());
    for (i, pore) in pores.into_iter().enumerate() {
        let name = || t.vertices_of(i as u32);
        let pore = pore.ok_or_else(|| PfvError::BadPore { pore: i as u32, vertices: name() })?;
        if !pore.center.iter().chain([&pore.volume]).all(|v| v.is_finite()) {
            return Err(PfvError::NotFinite {
                pore: i as u32,
                vertices: name(),
                quantity: "the pore's centre or volume",
            });
        }
        out.push(pore);
    }
    Ok(out)
}

/// Numbers each facet between two pores once, by its smaller pore.
pub(super) fn number_throats(t: &Tessellation) -> (Vec<Place>, Vec<[u32; 4]>) {
    let mut places = Vec::with_capacity(2 * t.cells.len());
    let mut throat_of = vec![[NONE; 4]; t.cells.len()];
    for (i, around) in t.neighbors.iter().enumerate() {
        for (facet, &j) in around.iter().enumerate() {
            if j == NONE || (j as usize) < i {
                continue;
            }
            let number = places.len() as u32;
            throat_of[i][facet] = number;
            if let Some(back) = t.neighbors[j as usize].iter().position(|&b| b as usize == i) {
                throat_of[j as usize][back] = number;
            }
            places.push(Place { pores: [i as u32, j], facet });
        }
    }
    (places, throat_of)
}

fn evaluate_throats(
    frame: &Frame,
    t: &Tessellation,
    pores: &[Pore],
    places: &[Place],
    friction: WallFriction,
) -> Vec<Throat> {
    places
        .par_iter()
        .map(|place| {
            let [i, j] = place.pores.map(|p| p as usize);
            let facet = FACETS[place.facet].map(|k| t.cells[i][k]);
            // A facet of three walls lies on the hull and separates no pores.
            throat(frame, friction, facet, pores[i].center, pores[j].center)
                .unwrap_or(Throat::CLOSED)
        })
        .collect()
}

fn conductances(throats: &[Throat], fluid: &Fluid) -> Vec<f64> {
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

fn check_finite(t: &Tessellation, places: &[Place], conductance: &[f64]) -> Result<(), PfvError> {
    match conductance.par_iter().position_first(|g| !g.is_finite()) {
        None => Ok(()),
        Some(k) => {
            let pore = places[k].pores[0];
            Err(PfvError::NotFinite {
                pore,
                vertices: t.vertices_of(pore),
                quantity: "a throat's conductance",
            })
        }
    }
}

fn gather_push(
    t: &Tessellation,
    places: &[Place],
    throats: &[Throat],
    throat_of: &[[u32; 4]],
    pores: &[Pore],
) -> Vec<[Vec3; 4]> {
    let push = |i: usize| push_of(t, places, throats, &throat_of[i], &pores[i].gradient, i);
    (0..t.cells.len()).into_par_iter().map(push).collect()
}

/// Adds up, for each vertex of pore `i`, what the pore's throats push, and
/// what the pressure pushes on the walls across the opposite facet.
pub(super) fn push_of(
    t: &Tessellation,
    places: &[Place],
    throats: &[Throat],
    throat_of: &[u32; 4],
    gradient: &[Vec3; 4],
    i: usize,
) -> [Vec3; 4] {
    let mut push = [Vec3::zeros(); 4];
    for &number in throat_of {
        if number == NONE {
            continue;
        }
        let (place, throat) = (&places[number as usize], &throats[number as usize]);
        let first = place.pores[0] as usize;
        let sign = if first == i { 1.0 } else { -1.0 };
        for (k, force) in FACETS[place.facet].iter().zip(throat.push) {
            let vertex = t.cells[first][*k];
            if let Some(here) = t.cells[i].iter().position(|&v| v == vertex) {
                push[here] += sign * force;
            }
        }
    }
    for (k, &vertex) in t.cells[i].iter().enumerate() {
        if t.wall(vertex).is_some() {
            // The facet's projection on the wall is what the volume gains
            // where the wall moves outward.
            push[k] += gradient[k];
        }
    }
    push
}
