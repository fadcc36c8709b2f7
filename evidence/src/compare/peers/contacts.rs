//! Effects of contacts that LAMMPS has too: a dry step with each, by turns on one thread, and whether both
//! programs find the same forces.

use dempfv::Aabb;
use dempfv::io::packing::Packing;
use dempfv_report::format::{count, three_digits};
use serde::{Deserialize, Serialize};

use super::Contest;
use super::forces::{self, Apart};
use super::job::{Dry, Job, Material, Stepped};
use super::lammps::{self, Input};
use super::lammps_law::{EFFECTS, Effects, Law, POISSON_RATIO, SETUP, TURNING};
use super::others::Lammps;
use super::sizes::Placed;
use crate::Error;
use crate::bench::sample::Sample;

/// The steps: a hundred to warm up, and those that are timed.
const STEPS: &str = "
compute         contacts all contact/atom
compute         mean all reduce ave c_contacts
thermo_style    custom step atoms ke c_mean
thermo          ${steps}
thermo_modify   lost error norm no
run             ${before}
run             ${steps}
";
const BEFORE: u64 = 100;
/// Steps of which the time is taken, and pairs of runs.
const TIMED: u64 = 500;
const PAIRS: usize = 9;

/// One combination in both programs.
#[derive(Serialize, Deserialize)]
pub struct Case {
    pub name: String,
    styles: String,
    pub spheres: usize,
    /// s, pair by pair.
    ours_s: Sample,
    lammps_s: Sample,
    /// Ours over theirs, of each pair.
    pub ratio: Sample,
    /// Between spheres at the end, ours and theirs.
    contacts: [f64; 2],
    /// How far forces are apart on equal spheres; none where the constants are not the same.
    pub apart: Option<Apart>,
    /// The same of normal forces on the packing, at rest.
    at_rest: f64,
}

impl Case {
    /// Whether it has nothing beside friction and rotation.
    pub fn is_plain(&self) -> bool {
        self.name == EFFECTS[0].name
    }
}

/// Measures every combination. Nothing without LAMMPS.
///
/// # Errors
/// One of the programs fails.
pub fn measure(contest: &Contest, placed: &Placed) -> Result<Vec<Case>, Error> {
    let Some(lammps) = &contest.others.lammps else { return Ok(vec![]) };
    EFFECTS.iter().map(|effects| case(contest, lammps, placed, effects)).collect()
}

fn case(
    contest: &Contest,
    lammps: &Lammps,
    placed: &Placed,
    effects: &Effects,
) -> Result<Case, Error> {
    let packing = Packing::read(&placed.path).map_err(dempfv::Error::from)?;
    let step = format!("contacts-{}-{}", placed.spheres, effects.slug());
    let apart = match effects.same {
        true => Some(forces::on_equal_spheres(contest, lammps, effects)?),
        false => None,
    };
    let mut case = Case {
        name: effects.name.to_owned(),
        styles: effects.styles.to_owned(),
        spheres: placed.spheres,
        ours_s: Sample::default(),
        lammps_s: Sample::default(),
        ratio: Sample::default(),
        contacts: [0.0; 2],
        apart,
        at_rest: forces::at_rest(contest, lammps, effects, (&packing, placed.bounds))?,
    };
    let law = Law::new(&packing.radius, &Material::default(), &effects.contacts);
    for pair in 0..if contest.quick { 1 } else { PAIRS } {
        let job = Dry {
            packing: placed.path.clone(),
            bounds: [placed.bounds.min.into(), placed.bounds.max.into()],
            material: Material::default(),
            contacts: effects.contacts,
            before: BEFORE,
            steps: contest.scaled(TIMED),
            run: pair,
        };
        let ours = || {
            let name = format!("{step}-pair{pair}-ours");
            let measure = || contest.bench.job(&name, &Job::Dry(job.clone()), 1);
            contest.bench.remembered::<Stepped>(&name, &job, measure)
        };
        let theirs = || {
            let name = format!("{step}-pair{pair}-lammps");
            let measure = || time(contest, lammps, (&name, &law), (&packing, &placed.bounds), &job);
            contest.bench.remembered::<Stepped>(&name, &(&job, &lammps.version), measure)
        };
        // Who is first takes turns: what slows a machine down meanwhile meets both alike.
        let (ours, theirs) = match pair % 2 {
            0 => (ours()?, theirs()?),
            _ => {
                let theirs = theirs()?;
                (ours()?, theirs)
            }
        };
        case.ours_s.0.push(ours.step_s);
        case.lammps_s.0.push(theirs.step_s);
        case.ratio.0.push(ours.step_s / theirs.step_s);
        case.contacts = [ours.contacts, theirs.contacts];
    }
    Ok(case)
}

fn time(
    contest: &Contest,
    lammps: &Lammps,
    (name, law): (&str, &Law),
    (packing, bounds): (&Packing, &Aabb),
    job: &Dry,
) -> Result<Stepped, Error> {
    let mut variables = law.variables();
    variables.push(("before", job.before.to_string()));
    variables.push(("steps", job.steps.to_string()));
    let data = lammps::data(packing, bounds, job.material.density);
    let commands = format!("{SETUP}{STEPS}");
    let input = Input { commands: &commands, data, variables: &variables };
    lammps::time(contest, (lammps, 1), name, &input, job.steps)
}

/// The section of the report.
pub fn section(cases: &[Case]) -> String {
    let Some(first) = cases.first() else { return String::new() };
    let mut text = format!(
        "\n## Contacts beside LAMMPS\n\nThe same packing of {} spheres, one thread each, {} runs of \
         either program by turns, who is first alternating; a step after the first {BEFORE}. Friction of \
         30°, rotation, frictionless walls that stand still, Δt = 2·10⁻⁵ s; ν = {POISSON_RATIO}; \
         μ = {}, k/k_n = {}, ζ = {} against rolling and twisting. The ratio is that of each pair of \
         runs: median, and quartiles in brackets.\n\n\
         | effects | LAMMPS | dempfv, ms | LAMMPS, ms | dempfv / LAMMPS | contacts, dempfv and LAMMPS |\n\
         |:--|:--|--:|--:|--:|--:|\n",
        count(first.spheres as u64),
        first.ratio.0.len(),
        TURNING.friction,
        TURNING.stiffness_ratio,
        TURNING.damping_ratio,
    );
    for case in cases {
        let [low, high] = case.ratio.quartiles().map(three_digits);
        text += &format!(
            "| {} | {} | {} | {} | **{}** ({low} to {high}) | {}, {} |\n",
            case.name,
            case.styles,
            three_digits(1e3 * case.ours_s.median()),
            three_digits(1e3 * case.lammps_s.median()),
            three_digits(case.ratio.median()),
            count(case.contacts[0] as u64),
            count(case.contacts[1] as u64),
        );
    }
    text += forces::INTRODUCTION;
    for case in cases {
        let cells = match &case.apart {
            Some(Apart { normal, force, torque }) => {
                format!("{normal:.1e} | {force:.1e} | {torque:.1e}")
            }
            None => "– | – | –".to_owned(),
        };
        text += &format!("| {} | {cells} | {:.1e} |\n", case.name, case.at_rest);
    }
    text
}
