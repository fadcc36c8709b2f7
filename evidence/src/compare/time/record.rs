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
    /// Times per step and per remesh of a run of so many steps.
    ///
    /// # Errors
    /// What is missing or has another form than expected.
    pub fn times(&self, steps: u64) -> Result<Times, String> {
        self.check(steps)?;
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
    fn check(&self, steps: u64) -> Result<(), String> {
        let clocked = [self.clock_s.len(), self.engines_ns.len(), self.flow_ns.len()];
        if clocked.iter().any(|&n| n as u64 != steps) {
            let [all, engines, flow] = clocked;
            return Err(format!(
                "made {all} steps of {steps}, and read its engines' clocks {engines} times, those of \
                 the flow engine {flow} times"
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

#[cfg(test)]
mod tests {
    use super::*;

    const FLOW: [&str; 6] =
        ["Position buffer", "Triangulating", VOLUMES, SOLVE, FORCES, "triangulate + init volumes"];

    /// A run of YADE's form: networks at steps 0 and 4, factorized at 0 and 5; 1 ms in each
    /// engine but for the flow engine, 0.5 ms nowhere, and 2 ms for reading the clocks.
    fn record() -> Record {
        let engine_names: Vec<String> =
            ENGINES.iter().chain([&READER]).map(|name| (*name).to_owned()).collect();
        let (mut clock, mut engines, mut flow) = (5.0, [0.0; 7], [0.0; 6]);
        let mut record = Record {
            clock_s: vec![],
            engine_names,
            engines_ns: vec![],
            flow_names: FLOW.map(str::to_owned).to_vec(),
            flow_ns: vec![],
            pores: 7,
            base_memory_bytes: 1,
        };
        for step in 0..8 {
            let mut parts = [0.1, 0.0, 0.2, 3.0, 0.4, 0.001];
            match step {
                0 => (parts[1], parts[3], parts[4]) = (30.0, 53.0, 2.4),
                4 => parts[5] = 40.001,
                5 => (parts[3], parts[4]) = (63.0, 2.4),
                _ => {}
            }
            let in_flow: f64 = parts.iter().sum();
            let spent = [1.0, 1.0, 1.0, in_flow, 1.0, 1.0, 2.0];
            for (clock, ms) in engines.iter_mut().zip(spent) {
                *clock += 1e6 * ms;
            }
            for (clock, ms) in flow.iter_mut().zip(parts) {
                *clock += 1e6 * ms;
            }
            clock += 1e-3 * (spent.iter().sum::<f64>() + 0.5);
            record.clock_s.push(clock);
            record.engines_ns.push(engines.to_vec());
            record.flow_ns.push(flow.to_vec());
        }
        record
    }

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-6
    }

    /// By hand: an ordinary step has 3 ms of contacts, 2 of integration, 0.2 of volumes, 3
    /// of the solve, and 0.1 + 0.4 + 0.001 of the rest of the flow engine. The two remeshes
    /// take (30 + 40) / 2 to triangulate, (50 + 60) / 2 to factorize and 2 more in forces.
    #[test]
    fn phases_are_told_apart() {
        let times = record().times(8).unwrap();
        let Step { contacts, integration, volumes, solve, forces, all } = times.step;
        assert!(near(contacts, 3.0) && near(integration, 2.0), "{times:?}");
        assert!(near(volumes, 0.2) && near(solve, 3.0) && near(forces, 0.501), "{times:?}");
        assert!(near(all, 9.201) && near(times.step.other(), 0.5), "{times:?}");
        assert!(near(times.remesh.factor, 55.0) && near(times.remesh.network(), 37.0));
        assert!(near(times.per_step(200.0), times.step.all + times.remesh.all / 200.0));
    }

    #[test]
    fn a_record_of_another_form_is_refused() {
        let error = |change: fn(&mut Record)| {
            let mut record = record();
            change(&mut record);
            record.times(8).unwrap_err()
        };
        assert!(error(|r| r.clock_s.truncate(5)).contains("made 5 steps of 8"));
        assert!(
            error(|r| r.flow_names[3] = "Solve".into()).contains("no clock `Factorize + Solve`")
        );
        assert!(error(|r| r.engine_names.truncate(2)).contains("no clock `InteractionLoop`"));
        assert!(error(|r| r.flow_ns.iter_mut().for_each(Vec::clear)).contains("no network"));
    }
}
