//! Every timing as a table for programs.

use super::measured::{Measured, Row};
use super::timing::{Mode, STEP, Timing};

/// The seven timings of section 5.3 of the paper and the rest of a step, by run (s).
pub fn csv(measured: &Measured) -> String {
    let mut text = "spheres,pores,unknowns,device,mode,threads,steps,remeshes,allocate_s,build_s,\
                    network_s,analyze_s,factor_s,solve_s,volumes_s,forces_s,contacts_s,integration_s,\
                    step_s,wall_s,peak_memory_bytes,state_hash,git\n"
        .to_owned();
    for row in measured.rows.iter().chain(&measured.alone) {
        for mode in Mode::ALL {
            if let Some(timing) = row.timing(mode) {
                text += &line(row, "cpu", mode.name(), mode.is_in_background(), timing);
            }
        }
        for on in &row.gpu {
            text += &line(row, &on.name, Mode::Gpu.name(), false, &on.with_gpu);
            let beside = format!("cpu beside {}", on.name);
            text += &line(row, &beside, Mode::Cholmod.name(), false, &on.one_core);
        }
    }
    text
}

fn line(row: &Row, device: &str, mode: &str, in_background: bool, timing: &Timing) -> String {
    let built = row.built[usize::from(timing.number("threads") > 1.0)];
    let whole = |key| format!("{:.0}", timing.number(key));
    let seconds = |t: f64| if t.is_finite() { format!("{t:.6e}") } else { String::new() };
    let [contacts, integration, volumes, solve, forces] = STEP.map(|p| seconds(timing.per_step(p)));
    let mut cells: Vec<String> = ["particles", "pores", "unknowns"].map(whole).into();
    cells.extend([device.to_owned(), mode.to_owned()]);
    cells.extend(["threads", "steps", "remeshes"].map(whole));
    cells.push(built.map_or(String::new(), |b| seconds(b.operators_s)));
    cells.push(built.map_or(String::new(), |b| seconds(b.network_s)));
    cells.extend(["network", "analyze", "factor"].map(|p| seconds(timing.per_remesh(p))));
    cells.extend([solve, volumes, forces, contacts, integration]);
    // Remeshes in the background have no part in the time of a step.
    let step = if in_background { timing.wall_per_step() } else { timing.step() };
    cells.push(seconds(step));
    cells.push(seconds(timing.number("wall_s")));
    cells.push(whole("peak_memory_bytes"));
    cells.push(timing.text("state_hash").to_owned());
    cells.push(timing.versions().remove("git").unwrap_or_default());
    cells.join(",") + "\n"
}
