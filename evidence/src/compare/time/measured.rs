//! The times of both programs, by the same phases.

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Time of a step between remeshes (ms).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Forces set to zero, collider or neighbour list, contact laws.
    pub contacts: f64,
    /// Servo, damping, leapfrog.
    pub integration: f64,
    /// Rates of the pores' volumes.
    pub volumes: f64,
    /// Right-hand side and solution.
    pub solve: f64,
    /// Forces of the fluid, and what its engine does beside.
    pub forces: f64,
    /// The whole step on the clock.
    pub all: f64,
}

/// Time of one remesh (ms), beyond that of the steps it falls into.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Remesh {
    /// Ordering, analysis and factorization of the system.
    pub factor: f64,
    /// All of it: triangulation, throats and operators beside.
    pub all: f64,
}

/// The times of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Times {
    /// A step between remeshes.
    pub step: Step,
    /// One remesh.
    pub remesh: Remesh,
}

impl Step {
    /// What no phase accounts for.
    pub fn other(&self) -> f64 {
        self.all - (self.contacts + self.integration + self.volumes + self.solve + self.forces)
    }
}

impl Remesh {
    /// Triangulation, throats and operators.
    pub fn network(&self) -> f64 {
        self.all - self.factor
    }
}

impl Times {
    /// Time per step (ms) with a remesh every so many steps.
    pub fn per_step(&self, interval: f64) -> f64 {
        self.step.all + self.remesh.all / interval
    }

    /// Times of a run of ours, from its `summary.json`.
    ///
    /// # Errors
    /// The name of a key that is missing.
    pub fn from_summary(summary: &Value) -> Result<Times, String> {
        let number = |value: &Value, key: &str| {
            value[key].as_f64().ok_or_else(|| format!("its summary has no number `{key}`"))
        };
        let phases = &summary["phases_ms"];
        let steps = number(summary, "steps")?;
        let remeshes = number(summary, "remeshes")?;
        if steps == 0.0 || remeshes == 0.0 {
            return Err("its run had no step or no remesh".to_owned());
        }
        let network = number(phases, "network")?;
        let factor = number(phases, "analyze")? + number(phases, "factor")?;
        let whole = 1e3 * number(summary, "wall_s")?;
        let step = |name: &str| Ok::<f64, String>(number(phases, name)? / steps);
        Ok(Times {
            step: Step {
                contacts: step("contacts")?,
                integration: step("integration")?,
                volumes: step("volume_rates")?,
                solve: step("solve")?,
                forces: step("fluid_forces")?,
                all: (whole - network - factor) / steps,
            },
            remesh: Remesh { factor: factor / remeshes, all: (network + factor) / remeshes },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_summary_is_taken_apart() {
        let summary = json!({
            "steps": 10, "remeshes": 2, "wall_s": 0.2,
            "phases_ms": {
                "contacts": 10.0, "integration": 20.0, "volume_rates": 30.0, "solve": 40.0,
                "fluid_forces": 5.0, "network": 20.0, "analyze": 12.0, "factor": 8.0,
            },
        });
        let times = Times::from_summary(&summary).unwrap();
        let step = Step {
            contacts: 1.0,
            integration: 2.0,
            volumes: 3.0,
            solve: 4.0,
            forces: 0.5,
            all: 16.0,
        };
        assert_eq!(times, Times { step, remesh: Remesh { factor: 10.0, all: 20.0 } });
        assert_eq!((times.step.other(), times.remesh.network()), (5.5, 10.0));
        let error = Times::from_summary(&json!({ "steps": 1, "remeshes": 1 })).unwrap_err();
        assert!(error.contains("`network`"), "{error}");
    }
}
