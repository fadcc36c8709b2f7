//! The rows of the contest: what was measured, what must be reached, what is aimed at.

use dempfv_report::format::{count, three_digits};

use super::coupled::{self, TOLERANCE, Way};
use super::linear::{self, CHOLMOD, PARDISO_NAME, Side};
use super::{Contest, Results};
use crate::bench::sample::{Sample, worst};

/// Largest error of a pressure, of the largest, that a step may have.
const PRESSURE: f64 = 1e-6;
/// Largest relative residual of a solve.
const RESIDUAL: f64 = 1e-12;
/// Largest difference of forces from LAMMPS's, of their mean.
const FORCES: f64 = 1e-6;
/// Pores of the network that is to be built in the time stated (s).
const NETWORK: [f64; 2] = [0.22, 0.15];

/// One line of the contest.
pub struct Row {
    /// Its number in the contest.
    pub number: u8,
    /// What is measured.
    pub what: &'static str,
    /// On what.
    pub on: String,
    /// Ratio, or time in s; or why there is none.
    pub value: Result<f64, String>,
    pub bound: Bound,
    /// What stands behind the value.
    pub detail: String,
    /// What else has to hold, and whether it does.
    pub conditions: Vec<(String, bool)>,
    /// Whether what else is aimed at holds.
    pub aim_holds: bool,
}

/// What a value has to keep.
#[derive(Clone, Copy)]
pub struct Bound {
    must: f64,
    aim: Option<f64>,
    sense: Sense,
    /// Behind the number.
    unit: &'static str,
}

#[derive(Clone, Copy, PartialEq)]
enum Sense {
    AtMost,
    AtLeast,
}

impl Bound {
    const fn at_most(must: f64, aim: Option<f64>, unit: &'static str) -> Bound {
        Bound { must, aim, sense: Sense::AtMost, unit }
    }

    const fn at_least(must: f64, aim: Option<f64>, unit: &'static str) -> Bound {
        Bound { must, aim, sense: Sense::AtLeast, unit }
    }

    fn keeps(&self, value: f64, limit: f64) -> bool {
        match self.sense {
            Sense::AtMost => value <= limit,
            Sense::AtLeast => value >= limit,
        }
    }

    /// What must be reached, or is aimed at, in words.
    fn words(&self, limit: f64) -> String {
        let sign = if self.sense == Sense::AtMost { "≤" } else { "≥" };
        format!("{sign} {}{}", three_digits(limit), self.unit)
    }
}

impl Row {
    /// What came out, in a word or a few.
    pub fn outcome(&self) -> String {
        match &self.value {
            Err(why) => format!("not measured: {why}"),
            Ok(_) if !self.conditions.iter().all(|(_, holds)| *holds) => {
                "**short**: a condition fails".to_owned()
            }
            Ok(value)
                if self.aim_holds
                    && self.bound.aim.is_some_and(|aim| self.bound.keeps(*value, aim)) =>
            {
                "aim reached".to_owned()
            }
            Ok(value) if self.bound.keeps(*value, self.bound.must) => "reached".to_owned(),
            Ok(_) => "**short**".to_owned(),
        }
    }

    /// True where all that must be is.
    pub fn is_reached(&self) -> bool {
        let value = self.value.as_ref().is_ok_and(|v| self.bound.keeps(*v, self.bound.must));
        value && self.conditions.iter().all(|(_, holds)| *holds)
    }

    /// The row as cells of a table.
    pub fn cells(&self) -> [String; 8] {
        let value = match &self.value {
            Ok(value) => format!("**{}{}**", three_digits(*value), self.bound.unit),
            Err(_) => "–".to_owned(),
        };
        let conditions = self
            .conditions
            .iter()
            .map(|(text, holds)| if *holds { text.clone() } else { format!("**{text}: no**") });
        let detail: Vec<String> = Some(self.detail.clone())
            .filter(|d| !d.is_empty())
            .into_iter()
            .chain(conditions)
            .collect();
        [
            self.number.to_string(),
            self.what.to_owned(),
            self.on.clone(),
            value,
            self.bound.words(self.bound.must),
            self.bound.aim.map_or("–".to_owned(), |aim| self.bound.words(aim)),
            self.outcome(),
            detail.join("; "),
        ]
    }
}

/// Every row, from what was measured.
pub fn rows(contest: &Contest, results: &Results) -> Vec<Row> {
    let mut rows = Vec::new();
    rows.extend(results.dry.iter().map(dry));
    rows.extend(results.contacts.iter().map(contacts));
    rows.extend(results.coupled.iter().map(coupled));
    rows.extend(results.network.iter().map(|case| network(case, results)));
    rows.extend(results.linear.iter().map(|case| ordering(contest, case)));
    let largest = results.linear.iter().map(|c| c.unknowns).max().unwrap_or(0);
    for case in results.linear.iter().filter(|c| c.unknowns < largest || results.linear.len() == 1)
    {
        rows.extend(factorization(contest, case));
    }
    rows.extend(results.inside.iter().map(|case| inside(contest, case, results)));
    rows.extend(
        results.linear.iter().filter(|c| c.unknowns == largest).map(|c| memory(contest, c)),
    );
    rows.sort_by_key(|row| row.number);
    rows
}

fn milliseconds(seconds: f64) -> String {
    format!("{} ms", three_digits(1e3 * seconds))
}

fn spheres(n: usize) -> String {
    format!("{} spheres", count(n as u64))
}

fn unknowns(n: usize) -> String {
    format!("{} unknowns", count(n as u64))
}

fn dry(case: &super::dry::Case) -> Row {
    let ours = case.ours.step_s.median();
    let lammps = case.lammps.as_ref().map(|side| side.step_s.median());
    let yade = case.yade.step_s.median();
    let mut detail = format!("{} against YADE {}", milliseconds(ours), milliseconds(yade));
    if let Some(lammps) = lammps {
        detail += &format!(", LAMMPS {}", milliseconds(lammps));
    }
    Row {
        number: 1,
        what: "dry step",
        on: spheres(case.spheres),
        value: lammps.map(|t| ours / t).ok_or_else(|| "without LAMMPS".to_owned()),
        bound: Bound::at_most(0.9, Some(0.6), " × LAMMPS"),
        detail,
        conditions: vec![],
        aim_holds: true,
    }
}

/// A dry step on one thread with some effects of contacts, by pairs of runs.
pub fn contacts(case: &super::contacts::Case) -> Row {
    let [low, high] = case.ratio.quartiles().map(three_digits);
    let conditions = case.apart.map(|apart| {
        let largest = worst([apart.normal, apart.force, apart.torque]);
        (format!("forces within {largest:.0e} of LAMMPS's"), largest <= FORCES)
    });
    Row {
        number: 1,
        what: "dry step by effects, one thread",
        on: format!("{}, {}", spheres(case.spheres), case.name),
        value: Ok(case.ratio.median()),
        bound: match case.is_plain() {
            true => Bound::at_most(0.65, None, " × LAMMPS"),
            false => Bound::at_most(1.0, None, " × LAMMPS"),
        },
        detail: format!("quartiles {low} to {high} of {} pairs", case.ratio.0.len()),
        conditions: conditions.into_iter().collect(),
        aim_holds: true,
    }
}

/// A step with its share of a remesh, which stops the steps in both programs. Beside it
/// what our background makes of it, and steps without remeshes.
fn coupled(case: &coupled::Case) -> Row {
    let side = |way: Way| case.ours.iter().find(|side| side.way == way);
    let ratio = side(Way::InTurn).map(|ours| case.yade_s.median() / ours.whole_s.median());
    let detail = side(Way::InTurn).zip(side(Way::Background)).map(|(ours, background)| {
        format!(
            "{} against {}, remeshes in turn; ours with remeshes in the background {}; without \
             remeshes {} against {}: {}×; tolerance = {TOLERANCE}",
            milliseconds(ours.whole_s.median()),
            milliseconds(case.yade_s.median()),
            milliseconds(background.whole_s.median()),
            milliseconds(ours.step_s.median()),
            milliseconds(case.yade_step_s.median()),
            three_digits(case.yade_step_s.median() / ours.step_s.median()),
        )
    });
    let error = worst(case.pressure.pressure_errors.iter().copied());
    let large = case.spheres > 100_000;
    Row {
        number: 2,
        what: "coupled step, remesh every 200",
        on: spheres(case.spheres),
        value: ratio.ok_or_else(|| "no run".to_owned()),
        bound: match large {
            true => Bound::at_least(6.0, Some(12.0), "× faster"),
            false => Bound::at_least(8.0, Some(15.0), "× faster"),
        },
        detail: detail.unwrap_or_default(),
        conditions: vec![(format!("pressures within {error:.0e}"), error <= PRESSURE)],
        aim_holds: true,
    }
}

fn network(case: &super::network::Case, results: &Results) -> Row {
    let yade = results.coupled.iter().find(|c| c.spheres == case.spheres);
    let ours = case.all_s.median();
    let beside = yade.map(|c| format!("; YADE {}", milliseconds(c.yade_network_s.median())));
    let right = (100_000.0..=150_000.0).contains(&case.pores);
    Row {
        number: 3,
        what: "network: positions to G, E, F",
        on: format!("{} pores", count(case.pores as u64)),
        value: match right {
            true => Ok(ours),
            false => Err("the bound is for 120,000 pores".to_owned()),
        },
        bound: Bound::at_most(NETWORK[0], Some(NETWORK[1]), " s"),
        detail: format!("{}{}", milliseconds(ours), beside.unwrap_or_default()),
        conditions: vec![],
        aim_holds: true,
    }
}

/// Ours and CHOLMOD on one system; what to say where ours is none of its own.
fn pair<'a>(contest: &Contest, case: &'a linear::Case) -> Result<[&'a Side; 2], String> {
    let missing = || format!("`{}` is no solver of its own", contest.ours);
    let ours = case.side(contest.ours).ok_or_else(missing)?;
    let cholmod = case.side(CHOLMOD).ok_or_else(missing)?;
    Ok([ours, cholmod])
}

fn ordering(contest: &Contest, case: &linear::Case) -> Row {
    let pair = pair(contest, case);
    let fill = pair.as_ref().map_or(f64::NAN, |[ours, peer]| ours.nnz_l / peer.nnz_l);
    let detail = pair.as_ref().map_or(String::new(), |[ours, peer]| {
        format!(
            "{} against {}: 1/{}",
            milliseconds(ours.analyze_s.median()),
            milliseconds(peer.analyze_s.median()),
            three_digits(peer.analyze_s.median() / ours.analyze_s.median())
        )
    });
    Row {
        number: 4,
        what: "ordering and analysis",
        on: unknowns(case.unknowns),
        value: pair
            .as_ref()
            .map(|[ours, peer]| ours.analyze_s.median() / peer.analyze_s.median())
            .map_err(Clone::clone),
        bound: Bound::at_most(0.2, Some(1.0 / 12.0), " × METIS"),
        detail,
        conditions: match pair {
            Ok(_) => vec![(format!("nnz(L) {} × METIS's", three_digits(fill)), fill <= 1.0)],
            Err(_) => vec![],
        },
        aim_holds: fill <= 0.96,
    }
}

fn factorization(contest: &Contest, case: &linear::Case) -> Vec<Row> {
    let ours = pair(contest, case);
    let versus = |name: &'static str, bound: Bound| {
        let both = ours.clone().and_then(|[ours, _]| {
            let peer = case.side(name).ok_or_else(|| format!("without {name}"))?;
            Ok([ours, peer])
        });
        let detail = both.as_ref().map_or(String::new(), |[ours, peer]| {
            let times = [ours, peer].map(|side| milliseconds(side.factor_s.median()));
            format!("{} against {name} {}", times[0], times[1])
        });
        Row {
            number: 6,
            what: "factorization",
            on: unknowns(case.unknowns),
            value: both
                .as_ref()
                .map_err(Clone::clone)
                .map(|[ours, peer]| peer.factor_s.median() / ours.factor_s.median()),
            bound,
            detail,
            conditions: match both {
                Ok([ours, _]) => {
                    let residual = ours.errors.residual;
                    vec![(format!("residual {residual:.0e}"), residual <= RESIDUAL)]
                }
                Err(_) => vec![],
            },
            aim_holds: true,
        }
    };
    vec![
        versus(CHOLMOD, Bound::at_least(2.0, Some(3.0), "× CHOLMOD's speed")),
        versus(PARDISO_NAME, Bound::at_least(1.0, None, "× PARDISO's speed")),
    ]
}

/// CHOLMOD in the faster way: in our time loop, where it profits from the prediction too, or
/// one plain solve, though that leaves more; by the median or by the mean, whichever is worse
/// for us.
fn inside(contest: &Contest, case: &coupled::Inside, results: &Results) -> Row {
    let side = |name: &str| case.side(name, false);
    let missing = || format!("`{}` is no solver of its own", contest.ours);
    let both = side("cholmod").zip(side(contest.ours).filter(|s| s.solver != "cholmod"));
    let both = both.ok_or_else(missing);
    let size = case.sides.first().map_or(0, |side| side.unknowns as usize);
    let same = results.linear.iter().find(|c| c.spheres == case.spheres);
    let plain = same.and_then(|c| c.side(CHOLMOD)).map(|s| &s.solve_s);
    // Ours, CHOLMOD in our loop, and its plain solve: by the median and by the mean, which
    // differ where some solves take longer than most.
    let times = |by: fn(&Sample) -> f64| {
        let both = both.as_ref().map_err(Clone::clone);
        both.map(|(peer, ours)| [by(&ours.solve_s), by(&peer.solve_s), plain.map_or(f64::NAN, by)])
    };
    let times = times(Sample::median).and_then(|medians| Ok([medians, times(Sample::mean)?]));
    // f64::min passes over what is no number.
    let ratio = |[ours, inside, plain]: [f64; 3]| inside.min(plain) / ours;
    Row {
        number: 7,
        what: "solve in the time loop",
        on: unknowns(size),
        value: times.clone().map(|[medians, means]| ratio(medians).min(ratio(means))),
        bound: Bound::at_least(3.0, Some(6.0), "× CHOLMOD's speed"),
        detail: both.as_ref().map_or(String::new(), |(_, ours)| {
            let rough = case.side(contest.ours, true).map_or(String::new(), |side| {
                let time = milliseconds(side.solve_s.median());
                let error = side.pressure_error;
                format!("; with tolerance = {TOLERANCE} {time}, largest error seen {error:.0e}")
            });
            let [medians, means] =
                times.clone().unwrap_or([[f64::NAN; 3]; 2]).map(|times| times.map(milliseconds));
            let [ours_takes, inside, plain] = medians;
            format!(
                "tolerance = {}: {ours_takes} against {inside} in our loop and {plain} plain (means \
                 {}){rough}",
                ours.tolerance().unwrap_or("1e-11"),
                means.join(", "),
            )
        }),
        conditions: match both {
            Ok((peer, ours)) => vec![(
                format!("residual {:.0e} (CHOLMOD {:.0e})", ours.residual, peer.residual),
                // The same to within rounding, or what a factorization is asked for.
                ours.residual <= (3.0 * peer.residual).max(RESIDUAL),
            )],
            Err(_) => vec![],
        },
        aim_holds: true,
    }
}

fn memory(contest: &Contest, case: &linear::Case) -> Row {
    let pair = pair(contest, case);
    let each = |bytes: f64| bytes / case.unknowns as f64;
    Row {
        number: 8,
        what: "peak memory of ordering, factorization and solve",
        on: unknowns(case.unknowns),
        value: pair.as_ref().map(|[ours, peer]| ours.taken() / peer.taken()).map_err(Clone::clone),
        bound: Bound::at_most(0.7, None, " × CHOLMOD"),
        detail: pair.as_ref().map_or(String::new(), |[ours, peer]| {
            format!(
                "{} B an unknown against {}",
                three_digits(each(ours.taken())),
                three_digits(each(peer.taken()))
            )
        }),
        conditions: vec![],
        aim_holds: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(value: Result<f64, String>, bound: Bound, holds: bool) -> Row {
        let conditions = vec![("residual".to_owned(), holds)];
        Row {
            number: 1,
            what: "",
            on: String::new(),
            value,
            bound,
            detail: String::new(),
            conditions,
            aim_holds: true,
        }
    }

    #[test]
    fn rows_are_judged_by_their_bounds() {
        let faster = Bound::at_least(2.0, Some(3.0), "×");
        assert_eq!(row(Ok(3.5), faster, true).outcome(), "aim reached");
        assert_eq!(row(Ok(2.5), faster, true).outcome(), "reached");
        assert_eq!(row(Ok(1.9), faster, true).outcome(), "**short**");
        let smaller = Bound::at_most(0.9, Some(0.6), "×");
        assert_eq!(row(Ok(0.95), smaller, true).outcome(), "**short**");
        assert_eq!(row(Ok(0.6), smaller, true).outcome(), "aim reached");
    }

    /// Neither a failed condition, nor a missing part, nor a NaN passes.
    #[test]
    fn nothing_passes_unmeasured() {
        let faster = Bound::at_least(2.0, Some(3.0), "×");
        for bad in [
            row(Ok(9.0), faster, false),
            row(Err("no such part".to_owned()), faster, true),
            row(Ok(f64::NAN), faster, true),
            row(Ok(f64::NAN), Bound::at_most(1.0, None, ""), true),
        ] {
            assert!(!bad.is_reached(), "{}", bad.outcome());
            assert!(!bad.outcome().contains("reached"));
        }
    }
}
