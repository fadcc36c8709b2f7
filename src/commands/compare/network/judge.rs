use super::Compared;
use super::Verdict;
pub fn verdicts(_: &[Compared]) -> Vec<Verdict> { vec![] }
