//! What the conductances of a network's throats are in the place of, or beside, what their geometry
//! says.

/// Rules for conductances, as they hold in one network.
#[derive(Clone, Debug)]
pub(super) struct Conductances {
    /// Permeability of a Darcy medium over the viscosity (m²/(Pa·s)).
    pub mobility: Option<f64>,
    /// Factor of each throat (1).
    pub factor: Vec<f64>,
    /// Pores that are blocked, sorted.
    pub blocked: Vec<u32>,
}

impl Conductances {
    /// The conductance of a throat (m³/(Pa·s)) whose geometry says so much, and a Darcy medium of a
    /// mobility (m²/(Pa·s)) that it is told.
    pub fn of(&self, throat: usize, geometric: f64, darcy: impl FnOnce(f64) -> f64) -> f64 {
        self.factor[throat] * self.mobility.map_or(geometric, darcy)
    }
}
