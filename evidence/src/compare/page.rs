//! The report: what was compared with what, one section for each part, and what lies
//! outside its bounds.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use dempfv::io::atomic;
use dempfv_report::{machine, versions};

use super::Part;
use super::peer::Bench;
use super::verdict::Verdict;
use crate::Error;

/// Folder of the figures, beside the page.
const FIGURES: &str = "yade";
/// The script that asks for YADE's libraries: the first that YADE runs.
const VERSIONS: &str = include_str!("scripts/versions.py");

/// The report while it grows.
pub struct Page {
    head: String,
    /// What each part has to say in a line or two.
    headlines: Vec<String>,
    sections: String,
    verdicts: Vec<Verdict>,
}

impl Page {
    /// The head of the report: date, versions, machine.
    ///
    /// # Errors
    /// When YADE does not run a script, or the system refuses the folder of the figures.
    pub fn new(bench: &Bench) -> Result<Page, Error> {
        let figures = bench.folder.join(FIGURES);
        std::fs::create_dir_all(&figures).map_err(|e| dempfv::Error::io(&figures, e))?;
        let libraries = bench.remembered("start", &(), || {
            Ok(bench.yade::<BTreeMap<String, String>>("start", VERSIONS, 1, &())?.result)
        })?;
        let head = head(&bench.peer.version, &libraries);
        Ok(Page { head, headlines: vec![], sections: String::new(), verdicts: vec![] })
    }

    /// Adds the section of a part. A chosen one is measured unless it was measured before;
    /// with `force` in any case. One that is not chosen is shown if it is known.
    ///
    /// # Errors
    /// Those of the part.
    pub fn add<P: Part>(
        &mut self,
        bench: &Bench,
        packings: &[PathBuf],
        chosen: bool,
        force: bool,
    ) -> Result<(), Error> {
        if chosen && force {
            bench.forget(P::NAME)?;
        }
        let part = match chosen {
            true => bench.remembered(P::NAME, &packings, || P::measure(bench, packings))?,
            false => match bench.known::<P>(P::NAME, &packings)? {
                Some(part) => part,
                None => return Ok(()),
            },
        };
        let section = part.section(&bench.folder.join(FIGURES))?;
        self.sections.push('\n');
        self.sections += &with_figures_beside(section.trim_end());
        self.sections.push('\n');
        let verdicts = part.verdicts();
        self.headlines.extend(headline(P::NAME, &verdicts));
        self.headlines.extend(part.headline());
        self.verdicts.extend(verdicts);
        Ok(())
    }

    /// Writes the report; returns what was judged.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn write(self, path: &Path) -> Result<Vec<Verdict>, Error> {
        let mut text = self.head;
        for line in &self.headlines {
            text += &format!("- {line}\n");
        }
        text += &self.sections;
        text += &differences(&self.verdicts);
        atomic::write(path, text.as_bytes())?;
        Ok(self.verdicts)
    }
}

/// Title, origin and versions.
fn head(yade: &str, libraries: &BTreeMap<String, String>) -> String {
    let ours = versions::all();
    let ours = |name: &str| ours.get(name).map_or("unknown", String::as_str);
    let theirs = |name: &str| libraries.get(name).map_or("unknown", String::as_str);
    let mut text = format!(
        "# dempfv beside YADE {yade}\n\nBoth programs on the same input, one beside the other in one \
         run. `dempfv compare yade` wrote this page on {}, and `make compare-yade` writes it anew.\n\n\
         | | dempfv | YADE |\n|:--|:--|:--|\n",
        machine::today()
    );
    let rows = [
        ("version", format!("{} ({})", ours("dempfv"), ours("git")), yade),
        ("compiler", format!("rustc {}", ours("rustc")), theirs("compiler")),
        ("CGAL", ours("cgal").to_owned(), theirs("cgal")),
        (
            "SuiteSparse (CHOLMOD)",
            format!("{} ({})", ours("suitesparse"), ours("cholmod")),
            theirs("suitesparse"),
        ),
        ("METIS", ours("metis").to_owned(), theirs("metis")),
        ("BLAS", versions::blas_with_kernels(), theirs("openblas")),
    ];
    for (name, ours, theirs) in rows {
        text += &format!("| {name} | {ours} | {theirs} |\n");
    }
    text + &format!("\nMachine: {}.\n\n", machine::description())
}

/// How many quantities of a part keep their bounds.
fn headline(part: &str, verdicts: &[Verdict]) -> Option<String> {
    let count = |of: fn(&Verdict) -> bool| verdicts.iter().filter(|v| of(v)).count();
    let (within, outside) = (count(Verdict::is_within), count(Verdict::fails));
    let explained = verdicts.len() - within - outside;
    if verdicts.is_empty() {
        return None;
    }
    let mut text = format!("{part}: {within} of {} quantities within their bounds", verdicts.len());
    if explained > 0 {
        text += &format!(", {explained} outside for a reason given below");
    }
    if outside > 0 {
        text += &format!(", **{outside} outside**");
    }
    Some(text)
}

/// What lies outside its bounds, by its reason.
fn differences(verdicts: &[Verdict]) -> String {
    let outside: Vec<&Verdict> = verdicts.iter().filter(|v| !v.is_within()).collect();
    if outside.is_empty() {
        return match verdicts.is_empty() {
            true => String::new(),
            false => "\n## Where they differ\n\nNowhere beyond the bounds.\n".to_owned(),
        };
    }
    let mut text = "\n## Where they differ, and why\n".to_owned();
    let mut reasons: Vec<Option<&str>> = Vec::new();
    for verdict in &outside {
        let reason = verdict.explanation.as_deref();
        if !reasons.contains(&reason) {
            reasons.push(reason);
        }
    }
    for reason in reasons {
        text += &format!("\n{}\n\n", reason.unwrap_or("**Nothing explains these:**"));
        text += "| on | quantity | largest difference | bound |\n|:--|:--|--:|--:|\n";
        for v in outside.iter().filter(|v| v.explanation.as_deref() == reason) {
            let Verdict { on, quantity, largest, bound, .. } = v;
            text += &format!("| {on} | {quantity} | {largest:.1e} | {bound:.1e} |\n");
        }
    }
    text
}

/// The links of a section to its figures, as they are beside the page.
fn with_figures_beside(section: &str) -> String {
    let mut pieces = section.split("![");
    let first = pieces.next().unwrap_or("").to_owned();
    pieces
        .fold(first, |text, piece| text + "![" + &piece.replacen("](", &format!("]({FIGURES}/"), 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(largest: f64, explanation: Option<&str>) -> Verdict {
        Verdict {
            on: "a packing".into(),
            quantity: "pressure".into(),
            largest,
            median: None,
            bound: 1e-5,
            explanation: explanation.map(str::to_owned),
        }
    }

    #[test]
    fn figures_are_found_beside_the_page_and_other_links_stay() {
        let section = "![a (b)](a.png) and [text](https://x.org) ![c](c.png)";
        let expected = "![a (b)](yade/a.png) and [text](https://x.org) ![c](yade/c.png)";
        assert_eq!(with_figures_beside(section), expected);
    }

    #[test]
    fn what_is_outside_is_listed_once_for_each_reason() {
        let all = [
            verdict(1e-6, None),
            verdict(1e-3, Some("The clamp.")),
            verdict(f64::NAN, None),
            verdict(2e-3, Some("The clamp.")),
        ];
        let text = differences(&all);
        assert_eq!(text.matches("The clamp.").count(), 1);
        assert_eq!(text.matches("a packing").count(), 3);
        assert!(text.contains("Nothing explains these") && text.contains("NaN"));
        let line = headline("dry", &all).unwrap();
        assert_eq!(
            line,
            "dry: 1 of 4 quantities within their bounds, 2 outside for a reason given below, **1 outside**"
        );
        assert!(differences(&all[..1]).contains("Nowhere"));
        assert_eq!(differences(&[]), "");
    }
}
