//! What contacts take from the energy of motion, by cause.

use serde::{Deserialize, Serialize};

/// A cause by which contacts dissipate energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// Slip against Coulomb friction.
    Friction,
    /// Viscous forces in contacts.
    ContactDamping,
    /// Rolling and twisting beyond what resists them elastically, and viscous moments.
    Rolling,
    /// Elastic energy of bonds that broke, and of adhesion that let go.
    Breakage,
    /// Time steps across which two bodies begin or cease to touch: lost, or made where negative.
    TouchChange,
    /// Time steps in which contacts turn: lost, or made where negative.
    Turning,
}

/// Energy dissipated (J) by each cause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Losses {
    /// By [`Loss::Friction`].
    pub friction: f64,
    /// By [`Loss::ContactDamping`].
    pub contact_damping: f64,
    /// By [`Loss::Rolling`].
    pub rolling: f64,
    /// By [`Loss::Breakage`].
    pub breakage: f64,
    /// By [`Loss::TouchChange`].
    pub touch_change: f64,
    /// By [`Loss::Turning`].
    pub turning: f64,
}

impl Losses {
    /// Adds an energy (J) to a cause.
    #[inline(always)]
    pub fn add(&mut self, cause: Loss, energy: f64) {
        *match cause {
            Loss::Friction => &mut self.friction,
            Loss::ContactDamping => &mut self.contact_damping,
            Loss::Rolling => &mut self.rolling,
            Loss::Breakage => &mut self.breakage,
            Loss::TouchChange => &mut self.touch_change,
            Loss::Turning => &mut self.turning,
        } += energy;
    }

    /// Adds the losses of others.
    pub(in crate::dem) fn join(&mut self, other: &Losses) {
        self.friction += other.friction;
        self.contact_damping += other.contact_damping;
        self.rolling += other.rolling;
        self.breakage += other.breakage;
        self.touch_change += other.touch_change;
        self.turning += other.turning;
    }

    /// All of them (J).
    pub fn total(&self) -> f64 {
        let Losses { friction, contact_damping, rolling, breakage, touch_change, turning } = self;
        friction + contact_damping + rolling + breakage + touch_change + turning
    }
}
