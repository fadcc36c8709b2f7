//! A random cloud of spheres without overlaps.

use serde::{Deserialize, Serialize};

use super::cell_neighbours::Sight;
use super::error::DemError;
use super::grid::CellIndex;
use super::material::positive;
use super::rng::Rng;
use super::walls::check_box;
use crate::{Aabb, Cell, Vec3};

/// Spheres are numbered in 32 bits, walls and one number for none behind them.
const MOST_SPHERES: usize = u32::MAX as usize - 8;

/// Places tried for a sphere before the cloud counts as full.
const TRIES: usize = 20_000;

/// How the radii are distributed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SizeDistribution {
    /// Uniform from mean (1 − spread) to mean (1 + spread).
    Uniform {
        /// 0 for equal spheres, less than 1.
        spread: f64,
    },
    /// Given radii (m) with their shares by number; the shares are rounded
    /// to whole spheres and need not add up to one.
    List(Vec<(f64, f64)>),
}

/// What sets the size of the spheres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CloudScale {
    /// The porosity of the cloud: all radii are scaled to it.
    Porosity(f64),
    /// The mean radius (m): all radii are scaled to it.
    MeanRadius(f64),
    /// The radii of the list as they are.
    AsListed,
}

/// A cloud to be made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CloudSpec {
    /// The box; all spheres lie inside it.
    pub box_: Aabb,
    /// Number of spheres.
    pub count: usize,
    /// How the radii are distributed.
    pub sizes: SizeDistribution,
    /// What sets their size.
    pub scale: CloudScale,
    /// The same seed gives the same cloud, on every machine.
    pub seed: u64,
}

/// Places spheres at random, the largest first, each where it overlaps none:
/// centre (m) and radius (m) of each.
///
/// # Errors
/// [`DemError::CloudFull`] where no room is found, which is to be expected
/// at porosities below about 0.65; [`DemError::Parameter`] and
/// [`DemError::WallsMet`] for values that make no sense.
///
/// ```
/// use dempfv::dem::{CloudScale, CloudSpec, SizeDistribution, random_cloud};
/// use dempfv::{Aabb, Vec3};
/// let cloud = random_cloud(&CloudSpec {
///     box_: Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) },
///     count: 10,
///     sizes: SizeDistribution::Uniform { spread: 0.3 },
///     scale: CloudScale::Porosity(0.9),
///     seed: 1,
/// })?;
/// assert_eq!(cloud.len(), 10);
/// # Ok::<(), dempfv::dem::DemError>(())
/// ```
pub fn random_cloud(spec: &CloudSpec) -> Result<Vec<(Vec3, f64)>, DemError> {
    check_box(&spec.box_)?;
    let mut rng = Rng::new(spec.seed);
    let volume = spec.box_.volume();
    let Drawn { radii, cloud } = draw(spec.count, (&spec.sizes, spec.scale), volume, &mut rng)?;
    let largest = radii.first().copied().unwrap_or_default();
    place(&radii, cloud, volume, (&spec.box_, largest), |radius, cloud, placed| {
        find_room(&spec.box_, radius, cloud, placed, &mut rng)
    })
}

/// The same in a periodic cell, where spheres may lie across its faces; their centres are in it.
///
/// # Errors
/// As [`random_cloud`]; [`DemError::CellTooSmall`] for a cell smaller than four of the largest
/// spheres.
pub fn random_cloud_in_cell(
    cell: &Cell,
    count: usize,
    sizes: &SizeDistribution,
    scale: CloudScale,
    seed: u64,
) -> Result<Vec<(Vec3, f64)>, DemError> {
    let mut rng = Rng::new(seed);
    let cell = &cell.reduced().unwrap_or(*cell);
    let volume = cell.volume();
    let Drawn { radii, cloud } = draw(count, (sizes, scale), volume, &mut rng)?;
    let largest = radii.first().copied().unwrap_or_default();
    let sight = Sight::new(cell, largest, 0.0)?;
    place(&radii, cloud, volume, (&cell.bounds(), largest), |radius, cloud, placed| {
        (0..TRIES).find_map(|_| {
            let share = Vec3::new(rng.uniform(), rng.uniform(), rng.uniform());
            let centre = cell.matrix() * share;
            let mut copies = sight.copies(&centre, radius);
            copies.all(|x| is_free(&x, radius, cloud, placed)).then_some(centre)
        })
    })
}

/// Radii, the largest first, and room for as many spheres.
struct Drawn {
    radii: Vec<f64>,
    cloud: Vec<(Vec3, f64)>,
}

fn draw(
    count: usize,
    (sizes, scale): (&SizeDistribution, CloudScale),
    volume: f64,
    rng: &mut Rng,
) -> Result<Drawn, DemError> {
    let (mut cloud, mut radii) = (vec![], vec![]);
    let has_room = count <= MOST_SPHERES
        && cloud.try_reserve_exact(count).is_ok()
        && radii.try_reserve_exact(count).is_ok();
    if !has_room {
        let expected = "no more than 4,294,967,287, for which there is memory";
        return Err(DemError::Parameter { name: "count", value: count as f64, expected });
    }
    sizes.draw(count, rng, &mut radii)?;
    rescale(&mut radii, (sizes, scale), volume)?;
    radii.iter().try_for_each(|&r| positive("radius", r))?;
    radii.sort_by(|a, b| b.total_cmp(a));
    Ok(Drawn { radii, cloud })
}

/// Places spheres where `find` has room for them.
fn place(
    radii: &[f64],
    mut cloud: Vec<(Vec3, f64)>,
    volume: f64,
    (box_, largest): (&Aabb, f64),
    mut find: impl FnMut(f64, &[(Vec3, f64)], &Cells) -> Option<Vec3>,
) -> Result<Vec<(Vec3, f64)>, DemError> {
    if radii.is_empty() {
        return Ok(cloud);
    }
    let mut cells = Cells::new(box_, largest, radii.len());
    for &radius in radii {
        let centre = find(radius, &cloud, &cells).ok_or_else(|| {
            let solid: f64 = radii.iter().map(|r| sphere_volume(*r)).sum();
            let porosity = 1.0 - solid / volume;
            DemError::CloudFull { placed: cloud.len(), count: radii.len(), porosity }
        })?;
        cells.add(&centre, cloud.len() as u32);
        cloud.push((centre, radius));
    }
    Ok(cloud)
}

fn sphere_volume(radius: f64) -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * radius.powi(3)
}

impl SizeDistribution {
    /// Radii in no particular unit, to be scaled.
    fn draw(&self, count: usize, rng: &mut Rng, radii: &mut Vec<f64>) -> Result<(), DemError> {
        match self {
            SizeDistribution::Uniform { spread } => {
                if !(0.0..1.0).contains(spread) {
                    return Err(DemError::Parameter {
                        name: "spread",
                        value: *spread,
                        expected: "from 0 to less than 1",
                    });
                }
                radii.extend((0..count).map(|_| 1.0 + spread * (2.0 * rng.uniform() - 1.0)));
            }
            SizeDistribution::List(list) => {
                for &(radius, share) in list {
                    positive("radius", radius)?;
                    positive("share", share)?;
                }
                let total: f64 = list.iter().map(|(_, share)| share).sum();
                positive("sum of the shares", total)?;
                whole_numbers(list, total, count, radii);
            }
        }
        Ok(())
    }
}

/// Each radius as often as its share says: the sphere that brings the sum of
/// the shares past a half, one and a half, ... gets the next number.
fn whole_numbers(list: &[(f64, f64)], total: f64, count: usize, radii: &mut Vec<f64>) {
    let mut sum = 0.0;
    for &(radius, share) in list {
        sum += share;
        let until = ((sum / total * count as f64).round() as usize).min(count);
        radii.resize(until.max(radii.len()), radius);
    }
}

fn rescale(
    radii: &mut [f64],
    (sizes, scale): (&SizeDistribution, CloudScale),
    volume: f64,
) -> Result<(), DemError> {
    let factor = match scale {
        CloudScale::Porosity(porosity) => {
            if !(porosity > 0.0 && porosity < 1.0) {
                return Err(DemError::Parameter {
                    name: "porosity",
                    value: porosity,
                    expected: "between 0 and 1",
                });
            }
            let solid: f64 = radii.iter().map(|r| sphere_volume(*r)).sum();
            ((1.0 - porosity) * volume / solid).cbrt()
        }
        CloudScale::MeanRadius(mean) => {
            positive("mean radius", mean)?;
            // The drawn radii of a uniform distribution are around one: the
            // mean is the distribution's, not the sample's.
            match sizes {
                SizeDistribution::Uniform { .. } => mean,
                SizeDistribution::List(_) => mean * radii.len() as f64 / radii.iter().sum::<f64>(),
            }
        }
        CloudScale::AsListed => match sizes {
            SizeDistribution::List(_) => 1.0,
            SizeDistribution::Uniform { spread } => {
                return Err(DemError::Parameter {
                    name: "spread",
                    value: *spread,
                    expected: "given with a porosity or a mean radius, since it lists no radii",
                });
            }
        },
    };
    for r in radii {
        *r *= factor;
    }
    Ok(())
}

/// A place for the next sphere, or none after many tries.
fn find_room(
    box_: &Aabb,
    radius: f64,
    cloud: &[(Vec3, f64)],
    cells: &Cells,
    rng: &mut Rng,
) -> Option<Vec3> {
    let room = box_.size().add_scalar(-2.0 * radius);
    if room.min() < 0.0 {
        return None;
    }
    (0..TRIES).find_map(|_| {
        let share = Vec3::new(rng.uniform(), rng.uniform(), rng.uniform());
        let centre = box_.min.add_scalar(radius) + room.component_mul(&share);
        is_free(&centre, radius, cloud, cells).then_some(centre)
    })
}

/// Whether a sphere at `x` overlaps none.
fn is_free(x: &Vec3, radius: f64, cloud: &[(Vec3, f64)], cells: &Cells) -> bool {
    cells.around(x, radius).all(|j| {
        let (other, r) = &cloud[j as usize];
        (other - x).norm_squared() >= (radius + r).powi(2)
    })
}

/// Spheres placed so far, in cells at least as wide as the largest.
struct Cells {
    index: CellIndex,
    largest: f64,
    members: Vec<Vec<u32>>,
}

impl Cells {
    fn new(box_: &Aabb, largest: f64, count: usize) -> Cells {
        let index = CellIndex::new(box_, 2.0 * largest, count);
        Cells { index, largest, members: vec![Vec::new(); index.count()] }
    }

    fn add(&mut self, x: &Vec3, j: u32) {
        self.members[self.index.of(x)].push(j);
    }

    /// The spheres that one of this radius at `x` may overlap.
    fn around(&self, x: &Vec3, radius: f64) -> impl Iterator<Item = u32> + '_ {
        let reach = radius + self.largest;
        let low = self.index.coordinates(&x.add_scalar(-reach));
        let high = self.index.coordinates(&x.add_scalar(reach));
        (low[0]..=high[0]).flat_map(move |a| {
            (low[1]..=high[1]).flat_map(move |b| {
                (low[2]..=high[2])
                    .flat_map(move |c| self.members[self.index.index(a, b, c)].iter().copied())
            })
        })
    }
}
