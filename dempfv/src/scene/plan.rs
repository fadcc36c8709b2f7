//! What a scene asks for, as plain validated data. SI units; angles in radians.

use std::path::PathBuf;

use serde::Serialize;

use super::accuracy::Accuracy;
use super::bonds::Bonds;
use super::cell::CellShape;
use super::contacts::{Contacts, NormalLaw};
use super::dem::Dem;
use super::fluid::Fluid;
use super::keys::{Keyed, Keys};
use super::lubrication;
use super::materials::{self, OtherMaterial, Pair};
use super::motion::GivenMotion;
use super::output::{self, Output};
use super::packing_check::{box_wrong, load_packing, load_packing_in_cell};
use super::particles::{ParticleSource, Particles};
use super::schema::Schema;
use super::sizes::Cloud;
use super::stage::Stage;
use super::walls::Walls;
use super::wrong::Wrong;
use crate::dem::law::{Granular, GranularEffects};
use crate::dem::{DemError, Material, MaterialPair};
use crate::domain::{Aabb, Vec3};
use crate::input::InputError;
use crate::io::packing::Packing;

pub(super) static SCHEMA: Schema = Schema::root(&[
    "title",
    "seed",
    "box",
    "cell",
    "particles",
    "material",
    "pair",
    "walls",
    "contacts",
    "bonds",
    "dem",
    "motion",
    "fluid",
    "accuracy",
    "stage",
    "output",
]);
pub(super) static BOX: Schema = Schema::table("[box]", &["min", "max"]);

/// What is said of walls in a cell, and what would be right.
pub(super) const WALLS_IN_CELL: (&str, &str) =
    ("[walls] stands beside [cell]", "leave it out: a cell has no walls");

/// A scene: what is simulated, with which numbers, in which order.
///
/// An absent part (`None`) is an effect that is not simulated. A plan is read from a scene file
/// ([`Plan::load`]) or made in code; [`validate`](Plan::validate) tells what is wrong with one,
/// and a [`Simulation`](crate::simulation::Simulation) refuses it.
///
/// ```
/// use dempfv::scene::{Compact, Dem, Plan, Stage, StageKind};
///
/// let compact = StageKind::Compact(Compact { stress: 1e4, ..Compact::default() });
/// let mut plan = Plan {
///     dem: Some(Dem::default()),
///     stages: vec![Stage::new("compact", compact)],
///     ..Plan::default()
/// };
/// plan.validate()?;
/// plan.particles.material.young = -1.0;
/// let error = plan.validate().unwrap_err();
/// assert_eq!(error.what, "`young` in [particles] is -1");
/// assert_eq!(error.remedy, "give a number above 0 in Pa");
/// # Ok::<(), dempfv::InputError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// Title; the scene file's name without its ending when the scene has none.
    pub title: String,
    /// The scene file, if the plan came from one.
    pub file: Option<PathBuf>,
    /// Seed of every random draw, below 2⁶³. Default 1.
    pub seed: u64,
    /// The box (m). `None`: the packing file's own, else the tight box of its spheres.
    /// Always `Some` when the particles are a cloud without a cell. Default: 1 m along each axis.
    pub bounds: Option<Aabb>,
    /// The periodic cell in the place of the box and its walls. Default: none.
    pub cell: Option<CellShape>,
    /// The spheres and their material.
    pub particles: Particles,
    /// Spheres of other materials.
    pub other_materials: Vec<OtherMaterial>,
    /// What two materials have against each other.
    pub pairs: Vec<Pair>,
    /// The six walls' material.
    pub walls: Walls,
    /// What contacts do beside linear springs and friction.
    pub contacts: Contacts,
    /// Bonds between spheres; `None`: there are none.
    pub bonds: Option<Bonds>,
    /// The mechanics; `None`: nothing moves.
    pub dem: Option<Dem>,
    /// Spheres whose motion is given.
    pub motions: Vec<GivenMotion>,
    /// The fluid in the pores; `None`: nothing is triangulated.
    pub fluid: Option<Fluid>,
    /// An error that the run keeps to by itself; `None`: nothing is estimated.
    pub accuracy: Option<Accuracy>,
    /// What happens, in order. At least one.
    pub stages: Vec<Stage>,
    /// What is written, and how often.
    pub output: Output,
}

impl Default for Plan {
    /// A cloud of 1000 spheres in a box of 1 m, at rest and dry, without stages.
    fn default() -> Plan {
        Plan {
            title: "untitled".to_owned(),
            file: None,
            seed: 1,
            bounds: Some(Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) }),
            cell: None,
            particles: Particles::default(),
            other_materials: vec![],
            pairs: vec![],
            walls: Walls::default(),
            contacts: Contacts::default(),
            bonds: None,
            dem: None,
            motions: vec![],
            fluid: None,
            accuracy: None,
            stages: vec![],
            output: Output::default(),
        }
    }
}

/// A broken rule between the parts of a plan, and where it is told.
pub(super) struct Fault {
    pub place: Place,
    pub what: String,
    pub remedy: String,
}

/// Where a broken rule is told.
pub(super) enum Place {
    /// At this stage.
    Stage(usize),
    /// At the table of this name.
    Table(&'static str),
}

impl Plan {
    /// Checks all that a scene file is checked for, but whether the packing file is there:
    /// every number, and the parts against each other.
    ///
    /// # Errors
    /// The first thing that is wrong, and what would be right.
    pub fn validate(&self) -> Result<(), InputError> {
        let keys = Keys::Check(&SCHEMA);
        keys.rule("seed", super::kind::Kind::wrong(&super::kind::Count(0), &self.seed))?;
        if let Some(bounds) = &self.bounds {
            Keys::Check(&BOX).rule("max", box_wrong(bounds))?;
        }
        self.particles.check()?;
        Keys::Check(self.particles.schema())
            .rule("cloud", self.particles.wrong_in(self.room().as_ref()))?;
        self.other_materials.iter().try_for_each(Keyed::check)?;
        self.pairs.iter().try_for_each(Keyed::check)?;
        self.walls.check()?;
        self.contacts.check()?;
        self.bonds.iter().try_for_each(Keyed::check)?;
        self.dem.iter().try_for_each(Keyed::check)?;
        self.motions.iter().try_for_each(Keyed::check)?;
        self.fluid.iter().try_for_each(Keyed::check)?;
        self.accuracy.iter().try_for_each(Keyed::check)?;
        self.stages.iter().try_for_each(Stage::check)?;
        self.output.check()?;
        let keys = Keys::Check(&output::SCHEMA);
        self.output.rules(&keys, self.bounds.as_ref(), self.fluid.is_some())?;
        if self.stages.is_empty() {
            return Err(InputError::new("the plan has no stage", "add one or more"));
        }
        self.rules().map_err(|fault| InputError::new(fault.what, fault.remedy))
    }

    /// Checks the parts against each other.
    pub(super) fn rules(&self) -> Result<(), Fault> {
        let around = self.fluid.as_ref().and_then(|f| f.wrong_around(self.cell.is_some()));
        if let Some(Wrong { problem, remedy }) = around {
            let what = format!("[fluid] {problem}");
            return Err(Fault { place: Place::Table("fluid"), what, remedy });
        }
        let error = self.accuracy.as_ref();
        let error = error.and_then(|a| a.wrong_in(&self.stages, self.fluid.as_ref()));
        if let Some(Wrong { problem, remedy }) = error {
            let what = format!("[accuracy] {problem}");
            return Err(Fault { place: Place::Table("accuracy"), what, remedy });
        }
        self.rules_of_cell()?;
        for (i, stage) in self.stages.iter().enumerate() {
            let earlier = &self.stages[..i];
            let wrong = stage
                .wrong_around(self.cell.is_some())
                .or_else(|| stage.wrong_in(earlier, self.dem.as_ref(), self.fluid.as_ref()));
            if let Some(Wrong { problem, remedy }) = wrong {
                let what = format!("stage \"{}\" {problem}", stage.name);
                return Err(Fault { place: Place::Stage(i), what, remedy });
            }
        }
        self.material_rules()?;
        self.contact_rules()?;
        if let Some(wrong) = self.output.wrong_in(self.cell.is_some(), self.dem.is_some()) {
            let what = format!("[output] {}", wrong.problem);
            return Err(Fault { place: Place::Table("output"), what, remedy: wrong.remedy });
        }
        self.body_rules()?;
        let is_coupled = self.stages.iter().any(|s| s.kind.is_coupled());
        let mut flowing = self.stages.iter().filter(|s| s.kind.has_conditions());
        let gravity = self.dem.is_some_and(|dem| dem.options.gravity.is_some());
        let turns = self.dem.is_some_and(|dem| dem.options.rotation);
        let wrong = self.fluid.as_ref().and_then(|fluid| {
            let edges = &fluid.effects.edges;
            let undetermined = |s: &Stage| s.kind.fluid(fluid, 0.0).undetermined_in(&s.name);
            let undetermined = match self.cell {
                None => flowing.find_map(undetermined),
                Some(_) => None,
            };
            undetermined
                .or_else(|| fluid.weightless(gravity))
                .or_else(|| lubrication::wrong_in(edges, is_coupled, turns))
                .or_else(|| fluid.misplaced_in(self.bounds.as_ref()))
        });
        match wrong {
            Some(Wrong { problem, remedy }) => Err(Fault {
                place: Place::Table("fluid"),
                what: format!("[fluid] {problem}"),
                remedy,
            }),
            None => Ok(()),
        }
    }

    /// What a periodic cell leaves no room for.
    fn rules_of_cell(&self) -> Result<(), Fault> {
        let Some(cell) = self.cell else { return Ok(()) };
        let gravity = self.dem.as_ref().is_some_and(|dem| dem.options.gravity.is_some());
        // As a scene has them that says nothing of walls, and as code has them.
        let unsaid = [Walls::as_stiff_as(self.particles.material.young), Walls::default()];
        for (given, table, what, remedy) in [
            (
                self.bounds.is_some(),
                "box",
                "[box] stands beside [cell]",
                "keep one: a cell has no walls",
            ),
            (!unsaid.contains(&self.walls), "walls", WALLS_IN_CELL.0, WALLS_IN_CELL.1),
            (
                self.particles.clump.is_some(),
                "particles",
                "`clump` in [particles] stands beside [cell]",
                "put walls around: there are no clumps in a periodic cell",
            ),
            (
                !self.motions.is_empty(),
                "motion",
                "[[motion]] stands beside [cell]",
                "put walls around: spheres move with a periodic cell",
            ),
            (
                self.fluid.as_ref().is_some_and(|fluid| fluid.effects.edges.any()),
                "fluid",
                "viscous shear or lubrication in [fluid] stands beside [cell]",
                "put walls around: there are no forces between neighbours across a periodic cell",
            ),
            (
                gravity,
                "dem",
                "`gravity` in [dem] stands beside [cell]",
                "leave it out: nothing holds the spheres up in a cell",
            ),
        ] {
            if given {
                let (what, remedy) = (what.to_owned(), remedy.to_owned());
                return Err(Fault { place: Place::Table(table), what, remedy });
            }
        }
        if let ParticleSource::Cloud(Cloud { sizes, .. }) = &self.particles.source {
            // Of a cloud whose radii are not known one by one.
            let mean = 0.5 * (sizes.smallest() + sizes.largest());
            if let Some(Wrong { problem, remedy }) = cell.wrong_with(sizes.largest(), mean) {
                let what = format!("[cell] {problem}");
                return Err(Fault { place: Place::Table("cell"), what, remedy });
            }
        }
        let effects = self.granular();
        let pulls = effects.bonds.is_some() || effects.adhesion.is_some();
        let young = self.particles.material.young;
        for (i, stage) in self.stages.iter().enumerate() {
            let closed = self.fluid.as_ref().is_some_and(|fluid| !fluid.effects.store());
            let wrong = stage.cell_stress_wrong(young, pulls);
            let wrong = wrong.or_else(|| stage.volume_wrong().filter(|_| closed));
            if let Some(Wrong { problem, remedy }) = wrong {
                let what = format!("stage \"{}\" {problem}", stage.name);
                return Err(Fault { place: Place::Stage(i), what, remedy });
            }
        }
        Ok(())
    }

    /// A box of the volume that the spheres have, as far as the scene says it: the box, or one
    /// like the periodic cell.
    pub fn room(&self) -> Option<Aabb> {
        self.bounds.or(self.cell.and_then(|cell| cell.room()))
    }

    /// Checks contacts and bonds against what moves, and against each other.
    fn contact_rules(&self) -> Result<(), Fault> {
        let fault = |place, what: &str, remedy: &str| {
            Err(Fault { place, what: what.to_owned(), remedy: remedy.to_owned() })
        };
        let still = "stands without [dem]: nothing moves, so nothing touches";
        let moves = "add a table [dem], or leave this one out";
        if self.dem.is_none() && self.contacts != Contacts::default() {
            return fault(Place::Table("contacts"), &format!("[contacts] {still}"), moves);
        }
        let ratio = self.particles.material.stiffness_ratio;
        let default = Particles::default().material.stiffness_ratio;
        if self.contacts.law == NormalLaw::HertzMindlin && ratio != default {
            let what = "`stiffness_ratio` in [particles] stands beside `law = \"hertz-mindlin\"`, whose \
                        shear stiffness follows from `poisson_ratio`";
            return fault(Place::Table("particles"), what, "leave it out, or give `poisson_ratio`");
        }
        let turns = self.dem.is_none_or(|dem| dem.options.rotation);
        if let Some(key) = self.contacts.needs_rotation().filter(|_| !turns) {
            let what = format!("`{key}` in [contacts] stands beside `rotation = false` in [dem]");
            return fault(Place::Table("contacts"), &what, "let spheres rotate, or leave it out");
        }
        let Some(bonds) = &self.bonds else { return Ok(()) };
        if self.dem.is_none() {
            return fault(Place::Table("bonds"), &format!("[bonds] {still}"), moves);
        }
        if let Err(error) = Granular::new(self.granular()) {
            let what = format!("[bonds] beside [contacts]: {error}");
            return fault(Place::Table("bonds"), &what, "leave one of the two effects out");
        }
        match bonds.wrong_in(self.particles.material.young, &self.stages) {
            Some(wrong) => {
                fault(Place::Table("bonds"), &format!("[bonds] {}", wrong.problem), &wrong.remedy)
            }
            None => Ok(()),
        }
    }

    /// Checks the materials against each other.
    fn material_rules(&self) -> Result<(), Fault> {
        let Some(Wrong { problem, remedy }) = materials::wrong(&self.other_materials, &self.pairs)
        else {
            return Ok(());
        };
        let table = if problem.starts_with("[[pair]]") { "pair" } else { "material" };
        Err(Fault { place: Place::Table(table), what: problem, remedy })
    }

    /// What the spheres are made of, that of `[particles]` first.
    pub fn materials(&self) -> Vec<Material> {
        materials::all(&self.particles.material, &self.other_materials)
    }

    /// What pairs of these materials have against each other.
    pub fn material_pairs(&self) -> Vec<MaterialPair> {
        materials::pairs(&self.pairs, &self.other_materials)
    }

    /// The index of the material of each sphere, of which these are the first places and the radii (m).
    ///
    /// # Errors
    /// [`DemError::NoSuchSphere`] for a number in a `[[material]]` that no sphere has.
    pub fn material_of_each(
        &self,
        position: &[Vec3],
        radius: &[f64],
    ) -> Result<Vec<u16>, DemError> {
        let count = position.len();
        let mut of_sphere = vec![0; count];
        for (index, material) in (1u16..).zip(&self.other_materials) {
            for number in material.which.chosen(position, radius) {
                let place = of_sphere.get_mut(number as usize);
                *place.ok_or(DemError::NoSuchSphere { number, count })? = index;
            }
        }
        Ok(of_sphere)
    }

    /// Checks clumps and motions against what moves.
    fn body_rules(&self) -> Result<(), Fault> {
        let fault = |place, what: String, remedy: &str| {
            Err(Fault { place, what, remedy: remedy.to_owned() })
        };
        let turns = self.dem.is_none_or(|dem| dem.options.rotation);
        if self.particles.clump.is_some() && !turns {
            let what = "`clump` in [particles] stands beside `rotation = false` in [dem]";
            let place = Place::Table("particles");
            return fault(place, what.to_owned(), "let spheres rotate, or leave it out");
        }
        if !self.motions.is_empty() && self.dem.is_none() {
            let what = "[[motion]] stands without [dem]: nothing moves".to_owned();
            return fault(Place::Table("motion"), what, "add a table [dem], or leave it out");
        }
        let wrong = |motion: &GivenMotion| motion.wrong_in(&self.stages);
        match self.motions.iter().find_map(wrong) {
            Some(Wrong { problem, remedy }) => {
                fault(Place::Table("motion"), format!("[[motion]] {problem}"), &remedy)
            }
            None => Ok(()),
        }
    }

    fn granular(&self) -> GranularEffects {
        let bonds = self.bonds.as_ref().map(|bonds| bonds.strength);
        GranularEffects { bonds, ..self.contacts.effects() }
    }

    /// The contact law where it is not the linear one.
    ///
    /// # Errors
    /// Constants that make no sense, or effects that do not go together: of a plan that
    /// [`validate`](Plan::validate) refuses.
    pub fn granular_law(&self) -> Result<Option<Granular>, DemError> {
        let effects = self.granular();
        (effects != GranularEffects::default()).then(|| Granular::new(effects)).transpose()
    }

    /// Whether spheres move in any stage.
    pub fn moves(&self) -> bool {
        self.stages.iter().any(|stage| stage.kind.moves())
    }

    /// The mechanics of a stage: `[dem]`, with what the stage says otherwise. `None` where
    /// nothing moves.
    pub fn mechanics(&self, stage: &Stage) -> Option<Dem> {
        let dem = self.dem.as_ref().filter(|_| stage.kind.moves())?;
        Some(stage.mechanics(dem))
    }

    /// Reads and checks the packing file of the scene, with the box that holds it: the
    /// scene's, else the file's own, else the tight one; in a periodic cell, which is then the
    /// packing's, the box around it. `None` when the spheres are a cloud.
    ///
    /// # Errors
    /// As [`load_packing`].
    pub fn packing(&self) -> Result<Option<(Packing, Aabb)>, InputError> {
        match &self.particles.source {
            ParticleSource::Packing(path) => {
                if let Some(shape) = self.cell {
                    return load_packing_in_cell(path, shape).map(Some);
                }
                let (packing, bounds) = load_packing(path, self.bounds)?;
                self.check_places(&bounds)?;
                Ok(Some((packing, bounds)))
            }
            ParticleSource::Cloud(_) => Ok(None),
        }
    }

    /// Refuses probes and regions outside the box that holds the packing.
    fn check_places(&self, bounds: &Aabb) -> Result<(), InputError> {
        if let Some((_, problem)) = self.output.probe_outside(bounds) {
            let what = format!("`probes` in [output] {problem}");
            return Err(self.error(what, "give points inside the box of the packing"));
        }
        match self.fluid.as_ref().and_then(|fluid| fluid.misplaced_in(Some(bounds))) {
            Some(wrong) => Err(self.error(format!("[fluid] {}", wrong.problem), wrong.remedy)),
            None => Ok(()),
        }
    }

    /// An error about this plan, with its file.
    pub(crate) fn error(&self, what: String, remedy: impl Into<String>) -> InputError {
        let error = InputError::new(what, remedy);
        match &self.file {
            Some(file) => error.in_file(file),
            None => error,
        }
    }
}
