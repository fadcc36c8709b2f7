//! The pore network of a periodic cell.

use super::cell_copies::Image;
use super::cell_tessellation::CellTessellation;
use super::flat_pores::FlatPores;
use super::network::{
    ThroatSite, check_finite, conductances, evaluate_pores, evaluate_throats, filled_pores,
    force_coefficients, number_throats, remarks,
};
use super::packing_check::{check_packing_in_cell, require_finite, require_length};
use super::periodic::{PeriodicNetwork, nearest};
use super::throat::ThroatRules;
use super::{Derivatives, Fluid, Network, PfvError, Throats};
use crate::parallel::for_each;
use crate::{Cell, Tensor, Vec3};

/// The most that a cell changes (1) by which it is still known what has become of a pore.
const MOST: f64 = 0.25;

impl Network {
    /// Triangulates spheres in a periodic cell and evaluates every pore and throat. Any copy of a
    /// sphere may be given. Of each pore there is one; [`Tessellation::neighbors`](super::Tessellation)
    /// names the pore of which some copy lies across a facet. Walls have no part in it.
    ///
    /// # Errors
    /// As [`Network::new`]; [`PfvError::WidePore`] where a pore reaches through half of the cell;
    /// [`PfvError::InvalidInput`] for a fluid with the pressure of a wall.
    pub fn in_cell(
        position: &[Vec3],
        radius: &[f64],
        cell: &Cell,
        fluid: &Fluid,
    ) -> Result<(Network, Derivatives), PfvError> {
        check_packing_in_cell(position, radius, cell, fluid)?;
        let cell = cell.reduced().unwrap_or(*cell);
        let found = CellTessellation::new(position, radius, &cell)?;
        let numbers = found.copies.spheres();
        build(found, cell, fluid).map_err(|error| error.with_numbers(&numbers))
    }

    /// What this network has of a periodic cell; `None` between walls.
    pub fn periodic(&self) -> Option<&PeriodicNetwork> {
        self.periodic.as_deref()
    }

    /// Volumes (m³) of the same pores when the spheres have moved to `position` and the cell to
    /// another shape, by any of its edges. Any copy of a sphere may be given.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for positions that are not one per sphere or not finite, for a cell
    /// that has changed by more than a quarter since the network was built, and between walls.
    pub fn volumes_in_cell(&self, position: &[Vec3], cell: &Cell) -> Result<Vec<f64>, PfvError> {
        let spheres = self.tessellation.spheres;
        require_length("position", position.len(), spheres, "spheres")?;
        require_finite("position", position)?;
        if self.periodic.is_none() {
            let problem = "is given, but the network is one between walls".to_owned();
            return Err(PfvError::InvalidInput { argument: "cell", index: None, problem });
        }
        let mut volume = vec![0.0; self.pores()];
        if !self.write_volumes_in_cell(position, cell, &mut volume) {
            let problem =
                "has changed by more than a quarter since the network was built".to_owned();
            return Err(PfvError::InvalidInput { argument: "cell", index: None, problem });
        }
        Ok(volume)
    }

    /// The same of positions that are known to fit. Says whether it knows them: the copies of a pore's
    /// spheres are those nearest to where the deformation of the cell has brought the first ones.
    #[must_use]
    pub(super) fn write_volumes_in_cell(
        &self,
        position: &[Vec3],
        cell: &Cell,
        volume: &mut [f64],
    ) -> bool {
        let Some(built) = &self.periodic else { return false };
        let Some(deformation) = deformation(&built.cell, cell) else { return false };
        let cells = &self.tessellation.cells;
        for_each(volume, &|i, volume| {
            let (at, arm) = (cells[i].map(|v| position[v as usize]), &built.arm[i]);
            let way = |k: usize| {
                let way = at[k] - at[0];
                let expected = deformation * (arm[0] - arm[k]);
                expected + nearest(&(way - expected), cell)
            };
            *volume = way(1).dot(&way(2).cross(&way(3))) / 6.0;
        });
        true
    }
}

/// What has become of the space of a cell in another one, which may have other edges for the same
/// copies; `None` where that is more than a quarter, and edges could be taken for others.
fn deformation(built: &Cell, cell: &Cell) -> Option<Tensor> {
    let [built, now] = [built, cell].map(|cell| Tensor::from_columns(&cell.edges()));
    let exchanged = (built.try_inverse()? * now).map(f64::round);
    // Of edges that make the same copies the determinant is 1, and so is that of the inverse.
    let deformation = now * (built * exchanged).try_inverse()?;
    let most = (deformation - Tensor::identity()).amax();
    ((exchanged.determinant() - 1.0).abs() < 1e-9 && most <= MOST).then_some(deformation)
}

fn build(
    found: CellTessellation,
    cell: Cell,
    fluid: &Fluid,
) -> Result<(Network, Derivatives), PfvError> {
    let CellTessellation { copies, tessellation, placed, across } = found;
    let frame = copies.frame();
    let mut pores = evaluate_pores(&frame, &placed)?;
    let flat = FlatPores::of(&frame, &placed);
    let mut flat = flat;
    let shift = |pore: u32, facet: usize| copies.shift(across[pore as usize][facet]);
    flat.place_across(&frame, &placed, &mut pores.center, shift);
    let (sites, throat_of) = number_throats(&placed);
    let (centers, leading) = with_copies(
        &pores.center,
        &sites,
        |site| across[site.pores[0] as usize][site.facet as usize],
        |image| copies.shift(image),
    );
    let rules = ThroatRules { balanced: true, ..fluid.throat_rules() };
    let evaluated = evaluate_throats(&frame, &placed, &centers, &leading, rules);
    let conductance = conductances(&evaluated, fluid);
    check_finite(&placed, &sites, &conductance)?;
    let force_coefficient =
        force_coefficients(&tessellation, &sites, &evaluated, &throat_of, &pores.gradient);
    let remarks = remarks(&placed, &pores, &evaluated);
    let filled = match remarks.closed_throats {
        0 => vec![],
        _ => filled_pores(&frame, &placed, &pores.center, &throat_of, &conductance),
    };
    let center_of = |k: u32| centers[k as usize];
    let way = leading.iter().map(|site| center_of(site.pores[1]) - center_of(site.pores[0]));
    let arm = placed.cells.iter().zip(&pores.center);
    let arm = arm.map(|(cell, center)| cell.map(|v| center - frame.x[v as usize])).collect();
    let way = way.collect();
    let mut network = Network {
        remarks,
        filled,
        flat: FlatPores::default(),
        bounds: cell.bounds(),
        viscosity: fluid.viscosity,
        center: pores.center.iter().map(|x| x + copies.origin).collect(),
        volume: pores.volume,
        throats: Throats { pores: sites.iter().map(|site| site.pores).collect(), conductance },
        throat_of,
        tessellation,
        conductances: None,
        periodic: None,
    };
    let mut void = vec![0.0; network.pores()];
    network.write_voids_of(&frame, &placed.cells, &mut void);
    network.periodic = Some(Box::new(PeriodicNetwork { cell, way, arm, void }));
    let derivatives = Derivatives { volume_gradient: pores.gradient, force_coefficient };
    Ok((network, derivatives))
}

/// The centres (m) of the pores, then of the copies that throats lead to; and the throats with these
/// for their second pores.
fn with_copies(
    center: &[Vec3],
    sites: &[ThroatSite],
    image: impl Fn(&ThroatSite) -> Image,
    shift: impl Fn(Image) -> Vec3,
) -> (Vec<Vec3>, Vec<ThroatSite>) {
    let mut centers = center.to_vec();
    let mut leading = sites.to_vec();
    for site in &mut leading {
        let image = image(site);
        if image != [0; 3] {
            centers.push(center[site.pores[1] as usize] + shift(image));
            site.pores[1] = centers.len() as u32 - 1;
        }
    }
    (centers, leading)
}
