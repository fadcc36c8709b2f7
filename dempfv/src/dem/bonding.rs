//! Bonds between spheres: made at one moment, and counted.

use super::contacts::Other;
use super::error::DemError;
use super::system::Dem;

impl Dem {
    /// Bonds all spheres that are near enough, by the law that the `Dem` was made with, and returns
    /// how many bonds there are now. Bonds that were broken before are made again; of a law without
    /// bonds none are made. What contacts store that are bonded is given up: tracked energy counts
    /// from what is left.
    ///
    /// # Errors
    /// As [`Dem::compute_contacts`].
    pub fn bond(&mut self) -> Result<u64, DemError> {
        self.compute_contacts()?;
        let tracked = |dem: &Dem| dem.ledger.as_ref().map(|_| dem.energy_now().iter().sum::<f64>());
        let before = tracked(self);
        let length = self.law.history_length();
        let mut made = 0;
        for k in (0..self.list.pairs.len()).filter(|&k| self.list.touch[k]) {
            let [i, j] = self.list.pairs[k].map(|i| i as usize);
            let p = &self.particles;
            let radii = [p.radius[i], p.radius[j]];
            let overlap = radii[0] + radii[1] - (p.position[j] - p.position[i]).norm();
            let history = &mut self.list.history[k * length..][..length];
            made += u64::from(self.law.bond(overlap, radii, history));
        }
        self.bonds = made;
        if let (Some(before), Some(now)) = (before, tracked(self))
            && let Some(ledger) = &mut self.ledger
        {
            ledger.began_with += now - before;
        }
        Ok(made)
    }

    /// Bonds that [`Dem::bond`] has made and that are broken since.
    pub fn broken_bonds(&self) -> u64 {
        // A state that was made by hand may count fewer than it holds.
        self.bonds.saturating_sub(self.intact_bonds())
    }

    /// Bonds that hold.
    pub fn intact_bonds(&self) -> u64 {
        if self.bonds == 0 {
            return 0;
        }
        let spheres = self.places().filter(|place| matches!(place.other, Other::Sphere(_)));
        spheres.filter(|place| self.law.is_bonded(place.history)).count() as u64
    }
}
