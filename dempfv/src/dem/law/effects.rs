//! The effects of the granular law, and what follows from which of them are on.

use serde::Serialize;

use super::adhesion::Adhesion;
use super::bonds::Bonds;
use super::hertz::Hertz;
use super::resistance::Resistance;
use super::restitution::Restitution;
use crate::dem::error::DemError;

/// What the granular law is put together from. Without any of it, it is the linear law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct GranularEffects {
    /// Hertz's and Mindlin's contact in the place of linear springs.
    pub hertz: Option<Hertz>,
    /// Viscous damping.
    pub restitution: Option<Restitution>,
    /// Resistance against rolling.
    pub rolling: Option<Resistance>,
    /// Resistance against twisting.
    pub twisting: Option<Resistance>,
    /// What holds surfaces together that touch.
    pub adhesion: Option<Adhesion>,
    /// Bonds between spheres.
    pub bonds: Option<Bonds>,
}

impl GranularEffects {
    /// What is wrong with them, each for itself and together.
    pub(super) fn check(&self) -> Result<(), DemError> {
        self.hertz.iter().try_for_each(Hertz::check)?;
        self.restitution.iter().try_for_each(Restitution::check)?;
        let rolling = ["rolling friction", "rolling stiffness_ratio", "rolling damping_ratio"];
        self.rolling.iter().try_for_each(|r| r.check(rolling))?;
        let twisting = ["twisting friction", "twisting stiffness_ratio", "twisting damping_ratio"];
        self.twisting.iter().try_for_each(|r| r.check(twisting))?;
        self.adhesion.iter().try_for_each(Adhesion::check)?;
        self.bonds.iter().try_for_each(Bonds::check)?;
        self.contradiction().map_or(Ok(()), |reason| Err(DemError::Effects { reason }))
    }

    /// Why these effects do not go together, if they do not.
    fn contradiction(&self) -> Option<&'static str> {
        let theory = matches!(self.adhesion, Some(Adhesion::Dmt(_) | Adhesion::Jkr(_)));
        if theory && self.hertz.is_none() {
            return Some("DMT and JKR adhesion are of Hertz's contact, not of linear springs");
        }
        if self.bonds.is_some() && self.hertz.is_some() {
            return Some("a bond has a linear spring, not Hertz's, which bears no tension");
        }
        if self.bonds.is_some() && self.adhesion.is_some() {
            return Some("a bond has its own tension: there is no adhesion beside bonds");
        }
        None
    }

    /// The law's name, with what it remembers beside the shear force: no other takes up its
    /// histories.
    pub(super) fn name(&self) -> &'static str {
        let jkr = matches!(self.adhesion, Some(Adhesion::Jkr(_)));
        let held = match (jkr, self.bonds.is_some()) {
            (true, _) => 1,
            (false, bonds) => 2 * usize::from(bonds),
        };
        let rolling = usize::from(self.rolling.is_some());
        let twisting = usize::from(self.twisting.is_some());
        NAMES[usize::from(self.restitution.is_some())][held][rolling + 2 * twisting]
    }
}

macro_rules! by_turning {
    ($law:literal) => {
        [
            $law,
            concat!($law, ", rolling"),
            concat!($law, ", twisting"),
            concat!($law, ", rolling and twisting"),
        ]
    };
}

/// Names by whether dashpots damp contacts, by what holds them together, and by what resists their
/// turning.
const NAMES: [[[&str; 4]; 3]; 2] = [
    [by_turning!("granular"), by_turning!("granular, JKR"), by_turning!("granular, bonds")],
    [
        by_turning!("granular, damped"),
        by_turning!("granular, damped, JKR"),
        by_turning!("granular, damped, bonds"),
    ],
];

/// Where each effect's numbers begin in the history; of one that is off, where they would.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slots {
    pub rolling: usize,
    pub twisting: usize,
    pub contact: usize,
    pub bond: usize,
    pub viscous: usize,
    /// Numbers in all.
    pub length: usize,
}

impl Slots {
    pub fn of(effects: &GranularEffects) -> Slots {
        let rolling = 3;
        let twisting = rolling + 3 * usize::from(effects.rolling.is_some());
        let contact = twisting + usize::from(effects.twisting.is_some());
        let bond = contact + usize::from(matches!(effects.adhesion, Some(Adhesion::Jkr(_))));
        let viscous = bond + 2 * usize::from(effects.bonds.is_some());
        let length = viscous + 3 * usize::from(effects.restitution.is_some());
        Slots { rolling, twisting, contact, bond, viscous, length }
    }
}
