//! What is said of a simulation as a whole.

use dempfv::dem::EnergyBalance;
use dempfv::io::history::Value;
use dempfv::simulation::{Simulation, StageOutcome, history};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;
use serde::Serialize;

use crate::errors::refused;
use crate::shared::Shared;

/// The keys of the program's `summary.json` that a simulation knows.
#[derive(Serialize)]
pub struct Summary {
    title: String,
    finished: bool,
    particles: usize,
    pores: usize,
    unknowns: usize,
    contacts: usize,
    steps: u64,
    model_time_s: f64,
    remeshes: u64,
    largest_residual: f64,
    largest_imbalance: f64,
    energy: Option<EnergyBalance>,
    threads: usize,
    solver: Option<&'static str>,
    effects: Vec<&'static str>,
    warnings: Vec<String>,
    state_hash: String,
    stages: Vec<Stage>,
}

/// A stage that is done.
#[derive(Serialize)]
struct Stage {
    kind: &'static str,
    #[serde(flatten)]
    outcome: StageOutcome,
}

impl Summary {
    pub fn of(simulation: &Simulation) -> Summary {
        let (plan, coupled) = (simulation.plan(), simulation.coupled());
        let flow = coupled.storage_flow();
        let stage =
            |done: &StageOutcome| Stage { kind: done.outcome.kind(), outcome: done.clone() };
        Summary {
            title: plan.title.clone(),
            finished: simulation.stage().is_none(),
            particles: coupled.dem().len(),
            pores: flow.map_or(0, |flow| flow.network().pores()),
            unknowns: flow.map_or(0, |flow| flow.operators().unknowns()),
            contacts: simulation.observe().contacts,
            steps: simulation.step(),
            model_time_s: simulation.time(),
            remeshes: simulation.remeshes(),
            largest_residual: coupled.largest_residual(),
            largest_imbalance: coupled.largest_imbalance(),
            energy: coupled.dem().energy_balance(),
            threads: rayon::current_num_threads(),
            solver: plan.fluid.as_ref().map(|fluid| fluid.solver.name()),
            effects: plan.effects_on(),
            warnings: simulation.warnings(),
            state_hash: simulation.state_hash(),
            stages: simulation.outcomes().iter().map(stage).collect(),
        }
    }
}

/// The same values as Python's dictionaries, lists and numbers.
pub fn to_python<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    static LOADS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let text = serde_json::to_string(value).map_err(|e| refused(py, &e.to_string()))?;
    LOADS.import(py, "json", "loads")?.call1((text,))
}

/// The columns of the history at this moment.
pub fn observe<'py>(py: Python<'py>, shared: &Shared) -> PyResult<Bound<'py, PyDict>> {
    /// A value that outlives the look.
    enum Own {
        Float(f64),
        Count(u64),
        Text(String),
    }
    let row = shared.look(py, |simulation| {
        let mut values = vec![];
        history::row(simulation, &mut values);
        let own = |value| match value {
            Value::Float(x) => Own::Float(x),
            Value::Count(n) => Own::Count(n),
            Value::Text(text) => Own::Text(text.to_owned()),
        };
        let names = history::columns(simulation.plan());
        names.into_iter().zip(values.into_iter().map(own)).collect::<Vec<_>>()
    })?;
    let dict = PyDict::new(py);
    for (name, value) in row {
        match value {
            Own::Float(x) => dict.set_item(name, x)?,
            Own::Count(n) => dict.set_item(name, n)?,
            Own::Text(text) => dict.set_item(name, text)?,
        }
    }
    Ok(dict)
}

/// What it is and where it stands, in a line.
pub fn line(simulation: &Simulation) -> String {
    let [title, what, step, stage] = parts(simulation);
    format!("'{title}': {what}; {step}; {stage}")
}

/// The same as a small table.
pub fn html(simulation: &Simulation) -> String {
    let [title, what, step, stage] = parts(simulation).map(|text| escaped(&text));
    let row = |name: &str, text: &str| format!("<tr><th>{name}</th><td>{text}</td></tr>");
    let rows = [row("holds", &what), row("has done", &step), row("is in", &stage)].concat();
    format!("<table><caption>{title}</caption>{rows}</table>")
}

fn parts(simulation: &Simulation) -> [String; 4] {
    let coupled = simulation.coupled();
    let pores = match coupled.storage_flow() {
        Some(flow) => format!("{} pores", flow.network().pores()),
        None if simulation.plan().fluid.is_some() => "no pore network yet".to_owned(),
        None => "dry".to_owned(),
    };
    let stage = match simulation.stage() {
        Some(stage) => {
            let share = simulation.stage_progress().map(|p| format!(", {:.0} %", 100.0 * p));
            format!("stage '{}'{}", stage.name, share.unwrap_or_default())
        }
        None => "all stages done".to_owned(),
    };
    [
        simulation.plan().title.clone(),
        format!("{} spheres, {pores}", coupled.dem().len()),
        format!("step {}, {:.4e} s", simulation.step(), simulation.time()),
        stage,
    ]
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
