//! A network whose spheres have moved: the triangulation stays, and whatever
//! depends on positions is computed anew in place.

use rayon::prelude::*;

use super::conductance_rules::darcy;
use super::conductances::Conductances;
use super::frame::Frame;
use super::lanes::LANES;
use super::network::{
    ThroatSite, bounded, force_coefficients_of, number_throats, pores_at, throats_at,
};
use super::terms::Terms;
use super::throat::Throat;
use super::{Fluid, NONE, Network, Operators};
use crate::parallel::for_each;
use crate::{Aabb, Vec3};

/// Pores or throats that one task takes at least: half a millisecond of work.
const GEOMETRY_TASK: usize = 1_024;

/// A difference of pressures that has come below this share of its energy in
/// the factor is solved for by itself.
const WEAKENED_ENERGY_RATIO: f64 = 0.7;

/// What a throat that closes keeps of its conductance while its network is in use.
const STILL_OPEN: f64 = 1e-9;

/// How far a triangulation that is kept while its spheres move is from that of the moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GeometryDegradation {
    /// Pores that had a volume when the network was built, and have turned
    /// inside out.
    pub inverted: u32,
    /// Throats whose pores have passed each other: the facet is no longer one
    /// of the regular triangulation.
    pub folded: u32,
    /// Pores or throats that have no finite size any more. They keep what they
    /// had when the network was built.
    pub lost: u32,
}

impl GeometryDegradation {
    fn and(self, other: GeometryDegradation) -> GeometryDegradation {
        GeometryDegradation {
            inverted: self.inverted + other.inverted,
            folded: self.folded + other.folded,
            lost: self.lost + other.lost,
        }
    }
}

/// What a network needs to be updated: 480 bytes a pore.
pub(super) struct GeometryUpdate {
    /// Sphere and pore centres from the box's lower corner (m).
    x: Vec<Vec3>,
    local: Vec<Vec3>,
    sites: Vec<ThroatSite>,
    throats: Vec<Throat>,
    force_coefficient: Vec<[Vec3; 4]>,
    /// For each entry of `F` which vertex of its pore it is.
    corner: Vec<u8>,
    /// Throat of each entry of `G`; [`NONE`] on the diagonal.
    throat_at: Vec<u32>,
    /// Of the network as it was built: centres, volumes, conductances.
    center: Vec<Vec3>,
    volume: Vec<f64>,
    conductance: Vec<f64>,
    /// Sum of the conductances of each pore then, and what it stored.
    diagonal: Vec<f64>,
    /// Throats that have become much weaker.
    weakened: Vec<WeakenedThroat>,
}

/// A throat whose pores the factor takes for joined far more firmly than they
/// are now.
#[derive(Clone, Copy, Debug)]
pub(super) struct WeakenedThroat {
    /// The pores' unknowns; [`NONE`] where the pressure is imposed.
    pub unknowns: [u32; 2],
    /// One over the energy of a unit difference of the two pressures
    /// (Pa·s/m³).
    pub inverse: f64,
}

impl GeometryUpdate {
    pub fn new(network: &Network, operators: &Operators) -> GeometryUpdate {
        let t = &network.tessellation;
        let (sites, _) = number_throats(t);
        let mut corner = Vec::with_capacity(4 * t.cells.len());
        for vertex in 0..t.spheres + 6 {
            for &pore in operators.forces.pores.of(vertex) {
                let cell = &t.cells[pore as usize];
                corner.push(cell.iter().position(|&v| v as usize == vertex).unwrap_or(0) as u8);
            }
        }
        GeometryUpdate {
            x: Vec::with_capacity(t.spheres),
            local: vec![Vec3::zeros(); t.cells.len()],
            throats: vec![Throat::CLOSED; sites.len()],
            force_coefficient: vec![[Vec3::zeros(); 4]; t.cells.len()],
            corner,
            throat_at: throats_of_entries(network, operators),
            center: network.center.clone(),
            volume: network.volume.clone(),
            conductance: network.throats.conductance.clone(),
            diagonal: (0..t.cells.len()).map(|i| energy(network, operators, i)).collect(),
            weakened: Vec::with_capacity(sites.len() / 16),
            sites,
        }
    }

    /// Centres of the pores when the network was built (m).
    pub fn built_center(self) -> Vec<Vec3> {
        self.center
    }

    /// The throats that have become much narrower than the factor has them.
    pub fn weakened(&self) -> &[WeakenedThroat] {
        &self.weakened
    }

    /// Volume of each pore when the network was built (m³).
    pub fn built_volume(&self) -> &[f64] {
        &self.volume
    }

    /// Moves the spheres, whose radii stay, to `position` and the walls to `bounds`.
    pub fn run(
        &mut self,
        network: &mut Network,
        operators: &mut Operators,
        (position, radius): (&[Vec3], &[f64]),
        bounds: &Aabb,
        (fluid, terms): (&Fluid, &Terms),
    ) -> GeometryDegradation {
        let mut x = std::mem::take(&mut self.x);
        x.clear();
        x.extend(position.iter().map(|x| x - bounds.min));
        let frame = Frame { x, r: radius, size: bounds.size() };
        network.bounds = *bounds;
        let mut degradation = self.update_pores(&frame, network, operators);
        self.place_flat_pores(&frame, network);
        self.update_throats(&frame, network, fluid);
        Self::update_storage(&frame, network, operators, terms);
        degradation.lost += self.write_conductances(&frame, network, fluid);
        self.x = frame.x;
        self.write_operators(network, operators);
        operators.write_diagonal();
        self.find_weakened(network, operators);
        degradation.folded = self.folded(network, operators);
        degradation
    }

    /// Writes centres, volumes and the volumes' gradients.
    fn update_pores(
        &mut self,
        frame: &Frame,
        network: &mut Network,
        operators: &mut Operators,
    ) -> GeometryDegradation {
        let (cells, origin) = (&network.tessellation.cells, network.bounds.min);
        let GeometryUpdate { center: built_center, volume: built_volume, local, .. } = self;
        let arrays = (
            local.par_chunks_mut(LANES),
            network.center.par_chunks_mut(LANES),
            network.volume.par_chunks_mut(LANES),
            operators.volume.gradient.par_chunks_mut(LANES),
        );
        let blocks = arrays.into_par_iter().with_min_len(GEOMETRY_TASK / LANES).enumerate();
        let degradation = blocks.map(|(block, (local, center, volume, gradient))| {
            let first = block * LANES;
            let (x, (v, dv)) = pores_at(frame, &cells[first..first + local.len()]);
            let mut degradation = GeometryDegradation::default();
            for l in 0..local.len() {
                let then = built_volume[first + l];
                if x[l].iter().chain([&v[l]]).all(|v| v.is_finite()) {
                    (local[l], volume[l], gradient[l]) = (x[l], v[l], dv[l]);
                    center[l] = x[l] + origin;
                    degradation.inverted += u32::from(v[l] <= 0.0 && then > 0.0);
                } else {
                    (center[l], volume[l]) = (built_center[first + l], then);
                    local[l] = center[l] - origin;
                    degradation.lost += 1;
                }
            }
            degradation
        });
        degradation.reduce(GeometryDegradation::default, GeometryDegradation::and)
    }

    /// Those that were flat when the network was built: whether others are is round-off.
    fn place_flat_pores(&mut self, frame: &Frame, network: &mut Network) {
        let Network { flat, tessellation, center, bounds, .. } = network;
        flat.place(frame, tessellation, &mut self.local);
        for i in flat.numbers() {
            center[i] = self.local[i] + bounds.min;
        }
    }

    fn update_throats(&mut self, frame: &Frame, network: &Network, fluid: &Fluid) {
        let (cells, rules) = (&network.tessellation.cells, fluid.throat_rules());
        let GeometryUpdate { throats, sites, local, .. } = self;
        let blocks = throats.par_chunks_mut(LANES).zip(sites.par_chunks(LANES));
        blocks.with_min_len(GEOMETRY_TASK / LANES).for_each(|(out, sites)| {
            let block = throats_at(frame, cells, local, sites, rules);
            out.copy_from_slice(&block[..out.len()]);
        });
    }

    /// Throats whose second pore has its centre before the first one's. A
    /// pore's volume grows where the vertex across the facet moves away from
    /// it, which tells the facet's side. Where walls are, planes and the huge
    /// spheres of the triangulation differ: these throats do not count.
    fn folded(&self, network: &Network, operators: &Operators) -> u32 {
        let t = &network.tessellation;
        let folded = |site: &&ThroatSite| {
            let [i, j] = site.pores.map(|p| p as usize);
            let inside = t.cells[i].iter().all(|&v| (v as usize) < t.spheres);
            let inward = operators.volume.gradient[i][site.facet as usize];
            inside && inward.dot(&(self.local[j] - self.local[i])) > 0.0
        };
        self.sites.par_iter().with_min_len(GEOMETRY_TASK).filter(folded).count() as u32
    }

    /// Returns how many are not finite.
    fn write_conductances(&self, frame: &Frame, network: &mut Network, fluid: &Fluid) -> u32 {
        let limits = fluid.clamp.bounds(&self.throats, fluid.viscosity);
        let Network { throats, conductances, tessellation, .. } = network;
        let (rules, cells) = (conductances.as_deref(), &tessellation.cells);
        let by_rules = |k: usize, geometric: f64, rules: &Conductances| {
            rules.of(k, geometric, |m| darcy(frame, cells, &self.sites[k], &self.local, m))
        };
        for_each(&mut throats.conductance, &|k, g| {
            let (now, then) = (self.throats[k].conductance(fluid.viscosity), self.conductance[k]);
            // What closes stays just open until the next remesh: which pores are unknown, and
            // reached, is the network's.
            let now = bounded(now, limits);
            let now = rules.map_or(now, |rules| by_rules(k, now, rules));
            *g = if now.is_finite() { now.max(STILL_OPEN * then) } else { then };
        });
        self.throats.iter().filter(|t| !t.conductance(1.0).is_finite()).count() as u32
    }

    /// Finds the throats whose pores' difference has less than [`WEAKENED_ENERGY_RATIO`] of
    /// what the factor takes it to have.
    fn find_weakened(&mut self, network: &Network, operators: &Operators) {
        let GeometryUpdate { conductance, diagonal: built, weakened, .. } = self;
        weakened.clear();
        for (k, (&now, &then)) in network.throats.conductance.iter().zip(&*conductance).enumerate()
        {
            if now > WEAKENED_ENERGY_RATIO * then {
                continue;
            }
            let pores = network.throats.pores[k].map(|i| i as usize);
            let unknowns = pores.map(|i| operators.unknown_of[i]);
            let free = |e: usize| unknowns[e] != NONE;
            // Beside the throat, each pore leads on through its others; an
            // imposed pressure leads on without resistance.
            let other =
                |e: usize| if free(e) { 1.0 / (built[pores[e]] - then).max(0.0) } else { 0.0 };
            let around = 1.0 / (other(0) + other(1));
            if (free(0) || free(1)) && now + around < WEAKENED_ENERGY_RATIO * (then + around) {
                let own =
                    |e: usize| if free(e) { energy(network, operators, pores[e]) } else { 0.0 };
                let joint = if free(0) && free(1) { 2.0 * now } else { 0.0 };
                weakened
                    .push(WeakenedThroat { unknowns, inverse: 1.0 / (own(0) + own(1) + joint) });
            }
        }
    }

    /// `G`, `F` and the surfaces at the walls; `E` is written with the pores.
    fn write_operators(&mut self, network: &Network, operators: &mut Operators) {
        let GeometryUpdate { sites, throats, force_coefficient, corner, throat_at, .. } = self;
        let (t, gradient) = (&network.tessellation, &operators.volume.gradient);
        let throat_of = &network.throat_of;
        for_each(force_coefficient, &|i, coefficients| {
            *coefficients =
                force_coefficients_of(t, sites, throats, &throat_of[i], &gradient[i], i);
        });
        let pores = &operators.forces.pores.pore;
        for_each(&mut operators.forces.coefficient, &|at, f| {
            *f = force_coefficient[pores[at] as usize][corner[at] as usize];
        });
        let Operators { matrix, pore_of, boundary_flux, .. } = operators;
        let row_idx = &matrix.row_idx;
        for_each(&mut matrix.values, &|at, g| {
            *g = match throat_at[at] {
                NONE => diagonal(network, pore_of[row_idx[at] as usize] as usize),
                throat => -network.throats.conductance[throat as usize],
            };
        });
        boundary_flux.update(&network.throats.conductance);
        operators.update_stencils(network);
    }

    /// Evaluates what the pores store now, where a term stores fluid.
    fn update_storage(frame: &Frame, network: &Network, operators: &mut Operators, terms: &Terms) {
        let Some(storage) = &mut operators.storage else { return };
        network.write_void_volumes(frame, &mut storage.void);
        storage.update(|void, capacity| terms.write_capacity(void, capacity));
    }
}

/// The throat of each entry of `G` below the diagonal.
fn throats_of_entries(network: &Network, operators: &Operators) -> Vec<u32> {
    let Operators { matrix, pore_of, unknown_of, .. } = operators;
    let mut throat_at = vec![NONE; matrix.nnz()];
    for (u, &pore) in pore_of.iter().enumerate() {
        let i = pore as usize;
        let column = matrix.col_ptr[u] as usize..matrix.col_ptr[u + 1] as usize;
        for at in column.skip(1) {
            let row = matrix.row_idx[at] as u32;
            let across = |&k: &usize| {
                let j = network.tessellation.neighbors[i][k];
                j != NONE && unknown_of[j as usize] == row
            };
            throat_at[at] = (0..4).find(across).map_or(NONE, |k| network.throat_of[i][k]);
        }
    }
    throat_at
}

/// Energy of a unit pressure in a pore alone (m³/(Pa·s)): its conductances, and what it stores.
fn energy(network: &Network, operators: &Operators, pore: usize) -> f64 {
    diagonal(network, pore) + operators.storage().map_or(0.0, |storage| storage.rate(pore))
}

/// The sum of a pore's conductances, in the order in which it is assembled.
fn diagonal(network: &Network, pore: usize) -> f64 {
    let around = network.tessellation.neighbors[pore].into_iter();
    around
        .zip(network.conductances_of(pore))
        .filter(|(j, _)| *j != NONE)
        .map(|(_, g)| g)
        .fold(0.0, |sum, g| sum + g)
}
