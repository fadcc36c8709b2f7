//! A quantity that both programs have, and how far they are apart.

use serde::{Deserialize, Serialize};

/// How far the two programs are apart in one quantity, and how far they may be.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Verdict {
    /// What the quantity was measured on: packing, settings.
    pub on: String,
    /// The quantity, and what its difference is relative to.
    pub quantity: String,
    /// Largest difference.
    pub largest: f64,
    /// Median difference, where there are several values.
    pub median: Option<f64>,
    /// What the largest difference may be.
    pub bound: f64,
    /// Why it may be larger than that: evidence from the same run, one sentence.
    pub explanation: Option<String>,
}

impl Verdict {
    /// Titles of the columns of [`row`](Verdict::row).
    pub const HEADER: [&str; 6] = ["on", "quantity", "largest", "median", "bound", ""];

    /// Whether the difference keeps its bound. A NaN does not.
    pub fn is_within(&self) -> bool {
        self.largest <= self.bound
    }

    /// Whether the difference is too large and nothing explains it.
    pub fn fails(&self) -> bool {
        !self.is_within() && self.explanation.is_none()
    }

    /// Verdicts as a table in Markdown.
    pub fn table(verdicts: &[Verdict]) -> String {
        let rows = verdicts.iter().map(|v| format!("| {} |\n", v.row().join(" | ")));
        let head = Verdict::HEADER.join(" | ");
        format!("| {head} |\n|:--|:--|--:|--:|--:|:--|\n{}\n", rows.collect::<String>())
    }

    /// The verdict as cells of a table.
    pub fn row(&self) -> Vec<String> {
        let judgement = match (self.is_within(), &self.explanation) {
            (true, _) => "within",
            (false, Some(_)) => "explained",
            (false, None) => "OUTSIDE",
        };
        let number = |x: f64| if x == 0.0 { "0".to_owned() } else { format!("{x:.1e}") };
        vec![
            self.on.clone(),
            self.quantity.clone(),
            number(self.largest),
            self.median.map_or(String::new(), number),
            number(self.bound),
            judgement.to_owned(),
        ]
    }
}
