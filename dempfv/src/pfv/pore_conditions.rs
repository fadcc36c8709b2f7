//! What is imposed on the fluid: a condition per pore. Walls are one way to give them.

use serde::{Deserialize, Serialize};

use super::packing_check::require_length;
use super::wall_profiles::WallProfiles;
use super::{Boundary, NONE, Network, PfvError, PressureProfile, SealedPoreRule};
use crate::{Aabb, PerWall, Vec3, WallId};

/// Some of a network's pores.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum PoreSelection {
    /// By their numbers, which are those of one network only.
    Pores(Vec<u32>),
    /// Those that contain these points (m).
    At(Vec<Vec3>),
    /// All whose centroid lies within a distance of a point.
    Around {
        /// The point (m).
        center: Vec3,
        /// The distance (m).
        radius: f64,
    },
    /// All whose centroid lies in a box.
    Within {
        /// Its lower corner (m).
        min: Vec3,
        /// Its upper corner (m).
        max: Vec3,
    },
}

impl PoreSelection {
    /// The numbers of the pores, of a network that was built of spheres at `position` (m).
    pub(super) fn select(
        &self,
        network: &Network,
        position: &[Vec3],
    ) -> Result<Vec<u32>, PfvError> {
        Ok(match self {
            PoreSelection::Pores(numbers) => numbers.clone(),
            PoreSelection::At(points) => at_points(network, position, points)?,
            PoreSelection::Around { center, radius } => {
                of_centroids(network, position, |x| (x - center).norm() <= *radius)?
            }
            PoreSelection::Within { min, max } => {
                let region = Aabb { min: *min, max: *max };
                of_centroids(network, position, |x| region.contains(x))?
            }
        })
    }
}

/// The pores that contain points, each once.
fn at_points(network: &Network, position: &[Vec3], points: &[Vec3]) -> Result<Vec<u32>, PfvError> {
    let mut pores = vec![];
    for (k, x) in points.iter().enumerate() {
        let inside = network.bounds.contains(x);
        let pore = if inside { network.tessellation.locate(position, x)? } else { NONE };
        if pore == NONE {
            let problem = format!("({}, {}, {}) lies in no pore", x.x, x.y, x.z);
            return Err(PfvError::invalid("points", k, problem));
        }
        if !pores.contains(&pore) {
            pores.push(pore);
        }
    }
    Ok(pores)
}

/// The pores whose centroid fits.
fn of_centroids(
    network: &Network,
    position: &[Vec3],
    fits: impl Fn(&Vec3) -> bool,
) -> Result<Vec<u32>, PfvError> {
    let centroids = network.centroids(position, &network.bounds)?;
    Ok((0u32..).zip(&centroids).filter(|(_, x)| fits(x)).map(|(i, _)| i).collect())
}

/// A pressure imposed on pores of choice, such as those around the tip of an injection tube.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImposedPressure {
    /// On which pores.
    pub pores: PoreSelection,
    /// The pressure (Pa).
    pub pressure: f64,
}

/// The pores of these have no condition, as walls that let nothing through.
const FREE: u32 = NONE;

/// The condition of each pore: an imposed pressure, or none.
///
/// Pores under one condition are a set. Sets 0 to 5 are the walls', in the order of
/// [`WallId::ALL`]; the others follow in the order in which they were imposed. The flux is
/// accounted per set.
#[derive(Clone, Debug, PartialEq)]
pub struct PoreConditions {
    /// Set of each pore, or [`FREE`].
    set_of: Vec<u32>,
    /// Pressure of each set (Pa); `None` for a wall that imposes none.
    pressure: Vec<Option<f64>>,
    /// What walls have beside that, from place to place.
    profiles: Option<Box<WallProfiles>>,
    /// Pores at walls of different pressures.
    contested: u32,
    /// The last set holds pores that were pinned because nothing else determines their pressure.
    pinned: bool,
    /// What holds for pores without a path to an imposed pressure.
    sealed_pores: SealedPoreRule,
}

impl PoreConditions {
    /// The conditions that walls give: a pore at several walls with imposed pressures has that
    /// of the last of these, as in YADE.
    pub fn of_walls(network: &Network, boundary: &Boundary) -> PoreConditions {
        let cells = &network.tessellation.cells;
        let set_of = cells.iter().map(|&cell| imposing_wall(network, boundary, cell)).collect();
        let contested = cells.iter().filter(|&&cell| is_contested(network, boundary, cell)).count();
        let pressure = boundary.pressure.values().copied().collect();
        let (contested, sealed_pores) = (contested as u32, boundary.sealed_pores);
        PoreConditions { set_of, pressure, profiles: None, contested, pinned: false, sealed_pores }
    }

    /// Imposes a pressure (Pa) on pores of choice. `position` (m) has the sphere centres that the
    /// network was built of.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] where the pressure is not finite, a pore has no such
    /// number, none is selected, a wall or an earlier call imposes another pressure on one, the
    /// positions are not one per sphere, or the network is another one than that of these
    /// conditions. Nothing has changed then.
    pub fn impose(
        &mut self,
        network: &Network,
        position: &[Vec3],
        imposed: &ImposedPressure,
    ) -> Result<(), PfvError> {
        let ImposedPressure { pores, pressure } = imposed;
        let set = self.pressure.len() as u32;
        let wrong = |argument, index, problem| PfvError::InvalidInput { argument, index, problem };
        if !pressure.is_finite() {
            let which = (set - 6) as usize;
            return Err(wrong(
                "imposed pressure",
                Some(which),
                format!("{pressure} is not finite"),
            ));
        }
        require_length("network", network.pores(), self.set_of.len(), "pores with a condition")?;
        let selected = pores.select(network, position)?;
        if selected.is_empty() {
            let which = (set - 6) as usize;
            return Err(wrong("imposed pressure", Some(which), "selects no pore".to_owned()));
        }
        let pores = self.set_of.len();
        if let Some(k) = selected.iter().position(|&pore| pore as usize >= pores) {
            let problem = format!("pore {} of a network of {pores}", selected[k]);
            return Err(wrong("selected pores", Some(k), problem));
        }
        for &pore in &selected {
            if network.is_blocked(pore as usize) {
                let problem = format!("pore {pore} is blocked; choose other pores");
                return Err(wrong("imposed pressure", Some((set - 6) as usize), problem));
            }
            if let Some(problem) = self.contradiction(pore, *pressure) {
                return Err(wrong("imposed pressure", Some((set - 6) as usize), problem));
            }
        }
        for &pore in &selected {
            self.set_of[pore as usize] = set;
        }
        self.pressure.push(Some(*pressure));
        Ok(())
    }

    /// What is wrong with a pressure (Pa) on a pore that has another one already.
    fn contradiction(&self, pore: u32, pressure: f64) -> Option<String> {
        let set = self.set_of(pore as usize)?;
        let before = self.pressure[set].filter(|before| *before != pressure)?;
        let by = match WallId::ALL.get(set) {
            Some(wall) => format!("by the wall {wall}"),
            None => format!("by entry {}", set - WallId::ALL.len()),
        };
        Some(format!(
            "{pressure} Pa on pore {pore}, on which {before} Pa are imposed {by}: a pore has one pressure; \
             choose other pores, or the same pressure"
        ))
    }

    /// Gives pores at walls what profiles say of their centres, beside the pressure of the wall.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for a profile that is none, or of a wall that imposes no pressure.
    pub(super) fn set_profiles(
        &mut self,
        network: &Network,
        profiles: &PerWall<Option<PressureProfile>>,
    ) -> Result<(), PfvError> {
        let given = |wall: WallId| profiles[wall].as_ref().map(|profile| (wall, profile));
        for (wall, profile) in WallId::ALL.into_iter().filter_map(given) {
            profile.check(wall)?;
            if self.pressure[wall.index()].is_none() {
                let problem = format!("{wall} imposes no pressure; give it one, 0 Pa for instance");
                return Err(PfvError::invalid("pressure profile", wall.index(), problem));
            }
        }
        if profiles.values().any(Option::is_some) {
            let wall_of = |pore: usize| self.wall_of(pore);
            self.profiles = Some(Box::new(WallProfiles::new(&network.center, wall_of, profiles)));
        }
        Ok(())
    }

    /// What holds for pores without a path to an imposed pressure.
    pub(super) fn sealed_pores(&self) -> SealedPoreRule {
        self.sealed_pores
    }

    /// Changes the pressure (Pa) that a wall imposes. False where it imposes none.
    pub(super) fn set_wall_pressure(&mut self, wall: WallId, pressure: f64) -> bool {
        let imposed = &mut self.pressure[wall.index()];
        *imposed = imposed.map(|_| pressure);
        imposed.is_some()
    }

    /// Changes the pressure (Pa) of one of those imposed beside walls. False where there is none of
    /// this number.
    pub(super) fn set_imposed_pressure(&mut self, number: usize, pressure: f64) -> bool {
        let sets = self.imposed_sets();
        let imposed = self.pressure[..sets].get_mut(WallId::ALL.len().saturating_add(number));
        imposed.map(|imposed| *imposed = Some(pressure)).is_some()
    }

    /// Number of pores that touch walls of different pressures, and have that of the last of
    /// these.
    pub fn contested(&self) -> u32 {
        self.contested
    }

    /// Pins the pressure of pores at the mean of the imposed ones, 0 where there are none: a
    /// set of its own, the last.
    pub(super) fn pin(&mut self, pores: impl Iterator<Item = u32>) {
        let set = self.pressure.len() as u32;
        for pore in pores {
            self.set_of[pore as usize] = set;
        }
        self.pressure.push(Some(self.mean_pressure()));
        self.pinned = true;
    }

    /// Mean of the imposed pressures (Pa); 0 where there are none.
    pub(super) fn mean_pressure(&self) -> f64 {
        let mean = |[_, mean, _]: [f64; 3]| mean;
        self.ranges().map(mean).sum::<f64>() / self.ranges().count().max(1) as f64
    }

    /// Lowest, mean and highest pressure of each set that has one (Pa).
    pub(super) fn ranges(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        let profiles = self.profiles.as_deref();
        let range = move |(set, pressure): (usize, &Option<f64>)| {
            let beside = profiles.map_or([0.0; 3], |profiles| profiles.range(set));
            pressure.map(|pressure| beside.map(|p| pressure + p))
        };
        self.pressure.iter().enumerate().filter_map(range)
    }

    /// Number of sets that were imposed: six walls, and those beside them.
    pub(super) fn imposed_sets(&self) -> usize {
        self.pressure.len() - usize::from(self.pinned)
    }

    /// Number of sets: six walls, those imposed beside them, and pores that were pinned
    /// ([`SealedPores`](super::SealedPores)).
    pub fn sets(&self) -> usize {
        self.pressure.len()
    }

    /// Number of pores.
    pub(super) fn pores(&self) -> usize {
        self.set_of.len()
    }

    /// Set of a pore with an imposed pressure; `None` for a free one, and for a number that no
    /// pore has.
    pub fn set_of(&self, pore: usize) -> Option<usize> {
        self.set_of.get(pore).filter(|&&set| set != FREE).map(|&set| set as usize)
    }

    /// Wall that imposes the pressure of a pore; `None` for a free one, and where it was
    /// imposed otherwise.
    pub fn wall_of(&self, pore: usize) -> Option<WallId> {
        WallId::ALL.get(self.set_of(pore)?).copied()
    }

    /// Pressure imposed on a pore (Pa); `None` for a free one.
    pub fn pressure_of(&self, pore: usize) -> Option<f64> {
        let pressure = self.pressure[self.set_of(pore)?]?;
        Some(match &self.profiles {
            None => pressure,
            Some(profiles) => pressure + profiles.of_pore(pore),
        })
    }

    /// Pressure of each set (Pa), without the profiles of walls; `None` for a wall that imposes none.
    pub fn pressures(&self) -> &[Option<f64>] {
        &self.pressure
    }
}

/// The wall that imposes a cell's pressure; of several the last, as in YADE.
fn imposing_wall(network: &Network, boundary: &Boundary, cell: [u32; 4]) -> u32 {
    let walls = cell.iter().filter_map(|&v| network.tessellation.wall(v));
    let imposing = walls.filter(|&wall| boundary.pressure[wall].is_some());
    imposing.map(|wall: WallId| wall.index() as u32).max().unwrap_or(FREE)
}

/// Whether walls of different pressures meet in a cell.
fn is_contested(network: &Network, boundary: &Boundary, cell: [u32; 4]) -> bool {
    let walls = cell.iter().filter_map(|&v| network.tessellation.wall(v));
    let mut pressures = walls.filter_map(|wall| boundary.pressure[wall]);
    let first = pressures.next();
    pressures.any(|pressure| Some(pressure) != first)
}
