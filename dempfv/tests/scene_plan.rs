//! Plans made in code: what is wrong with one is told, and one that is right is a scene file.

use std::path::Path;

use dempfv::dem::WallControl;
use dempfv::scene::*;
use dempfv::simulation::Simulation;
use dempfv::{Axis, InputError, Vec3, WallId};

/// A plan with every kind of stage.
fn plan() -> Plan {
    let mut fluid = Fluid::default();
    fluid.fluid.boundary.pressure[WallId::YMax] = Some(0.0);
    let stages = [
        StageKind::Compact(Compact::default()),
        StageKind::Cycle(Cycle::default()),
        StageKind::Permeability(Permeability::default()),
        StageKind::Consolidate(Consolidate::default()),
        StageKind::Run(Run { fluid: true, ..Run::default() }),
    ];
    Plan {
        dem: Some(Dem::default()),
        fluid: Some(fluid),
        stages: stages.into_iter().map(|kind| Stage::new(kind.name(), kind)).collect(),
        ..Plan::default()
    }
}

fn dem(plan: &mut Plan) -> &mut Dem {
    plan.dem.as_mut().unwrap()
}

fn fluid(plan: &mut Plan) -> &mut Fluid {
    plan.fluid.as_mut().unwrap()
}

fn compact(plan: &mut Plan) -> &mut Compact {
    let StageKind::Compact(stage) = &mut plan.stages[0].kind else { panic!("not compact") };
    stage
}

fn cycle(plan: &mut Plan) -> &mut Cycle {
    let StageKind::Cycle(stage) = &mut plan.stages[1].kind else { panic!("no cycle") };
    stage
}

fn consolidate(plan: &mut Plan) -> &mut Consolidate {
    let StageKind::Consolidate(stage) = &mut plan.stages[3].kind else { panic!("not it") };
    stage
}

fn run(plan: &mut Plan) -> &mut Run {
    let StageKind::Run(stage) = &mut plan.stages[4].kind else { panic!("no run") };
    stage
}

fn cloud(plan: &mut Plan) -> &mut Cloud {
    let ParticleSource::Cloud(cloud) = &mut plan.particles.source else { panic!("no cloud") };
    cloud
}

/// One mistake, and what must be said of it.
type Mistake = (fn(&mut Plan), &'static str);

const MISTAKES: &[Mistake] = &[
    (|p| p.seed = u64::MAX, "`seed` is 18446744073709551615"),
    (|p| p.stages.clear(), "the plan has no stage"),
    (|p| p.bounds = None, "`cloud` in [particles] needs a box"),
    (|p| p.bounds.as_mut().unwrap().max.y = 0.0, "`max` in [box] has y = 0"),
    (|p| p.bounds.as_mut().unwrap().max.y = 5e-324, "`max` in [box] has a volume of 5e-324 m³"),
    (|p| p.bounds.as_mut().unwrap().min.x = f64::NAN, "`max` in [box] or `min` is not finite"),
    (|p| p.particles.material.density = 0.0, "`density` in [particles] is 0"),
    (|p| p.particles.material.young = f64::NAN, "`young` in [particles] is NaN"),
    (|p| p.particles.material.stiffness_ratio = -0.5, "`stiffness_ratio` in [particles] is -0.5"),
    (|p| p.particles.material.friction_angle = 30.0, "`friction_angle` in [particles] is 30 rad"),
    (|p| cloud(p).count = 0, "`count` in `cloud` is 0"),
    (|p| cloud(p).sizes = Sizes::Uniform { mean: -1.0, spread: 0.0 }, "`radius` in `cloud` is -1"),
    (|p| cloud(p).sizes = Sizes::Uniform { mean: 0.01, spread: 1.0 }, "`spread` in `cloud` is 1"),
    (|p| cloud(p).sizes = Sizes::Uniform { mean: 0.2, spread: 0.0 }, "do not fit"),
    (|p| cloud(p).sizes = Sizes::Classes(vec![]), "`sizes` in `cloud` has shares that add up to"),
    (
        |p| cloud(p).sizes = Sizes::Classes(vec![SizeClass { radius: 0.0, share: 1.0 }]),
        "`sizes` in `cloud` has a pair 1 that is 0",
    ),
    (|p| p.walls.material.young = f64::INFINITY, "`young` in [walls] is inf"),
    (|p| p.walls.max_velocity = Some(0.0), "`max_velocity` in [walls] is 0"),
    (|p| dem(p).dt = TimeStep::Fixed(-1e-4), "`dt` in [dem] is -0.0001"),
    (|p| dem(p).safety = 1.5, "`safety` in [dem] is 1.5"),
    (|p| dem(p).options.damping = 1.0, "`damping` in [dem] is 1"),
    (|p| dem(p).options.gravity = Some(Vec3::new(0.0, f64::NAN, 0.0)), "`gravity` in [dem] is [0"),
    (|p| p.dem = None, "stage \"compact\" moves spheres, but there is no [dem]"),
    (|p| fluid(p).fluid.viscosity = 0.0, "`viscosity` in [fluid] is 0"),
    (|p| p.accuracy = Some(Accuracy { target: 1.0 }), "`target` in [accuracy] is 1"),
    (
        |p| {
            p.accuracy = Some(Accuracy { target: 0.1 });
            fluid(p).effects.bulk_modulus = Some(1e6);
        },
        "[accuracy] stands beside `bulk_modulus` in [fluid]",
    ),
    (
        |p| {
            p.accuracy = Some(Accuracy { target: 0.1 });
            p.fluid = None;
            p.stages.truncate(2);
        },
        "[accuracy] stands in a scene where no fluid flows",
    ),
    (|p| fluid(p).tolerance = f64::NAN, "`tolerance` in [fluid] is NaN"),
    (|p| fluid(p).remesh.interval = Some(0), "`remesh_interval` in [fluid] is 0"),
    (|p| fluid(p).remesh.interval = None, "`remesh_interval` in [fluid] is none"),
    (|p| fluid(p).remesh.strain = Some(0.0), "`remesh_strain` in [fluid] is 0"),
    (|p| fluid(p).acceleration.auto_interval = true, "a background that is not there"),
    (|p| fluid(p).acceleration.swap = dempfv::coupling::Swap::WhenReady, "`swap` in [fluid]"),
    (
        |p| fluid(p).acceleration.on_failure = dempfv::coupling::OnFailure::Retry,
        "`on_failure` in [fluid]",
    ),
    (
        |p| fluid(p).fluid.boundary.pressure[WallId::YMax] = Some(f64::NAN),
        "`y_max` in `pressure` is NaN",
    ),
    (|p| fluid(p).fluid.boundary.pressure[WallId::XMin] = Some(0.0), "x_min drains across it"),
    (
        |p| fluid(p).fluid.boundary.pressure[WallId::YMin] = Some(1.0),
        "drains at both ends of y, at 0 Pa and at 1 Pa",
    ),
    (
        |p| {
            p.stages.remove(3);
            fluid(p).fluid.boundary.pressure[WallId::YMax] = None;
        },
        "[fluid] has no wall with imposed pressure",
    ),
    (|p| p.fluid = None, "stage \"permeability\" needs a fluid"),
    (|p| p.stages[1].name = "compact".to_owned(), "the name of an earlier stage"),
    (|p| p.stages[1].name = " ".to_owned(), "has an empty name"),
    (|p| p.stages[0].dt = Some(TimeStep::Fixed(f64::NAN)), "`dt` in a compact stage is NaN"),
    (|p| p.stages[4].damping = Some(-0.1), "`damping` in a run stage is -0.1"),
    (|p| p.stages[2].damping = Some(0.1), "`damping` in a permeability stage is given, but"),
    (|p| compact(p).stress = 0.0, "`stress` in a compact stage is 0"),
    (|p| compact(p).max_steps = 0, "`max_steps` in a compact stage is 0"),
    (|p| compact(p).friction_angle = Some(-0.1), "`friction_angle` in a compact stage is -0.1"),
    (|p| cycle(p).to = 1e3, "`to` in a cycle stage is 1000, not above `from` = 10000"),
    (|p| cycle(p).cycles = 0, "`cycles` in a cycle stage is 0"),
    (|p| cycle(p).wall = WallId::XMin, "needs the oedometric modulus along y"),
    (|p| consolidate(p).until_tv = 0.0, "`until_tv` in a consolidate stage is 0"),
    (|p| consolidate(p).profiles = vec![0.5, 0.1], "holds 0.1 after 0.5"),
    (|p| consolidate(p).profiles = vec![f64::NAN], "has an item 1 that is NaN"),
    (|p| run(p).until = Until::Steps(0), "`steps` in a run stage is 0"),
    (|p| run(p).until = Until::Time(f64::INFINITY), "`time` in a run stage is inf"),
    (
        |p| run(p).until = Until::Strain { strain: 0.1, axis: Axis::X, max_steps: 9 },
        "stage \"run\" waits for a strain along x, but the walls there do not move",
    ),
    (
        |p| run(p).until = Until::Strain { strain: f64::NAN, axis: Axis::X, max_steps: 9 },
        "`until` in a run stage has the strain NaN",
    ),
    (
        |p| run(p).walls[WallId::XMin] = WallControl::Velocity(f64::NAN),
        "`x_min` in `walls` has a `velocity` that is NaN",
    ),
    (
        |p| {
            run(p).walls[WallId::XMin] = WallControl::Servo { stress: 1.0, max_velocity: Some(0.0) }
        },
        "`x_min` in `walls` has a `max_velocity` that is 0",
    ),
    (|p| p.output.history_every = 0, "`history_every` in [output] is 0"),
    (
        |p| p.output.probes = vec![Vec3::repeat(2.0)],
        "`probes` in [output] has probe 1 at [2, 2, 2]",
    ),
];

#[test]
fn every_mistake_of_a_plan_in_code_is_an_input_error() {
    assert_eq!(plan().validate(), Ok(()));
    for (spoil, expected) in MISTAKES {
        let mut plan = plan();
        spoil(&mut plan);
        let error: InputError = match plan.validate() {
            Err(error) => error,
            Ok(()) => panic!("nothing is wrong where it should be: {expected}"),
        };
        assert!(error.what.contains(expected), "want {expected}\n got {error}");
        assert!(!error.remedy.is_empty(), "{error}");
        let refused = Simulation::new(plan).err().expect("it must not start");
        assert!(refused.is_input(), "{refused}");
    }
}

fn same_again(plan: &Plan) {
    let text = plan.to_toml();
    let again = Plan::from_toml(&text, None).unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(&again, plan, "{text}");
    assert_eq!(again.to_toml(), text);
}

#[test]
fn shipped_scenes_and_plans_in_code_survive_as_scene_files() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let mut scenes = 0;
    for entry in std::fs::read_dir(&folder).unwrap() {
        let mut plan = Plan::load(entry.unwrap().path()).unwrap();
        plan.validate().unwrap();
        plan.file = None;
        same_again(&plan);
        scenes += 1;
    }
    assert!(scenes >= 4, "{scenes} scenes in {}", folder.display());
    same_again(&plan());
}

/// A scene with a value other than its default for every key, but where two keys exclude each
/// other: those are in `OTHER_WAYS`.
const EVERY_KEY: &str = r#"
title = "a \"quoted\" title, with \\ and µ"
seed = 7
[box]
min = [-0.1, 0.0, 1e-3]
max = [1.0, 2.0, 3.0]
[particles]
cloud = { count = 50, radius = 0.0123, spread = 0.31 }
density = 2650.5
young = 3.3e7
stiffness_ratio = 0.3
friction_angle = 23.7
[walls]
young = 1.1e7
friction_angle = 11.3
max_velocity = 0.7
[dem]
dt = 1.3e-5
safety = 0.55
damping = 0.15
gravity = [0.1, -9.81, 0.0]
rotation = false
[fluid]
viscosity = 1.7e-3
bulk_modulus = 2.2e9
density = 998.5
imposed = [{ center = [0.1, 0.2, 0.3], radius = 0.1, pressure = 3.5 }]
coupling = "two-way"
conductance_factor = 0.83
conductance_regions = [{ center = [0.2, 0.7, 0.9], radius = 0.11, factor = 3.1 }]
blocked = [{ points = [[0.2, 1.7, 2.9], [0.3, 1.6, 2.8]] }]
sources = [{ min = [0.5, 0.5, 0.5], max = [0.7, 0.8, 0.9], rate = -1.5e-6 }]
remesh_interval = 77
remesh_strain = 0.013
remesh = "background"
swap = "when ready"
on_failure = "retry"
update = "every step"
parallel_tasks = true
slip_walls = false
clamp = "relative"
solver = "cholmod-gpu"
gpu_device = 1
gpu_memory = 123456789
tolerance = 1e-7
pressure = { y_min = 12.5 }
no_flow = ["x_min"]
sealed_pores = "drained"
[[stage]]
kind = "compact"
name = "grow"
stress = 1.5e4
friction_angle = 4.1
unbalanced = 0.02
tolerance = 0.03
max_steps = 1234
dt = "auto"
damping = 0.3
[[stage]]
kind = "cycle"
name = "press"
wall = "y_min"
from = 1.5e4
to = 1.7e4
cycles = 3
unbalanced = 0.01
tolerance = 0.02
max_velocity = 0.06
max_steps = 4321
dt = 1e-6
damping = 0.35
[[stage]]
kind = "permeability"
name = "leak"
axis = "y"
[[stage]]
kind = "consolidate"
name = "drain"
wall = "y_min"
stress = 1.8e4
until_tv = 0.9
profiles = [0.1, 0.3]
max_velocity = 0.08
max_steps = 999
dt = 2e-6
damping = 0.0
[[stage]]
kind = "run"
name = "shear"
until = { strain = -0.2, axis = "z", max_steps = 777 }
fluid = false
friction_angle = 17.9
walls = { z_max = { velocity = 0.01 }, x_min = { stress = 3.0, max_velocity = 0.09 }, y_min = "fixed" }
dt = 3e-6
damping = 0.45
[output]
history_every = 13
vtk_every = 17
checkpoint_every = 19
pictures = false
energy = false
energy_turning = true
state = true
contacts = true
probes = [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]
regions = [{ min = [0.1, 0.1, 0.1], max = [0.2, 0.3, 0.4] }]
section = { axis = "x", position = 0.21 }
"#;

/// From the friction of the spheres to the end of `[dem]`.
const MIDDLE: &str = "stiffness_ratio = 0.3\nfriction_angle = 23.7\n[walls]\nyoung = 1.1e7\nfriction_angle = 11.3\n\
                      max_velocity = 0.7\n[dem]\ndt = 1.3e-5\nsafety = 0.55\ndamping = 0.15\n\
                      gravity = [0.1, -9.81, 0.0]\nrotation = false\n";

/// From the fluid to how its networks are swapped.
const FLUID: &str = r#"[fluid]
viscosity = 1.7e-3
bulk_modulus = 2.2e9
density = 998.5
imposed = [{ center = [0.1, 0.2, 0.3], radius = 0.1, pressure = 3.5 }]
coupling = "two-way"
conductance_factor = 0.83
conductance_regions = [{ center = [0.2, 0.7, 0.9], radius = 0.11, factor = 3.1 }]
blocked = [{ points = [[0.2, 1.7, 2.9], [0.3, 1.6, 2.8]] }]
sources = [{ min = [0.5, 0.5, 0.5], max = [0.7, 0.8, 0.9], rate = -1.5e-6 }]
remesh_interval = 77
remesh_strain = 0.013
remesh = "background"
swap = "when ready"
"#;

/// What replaces what in `EVERY_KEY`.
const OTHER_WAYS: &[(&str, &str)] = &[
    ("clamp = \"relative\"\n", "darcy_permeability = 1.3e-9\n"),
    ("[output]\n", "[[stage]]\nkind = \"flow\"\ntime = 0.7\nsteps = 3\n[output]\n"),
    ("radius = 0.0123, spread = 0.31", "porosity = 0.871, spread = 0.2"),
    ("radius = 0.0123, spread = 0.31", "sizes = [[0.01, 1], [0.02, 1.7], [0.013, 0.4]]"),
    ("radius = 0.0123, spread = 0.31", "sizes = [[0.01, 0.1], [0.02, 0.2], [0.013, 0.7]]"),
    ("radius = 0.0123, spread = 0.31", "sizes = [[0.01, 1.0], [0.02, 1.7]], sizes_by = \"mass\""),
    ("radius = 0.0123, spread = 0.31", "curve = [[0.01, 0.0], [0.015, 0.3], [0.03, 1.0]]"),
    ("radius = 0.0123, spread = 0.31", "log_normal = { median = 0.02, deviation = 0.3 }"),
    ("kind = \"compact\"", "kind = \"compact\"\nkeep_radii = true"),
    ("dt = 1.3e-5", "dt = \"auto\""),
    (
        MIDDLE,
        "[dem]\ngravity = [0.1, -9.81, 0.0]\n[contacts]\nlaw = \"hertz-mindlin\"\npoisson_ratio = 0.21\nwall_poisson_ratio = 0.31\n\
         restitution = 0.7\nwall_restitution = 0.6\nrolling_friction = 0.03\n\
         rolling_stiffness_ratio = 0.4\nrolling_damping_ratio = 0.2\ntwisting_friction = 0.02\n\
         twisting_stiffness_ratio = 0.35\ntwisting_damping_ratio = 0.0\nadhesion = \"jkr\"\n\
         work_of_adhesion = 0.07\n",
    ),
    ("[fluid]\n", "[contacts]\nadhesion = \"constant\"\npull_off_force = 1e-3\n[fluid]\n"),
    (
        MIDDLE,
        "[dem]\ngravity = [0.1, -9.81, 0.0]\n[contacts]\nlaw = \"hertz-mindlin\"\nadhesion = \"dmt\"\nwork_of_adhesion = 1\n",
    ),
    (
        MIDDLE,
        "clump = [[0.5, 0.0, 0.1, 0.4], [-0.5, 0.0, 0.0, 0.45]]\n\
         [[material]]\nname = \"gravel\"\nradii = [0.02, 0.03]\ndensity = 2700\nyoung = 4e7\n\
         stiffness_ratio = 0.2\nfriction_angle = 35\n\
         [[material]]\nname = \"clay\"\nnumbers = [3, 7]\n\
         [[pair]]\nbetween = [\"gravel\", \"particles\"]\nyoung = 5e6\nstiffness_ratio = 0.1\n\
         friction_angle = 17\n\
         [dem]\ngravity = [0.1, -9.81, 0.0]\n[[motion]]\nnumbers = [0, 9]\nspin = [0, { mean = 1, amplitude = 2, frequency = 3 }, 0]\n\
         [[motion]]\ncenter = [0.5, 0.5, 0.5]\nradius = 0.3\nvelocity = [0.1, 0, 0]\n\
         about = [0.1, 0.2, 0.3]\nfrom = \"press\"\n",
    ),
    (
        "[fluid]\n",
        "[bonds]\ntension = 1e5\ncohesion = 2e5\ninteraction_range = 1.1\nfrom = \"press\"\n[fluid]\n",
    ),
    (
        "rotation = false\n[fluid]\n",
        "[fluid]\nviscous_shear = true\nnormal_lubrication = true\nshear_lubrication = true\n\
         pump_torque = true\ntwist_torque = true\neps = 0.02\nlubrication_stiffness = 1.2e6\n",
    ),
    (
        FLUID,
        "[accuracy]\ntarget = 0.03\n[fluid]\nviscosity = 1.7e-3\nremesh = \"background\"\ndensity = 998.5\n",
    ),
    ("remesh_interval = 77", "remesh_interval = \"auto\""),
    ("remesh_interval = 77\n", ""),
    ("solver = \"cholmod-gpu\"\ngpu_device = 1\ngpu_memory = 123456789", "solver = \"frontal\""),
    ("until = { strain = -0.2, axis = \"z\", max_steps = 777 }", "steps = 12"),
    ("strain = -0.2, axis = \"z\"", "stress = 3.1e3, axis = \"x\""),
    ("strain = -0.2, axis = \"z\"", "porosity = 0.41"),
    ("strain = -0.2, axis = \"z\"", "unbalanced = 0.02, tolerance = 0.03"),
    ("until = { strain = -0.2, axis = \"z\", max_steps = 777 }", "time = 0.37"),
];

/// A scene with what goes in a periodic cell only.
const IN_CELL: &str = r#"
title = "in a cell"
[cell]
size = [0.3, 0.4, 0.5]
[particles]
cloud = { count = 30, radius = 0.0123, spread = 0.31 }
[dem]
[fluid]
viscosity = 1.3e-3
pressure_gradient = [3.0, -4.0, 5.0]
[[stage]]
kind = "run"
name = "shear"
steps = 12
fluid = false
velocity_gradient = { xx = -0.1, xy = 0.2, xz = 0.3, yx = 0.4, yz = 0.5, zx = 1e-7, zy = -0.7 }
cell_stress = { yy = 1.3e4, zz = 20.0 }
"#;

#[test]
fn a_scene_with_every_key_survives() {
    let plan = Plan::from_toml(EVERY_KEY, None).unwrap();
    plan.validate().unwrap();
    same_again(&plan);
    for (old, new) in OTHER_WAYS {
        assert!(EVERY_KEY.contains(old), "{old}");
        let plan = Plan::from_toml(&EVERY_KEY.replacen(old, new, 1), None).unwrap();
        plan.validate().unwrap();
        same_again(&plan);
    }
    let edges = "edges = [[0.3, 0.01, 0.0], [0.02, 0.4, 0.03], [0.0, 0.0, 0.5]]";
    for shape in ["size = [0.3, 0.4, 0.5]", edges] {
        let plan = Plan::from_toml(&IN_CELL.replace("size = [0.3, 0.4, 0.5]", shape), None);
        let plan = plan.unwrap();
        plan.validate().unwrap();
        same_again(&plan);
    }
    // None was forgotten: each is in a scene or among its other ways, but the packing file, and
    // functions of time and profiles, which a consolidation refuses (`coupling_conditions`).
    let ways: String = OTHER_WAYS.iter().map(|(_, new)| *new).collect();
    let ways = ways + IN_CELL + edges;
    let default_again = Plan { title: plan.title.clone(), ..Plan::default() };
    assert_ne!(plan.output, default_again.output);
    for (table, keys) in known_keys()
        .filter(|(table, _)| !table.contains("walls`") && !table.contains("function of time"))
        .filter(|(table, _)| !table.contains("along a wall"))
    {
        for key in keys.iter().filter(|k| **k != "packing" && !k.contains("_m")) {
            let is_there = [format!("{key} ="), format!("[{key}]"), format!("[[{key}]]")]
                .iter()
                .any(|form| EVERY_KEY.contains(form) || ways.contains(form));
            assert!(is_there, "{key} of {table}");
        }
    }
}

/// A packing's path stays as it is.
#[test]
fn a_packing_survives() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../packings/oedometer-1000.txt");
    let text = format!(
        "[particles]\npacking = {file:?}\n[fluid]\nviscosity = 1\n\
         [[stage]]\nkind = \"permeability\"\naxis = \"x\"\n"
    );
    let plan = Plan::from_toml(&text, None).unwrap();
    assert_eq!(plan.bounds, None);
    same_again(&plan);
}

/// The defaults in code are those of a scene file that says nothing.
#[test]
fn defaults_are_those_of_an_empty_table() {
    let text = "[box]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n\
                [particles]\ncloud = { count = 1000, porosity = 0.9 }\n\
                [walls]\n[dem]\n[fluid]\nviscosity = 1e-3\npressure = { y_max = 0 }\n[output]\n\
                [[stage]]\nkind = \"compact\"\nstress = 1e4\n\
                [[stage]]\nkind = \"cycle\"\nwall = \"y_max\"\nfrom = 1e4\nto = 1.1e4\n\
                [[stage]]\nkind = \"permeability\"\naxis = \"y\"\n\
                [[stage]]\nkind = \"consolidate\"\nwall = \"y_max\"\nstress = 1.1e4\nuntil_tv = 1\n\
                [[stage]]\nkind = \"run\"\nsteps = 1000\n";
    assert_eq!(Plan::from_toml(text, None).unwrap(), plan());
}
