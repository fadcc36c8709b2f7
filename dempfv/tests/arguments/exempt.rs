//! Public functions without a row, and why.

/// Names, and the reason that they have in common. The name of a trait or a type stands for all
/// that is in it.
pub const EXEMPT: &[(&[&str], &str)] = &[
    (
        &[
            "domain::Axis::of",
            "domain::Aabb::wall",
            "dem::Dem::wall_stress",
            "coupling::Coupled::wall_stress",
            "pfv::Flow::wall_resistance",
            "pfv::Flow::wall_persistence",
            "pfv::Flow::permeability",
        ],
        "takes a name of a wall: there is no wrong one",
    ),
    (
        &[
            "domain::PerWall::from_fn",
            "domain::PerWall::map",
            "domain::Aabb::contains",
            "domain::Aabb::wall_area",
            "dem::law::vector",
            "dem::law::get",
            "dem::law::put",
            "dem::law::Batch::book",
            "dem::law::Losses::add",
        ],
        "arithmetic on what is given, which is not a number where that is none",
    ),
    (
        &[
            "input::InputError",
            "error::Error::io",
            "io::IoError::file",
            "pfv::PfvError::with_numbers",
            "coupling::CouplingError::with_numbers",
        ],
        "makes a message of whatever it is given",
    ),
    (
        &[
            "dem::law::ContactLaw",
            "dem::law::Geometry",
            "dem::law::History",
            "dem::law::Radii",
            "solver::LinearOperator",
            "solver::Preconditioner",
            "coupling::NetworkBuilder",
            "pfv::terms::FluidTerm",
        ],
        "a trait that is called by the library with what it has checked",
    ),
    (
        &[
            "coupling::Coupled::new",
            "coupling::BackendBuilder::new",
            "coupling::Coupled::build_with",
            "simulation::Simulation::build_with",
            "coupling::Coupled::accelerate",
            "time_function::TimeFunction::value",
            "pfv::Flow::hydrostatic_pressure",
            "coupling::Coupled::update_viscous_mode",
            "coupling::Phases",
            "pfv::Flow::has_pattern_of",
            "pfv::Flow::transfer_pressures",
            "pfv::Flow::remove_term",
            "pfv::NetworkRemarks::or_more",
            "pfv::PoreConditions::of_walls",
            "pfv::ViscousMode::carriers",
            "dem::GrowthCompaction::step",
            "scene::Difference::is_in",
            "dem::GrowthCompaction::run",
            "dem::Dem::track_energy",
            "coupling::Controls::track_energy",
        ],
        "takes any value of its argument's type, or one that was checked when it was made or will be \
         where it is used",
    ),
    (
        &[
            "scene::Plan::mechanics",
            "scene::Stage::new",
            "scene::Stage::mechanics",
            "simulation::Specimen",
        ],
        "puts plain data together; `Plan::validate` and `Estimate::of` look at them",
    ),
    (
        &[
            "solver::SystemSize",
            "solver::Cost::solve_to",
            "solver::CostModel::cost",
            "solver::SolverKind::cost",
            "simulation::Advice::of",
        ],
        "a guess of a time from counts, of which any is possible",
    ),
    (
        &[
            "io::atomic",
            "io::atomic::AtomicFile",
            "io::checkpoint",
            "io::vtk::Collection::new",
            "io::vtk::Cells",
        ],
        "takes paths and what is to be written, whatever it is; tests of their own have the failures",
    ),
];
