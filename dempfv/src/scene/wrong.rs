//! What is wrong with a value, whether it stands in a scene file or in a plan made in code.

use crate::input::InputError;

/// What is wrong with a value, to be read after its name, and what would be right.
pub(super) struct Wrong {
    /// "is 1.5".
    pub problem: String,
    /// "give a number above 0".
    pub remedy: String,
}

impl Wrong {
    pub fn new(problem: impl Into<String>, remedy: impl Into<String>) -> Wrong {
        Wrong { problem: problem.into(), remedy: remedy.into() }
    }

    /// The error about the value with this name, in no file.
    pub fn of(self, name: &str) -> InputError {
        InputError::new(format!("{name} {}", self.problem), self.remedy)
    }
}
