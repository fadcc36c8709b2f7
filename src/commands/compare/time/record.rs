//! From YADE's clocks to times of phases.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::measured::{Remesh, Step, Times};

/// What the script reads after every step: all clocks count up.
#[derive(Debug, Serialize, Deserialize)]
pub struct Record {
    /// Time on the clock after each step (s).
    clock_s: Vec<f64>,
    engine_names: Vec<String>,
    /// Time spent in each engine until then (ns).
    engines_ns: Vec<Vec<f64>>,
    flow_names: Vec<String>,
    /// Time spent in each part of the flow engine until then (ns); empty before its first
    /// run.
    flow_ns: Vec<Vec<f64>>,
    /// Pores of the last network.
    pub pores: u64,
    /// Memory that YADE takes before it has any sphere (bytes).
    pub base_memory_bytes: u64,
}

/// Times of one step (ms), by the name of a clock.
type Clocks = BTreeMap<String, f64>;

const ENGINES: [&str; 6] = [
    "ForceResetter",
    "InsertionSortCollider",
    "InteractionLoop",
    "FlowEngine",
    "TriaxialStressController",
    "NewtonIntegrator",
];
/// The engine that reads the clocks.
const READER: &str = "PyRunner";
/// The first network of a run is built at its first step, the others at the end of a step;
/// all are factorized at the step after.
const MESHING: [&str; 2] = ["Triangulating", "triangulate + init volumes"];
const VOLUMES: &str = "Update_Volumes";
const SOLVE: &str = "Factorize + Solve";
const FORCES: &str = "compute_Forces";
/// A triangulation takes longer than this (ms); a step without one, next to nothing.
const MESHED: f64 = 0.05;
/// The whole step.
const WALL: &str = "wall";

impl Record {
    /// Times per step and per remesh.
    ///
    /// # Errors
    /// What is missing or has another form than expected.
    pub fn times(&self) -> Result<Times, String> {
        self.check()?;
        let steps: Vec<Clocks> = (0..self.clock_s.len()).map(|i| self.step(i)).collect();
        let meshed = |s: &Clocks| MESHING.iter().map(|name| s[*name]).sum::<f64>() > MESHED;
        // A mesh at the end of a step is factorized in the step after.
        let touched: Vec<bool> = (0..steps.len())
            .map(|i| i == 0 || meshed(&steps[i]) || meshed(&steps[i - 1]))
            .collect();
        let plain: Vec<&Clocks> =
            steps.iter().zip(&touched).filter(|(_, touched)| !**touched).map(|(s, _)| s).collect();
        if plain.is_empty() {
            return Err("has no step without a remesh".to_owned());
        }
        let mean = |name: &str| plain.iter().map(|s| s[name]).sum::<f64>() / plain.len() as f64;
        let remeshes = steps.iter().filter(|s| meshed(s)).count();
        if remeshes == 0 {
            return Err("has built no network".to_owned());
        }
        let remeshed: Vec<&Clocks> =
            steps.iter().zip(&touched).filter(|(_, touched)| **touched).map(|(s, _)| s).collect();
        // What these steps take beyond an ordinary one.
        let excess = |name: &str| {
            remeshed.iter().map(|s| s[name] - mean(name)).sum::<f64>() / remeshes as f64
        };
        let contacts = ["ForceResetter", "InsertionSortCollider", "InteractionLoop"];
        let (volumes, solve) = (mean(VOLUMES), mean(SOLVE));
        Ok(Times {
            step: Step {
                contacts: contacts.iter().map(|name| mean(name)).sum(),
                integration: mean("TriaxialStressController") + mean("NewtonIntegrator"),
                volumes,
                solve,
                // With what the engine does beside: positions read, forces handed on.
                forces: mean("FlowEngine") - volumes - solve,
                all: mean(WALL),
            },
            remesh: Remesh { factor: excess(SOLVE), all: excess("FlowEngine") },
        })
    }

    /// All clocks are there, for every step.
    fn check(&self) -> Result<(), String> {
        let steps = self.clock_s.len();
        if steps < 3 || self.engines_ns.len() != steps || self.flow_ns.len() != steps {
            return Err(format!(
                "clocked {steps} steps, {} times its engines and {} times its flow engine",
                self.engines_ns.len(),
                self.flow_ns.len()
            ));
        }
        let missing = |names: &[String], wanted: &[&str]| {
            wanted.iter().find(|w| !names.iter().any(|n| n == *w)).map(|w| (*w).to_owned())
        };
        let parts: Vec<&str> = [&MESHING[..], &[VOLUMES, SOLVE, FORCES]].concat();
        let engines = [&ENGINES[..], &[READER]].concat();
        let missing =
            missing(&self.engine_names, &engines).or_else(|| missing(&self.flow_names, &parts));
        match missing {
            Some(name) => Err(format!("has no clock `{name}`")),
            None => Ok(()),
        }
    }

    /// What every clock advanced in a step (ms), the reading of them not counted.
    fn step(&self, i: usize) -> Clocks {
        let advanced = |clocks: &[Vec<f64>], j: usize| {
            let at = |i: usize| clocks[i].get(j).copied().unwrap_or(0.0);
            1e-6 * (at(i) - if i > 0 { at(i - 1) } else { 0.0 })
        };
        let mut clocks = Clocks::new();
        for (j, name) in self.engine_names.iter().enumerate() {
            clocks.insert(name.clone(), advanced(&self.engines_ns, j));
        }
        for (j, name) in self.flow_names.iter().enumerate() {
            clocks.insert(name.clone(), advanced(&self.flow_ns, j));
        }
        // Nobody looked at the clock before the first step, which is not counted anyway.
        let wall = if i > 0 { 1e3 * (self.clock_s[i] - self.clock_s[i - 1]) } else { 0.0 };
        clocks.insert(WALL.to_owned(), wall - clocks[READER]);
        clocks
    }
}
