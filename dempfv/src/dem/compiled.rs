//! A law compiled for the contact pass and put behind one dynamic call, so
//! that [`Dem`](super::Dem) is one type for all laws.

use std::fmt::Debug;

use super::law::{ContactForce, ContactLaw, History, Needs, SphereOnPlane, Stiffness, TwoSpheres};
use super::material::{Material, MaterialPair, WallMaterial};
use super::neighbours::Neighbours;
use super::parameters::ParameterTable;
use super::particles::Particles;
use super::pass::{Forces, contact_forces};
use super::pass_input::Input;
use super::stiffness_pass::{
    EXPECTED_OVERLAP_SHARE, StiffnessInput, StiffnessScratch, fastest_held, fastest_lone,
};
use crate::Vec3;

/// A contact between two steps, as an observer sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    pub surfaces: Surfaces,
    /// Depth of the overlap (m).
    pub overlap: f64,
}

/// The two bodies of a contact.
#[derive(Clone, Copy, Debug)]
pub(super) enum Surfaces {
    /// With the indices of their materials.
    Spheres(TwoSpheres, [u16; 2]),
    Wall(SphereOnPlane, u16),
}

/// What [`super::Dem`] asks of any law: one call per pass, and one per
/// contact of an observation.
pub(super) trait CompiledLaw: Debug + Send + Sync {
    fn clone_box(&self) -> Box<dyn CompiledLaw>;
    fn name(&self) -> &'static str;
    /// Numbers per contact in the histories.
    fn history_length(&self) -> usize;
    fn cut_off(&self) -> f64;
    /// See [`ContactLaw::fit_cut_off`].
    fn fit_cut_off(&mut self, largest_radius: f64);
    /// See [`ContactLaw::acts`].
    fn acts(&self, touch: &Touch, history: &[f64]) -> bool;
    /// See [`ContactLaw::stiffens`].
    fn stiffens(&self) -> bool;
    /// A contact that does not exist yet, of a sphere of this radius (m), that an energy of
    /// approach (J) goes into.
    fn expected(&self, surfaces: Surfaces, radius: f64, energy: f64) -> Touch;
    /// Takes the constants of these materials.
    fn set_materials(&mut self, spheres: (&[Material], &[MaterialPair]), wall: &WallMaterial);
    /// The most that any contact needs, and that one of spheres and that one
    /// with a wall needs.
    fn needs(&self) -> Needs;
    fn pair_needs(&self) -> Needs;
    fn wall_needs(&self) -> Needs;
    /// Computes all contact forces; histories follow the last step.
    fn contact_forces(&self, list: &mut Neighbours, out: &mut Forces, input: Input<'_>);
    fn stiffness(&self, touch: &Touch) -> Stiffness;
    /// See [`fastest_held`].
    fn fastest_held(&self, input: StiffnessInput<'_>, scratch: &mut StiffnessScratch) -> f64;
    /// See [`fastest_lone`].
    fn fastest_lone(&self, particles: &Particles, impact2: f64) -> f64;
    fn force(&self, touch: &Touch, history: &[f64]) -> ContactForce;
    fn elastic_energy(&self, touch: &Touch, history: &[f64]) -> f64;
    /// See [`ContactLaw::viscous_force`].
    fn viscous_force(&self, history: &[f64]) -> Vec3;
    /// See [`ContactLaw::bond`].
    fn bond(&self, overlap: f64, radii: [f64; 2], history: &mut [f64]) -> bool;
    /// See [`ContactLaw::is_bonded`].
    fn is_bonded(&self, history: &[f64]) -> bool;
    /// See [`ContactLaw::reversed`].
    fn reverse(&self, history: &mut [f64]);
}

/// A law and its constants.
#[derive(Clone, Debug)]
struct Compiled<L: ContactLaw> {
    law: L,
    table: ParameterTable<L>,
}

/// Compiles a law for these materials.
pub(super) fn compile<L: ContactLaw>(
    law: L,
    spheres: &[Material],
    wall: &WallMaterial,
) -> Box<dyn CompiledLaw> {
    let table = ParameterTable::new(&law, (spheres, &[]), wall);
    Box::new(Compiled { law, table })
}

impl<L: ContactLaw> CompiledLaw for Compiled<L> {
    fn clone_box(&self) -> Box<dyn CompiledLaw> {
        Box::new(self.clone())
    }

    fn name(&self) -> &'static str {
        self.law.name()
    }

    fn history_length(&self) -> usize {
        self.law.history_length()
    }

    fn cut_off(&self) -> f64 {
        self.law.cut_off()
    }

    fn fit_cut_off(&mut self, largest_radius: f64) {
        self.law.fit_cut_off(self.table.all(), largest_radius);
    }

    fn acts(&self, touch: &Touch, history: &[f64]) -> bool {
        self.law.acts(touch.overlap, &L::History::read(history))
    }

    fn stiffens(&self) -> bool {
        self.law.stiffens()
    }

    fn expected(&self, surfaces: Surfaces, radius: f64, energy: f64) -> Touch {
        let usual = EXPECTED_OVERLAP_SHARE * radius;
        let parameters = self.parameters(surfaces);
        let overlap = match surfaces {
            Surfaces::Spheres(radii, _) => {
                self.law.expected_overlap(&parameters, radii, energy, usual)
            }
            Surfaces::Wall(radii, _) => {
                self.law.expected_overlap(&parameters, radii, energy, usual)
            }
        };
        Touch { surfaces, overlap }
    }

    fn set_materials(&mut self, spheres: (&[Material], &[MaterialPair]), wall: &WallMaterial) {
        self.table = ParameterTable::new(&self.law, spheres, wall);
    }

    fn needs(&self) -> Needs {
        self.table.needs()
    }

    fn pair_needs(&self) -> Needs {
        self.table.pair_needs()
    }

    fn wall_needs(&self) -> Needs {
        self.table.wall_needs()
    }

    fn contact_forces(&self, list: &mut Neighbours, out: &mut Forces, input: Input<'_>) {
        contact_forces(&self.law, &self.table, list, out, input);
    }

    fn stiffness(&self, touch: &Touch) -> Stiffness {
        let parameters = self.parameters(touch.surfaces);
        match touch.surfaces {
            Surfaces::Spheres(radii, _) => self.law.stiffness(&parameters, radii, touch.overlap),
            Surfaces::Wall(radii, _) => self.law.stiffness(&parameters, radii, touch.overlap),
        }
    }

    fn fastest_held(&self, input: StiffnessInput<'_>, scratch: &mut StiffnessScratch) -> f64 {
        fastest_held(&self.law, &self.table, input, scratch)
    }

    fn fastest_lone(&self, p: &Particles, impact2: f64) -> f64 {
        fastest_lone(&self.law, &self.table, &p.radius, &p.mass, &p.material, impact2)
    }

    fn force(&self, touch: &Touch, history: &[f64]) -> ContactForce {
        let (parameters, history) = (self.parameters(touch.surfaces), L::History::read(history));
        match touch.surfaces {
            Surfaces::Spheres(radii, _) => {
                self.law.force(&parameters, radii, touch.overlap, &history)
            }
            Surfaces::Wall(radii, _) => self.law.force(&parameters, radii, touch.overlap, &history),
        }
    }

    fn elastic_energy(&self, touch: &Touch, history: &[f64]) -> f64 {
        let (parameters, history) = (self.parameters(touch.surfaces), L::History::read(history));
        match touch.surfaces {
            Surfaces::Spheres(radii, _) => {
                self.law.elastic_energy(&parameters, radii, touch.overlap, &history)
            }
            Surfaces::Wall(radii, _) => {
                self.law.elastic_energy(&parameters, radii, touch.overlap, &history)
            }
        }
    }

    fn viscous_force(&self, history: &[f64]) -> Vec3 {
        self.law.viscous_force(&L::History::read(history))
    }

    fn bond(&self, overlap: f64, radii: [f64; 2], history: &mut [f64]) -> bool {
        self.law.bond(overlap, radii, history)
    }

    fn is_bonded(&self, history: &[f64]) -> bool {
        self.law.is_bonded(&L::History::read(history))
    }

    fn reverse(&self, history: &mut [f64]) {
        self.law.reversed(L::History::read(history)).write(history);
    }
}

impl<L: ContactLaw> Compiled<L> {
    fn parameters(&self, surfaces: Surfaces) -> L::Parameters {
        match surfaces {
            Surfaces::Spheres(_, [first, second]) => self.table.spheres(first, second),
            Surfaces::Wall(_, material) => self.table.wall(material),
        }
    }
}
