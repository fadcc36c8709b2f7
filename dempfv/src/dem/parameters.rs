//! The constants that a law takes from materials, by material.

use super::law::{ContactLaw, Needs};
use super::material::{Material, MaterialPair, WallMaterial};

/// The constants of each pair of materials, and of each material on a wall.
#[derive(Clone, Debug)]
pub(super) struct ParameterTable<L: ContactLaw> {
    materials: usize,
    spheres: Vec<L::Parameters>,
    walls: Vec<L::Parameters>,
    pair_needs: Needs,
    wall_needs: Needs,
}

impl<L: ContactLaw> ParameterTable<L> {
    /// The table of the `materials` of spheres, of which there is one at
    /// least; of several `pairs` of the same two the last one counts.
    pub fn new(
        law: &L,
        (materials, pairs): (&[Material], &[MaterialPair]),
        wall: &WallMaterial,
    ) -> ParameterTable<L> {
        let numbered = || materials.iter().enumerate();
        let all = numbered().flat_map(|a| numbered().map(move |b| (a, b)));
        let between = |((i, a), (j, b)): ((usize, &Material), (usize, &Material))| match pairs
            .iter()
            .rfind(|pair| pair.joins(i, j))
        {
            Some(pair) => law.between_spheres(&pair.of(a), &pair.of(b)),
            None => law.between_spheres(a, b),
        };
        let spheres: Vec<_> = all.map(between).collect();
        let walls: Vec<_> = materials.iter().map(|a| law.on_wall(a, wall)).collect();
        let most = |table: &[L::Parameters]| {
            table.iter().map(|p| law.needs(p)).max().unwrap_or(Needs::Overlap)
        };
        let (pair_needs, wall_needs) = (most(&spheres), most(&walls));
        ParameterTable { materials: materials.len(), spheres, walls, pair_needs, wall_needs }
    }

    /// Constants of a contact of two spheres of these materials.
    #[inline(always)]
    pub fn spheres(&self, first: u16, second: u16) -> L::Parameters {
        self.spheres[usize::from(first) * self.materials + usize::from(second)]
    }

    /// Number of materials, which are no more than an index can tell.
    pub fn materials(&self) -> u16 {
        self.materials as u16
    }

    /// Constants of a sphere of this material on a wall.
    #[inline(always)]
    pub fn wall(&self, material: u16) -> L::Parameters {
        self.walls[usize::from(material)]
    }

    /// Constants of every contact.
    pub fn all(&self) -> impl Iterator<Item = &L::Parameters> {
        self.spheres.iter().chain(&self.walls)
    }

    /// The most that any contact needs.
    pub fn needs(&self) -> Needs {
        self.pair_needs.max(self.wall_needs)
    }

    /// The most that a contact of two spheres needs.
    pub fn pair_needs(&self) -> Needs {
        self.pair_needs
    }

    /// The most that a contact with a wall needs.
    pub fn wall_needs(&self) -> Needs {
        self.wall_needs
    }
}
