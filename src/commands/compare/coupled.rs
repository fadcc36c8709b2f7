//! The part `coupled` of the comparison.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::peer::Bench;
use super::verdict::Verdict;
use crate::commands::Error;

/// What was measured.
#[derive(Serialize, Deserialize)]
pub struct Part {}

impl super::Part for Part {
    const NAME: &'static str = "coupled";

    fn measure(_: &Bench, _: &[PathBuf]) -> Result<Part, Error> {
        Ok(Part {})
    }

    fn verdicts(&self) -> Vec<Verdict> {
        vec![]
    }

    fn section(&self, _: &Path) -> Result<String, Error> {
        Ok(String::new())
    }
}
