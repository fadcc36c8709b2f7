//! Conductances that are not what the geometry of a throat says: those of a Darcy medium, larger or
//! smaller ones, blocked pores.

use serde::{Deserialize, Serialize};

use super::conductances::Conductances;
use super::frame::Frame;
use super::network::{ThroatSite, number_throats};
use super::throat::{MIN_LENGTH_PER_WIDTH, area_vector};
use super::{Network, PfvError, PoreSelection};
use crate::{Effect, EffectKey, Family, Vec3};

/// What this effect says of itself.
pub const DARCY: Effect = Effect {
    name: "Darcy conductances",
    family: Family::Fluid,
    equation: "g = k |S| / (mu l), S the whole facet",
    source: "YADE's FlowEngine, permeabilityFactor < 0",
    keys: &[EffectKey { key: "darcy_permeability in [fluid]", unit: "m²", default: "none" }],
    needs: "pore flow",
    test: "dempfv/tests/pfv_conditions.rs",
};

/// What factors of conductances say of themselves.
pub const FACTORS: Effect = Effect {
    name: "conductance factors",
    family: Family::Fluid,
    equation: "g -> m g 2 / (1/m_i + 1/m_j), m of all throats, m_i of pores in regions",
    source: "YADE's FlowEngine, permeabilityFactor; halves of a throat in series",
    keys: &[
        EffectKey { key: "conductance_factor in [fluid]", unit: "", default: "1" },
        EffectKey { key: "conductance_regions in [fluid]", unit: "", default: "none" },
    ],
    needs: "pore flow",
    test: "dempfv/tests/pfv_conditions.rs",
};

/// What blocked pores say of themselves.
pub const BLOCKED: Effect = Effect {
    name: "blocked pores",
    family: Family::Fluid,
    equation: "g = 0 for all throats of pores in a region",
    source: "YADE's FlowEngine, blockCell",
    keys: &[EffectKey { key: "blocked in [fluid]", unit: "", default: "none" }],
    needs: "pore flow",
    test: "dempfv/tests/pfv_conditions.rs",
};

/// How throats conduct where that is not what their geometry says. Default: as it says.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ConductanceRules {
    /// Permeability (m²) of the medium that fills the facets in the place of a pore space, as in a
    /// network that stands for a continuum. Overlaps close nothing then.
    pub darcy_permeability: Option<f64>,
    /// Factor of all conductances (1); `None`: 1.
    pub factor: Option<f64>,
    /// Factors (1) of pores of choice: the half of a throat on their side conducts so much better or
    /// worse. Where several hold for one pore, their product.
    pub regions: Vec<ConductanceRegion>,
    /// Pores that nothing flows through.
    pub blocked: Vec<PoreSelection>,
}

/// Pores whose throats conduct better or worse.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConductanceRegion {
    /// Which pores.
    pub pores: PoreSelection,
    /// By which factor (1), above 0.
    pub factor: f64,
}

impl ConductanceRules {
    fn check(&self) -> Result<(), PfvError> {
        let wrong = |argument, index, x: f64, unit: &str| {
            let problem = format!("{x}{unit}; it must be positive and finite");
            Err(PfvError::InvalidInput { argument, index, problem })
        };
        let fits = |x: f64| x > 0.0 && x.is_finite();
        match (self.darcy_permeability, self.factor) {
            (Some(k), _) if !fits(k) => return wrong("darcy_permeability", None, k, " m²"),
            (_, Some(m)) if !fits(m) => return wrong("conductance factor", None, m, ""),
            _ => {}
        }
        match self.regions.iter().position(|region| !fits(region.factor)) {
            Some(i) => wrong("conductance regions", Some(i), self.regions[i].factor, ""),
            None => Ok(()),
        }
    }
}

/// k/μ · |S| / l of a facet between pores centred at these points of the frame.
pub(super) fn darcy(
    frame: &Frame,
    cells: &[[u32; 4]],
    site: &ThroatSite,
    center: &[Vec3],
    mobility: f64,
) -> f64 {
    // A facet of three walls lies on the hull and separates no pores.
    let area = area_vector(frame, site.facet(cells)).map_or(0.0, |s| s.norm());
    let [a, b] = site.pores.map(|i| center[i as usize]);
    let length = (a - b).norm().max(MIN_LENGTH_PER_WIDTH * area.sqrt());
    if area > 0.0 { mobility * area / length } else { 0.0 }
}

/// The pores of each of a list of selections.
fn select_all<'s>(
    network: &Network,
    position: &[Vec3],
    argument: &'static str,
    selections: impl Iterator<Item = &'s PoreSelection>,
) -> Result<Vec<Vec<u32>>, PfvError> {
    let select = |(k, selection): (usize, &PoreSelection)| {
        let pores = selection.select(network, position)?;
        let beyond = pores.iter().find(|&&i| i as usize >= network.pores());
        match (pores.is_empty(), beyond) {
            (true, _) => Err(PfvError::invalid(argument, k, "selects no pore")),
            (_, Some(i)) => {
                let problem = format!("pore {i} of a network of {}", network.pores());
                Err(PfvError::invalid(argument, k, problem))
            }
            _ => Ok(pores),
        }
    };
    selections.enumerate().map(select).collect()
}

impl Network {
    /// Changes the conductances by rules other than the geometry's. `position` has the sphere
    /// centres that the network was built of, `frame` the same in its coordinates.
    pub(super) fn change_conductances(
        &mut self,
        frame: &Frame,
        position: &[Vec3],
        rules: &ConductanceRules,
    ) -> Result<(), PfvError> {
        if *rules == ConductanceRules::default() {
            return Ok(());
        }
        rules.check()?;
        let mut of_pore = vec![1.0; self.pores()];
        let regions = rules.regions.iter().map(|region| &region.pores);
        let selected = select_all(self, position, "conductance regions", regions)?;
        for (pores, region) in selected.iter().zip(&rules.regions) {
            pores.iter().for_each(|&i| of_pore[i as usize] *= region.factor);
        }
        let mut blocked =
            select_all(self, position, "blocked pores", rules.blocked.iter())?.concat();
        blocked.sort_unstable();
        blocked.dedup();
        blocked.iter().for_each(|&i| of_pore[i as usize] = 0.0);
        let all = rules.factor.unwrap_or(1.0);
        // Halves in series: exactly `all` between pores that no region holds.
        let factor = |&[i, j]: &[u32; 2]| match [of_pore[i as usize], of_pore[j as usize]] {
            [a, b] if a == b => all * a,
            [a, b] => all * 2.0 * a * b / (a + b),
        };
        let factor = self.throats.pores.iter().map(factor).collect();
        let mobility = rules.darcy_permeability.map(|k| k / self.viscosity);
        let conductances = Conductances { mobility, factor, blocked };
        let (sites, _) = number_throats(&self.tessellation);
        let center: Vec<Vec3> = self.center.iter().map(|x| x - self.bounds.min).collect();
        let cells = &self.tessellation.cells;
        for (k, g) in self.throats.conductance.iter_mut().enumerate() {
            *g = conductances.of(k, *g, |m| darcy(frame, cells, &sites[k], &center, m));
        }
        if let Some(k) = self.throats.conductance.iter().position(|g| !g.is_finite()) {
            let pore = self.throats.pores[k][0];
            let vertices = self.tessellation.vertices_of(pore);
            return Err(PfvError::NotFinite { pore, vertices, quantity: "a throat's conductance" });
        }
        if rules.darcy_permeability.is_some() {
            // Of what spheres close or fill there is nothing then.
            self.filled = vec![];
            self.remarks.closed_throats = 0;
            self.remarks.overlapped_throats = 0;
            self.remarks.tube_throats = 0;
        }
        self.conductances = Some(Box::new(conductances));
        Ok(())
    }

    /// Whether nothing flows through a pore because a condition says so. False for a number that no
    /// pore has.
    pub fn is_blocked(&self, pore: usize) -> bool {
        let blocked = self.conductances.as_ref().map_or(&[][..], |c| &c.blocked);
        u32::try_from(pore).is_ok_and(|pore| blocked.binary_search(&pore).is_ok())
    }
}
