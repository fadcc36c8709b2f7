//! Keys of `summary.json`.

use super::stages;
use super::{Entry, entry};

/// All keys: those within tables after a point, `[]` for the items of an array, `*` for any name.
pub fn keys() -> impl Iterator<Item = &'static Entry> {
    RUN.iter().chain(&REMESH).chain(&ENERGY).chain(stages::KEYS)
}

static RUN: [Entry; 74] = [
    entry("title", "", "The scene's title."),
    entry("finished", "", "Whether all stages are done."),
    entry("interrupted", "", "Whether a signal ended the run."),
    entry("error", "", "Why it could not go on; null where it could."),
    entry("restart.from", "", "The checkpoint that it went on from; `restart` is null for none."),
    entry("restart.step", "1", "Steps that were done before."),
    entry("restart.changed[].key", "", "A key that the scene has changed, as `fluid.viscosity`."),
    entry("restart.changed[].name", "", "The key as messages name it."),
    entry(
        "restart.changed[].before",
        "",
        "Its value before, as TOML; null where it was not given.",
    ),
    entry("restart.changed[].now", "", "Its value now."),
    entry("restart.changed[].effect", "", "`used`, `odd` or `none`."),
    entry("restart.changed[].note", "", "What else there is to know of it."),
    entry("particles", "1", "Spheres."),
    entry(
        "pores",
        "1",
        "Pores of the last network; of the last permeability stage where nothing is \
         coupled.",
    ),
    entry("unknowns", "1", "Their unknown pressures: pores without an imposed one."),
    entry(
        "hidden[]",
        "",
        "Numbers of spheres that are a vertex of no pore: larger ones cover them.",
    ),
    entry("contacts", "1", "Contacts at the end, walls included."),
    entry("grading.smallest_m", "m", "Smallest diameter at the end; `grading` goes by mass."),
    entry("grading.d10_m", "m", "Diameter that a tenth of the mass is finer than."),
    entry("grading.d30_m", "m", "Three tenths."),
    entry("grading.d50_m", "m", "Half."),
    entry("grading.d60_m", "m", "Six tenths."),
    entry("grading.d90_m", "m", "Nine tenths."),
    entry("grading.largest_m", "m", "Largest diameter."),
    entry("grading.uniformity", "1", "Coefficient of uniformity, d60/d10."),
    entry("grading.curvature", "1", "Coefficient of curvature, d30² / (d10 d60)."),
    entry("grading.classes[].diameter_m", "m", "A size, where there are 12 or less of them."),
    entry("grading.classes[].spheres", "1", "Spheres of it."),
    entry("grading.classes[].mass_share", "1", "Their share of the mass."),
    entry("bonds.intact", "1", "Bonds that hold; `bonds` is null without [bonds]."),
    entry("bonds.broken", "1", "Bonds that have broken."),
    entry("steps", "1", "Steps since the simulation began."),
    entry("steps_this_session", "1", "Steps since the last restart."),
    entry("model_time_s", "s", "Model time since the simulation began."),
    entry("wall_s", "s", "Time that this session took by the clock."),
    entry("ms_per_step", "ms", "The same over its steps; null where there were none."),
    entry("phases_ms.*", "ms", "What of it each phase took."),
    entry("remeshes", "1", "Networks that came into use since the simulation began."),
    entry("calls.triangulations", "1", "Triangulations that this session called for."),
    entry("calls.analyses", "1", "Orderings and symbolic analyses, likewise."),
    entry("calls.factorizations", "1", "Factorizations, likewise."),
    entry("calls.neighbour_lists", "1", "Neighbour lists of the contacts, likewise."),
    entry("largest_residual", "1", "Largest residual of a first solve after a factorization."),
    entry("largest_imbalance", "1", "Largest imbalance of fluid mass of any step, over the flow."),
    entry(
        "accuracy.target",
        "1",
        "Error of the pore pressures that was asked for; `accuracy` is null without [accuracy].",
    ),
    entry(
        "accuracy.estimated_error",
        "1",
        "The estimate: root of the mean square over spheres and time, beside that of the pressures.",
    ),
    entry("accuracy.estimated_network_error", "1", "Of that, by the age of networks."),
    entry("accuracy.estimated_time_step_error", "1", "Of that, by the length of the steps."),
    entry("accuracy.estimated_solver_error", "1", "Of that, by the solver's tolerance."),
    entry("peak_memory_bytes", "byte", "The most memory that the process had."),
    entry("threads", "1", "Threads."),
    entry("solver", "", "The linear solver asked for; null without a fluid."),
    entry("solved_by", "", "The one that has the last factor."),
    entry(
        "gpu.factorizations",
        "1",
        "Factorizations in which a GPU did a part; `gpu` is null unless the solver asks \
         for one.",
    ),
    entry("gpu.fallbacks", "1", "Factorizations that the CPU had to do."),
    entry("gpu.reason", "", "Why, the last time."),
    entry("gpu.*", "", "The GPU's name and its counters."),
    entry("effects[]", "", "What was simulated; see effects.md."),
    entry("advice[].stage", "", "Stage that a piece of advice is of."),
    entry("advice[].effect", "", "The effect that it is about."),
    entry("advice[].number", "", "The dimensionless number."),
    entry("advice[].value", "1", "Its value."),
    entry("advice[].change", "1", "What the effect changes, as a share of `of`."),
    entry("advice[].of", "", "What it changes."),
    entry("advice[].verdict", "", "`leave_out`, `needed` or `beware`."),
    entry("warnings[]", "", "What a user should know, a sentence each."),
    entry("versions.*", "", "Versions of program and libraries."),
    entry("state_hash", "", "Hash of the bits of positions, velocities and pressures at the end."),
    entry("stages[].name", "", "The stage's name."),
    entry("stages[].steps", "1", "Its steps."),
    entry("stages[].model_time_s", "s", "Its model time."),
    entry("stages[].dt", "s", "Its time step, or `auto`; null where nothing moves."),
    entry("stages[].dt.fixed", "s", "Its time step where it is fixed."),
    entry("stages[].damping", "1", "Its local damping; null where nothing moves."),
];

static REMESH: [Entry; 17] = [
    entry(
        "remesh.mode",
        "",
        "`at once`, `ahead` or `background`; `remesh` is null without a fluid, and is of \
         this session.",
    ),
    entry("remesh.swap", "", "`when due` or `when ready`."),
    entry("remesh.analyses", "1", "Orderings and symbolic analyses."),
    entry("remesh.failures", "1", "Networks that could not be built, where the old one stayed."),
    entry("remesh.waits", "1", "How often the time loop waited for the background."),
    entry("remesh.waited_s", "s", "How long in all."),
    entry(
        "remesh.largest_age",
        "1",
        "Largest age of a network that was replaced, in steps since its positions.",
    ),
    entry("remesh.mean_age", "1", "Mean of these ages; null where none was replaced."),
    entry("remesh.interval", "1", "The interval in force at the end, in steps; null for none."),
    entry("remesh.background_ms.*", "ms", "What the background took, by phase."),
    entry("remesh.update", "", "`remesh` or `every step`."),
    entry(
        "remesh.every_step.solves",
        "1",
        "Solves between remeshes; `every_step` is null unless networks follow the spheres.",
    ),
    entry(
        "remesh.every_step.mean_applications",
        "1",
        "Applications of the factor in a solve, on average.",
    ),
    entry("remesh.every_step.most_applications", "1", "At most."),
    entry("remesh.every_step.last_error", "1", "Estimated error of the last pressures, relative."),
    entry("remesh.every_step.largest_error", "1", "Of any step."),
    entry(
        "remesh.every_step.worn_out",
        "1",
        "Networks that were replaced before a remesh was due.",
    ),
];

static ENERGY: [Entry; 24] = [
    entry(
        "energy.translation",
        "J",
        "Kinetic energy of translation; `energy` is null where none is tracked, and \
         counts from the end of the last stage that grew spheres. States and works close: \
         what there was and works are what there is, losses and the residual.",
    ),
    entry("energy.rotation", "J", "Kinetic energy of rotation."),
    entry("energy.elastic", "J", "Elastic energy of contacts."),
    entry("energy.gravity", "J", "Energy of position, 0 at the origin."),
    entry("energy.friction", "J", "Dissipated by slip."),
    entry("energy.contact_damping", "J", "Dissipated by dashpots in contacts."),
    entry("energy.rolling", "J", "Dissipated by rolling and twisting resistance."),
    entry("energy.breakage", "J", "Lost with bonds that broke."),
    entry(
        "energy.touch_change",
        "J",
        "Lost by steps across which bodies begin or cease to touch; negative where made.",
    ),
    entry(
        "energy.turning",
        "J",
        "Lost by steps in which contacts turn, since springs follow the directions after each step and \
         forces act along those before it, too; negative where made. 0 without `energy_turning`.",
    ),
    entry(
        "energy.step_change",
        "J",
        "Lost where a time step is shorter than the one before; negative where made.",
    ),
    entry("energy.local_damping", "J", "Dissipated by local damping."),
    entry("energy.fluid_work", "J", "Work of the fluid on the spheres."),
    entry("energy.wall_work", "J", "Work of the walls on the spheres."),
    entry("energy.cell_work", "J", "Work of the motion of a periodic cell on the spheres."),
    entry("energy.motion_work", "J", "Work of given motions on the other spheres."),
    entry("energy.viscous_shear", "J", "Dissipated by viscous shear between neighbours."),
    entry("energy.normal_lubrication", "J", "Dissipated by normal lubrication."),
    entry("energy.shear_lubrication", "J", "Dissipated by shear lubrication."),
    entry("energy.pump_torque", "J", "Dissipated by pump torques."),
    entry("energy.twist_torque", "J", "Dissipated by twist torques."),
    entry("energy.film_elastic", "J", "What the springs in series with films store."),
    entry("energy.external_work", "J", "Work of forces that a library user adds."),
    entry(
        "energy.residual",
        "J",
        "Without a cause: made by time integration, lost where negative.",
    ),
];
