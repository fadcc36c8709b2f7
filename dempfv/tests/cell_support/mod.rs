//! Spheres in a periodic cell, and the flow between them.
#![allow(dead_code)]

use dempfv::dem::law::Linear;
use dempfv::dem::{
    Dem, DemOptions, GrowthCompaction, GrowthOptions, Material, Particles, SizeDistribution,
    random_cloud_in_cell,
};
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid, SealedPoreRule};
use dempfv::solver::SolverKind;
use dempfv::{Cell, PerWall, Tensor, Vec3};

pub const FLUID: Fluid = Fluid {
    viscosity: 1e-3,
    slip_walls: true,
    clamp: Clamp::None,
    boundary: Boundary { pressure: PerWall([None; 6]), sealed_pores: SealedPoreRule::Closed },
};

/// A cell without a right angle.
pub fn skew() -> Cell {
    let edges =
        [Vec3::new(0.1, 0.01, 0.0), Vec3::new(0.02, 0.095, -0.01), Vec3::new(-0.01, 0.015, 0.105)];
    Cell::new(edges).unwrap()
}

pub const MATERIAL: Material =
    Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.2, density: 2600.0 };

/// 200 spheres in a skew cell that have settled at 1 kPa.
pub fn settled(seed: u64) -> Dem {
    let sizes = SizeDistribution::Uniform { spread: 0.3 };
    let scale = dempfv::dem::CloudScale::MeanRadius(0.0055);
    let cloud = random_cloud_in_cell(&skew(), 200, &sizes, scale, seed).unwrap();
    let (x, r) = cloud.into_iter().unzip();
    let spheres = Particles::new(x, r, MATERIAL.density);
    let options = DemOptions { damping: 0.3, ..DemOptions::default() };
    let mut dem = Dem::in_cell(Linear, spheres, skew(), &[MATERIAL], options).unwrap();
    let mut growth = GrowthCompaction::new(GrowthOptions::new(1e3, MATERIAL.young)).unwrap();
    while !growth.step(&mut dem).unwrap().done {}
    dem
}

/// Their places, radii and cell.
pub fn packed_cell(seed: u64) -> (Vec<Vec3>, Vec<f64>, Cell) {
    let dem = settled(seed);
    let cell = *dem.cell().unwrap().cell();
    (dem.storage().position.clone(), dem.storage().radius.clone(), cell)
}

/// A cubic lattice of `n` cubes a side, each `a` (m) long with `basis` spheres: 1 simple, 2
/// body-centred, 4 face-centred.
pub fn lattice(basis: usize, n: usize, a: f64) -> (Vec<Vec3>, Cell) {
    let half = |x: f64, y: f64, z: f64| 0.5 * Vec3::new(x, y, z);
    let places = match basis {
        1 => vec![Vec3::zeros()],
        2 => vec![Vec3::zeros(), half(1.0, 1.0, 1.0)],
        _ => vec![Vec3::zeros(), half(1.0, 1.0, 0.0), half(1.0, 0.0, 1.0), half(0.0, 1.0, 1.0)],
    };
    let corner = |k: usize| Vec3::new((k % n) as f64, (k / n % n) as f64, (k / n / n) as f64);
    let x = (0..n * n * n).flat_map(|k| places.iter().map(move |p| a * (corner(k) + p))).collect();
    (x, Cell::of_size(Vec3::repeat(n as f64 * a)).unwrap())
}

pub fn cell_flow(x: &[Vec3], r: &[f64], cell: &Cell) -> Flow {
    Flow::in_cell(x, r, cell, &FLUID, SolverKind::default()).unwrap()
}

pub fn permeability(x: &[Vec3], r: &[f64], cell: &Cell) -> Tensor {
    cell_flow(x, r, cell).permeability_tensor().unwrap().unwrap()
}
