//! Rows of periodic cells.

use super::dem_support::{cloud, material};
use super::pfv::UNIT_WATER;
use super::{NO_LENGTHS, Table};
use dempfv::coupling::Coupled;
use dempfv::dem::law::Linear;
use dempfv::dem::{
    CellControl, CellControls, CloudScale, Dem, DemError, DemOptions, Material, Particles,
    SizeDistribution, random_cloud_in_cell,
};
use dempfv::io::{packing, vtk};
use dempfv::pfv::terms::{Compressibility, StepTerms};
use dempfv::pfv::{Assembled, Flow, Fluid, Network, PfvError};
use dempfv::solver::SolverKind;
use dempfv::{Axis, Cell, Tensor, Vec3};

const NAN: Vec3 = Vec3::new(f64::NAN, f64::NAN, f64::NAN);

fn unit() -> Cell {
    Cell::of_size(Vec3::repeat(1.0)).unwrap()
}

fn in_cell(p: Particles, cell: Cell, m: Material, o: DemOptions) -> Result<Dem, DemError> {
    Dem::in_cell(Linear, p, cell, &[m], o)
}

fn small() -> Dem {
    in_cell(cloud(20, 1), unit(), material(), DemOptions::default()).unwrap()
}

pub fn table() -> Table {
    let mut t = Table::default();
    shapes(&mut t);
    making(&mut t);
    moving(&mut t);
    flowing(&mut t);
    let path = std::env::temp_dir().join("dempfv-arguments-cell.txt");
    let function = "io::packing::write_in_cell";
    for (word, x, r) in [
        ("position", NAN, 1.0),
        ("radius", Vec3::zeros(), f64::NAN),
        ("radius", Vec3::zeros(), -1.0),
    ] {
        t.refuses(function, word, || packing::write_in_cell(&path, &[x], &[r], &unit(), ""));
    }
    t.refuses(function, "position", || packing::write_in_cell(&path, &[], &[], &unit(), ""));
    t
}

fn shapes(t: &mut Table) {
    for value in NO_LENGTHS.into_iter().chain([1e300, 1e-300]) {
        t.refuses("domain::Cell::of_size", "cell", || Cell::of_size(Vec3::new(1.0, value, value)));
    }
    for value in NO_LENGTHS {
        let edges = [value * Vec3::x(), Vec3::y(), Vec3::z() + Vec3::x()];
        t.refuses("domain::Cell::new", "cell", || Cell::new(edges));
    }
    let infinite = Tensor::repeat(f64::INFINITY);
    for (gradient, dt) in [(infinite, 1.0), (Tensor::zeros(), f64::NAN), (-Tensor::identity(), 1.0)]
    {
        t.refuses("domain::Cell::deformed", "cell", || unit().deformed(&gradient, dt));
    }
    let no_number = |x: Vec3| x.iter().any(|x| x.is_nan());
    t.gives("domain::Cell::fractions", "no number", || no_number(unit().fractions(&NAN)));
    t.gives("domain::Cell::wrap", "no number", || no_number(unit().wrap(&NAN).0));
    t.gives("domain::Cell::wrap", "far away, where it was", || {
        unit().wrap(&Vec3::repeat(1e30)).0.x > 0.9e30
    });
    t.gives("domain::Cell::shift", "any whole numbers", || {
        unit().shift([i32::MAX, i32::MIN, 0]).iter().all(|x| x.is_finite())
    });
}

fn making(t: &mut Table) {
    let function = "dem::Dem::in_cell";
    let (m, o) = (material(), DemOptions::default());
    for value in NO_LENGTHS {
        let p = Particles { radius: vec![value; 20], ..cloud(20, 1) };
        t.refuses(function, "radius", || in_cell(p, unit(), m, o));
        let young = Material { young: value, ..m };
        t.refuses(function, "young", || in_cell(cloud(20, 1), unit(), young, o));
        let skin = DemOptions { skin: value, ..o };
        t.refuses(function, "skin", || in_cell(cloud(20, 1), unit(), m, skin));
    }
    for (word, p) in [
        ("position", Particles { position: vec![NAN; 20], ..cloud(20, 1) }),
        ("same centre", Particles { position: vec![Vec3::zeros(); 20], ..cloud(20, 1) }),
        ("lost their digits", Particles { position: vec![Vec3::repeat(1e9); 20], ..cloud(20, 1) }),
        ("periodic cell", Particles { radius: vec![0.3; 20], ..cloud(20, 1) }),
    ] {
        t.refuses(function, word, || in_cell(p, unit(), m, o));
    }
    let heavy = DemOptions { gravity: Some(NAN), ..o };
    t.refuses(function, "gravity", || in_cell(cloud(20, 1), unit(), m, heavy));

    let function = "dem::random_cloud_in_cell";
    let equal = SizeDistribution::Uniform { spread: 0.0 };
    let made = |count: usize, sizes: &SizeDistribution, scale: CloudScale| {
        random_cloud_in_cell(&unit(), count, sizes, scale, 1)
    };
    t.refuses(function, "count", || made(usize::MAX, &equal, CloudScale::Porosity(0.9)));
    t.refuses(function, "porosity", || made(9, &equal, CloudScale::Porosity(1.5)));
    t.refuses(function, "spread", || {
        made(9, &SizeDistribution::Uniform { spread: 2.0 }, CloudScale::Porosity(0.9))
    });
    t.refuses(function, "periodic cell", || made(9, &equal, CloudScale::MeanRadius(0.3)));
    t.refuses(function, "no room", || made(900, &equal, CloudScale::Porosity(0.4)));
}

fn moving(t: &mut Table) {
    let function = "dem::Dem::set_cell_controls";
    let with = |control: CellControl| {
        let mut controls = CellControls::default();
        controls[1][2] = control;
        controls
    };
    for value in [f64::NAN, f64::INFINITY] {
        let rate = with(CellControl::Rate(value));
        t.refuses(function, "velocity gradient", || small().set_cell_controls(rate));
        let stress = with(CellControl::Stress(value));
        t.refuses(function, "cell stress", || small().set_cell_controls(stress));
        let mut coupled = Coupled::new(small());
        t.refuses("coupling::Controls::set_cell_controls", "cell stress", || {
            coupled.controls().set_cell_controls(stress)
        });
    }
    t.gives("coupling::Coupled::axis_stress", "no contact, no stress", || {
        Coupled::new(small()).axis_stress(Axis::Y) == 0.0
    });
}

/// Spheres on a cubic lattice, 4 along each edge of the unit cell.
fn places() -> Vec<Vec3> {
    let along = |k: usize| 0.25 * k as f64;
    (0..64).map(|k| Vec3::new(along(k % 4), along(k / 4 % 4), along(k / 16))).collect()
}

fn flow() -> Flow {
    Flow::in_cell(&places(), &[0.1; 64], &unit(), &UNIT_WATER, SolverKind::default()).unwrap()
}

/// A way to build a network of what is given.
type Make = fn(&[Vec3], &[f64], &Cell, &Fluid) -> Result<(), PfvError>;

fn flowing(t: &mut Table) {
    let ways: [(&'static str, Make); 3] = [
        ("pfv::Network::in_cell", |x, r, cell, fluid| {
            Network::in_cell(x, r, cell, fluid).map(drop)
        }),
        ("pfv::Assembled::in_cell", |x, r, cell, fluid| {
            Assembled::in_cell(x, r, cell, fluid, StepTerms::default()).map(drop)
        }),
        ("pfv::Flow::in_cell", |x, r, cell, fluid| {
            Flow::in_cell(x, r, cell, fluid, SolverKind::default()).map(drop)
        }),
    ];
    let x = places();
    for (function, make) in ways {
        let (cell, fluid) = (unit(), UNIT_WATER);
        t.refuses(function, "no spheres", || make(&[], &[], &cell, &fluid));
        t.refuses(function, "radius", || make(&x, &[0.1; 63], &cell, &fluid));
        for value in NO_LENGTHS {
            let radius: Vec<f64> = [value].into_iter().chain([0.1; 63]).collect();
            t.refuses(function, "radius[0]", || make(&x, &radius, &cell, &fluid));
            let viscosity = Fluid { viscosity: value, ..fluid };
            t.refuses(function, "fluid.viscosity", || make(&x, &[0.1; 64], &cell, &viscosity));
        }
        for place in [NAN, Vec3::repeat(1e300), Vec3::repeat(1e12)] {
            let x: Vec<Vec3> = [place].into_iter().chain(x[1..].iter().copied()).collect();
            t.refuses(function, "position[0]", || make(&x, &[0.1; 64], &cell, &fluid));
        }
        let mut walls = fluid;
        walls.boundary.pressure.0[3] = Some(1.0);
        t.refuses(function, "no walls", || make(&x, &[0.1; 64], &cell, &walls));
        t.refuses(function, "larger cell", || make(&x[..2], &[0.1; 2], &cell, &fluid));
    }
    for time_step in NO_LENGTHS {
        let compressible =
            || StepTerms { terms: vec![Box::new(Compressibility::new(1e6).unwrap())], time_step };
        t.refuses("pfv::Assembled::in_cell", "time_step", || {
            Assembled::in_cell(&x, &[0.1; 64], &unit(), &UNIT_WATER, compressible())
        });
    }
    for value in [NAN, Vec3::repeat(f64::INFINITY)] {
        t.refuses("pfv::Flow::set_pressure_gradient", "gradient", || {
            flow().set_pressure_gradient(value)
        });
    }
    for mass in [vec![1.0; 63], vec![f64::NAN; 64], vec![0.0; 64]] {
        t.refuses("pfv::Flow::move_with_spheres", "mass", || flow().move_with_spheres(&mass));
    }
    for length in [0, 63, 65] {
        t.refuses("pfv::Flow::update_volume_rate_in_cell", "velocity", || {
            flow().update_volume_rate_in_cell(&vec![Vec3::zeros(); length], 0.0)
        });
        let network = flow().network().clone();
        t.refuses("pfv::Network::volumes_in_cell", "position", || {
            network.volumes_in_cell(&vec![Vec3::zeros(); length], &unit())
        });
        t.refuses("io::vtk::pore_cells_in_cell", "position", || {
            vtk::pore_cells_in_cell(&network, &vec![Vec3::zeros(); length], &unit())
        });
    }
    t.refuses("pfv::Network::volumes_in_cell", "position", || {
        flow().network().volumes_in_cell(&[NAN; 64], &unit())
    });
    let missing = std::env::temp_dir().join("dempfv-no-such-packing.txt");
    t.refuses("scene::load_periodic_packing", "dempfv-no-such", || {
        dempfv::scene::load_periodic_packing(&missing)
    });
}
