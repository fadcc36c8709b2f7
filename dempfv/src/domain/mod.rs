//! The box that holds the packing, the names of its six walls, and the cell that has none.

mod ball_in_box;
mod cell;
mod invariants;

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

pub(crate) use ball_in_box::ball_in_box;
pub use cell::{Cell, CellError};
pub use invariants::{deviatoric_stress, mean_stress};

/// A point or a vector in space; SI units as the field that holds it says.
pub type Vec3 = nalgebra::Vector3<f64>;

/// A 3 × 3 matrix, as a stress or a velocity gradient.
pub type Tensor = nalgebra::Matrix3<f64>;

/// One of the six axis-aligned walls of the box.
///
/// The discriminant is the wall's index everywhere: in arrays of six, and
/// (after the spheres) as a vertex of the triangulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[repr(u8)]
pub enum WallId {
    /// The wall at the smallest x.
    XMin = 0,
    /// The wall at the largest x.
    XMax = 1,
    /// The wall at the smallest y.
    YMin = 2,
    /// The wall at the largest y.
    YMax = 3,
    /// The wall at the smallest z.
    ZMin = 4,
    /// The wall at the largest z.
    ZMax = 5,
}

impl WallId {
    /// All walls, in the order of their indices.
    pub const ALL: [WallId; 6] =
        [WallId::XMin, WallId::XMax, WallId::YMin, WallId::YMax, WallId::ZMin, WallId::ZMax];

    /// Index of the wall, 0 to 5.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// Axis the wall is normal to: 0, 1 or 2.
    pub const fn axis(self) -> usize {
        self as usize / 2
    }

    /// True for the wall at the upper end of its axis.
    pub const fn is_max(self) -> bool {
        self as usize % 2 == 1
    }

    /// The wall at the other end of the same axis.
    pub const fn opposite(self) -> WallId {
        WallId::ALL[self as usize ^ 1]
    }

    /// Component of the inward normal along the wall's axis: +1 or -1.
    pub const fn inward(self) -> f64 {
        if self.is_max() { -1.0 } else { 1.0 }
    }

    /// Unit normal that points into the box.
    pub fn inward_normal(self) -> Vec3 {
        let mut n = Vec3::zeros();
        n[self.axis()] = self.inward();
        n
    }

    /// The wall's name in files and messages: `x_min` to `z_max`.
    pub const fn name(self) -> &'static str {
        ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"][self as usize]
    }
}

impl fmt::Display for WallId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A wall name that is none of the six.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown wall `{0}`; the walls are x_min, x_max, y_min, y_max, z_min, z_max")]
pub struct UnknownWall(pub String);

impl FromStr for WallId {
    type Err = UnknownWall;

    fn from_str(s: &str) -> Result<Self, Self::Err> {
        WallId::ALL.into_iter().find(|w| w.name() == s).ok_or_else(|| UnknownWall(s.to_owned()))
    }
}

/// One axis of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// x
    X,
    /// y
    Y,
    /// z
    Z,
}

impl Axis {
    /// All three.
    pub const ALL: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

    /// The two walls that are normal to it, the lower first.
    pub const fn walls(self) -> [WallId; 2] {
        [WallId::ALL[2 * self as usize], WallId::ALL[2 * self as usize + 1]]
    }

    /// 0, 1 or 2.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// `x`, `y` or `z`.
    pub const fn name(self) -> &'static str {
        ["x", "y", "z"][self as usize]
    }

    /// The axis that a wall is normal to.
    pub const fn of(wall: WallId) -> Axis {
        [Axis::X, Axis::Y, Axis::Z][wall.axis()]
    }
}

/// One value for each of the six walls, by [`WallId`].
///
/// ```
/// use dempfv::{PerWall, WallId};
/// let mut pressure = PerWall::from_fn(|_| None);
/// pressure[WallId::YMax] = Some(0.0);
/// assert_eq!(pressure.iter().filter(|(_, p)| p.is_some()).count(), 1);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PerWall<T>(pub [T; 6]);

impl<T> PerWall<T> {
    /// The value of a function for each wall.
    pub fn from_fn(value: impl FnMut(WallId) -> T) -> PerWall<T> {
        PerWall(WallId::ALL.map(value))
    }

    /// Each wall with its value.
    pub fn iter(&self) -> impl Iterator<Item = (WallId, &T)> {
        WallId::ALL.into_iter().zip(&self.0)
    }

    /// Each wall with its value, to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (WallId, &mut T)> {
        WallId::ALL.into_iter().zip(&mut self.0)
    }

    /// The values, in the order of the walls' indices.
    pub fn values(&self) -> impl Iterator<Item = &T> {
        self.0.iter()
    }

    /// What a function makes of each value.
    pub fn map<U>(&self, f: impl FnMut(&T) -> U) -> PerWall<U> {
        PerWall(self.0.each_ref().map(f))
    }
}

impl<T> std::ops::Index<WallId> for PerWall<T> {
    type Output = T;

    fn index(&self, wall: WallId) -> &T {
        &self.0[wall.index()]
    }
}

impl<T> std::ops::IndexMut<WallId> for PerWall<T> {
    fn index_mut(&mut self, wall: WallId) -> &mut T {
        &mut self.0[wall.index()]
    }
}

impl<T> From<[T; 6]> for PerWall<T> {
    fn from(values: [T; 6]) -> PerWall<T> {
        PerWall(values)
    }
}

/// An axis-aligned box. Lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Aabb {
    /// Corner with the smallest coordinates (m).
    pub min: Vec3,
    /// Corner with the largest coordinates (m).
    pub max: Vec3,
}

impl Aabb {
    /// Edge lengths (m).
    pub fn size(&self) -> Vec3 {
        self.max - self.min
    }

    /// Volume (m³).
    pub fn volume(&self) -> f64 {
        self.size().product()
    }

    /// Centre (m).
    pub fn center(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }

    /// Whether a point lies in the box or on its surface.
    pub fn contains(&self, x: &Vec3) -> bool {
        (0..3).all(|k| self.min[k] <= x[k] && x[k] <= self.max[k])
    }

    /// Coordinate of a wall's plane along the wall's axis (m).
    pub fn wall(&self, wall: WallId) -> f64 {
        if wall.is_max() { self.max[wall.axis()] } else { self.min[wall.axis()] }
    }

    /// Area of a wall (m²).
    pub fn wall_area(&self, wall: WallId) -> f64 {
        let size = self.size();
        size[(wall.axis() + 1) % 3] * size[(wall.axis() + 2) % 3]
    }

    /// Distance between neighbouring numbers in double precision at the largest of the box's
    /// coordinates (m): positions in it are known no better.
    pub(crate) fn spacing(&self) -> f64 {
        let farthest = self.min.amax().max(self.max.amax());
        farthest.next_up() - farthest
    }

    /// The tight box around spheres; `None` when there are none, for arrays of different
    /// lengths, and where a number is not finite.
    ///
    /// ```
    /// use dempfv::{Aabb, Vec3};
    /// let b = Aabb::of_spheres(&[Vec3::new(1.0, 2.0, 3.0)], &[0.5]).unwrap();
    /// assert_eq!(b.min, Vec3::new(0.5, 1.5, 2.5));
    /// ```
    pub fn of_spheres(position: &[Vec3], radius: &[f64]) -> Option<Aabb> {
        let ends = |(x, r): (&Vec3, &f64)| (x.add_scalar(-r), x.add_scalar(*r));
        let is_known = |(low, high): &(Vec3, Vec3)| low.iter().chain(high).all(|c| c.is_finite());
        let mut around = position.iter().zip(radius).map(ends);
        if position.len() != radius.len() || !around.clone().all(|ends| is_known(&ends)) {
            return None;
        }
        let first = around.next()?;
        let (min, max) = around.fold(first, |(a, b), (low, high)| (a.inf(&low), b.sup(&high)));
        Some(Aabb { min, max })
    }
}
