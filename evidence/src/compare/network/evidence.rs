//! Which of the two programs is off, and by what: the evidence of the second evaluation.

use dempfv::Vec3;
use dempfv::pfv::{Derivatives, Flow};
use serde::{Deserialize, Serialize};

use super::case::Case;
use super::difference::{ByPlace, Place, corner_push, places};
use super::independent::{Independent, IndependentFlow, Model};
use super::solve::Solution;
use super::stat::Stat;
use super::theirs::{Match, TheirFlow};
use crate::Error;

/// What a pair of evaluations differs by.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub struct Distance {
    /// Conductances, relative.
    pub conductance: ByPlace,
    /// Pressures over the imposed difference.
    pub pressure: Stat,
    /// Forces on spheres over their mean; YADE's with the push of the corner pores that it
    /// leaves out.
    pub force: Stat,
    /// Flux at the bottom, relative.
    pub flux: f64,
}

/// Distances between the programs and the second evaluation, for one flow.
#[derive(Clone, Serialize, Deserialize)]
pub struct Evidence {
    /// Settings.
    pub case: Case,
    /// Whether the second evaluation has solved for the pressures itself; else our solver
    /// did, with its conductances.
    pub solved: bool,
    /// Ours from walls as planes.
    pub ours_planes: Distance,
    /// YADE's from walls as planes.
    pub theirs_planes: Distance,
    /// Huge spheres from planes, both exact.
    pub spheres_planes: Distance,
    /// YADE's from huge spheres.
    pub theirs_spheres: Distance,
    /// Huge spheres in double precision from exact ones.
    pub double_spheres: Distance,
    /// YADE's pressures from those that its own conductances have.
    pub theirs_solver: Distance,
    /// Our forces along the flow on spheres and walls, less what the overlaps of spheres
    /// and edges account for, over area times pressure difference.
    pub our_balance: Option<f64>,
    /// Shares of throats at walls by relative difference, for the figure.
    pub curves: Option<Curves>,
}

/// Relative differences of conductances at walls, ascending, at even shares of the throats.
#[derive(Clone, Serialize, Deserialize)]
pub struct Curves {
    /// Ours from planes.
    pub ours_planes: Vec<f64>,
    /// YADE's from planes.
    pub theirs_planes: Vec<f64>,
    /// Exact huge spheres from planes.
    pub spheres_planes: Vec<f64>,
    /// YADE's from exact huge spheres.
    pub theirs_spheres: Vec<f64>,
    /// Huge spheres in double precision from exact ones.
    pub double_spheres: Vec<f64>,
}

/// One evaluation of a flow.
struct Held {
    conductance: Vec<Option<f64>>,
    pressure: Vec<Option<f64>>,
    /// On each sphere.
    force: Vec<Vec3>,
    flux: f64,
}

impl Held {
    fn solved(conductance: Vec<Option<f64>>, solution: Solution) -> Held {
        let pressure = solution.pressure.into_iter().map(Some).collect();
        Held { conductance, pressure, force: solution.force, flux: solution.flux[2] }
    }
}

impl Evidence {
    /// Compares one flow of both programs with the second evaluation. `None` where that
    /// has no conductances to compare: in larger packings, with a clamp.
    ///
    /// # Errors
    /// Those of the solver.
    pub fn new(
        case: Case,
        ours: (&Flow, &Derivatives),
        theirs: &TheirFlow,
        matched: &Match,
        independent: &Independent,
    ) -> Result<Option<Evidence>, Error> {
        let (flow, derivatives) = ours;
        let solved = !independent.flows.is_empty();
        if case.clamp && !solved {
            return Ok(None);
        }
        let find = |model| {
            let mut flows = independent.flows.iter();
            flows.find(|f| f.model == model && f.slip == case.slip && f.clamp == case.clamp)
        };
        let held = |model| match find(model) {
            Some(found) => Ok(found.held()),
            None => mixed(ours, independent, model, case.slip),
        };
        let planes = held(Model::Planes)?;
        let (spheres, double) = (held(Model::Spheres)?, held(Model::Double)?);
        let yades = yades(theirs, matched, &corner_push(flow, derivatives));
        let own = own(ours, theirs, matched)?;
        let ours = self::ours(flow);
        let at = places(flow.network());
        let between = |a: &Held, b: &Held| Distance::new(&at, a, b);
        let exact = find(Model::Planes);
        let curves = (!case.clamp).then(|| {
            let of = |a: &Held, b: &Held| curve(&at, &a.conductance, &b.conductance);
            Curves {
                ours_planes: of(&ours, &planes),
                theirs_planes: of(&yades, &planes),
                spheres_planes: of(&spheres, &planes),
                theirs_spheres: of(&yades, &spheres),
                double_spheres: of(&double, &spheres),
            }
        });
        Ok(Some(Evidence {
            case,
            solved,
            ours_planes: between(&ours, &planes),
            theirs_planes: between(&yades, &planes),
            spheres_planes: between(&spheres, &planes),
            theirs_spheres: between(&yades, &spheres),
            double_spheres: between(&double, &spheres),
            theirs_solver: between(&yades, &own),
            our_balance: exact.map(|exact| balance(flow, exact)),
            curves,
        }))
    }
}

impl IndependentFlow {
    fn held(&self) -> Held {
        Held {
            conductance: self.conductance.iter().map(|&g| Some(g)).collect(),
            pressure: self.pressure.iter().map(|&p| Some(p)).collect(),
            force: self.force.clone(),
            flux: self.flux[2],
        }
    }
}

impl Distance {
    fn new(places: &[Place], a: &Held, b: &Held) -> Distance {
        let conductance =
            ByPlace::relative(places, a.conductance.iter().copied(), b.conductance.iter().copied());
        let pairs = a.pressure.iter().zip(&b.pressure);
        Distance {
            conductance,
            pressure: Stat::of(pairs.filter_map(|(a, b)| Some((*a)? - (*b)?))),
            force: forces(&a.force, &b.force),
            flux: (a.flux / b.flux - 1.0).abs(),
        }
    }
}

/// Our own flow.
fn ours(flow: &Flow) -> Held {
    Held {
        conductance: flow.network().throats.conductance.iter().map(|&g| Some(g)).collect(),
        pressure: flow.pressure().iter().map(|&p| Some(p)).collect(),
        force: flow.force().to_vec(),
        flux: flow.flux()[2],
    }
}

/// YADE's flow, on our pores and throats.
fn yades(theirs: &TheirFlow, matched: &Match, push: &[Option<Vec3>]) -> Held {
    let push = push.iter().map(|push| push.unwrap_or_default());
    let pressure = |p: &Option<u32>| p.map(|p| theirs.pressure[p as usize]);
    Held {
        conductance: matched.conductances(theirs).collect(),
        pressure: matched.pore.iter().map(pressure).collect(),
        force: theirs.force.iter().zip(push).map(|(f, push)| f + push).collect(),
        flux: -theirs.flux[2],
    }
}

/// The flow that YADE's conductances have.
fn own(
    (flow, derivatives): (&Flow, &Derivatives),
    theirs: &TheirFlow,
    matched: &Match,
) -> Result<Held, Error> {
    let found: Vec<Option<f64>> = matched.conductances(theirs).collect();
    let solution = Solution::new(flow.network(), derivatives, filled(flow, &found))?;
    Ok(Held::solved(found, solution))
}

/// The flow with the conductances and pushes of the second evaluation where it has them, at
/// the walls, and ours elsewhere.
fn mixed(
    (flow, derivatives): (&Flow, &Derivatives),
    independent: &Independent,
    model: Model,
    slip: bool,
) -> Result<Held, Error> {
    let found = independent.conductances(model, slip).to_vec();
    let mut solution = Solution::new(flow.network(), derivatives, filled(flow, &found))?;
    let Solution { pressure, force, .. } = &mut solution;
    independent.beyond_planes(flow.network(), (model, slip), pressure, force);
    Ok(Held::solved(found, solution))
}

fn filled(flow: &Flow, found: &[Option<f64>]) -> Vec<f64> {
    let ours = &flow.network().throats.conductance;
    ours.iter().enumerate().map(|(k, &g)| found.get(k).copied().flatten().unwrap_or(g)).collect()
}

fn forces(a: &[Vec3], b: &[Vec3]) -> Stat {
    let mean = b.iter().map(Vec3::norm).sum::<f64>() / b.len().max(1) as f64;
    Stat::of(a.iter().zip(b).map(|(a, b)| (a - b).norm() / mean))
}

fn balance(flow: &Flow, exact: &IndependentFlow) -> f64 {
    let size = flow.network().bounds.size();
    let sum = flow.force().iter().chain(flow.wall_force()).map(|f| f.y).sum::<f64>();
    (sum - exact.excess.y) / (size.x * size.z)
}

/// Relative differences of throats at walls at 0, 1, … 100 % of them, ascending.
fn curve(places: &[Place], a: &[Option<f64>], b: &[Option<f64>]) -> Vec<f64> {
    let mut values: Vec<f64> = (places.iter().zip(a).zip(b))
        .filter(|((place, _), _)| **place != Place::Inside)
        .filter_map(|((_, a), b)| Some(((*a)? / (*b)? - 1.0).abs()))
        .filter(|v| v.is_finite())
        .collect();
    values.sort_unstable_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    (0..=100).filter_map(|k| values.get(k * last / 100).copied()).collect()
}
