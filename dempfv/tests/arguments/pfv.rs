//! Rows of the fluid.

use super::{NO_LENGTHS, Table};
use dempfv::pfv::terms::{Compressibility, FluidTerm, PoreSource, Sources, StepTerms};
use dempfv::pfv::{
    Assembled, Boundary, Clamp, Derivatives, Flow, Fluid, ImposedPressure, Network,
    NetworkConditions, Operators, PfvError, PoreConditions, PoreSelection, PressureProfile,
};
use dempfv::solver::SolverKind;
use dempfv::{Aabb, Axis, Vec3, WallId};

const NAN: Vec3 = Vec3::new(f64::NAN, f64::NAN, f64::NAN);
const UNIT: Aabb = Aabb { min: Vec3::new(0.0, 0.0, 0.0), max: Vec3::new(1.0, 1.0, 1.0) };
const X: [Vec3; 2] = [Vec3::new(0.3, 0.3, 0.4), Vec3::new(0.7, 0.6, 0.6)];
const R: [f64; 2] = [0.2, 0.15];

/// Water between no walls.
pub const UNIT_WATER: Fluid = Fluid {
    viscosity: 1e-3,
    slip_walls: true,
    clamp: Clamp::None,
    boundary: Boundary {
        pressure: dempfv::PerWall([None; 6]),
        sealed_pores: dempfv::pfv::SealedPoreRule::Closed,
    },
};

fn water() -> Fluid {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMin] = Some(1.0);
    boundary.pressure[WallId::YMax] = Some(0.0);
    Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary }
}

fn network() -> (Network, Derivatives) {
    Network::new(&X, &R, UNIT, &water()).unwrap()
}

/// The network of other spheres.
fn other() -> Network {
    Network::new(&X[..1], &R[..1], UNIT, &water()).unwrap().0
}

/// A flow with unknown pressures.
fn flow() -> Flow {
    let mut fluid = water();
    fluid.boundary.pressure[WallId::YMin] = None;
    Flow::new(&X, &R, UNIT, &fluid, SolverKind::default()).unwrap()
}

fn operators() -> Operators {
    let (network, derivatives) = network();
    Operators::new(&network, derivatives, water().boundary).unwrap()
}

fn around(radius: f64) -> PoreSelection {
    PoreSelection::Around { center: Vec3::zeros(), radius }
}

/// A way to build a network of what is given.
type Make = fn(&[Vec3], &[f64], Aabb, &Fluid) -> Result<(), PfvError>;

fn making(t: &mut Table, function: &'static str, make: Make) {
    let fluid = water();
    t.refuses(function, "no spheres", || make(&[], &[], UNIT, &fluid));
    t.refuses(function, "radius", || make(&X, &R[..1], UNIT, &fluid));
    t.refuses(function, "radius", || make(&X, &[0.1; 3], UNIT, &fluid));
    t.refuses(function, "radius", || make(&[], &R, UNIT, &fluid));
    for value in NO_LENGTHS {
        t.refuses(function, "radius[1]", || make(&X, &[0.1, value], UNIT, &fluid));
        let viscosity = Fluid { viscosity: value, ..fluid };
        t.refuses(function, "fluid.viscosity", || make(&X, &R, UNIT, &viscosity));
    }
    for value in [1e5, 1e200, f64::MAX] {
        t.refuses(function, "radius[0]", || make(&X, &[value, 0.1], UNIT, &fluid));
    }
    for x in [NAN, Vec3::repeat(f64::INFINITY), Vec3::repeat(-1e300), Vec3::repeat(5.0)] {
        t.refuses(function, "position[1]", || make(&[X[0], x], &R, UNIT, &fluid));
    }
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut pressure = fluid;
        pressure.boundary.pressure[WallId::ZMax] = Some(value);
        t.refuses(function, "pressure", || make(&X, &R, UNIT, &pressure));
    }
    for bounds in boxes() {
        t.refuses(function, "bounds", || make(&X, &R, bounds, &fluid));
    }
    let far = Aabb { min: Vec3::repeat(-1e13), max: Vec3::repeat(1e13) };
    t.refuses(function, "lost their digits", || make(&X, &R, far, &fluid));
    let flat = Aabb { min: Vec3::zeros(), max: Vec3::new(1e8, 1.0, 1.0) };
    t.refuses(function, "flat", || make(&X, &R, flat, &fluid));
    // Conductances go with 1/μ: beyond double precision.
    for viscosity in [f64::MIN_POSITIVE / 1e10, 1e308] {
        let extreme = Fluid { viscosity, ..fluid };
        t.refuses(function, "fluid.viscosity", || make(&X, &R, UNIT, &extreme));
    }
}

/// Boxes that are none.
fn boxes() -> [Aabb; 6] {
    [
        Aabb { min: UNIT.max, max: UNIT.min },
        Aabb { min: UNIT.min, max: UNIT.min },
        Aabb { min: UNIT.min, max: NAN },
        Aabb { min: UNIT.min, max: Vec3::repeat(f64::INFINITY) },
        Aabb { min: Vec3::repeat(-1e300), max: Vec3::repeat(1e300) },
        Aabb { min: UNIT.min, max: Vec3::repeat(1e-200) },
    ]
}

/// A way to tell the network where its spheres are.
type Moved = fn(&[Vec3], &Aabb) -> Result<(), PfvError>;

fn moving(t: &mut Table, function: &'static str, moved: Moved) {
    t.refuses(function, "position", || moved(&[], &UNIT));
    t.refuses(function, "position", || moved(&X[..1], &UNIT));
    t.refuses(function, "position", || moved(&[X[0]; 9], &UNIT));
    t.refuses(function, "position[1]", || moved(&[X[0], NAN], &UNIT));
    for bounds in boxes() {
        t.refuses(function, "bounds", || moved(&X, &bounds));
    }
}

pub fn table() -> Table {
    let mut t = Table::default();
    let kind = SolverKind::default;
    making(&mut t, "pfv::Network::new", |x, r, b, f| Network::new(x, r, b, f).map(drop));
    making(&mut t, "pfv::Assembled::new", |x, r, b, f| Assembled::new(x, r, b, f).map(drop));
    making(&mut t, "pfv::Assembled::with_imposed", |x, r, b, f| {
        Assembled::with_imposed(x, r, b, f, &[]).map(drop)
    });
    making(&mut t, "pfv::Assembled::with_terms", |x, r, b, f| {
        let terms: Vec<Box<dyn FluidTerm>> = vec![Box::new(Compressibility::new(1e6).unwrap())];
        Assembled::with_terms(x, r, b, f, &[], StepTerms { terms, time_step: 1.0 }).map(drop)
    });
    making(&mut t, "pfv::Assembled::with_conditions", |x, r, b, f| {
        let conditions = NetworkConditions::default();
        Assembled::with_conditions(x, r, b, f, conditions, StepTerms::default()).map(drop)
    });
    making(&mut t, "pfv::NetworkConditions::check", |x, r, b, f| {
        NetworkConditions::default().check(x, r, b, f, &[])
    });
    t.gives("pfv::Network::is_blocked", "false", || !network().0.is_blocked(usize::MAX));
    for (number, pressure) in [(0, 1.0), (usize::MAX, 1.0), (0, f64::NAN)] {
        t.refuses("pfv::Flow::set_imposed_pressure", "is not", || {
            flow().set_imposed_pressure(number, pressure)
        });
        t.refuses("pfv::Flow::set_source_rate", "is not", || {
            flow().set_source_rate(number, pressure)
        });
    }
    let profile = || PressureProfile { along: Axis::X, points: vec![] };
    t.gives("pfv::PressureProfile::value", "no number", || profile().value(f64::NAN).is_nan());
    t.gives("pfv::PressureProfile::problem", "one", || profile().problem(WallId::YMin).is_some());
    for value in NO_LENGTHS {
        let storing =
            || -> Vec<Box<dyn FluidTerm>> { vec![Box::new(Compressibility::new(1e6).unwrap())] };
        t.refuses("pfv::Assembled::with_terms", "time_step", || {
            let terms = StepTerms { terms: storing(), time_step: value };
            Assembled::with_terms(&X, &R, UNIT, &water(), &[], terms)
        });
        t.refuses("pfv::Flow::set_wall_pressure", "imposes none", || {
            flow().set_wall_pressure(WallId::XMin, 1.0)
        });
        t.refuses("pfv::Flow::set_time_step", "time_step", || flow().set_time_step(value));
        t.refuses("pfv::terms::Compressibility::new", "bulk_modulus", || {
            Compressibility::new(value)
        });
    }
    t.refuses("pfv::Flow::set_weight", "not finite", || flow().set_weight(NAN));
    t.refuses("pfv::Flow::set_wall_pressure", "is not finite", || {
        flow().set_wall_pressure(WallId::YMax, f64::NAN)
    });
    t.refuses("pfv::Flow::set_term", "stores fluid", || {
        flow().set_term(Box::new(Compressibility::new(1e6).unwrap()))
    });
    t.refuses("pfv::Network::void_volumes", "position", || network().0.void_volumes(&[], &R));
    t.refuses("pfv::Network::void_volumes", "radius", || network().0.void_volumes(&X, &R[..1]));
    t.refuses("pfv::Network::void_volumes", "radius[1]", || {
        network().0.void_volumes(&X, &[R[0], f64::NAN])
    });
    making(&mut t, "pfv::Flow::new", |x, r, b, f| {
        Flow::new(x, r, b, f, SolverKind::default()).map(drop)
    });
    making(&mut t, "pfv::Flow::with_imposed", |x, r, b, f| {
        Flow::with_imposed(x, r, b, f, &[], SolverKind::default()).map(drop)
    });
    making(&mut t, "pfv::Flow::renew", |x, r, b, f| flow().renew(x, r, b, f).map(drop));
    t.gives("pfv::Assembled::analyze", "a factor of another matrix is dropped", || {
        let (_, reusable) = flow().retire();
        let one = Assembled::new(&X[..1], &R[..1], UNIT, &water()).unwrap();
        one.analyze(kind(), reusable).is_ok()
    });
    moving(&mut t, "pfv::Network::volumes_at", |x, b| network().0.volumes_at(x, b).map(drop));
    moving(&mut t, "pfv::Network::centroids", |x, b| network().0.centroids(x, b).map(drop));
    moving(&mut t, "pfv::Flow::update_geometry", |x, b| flow().update_geometry(x, b).map(drop));
    t.gives("pfv::Network::is_filled", "false", || !network().0.is_filled(usize::MAX));
    t.panics("pfv::Network::conductances_of", || network().0.conductances_of(usize::MAX));
    let locate = "pfv::Tessellation::locate";
    for length in [0, 1, 9] {
        t.refuses(locate, "position", || {
            network().0.tessellation.locate(&vec![X[0]; length], &X[0])
        });
    }
    t.gives(locate, "no pore holds what is no point", || {
        network().0.tessellation.locate(&X, &NAN) == Ok(dempfv::pfv::NONE)
    });
    t.gives("pfv::Tessellation::wall", "no wall", || {
        let tessellation = network().0.tessellation;
        tessellation.wall(0).is_none() && tessellation.wall(u32::MAX).is_none()
    });
    solving(&mut t);
    conditions(&mut t);
    products(&mut t);
    let mut solved = Flow::new(&X, &R, UNIT, &water(), SolverKind::default()).unwrap();
    solved.solve_static().unwrap();
    for margin in [f64::NAN, f64::INFINITY, 0.5, 1e300] {
        t.gives("pfv::Flow::core_permeability", "none without an inside", || {
            solved.core_permeability(WallId::YMin, margin).is_none()
        });
    }
    t
}

fn solving(t: &mut Table) {
    for (word, velocity, walls) in [
        ("velocity", vec![], [0.0; 6]),
        ("velocity", vec![Vec3::zeros(); 3], [0.0; 6]),
        ("velocity[1]", vec![Vec3::zeros(), NAN], [0.0; 6]),
        ("wall_velocity[0]", vec![Vec3::zeros(); 2], [f64::INFINITY; 6]),
    ] {
        t.refuses("pfv::Flow::solve", word, || flow().solve(&velocity, &walls));
    }
    t.refuses("pfv::Flow::update_volume_rate", "velocity", || {
        flow().update_volume_rate(&[Vec3::zeros()], &[0.0; 6])
    });
    t.refuses("pfv::Flow::update_volume_rate", "right-hand side", || {
        let mut flow = flow();
        flow.update_volume_rate(&[NAN; 2], &[0.0; 6])?;
        flow.update_pressure()
    });
    for value in [f64::NAN, f64::INFINITY, -1.0, 0.0, 1.0, 1e300] {
        t.refuses("pfv::Flow::iterate", "tolerance", || flow().iterate(value));
        t.refuses("pfv::Flow::set_tolerance", "tolerance", || flow().set_tolerance(value));
    }
    let restore = "pfv::Flow::restore_pressures";
    t.refuses(restore, "volume_rate[0]", || {
        let mut flow = flow();
        let pressures = flow.extrapolation().clone();
        flow.restore_pressures(&pressures, &[f64::NAN])
    });
    t.gives(restore, "values of another number of pores are ignored", || {
        let mut flow = flow();
        flow.solve_static().unwrap();
        let (before, pressures) = (flow.pressure().to_vec(), flow.extrapolation().clone());
        flow.restore_pressures(&pressures, &[1.0]).unwrap();
        flow.pressure() == before && flow.volume_rate().iter().all(|v| *v == 0.0)
    });
    let mode = "pfv::Flow::viscous_mode";
    for (word, mass, start, negligible) in [
        ("mass", vec![1.0], None, 0.0),
        ("mass", vec![], None, 0.0),
        ("mass[1]", vec![1.0, 0.0], None, 0.0),
        ("mass[0]", vec![f64::NAN, 1.0], None, 0.0),
        ("mass[0]", vec![-1.0, 1.0], None, 0.0),
        ("start", vec![1.0; 2], Some(vec![Vec3::zeros(); 3]), 0.0),
        ("start[0]", vec![1.0; 2], Some(vec![NAN; 2]), 0.0),
        ("negligible", vec![1.0; 2], None, f64::NAN),
        ("negligible", vec![1.0; 2], None, -1.0),
    ] {
        t.refuses(mode, word, || {
            flow().viscous_mode(&mass, [true; 6], start.as_deref(), negligible)
        });
    }
}

fn conditions(t: &mut Table) {
    let wrong = |pores, pressure| ImposedPressure { pores, pressure };
    for (word, imposed) in [
        ("imposed pressure[0]", wrong(around(1.0), f64::NAN)),
        ("selects no pore", wrong(around(-1.0), 1.0)),
        ("selects no pore", wrong(around(f64::NAN), 1.0)),
        ("selects no pore", wrong(PoreSelection::Pores(vec![]), 1.0)),
        ("selected pores[1]", wrong(PoreSelection::Pores(vec![0, u32::MAX]), 1.0)),
    ] {
        t.refuses("pfv::Flow::with_imposed", word, || {
            Flow::with_imposed(
                &X,
                &R,
                UNIT,
                &water(),
                std::slice::from_ref(&imposed),
                SolverKind::default(),
            )
        });
        t.refuses("pfv::PoreConditions::impose", word, || {
            let (network, _) = network();
            let mut conditions = PoreConditions::of_walls(&network, &water().boundary);
            let before = conditions.clone();
            let refused = conditions.impose(&network, &X, &imposed);
            assert_eq!(conditions, before);
            refused
        });
    }
    t.refuses("pfv::PoreConditions::impose", "position", || {
        let (network, _) = network();
        let mut conditions = PoreConditions::of_walls(&network, &water().boundary);
        conditions.impose(&network, &X[..1], &wrong(around(1.0), 1.0))
    });
    t.refuses("pfv::PoreConditions::impose", "network", || {
        let mut conditions = PoreConditions::of_walls(&network().0, &water().boundary);
        conditions.impose(&other(), &X[..1], &wrong(around(1.0), 1.0))
    });
    let none = || PoreConditions::of_walls(&network().0, &water().boundary);
    t.gives("pfv::PoreConditions::set_of", "none", || none().set_of(usize::MAX).is_none());
    t.gives("pfv::PoreConditions::wall_of", "none", || none().wall_of(usize::MAX).is_none());
    t.gives("pfv::PoreConditions::pressure_of", "none", || {
        none().pressure_of(usize::MAX).is_none()
    });
    t.gives("pfv::Operators::imposed", "none", || operators().imposed(usize::MAX).is_none());
    for (word, pores, rate) in [
        ("sources[0]", around(1.0), f64::NAN),
        ("sources[0]", around(f64::NAN), 1.0),
        ("sources[0]", PoreSelection::Pores(vec![u32::MAX]), 1.0),
    ] {
        let source = PoreSource { pores, rate };
        t.refuses("pfv::Flow::set_sources", word, || {
            flow().set_sources(&X, std::slice::from_ref(&source))
        });
    }
    let source = [PoreSource { pores: around(1.0), rate: 1.0 }];
    t.refuses("pfv::Flow::set_sources", "position", || flow().set_sources(&[], &source));
    t.refuses("pfv::terms::Sources::new", "position", || {
        Sources::new(&network().0, &none(), &[NAN; 2], &source)
    });
    t.refuses("pfv::terms::Sources::new", "conditions", || {
        Sources::new(&other(), &none(), &X[..1], &source)
    });
}

fn products(t: &mut Table) {
    let (new, with) = ("pfv::Operators::new", "pfv::Operators::with_conditions");
    t.refuses(new, "derivatives.volume_gradient", || {
        Operators::new(&other(), network().1, water().boundary)
    });
    t.refuses(new, "imposed pressure", || {
        let mut boundary = water().boundary;
        boundary.pressure[WallId::XMin] = Some(f64::NAN);
        let (network, derivatives) = network();
        Operators::new(&network, derivatives, boundary)
    });
    let spoil: [fn(&mut Network); 5] = [
        |n| n.tessellation.neighbors.truncate(1),
        |n| n.tessellation.cells[0][0] = u32::MAX,
        |n| n.tessellation.neighbors[0][0] = u32::MAX - 7,
        |n| n.throats.conductance.truncate(1),
        |n| n.throat_of[0][1] = u32::MAX - 7,
    ];
    for change in spoil {
        t.refuses(new, "network", || {
            let (mut network, derivatives) = network();
            change(&mut network);
            Operators::new(&network, derivatives, water().boundary)
        });
    }
    t.refuses(with, "conditions", || {
        let conditions = PoreConditions::of_walls(&other(), &water().boundary);
        let (network, derivatives) = network();
        Operators::with_conditions(&network, derivatives, conditions)
    });
    let o = operators();
    let (pores, unknowns) = (o.unknown_of.len(), o.unknowns());
    let (p, short) = (vec![0.0; pores], vec![0.0; pores - 1]);
    let still = [Vec3::zeros(); 2];
    let walls = &mut [Vec3::zeros(); 6];
    t.refuses("pfv::Operators::volume_rate", "velocity", || {
        o.volume_rate(&still[..1], &[0.0; 6], &mut p.clone())
    });
    t.refuses("pfv::Operators::volume_rate", "out", || {
        o.volume_rate(&still, &[0.0; 6], &mut short.clone())
    });
    t.refuses("pfv::Operators::pressures", "solution", || {
        o.pressures(&vec![0.0; unknowns + 1], &mut p.clone())
    });
    t.refuses("pfv::Operators::pressures", "out", || {
        o.pressures(&vec![0.0; unknowns], &mut short.clone())
    });
    t.refuses("pfv::Operators::forces", "pressure", || o.forces(&short, &mut still.clone(), walls));
    t.refuses("pfv::Operators::forces", "spheres", || {
        o.forces(&p, &mut [Vec3::zeros(); 3], &mut [Vec3::zeros(); 6])
    });
    t.refuses("pfv::Operators::flux", "pressure", || o.flux(&short, &p));
    t.refuses("pfv::Operators::write_flux", "volume_rate", || {
        o.write_flux(&p, &short, &mut [0.0; 6])
    });
    t.gives("pfv::Operators::write_flux", "as many sets as there is room for", || {
        o.write_flux(&p, &p, &mut [0.0; 99]).is_ok() && o.write_flux(&p, &p, &mut []).is_ok()
    });
    t.refuses("pfv::Operators::imbalance", "volume_rate", || o.imbalance(&p, &short));
    t.refuses("pfv::Operators::residual", "pressure", || {
        o.residual(&short, &p, &mut vec![0.0; unknowns])
    });
    t.refuses("pfv::Operators::residual", "out", || {
        o.residual(&p, &p, &mut vec![0.0; unknowns + 1])
    });
}
