//! A restart with another scene: what of it is used, what is odd, what is refused.

mod origin;
mod verdict;

use std::fmt;

use serde::{Deserialize, Serialize};

pub(super) use origin::Origin;
pub(super) use verdict::UnderWay;

use crate::InputError;
use crate::scene::{Difference, Plan};
use verdict::{Verdict, verdict};

/// How a simulation was taken up again.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Restart {
    /// Steps that were done before.
    pub step: u64,
    /// What the scene says otherwise than the one that the state was made with.
    pub changed: Vec<Change>,
}

/// A key that another scene changes at a restart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// The key behind its table's name: `fluid.viscosity`, `stage.load.steps`.
    pub key: String,
    /// The key as messages name it: `` `viscosity` in [fluid] ``.
    pub name: String,
    /// Its value before, as TOML; `None` where it was not given.
    pub before: Option<String>,
    /// Its value now.
    pub now: Option<String>,
    /// What becomes of it.
    pub effect: Effect,
    /// What else there is to know; may be empty.
    pub note: String,
}

/// What becomes of a changed key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Effect {
    /// It holds from the first step after the restart, or when its stage comes.
    Used,
    /// It holds, but what is simulated becomes something else in the midst of the run: a warning.
    Odd,
    /// Nothing that is still to come depends on it.
    None,
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&both_values(&self.name, &self.before, &self.now))?;
        f.write_str(match self.effect {
            Effect::Used => ": used",
            Effect::Odd => ": used, which is odd in the midst of a run",
            Effect::None => ": no effect",
        })?;
        if self.note.is_empty() { Ok(()) } else { write!(f, "; {}", self.note) }
    }
}

/// Judges each key that differs from the scene that a state was made with.
///
/// # Errors
/// The keys that a restart cannot change, each with both values, and why.
pub(super) fn judge(
    plan: &Plan,
    differences: &[Difference],
    under_way: &UnderWay,
) -> Result<Vec<Change>, InputError> {
    let mut changes = vec![];
    let mut refused = vec![];
    for difference in differences.iter().filter(|d| !d.is_inherited(differences)) {
        let (effect, note) = match verdict(plan, difference, under_way) {
            Verdict::Used(note) => (Effect::Used, note),
            Verdict::Odd(note) => (Effect::Odd, note),
            Verdict::NoEffect(note) => (Effect::None, note),
            Verdict::Refused(why) => {
                let Difference { before, now, .. } = difference;
                refused.push(format!("{}: {why}", both_values(&difference.name(), before, now)));
                continue;
            }
        };
        let Difference { path, before, now } = difference.clone();
        let (key, name) = (path.join("."), difference.name());
        changes.push(Change { key, name, before, now, effect, note });
    }
    match refused.is_empty() {
        true => Ok(changes),
        false => Err(refused_all(plan, &refused.join("; "))),
    }
}

fn both_values(name: &str, before: &Option<String>, now: &Option<String>) -> String {
    let value = |value: &Option<String>| value.clone().unwrap_or_else(|| "not given".to_owned());
    format!("{name} is {}, was {}", value(now), value(before))
}

/// The error of a restart with what it cannot change.
fn refused_all(plan: &Plan, what: &str) -> InputError {
    let error = InputError::new(
        format!("no restart with this scene: {what}"),
        "give the value of the checkpoint, or begin a run of its own without --restart",
    );
    match &plan.file {
        Some(file) => error.in_file(file),
        None => error,
    }
}
