//! Networks and static flows.

use std::collections::{BTreeMap, BTreeSet};

use dempfv::pfv::{Flow, NONE, Network, Operators, PfvError};
use dempfv::solver::SolverKind;
use dempfv::{Vec3, WallId};
use proptest::prelude::*;

use crate::common::{Random, Spheres};
use crate::packings::{draws, packing, through_flow};

fn config() -> ProptestConfig {
    let cases = std::env::var("DEMPFV_PROPERTIES").ok().and_then(|n| n.parse().ok());
    ProptestConfig { cases: cases.unwrap_or(160), failure_persistence: None, ..Default::default() }
}

fn network(s: &Spheres) -> Result<(Network, Operators), PfvError> {
    let fluid = through_flow();
    let (network, derivatives) = Network::new(&s.x, &s.r, s.bounds, &fluid)?;
    let operators = Operators::new(&network, derivatives, fluid.boundary)?;
    Ok((network, operators))
}

/// A refusal has words, and one line of them.
fn is_refused_in_words(error: &PfvError) -> Result<(), TestCaseError> {
    let words = error.to_string();
    prop_assert!(words.len() > 10 && !words.contains('\n'), "{words:?}");
    Ok(())
}

proptest! {
    #![proptest_config(config())]

    /// Cells are a triangulation: neighbours share a facet and know each other, and vertices,
    /// edges, facets and cells of what fills a convex hull obey Euler: V − E + F − C = 1.
    #[test]
    fn cells_are_a_triangulation(draw in draws()) {
        let s = packing(draw);
        let (n, _) = match network(&s) {
            Ok(built) => built,
            Err(error) => return is_refused_in_words(&error),
        };
        let t = &n.tessellation;
        let (mut edges, mut facets) = (BTreeSet::new(), BTreeMap::new());
        let mut vertices = BTreeSet::<u32>::new();
        for (i, cell) in t.cells.iter().enumerate() {
            vertices.extend(cell);
            for k in 0..4 {
                edges.extend((0..k).map(|l| [cell[k].min(cell[l]), cell[k].max(cell[l])]));
                let facet = facet(cell, k);
                *facets.entry(facet).or_insert(0) += 1;
                let j = t.neighbors[i][k];
                if j != NONE {
                    let back = t.neighbors[j as usize].iter().position(|&b| b == i as u32);
                    let back = back.expect("neighbours know each other");
                    prop_assert_eq!(self::facet(&t.cells[j as usize], back), facet);
                }
            }
        }
        prop_assert!(facets.values().all(|&cells| cells <= 2));
        let count = [vertices.len(), edges.len(), facets.len(), t.cells.len()].map(|n| n as i64);
        prop_assert_eq!(count[0] - count[1] + count[2] - count[3], 1, "{:?}", count);
        let hidden: BTreeSet<u32> = t.hidden.iter().copied().collect();
        prop_assert_eq!(vertices.len() + hidden.len(), s.x.len() + 6);
    }

    /// Volumes of the pores add up to the box's to round-off (1e-12), and all is finite: volumes,
    /// conductances, forces, fluxes. G is symmetric by its storage; what it has off the diagonal
    /// is not positive, and each diagonal outweighs its row, to round-off.
    #[test]
    fn volumes_add_up_and_conductances_are_dominant(draw in draws()) {
        let s = packing(draw);
        let (n, o) = match network(&s) {
            Ok(built) => built,
            Err(error) => return is_refused_in_words(&error),
        };
        let sum: f64 = n.volume.iter().sum();
        prop_assert!((sum / s.bounds.volume() - 1.0).abs() < 1e-12, "{:e}", sum - 1.0);
        prop_assert!(n.volume.iter().all(|v| v.is_finite()));
        prop_assert!(n.throats.conductance.iter().all(|g| g.is_finite() && *g >= 0.0));
        let a = &o.matrix;
        let (mut diagonal, mut beside) = (vec![0.0; a.n], vec![0.0; a.n]);
        for column in 0..a.n {
            for k in a.col_ptr[column] as usize..a.col_ptr[column + 1] as usize {
                let (row, value) = (a.row_idx[k] as usize, a.values[k]);
                prop_assert!(row >= column && value.is_finite());
                if row == column {
                    diagonal[row] = value;
                } else {
                    prop_assert!(value <= 0.0);
                    beside[row] -= value;
                    beside[column] -= value;
                }
            }
        }
        for (own, others) in diagonal.iter().zip(&beside) {
            prop_assert!(*own >= others * (1.0 - 1e-13), "{own:e} against {others:e}");
        }
    }

    /// A flow that is solved is one of numbers, no pressure is outside those of the walls (the
    /// maximum principle of a matrix without positive couplings), and what enters leaves.
    #[test]
    fn static_flows_keep_between_the_walls_pressures(draw in draws()) {
        let s = packing(draw);
        let fluid = through_flow();
        let solved = Flow::new(&s.x, &s.r, s.bounds, &fluid, SolverKind::default())
            .and_then(|mut flow| flow.solve_static().map(|()| flow));
        let flow = match solved {
            Ok(flow) => flow,
            Err(error) => return is_refused_in_words(&error),
        };
        prop_assert!(flow.pressure().iter().all(|p| (-1e-6..=1.0 + 1e-6).contains(p)));
        prop_assert!(flow.force().iter().flat_map(|f| f.iter()).all(|f| f.is_finite()));
        let flux = flow.flux();
        let (enters, leaves) = (flux[WallId::YMin.index()], -flux[WallId::YMax.index()]);
        prop_assert!((enters - leaves).abs() <= 1e-6 * enters.abs(), "{enters:e}, {leaves:e}");
        prop_assert!(enters >= 0.0);
    }

    /// What the fluid does to moving spheres is no more than what is put into it: between walls
    /// at rest and at a pressure of zero, the work of squeezing, p · E v, is dissipated, pᵀ G p,
    /// which is not negative.
    #[test]
    fn squeezing_is_dissipated(draw in draws()) {
        let s = packing(draw);
        let mut fluid = through_flow();
        fluid.boundary.pressure[WallId::YMin] = Some(0.0);
        let built = Flow::new(&s.x, &s.r, s.bounds, &fluid, SolverKind::default());
        let mut random = Random(draw.seed ^ 1);
        let velocity: Vec<Vec3> = s.x.iter().map(|_| random.vector()).collect();
        let solved = built.and_then(|mut flow| flow.solve(&velocity, &[0.0; 6]).map(|()| flow));
        let flow = match solved {
            Ok(flow) => flow,
            Err(error) => return is_refused_in_words(&error),
        };
        let put_in: f64 = flow.pressure().iter().zip(flow.volume_rate()).map(|(p, v)| p * v).sum();
        let throats = &flow.network().throats;
        let pairs = throats.pores.iter().zip(&throats.conductance);
        let p = flow.pressure();
        let dissipated: f64 =
            pairs.map(|(&[i, j], g)| g * (p[i as usize] - p[j as usize]).powi(2)).sum();
        prop_assert!(dissipated >= 0.0 && dissipated.is_finite());
        // The pressure is against the rate at which pores shrink.
        prop_assert!((put_in + dissipated).abs() <= 1e-6 * dissipated, "{put_in:e}, {dissipated:e}");
    }
}

fn facet(cell: &[u32; 4], opposite: usize) -> [u32; 3] {
    let mut three = [0; 3];
    let others = (0..4).filter(|&k| k != opposite).map(|k| cell[k]);
    three.iter_mut().zip(others).for_each(|(slot, v)| *slot = v);
    three.sort_unstable();
    three
}
