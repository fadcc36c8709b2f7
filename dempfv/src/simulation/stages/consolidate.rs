//! `consolidate`: a stress is put on a wall at once and the packing drains.

use serde::{Deserialize, Serialize};

use super::changes::Changes;
use super::context::{Context, Progress};
use super::servo_watch::ServoWatch;
use super::wall_layers;
use crate::coupling::Coupled;
use crate::dem::WallControl;
use crate::pfv::Flow;
use crate::scene;
use crate::simulation::StageError;
use crate::simulation::clock::Clock;
use crate::simulation::outcome::{
    Consolidation, ConsolidationSample, LoadCycles, Outcome, PermeabilityTest, Profile,
    StageOutcome,
};
use crate::simulation::warning::{LateLoad, Warning, warn};
use crate::{Axis, InputError, Result, Vec3, WallId};

/// Slabs of a pressure profile: about one sphere each in a packing of 1000.
const SLABS: usize = 10;
/// Share of the height whose pores are the middle where both ends drain: about one sphere, as the
/// pores at a wall.
const MIDDLE: f64 = 0.1;
/// Samples are this share of the time apart, but at least [`FINEST`].
const SPACING: f64 = 0.01;
const FINEST: f64 = 1e-4;
/// The load has arrived where the stress on the wall is off by this share of it.
const ARRIVED: f64 = 0.1;
/// A load that arrives later than at this T_v is not one that is put on at once: a tenth of the
/// settlement is over by then.
const LATE: f64 = 0.01;
/// The first sample: before it the servo wall is still bringing the load.
const FIRST: f64 = 1e-3;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    result: Consolidation,
    /// Pressure imposed at the drained walls (Pa): excess pressures are above it.
    outside: f64,
    until: f64,
    profiles_left: Vec<f64>,
    start_time: f64,
    start_position: f64,
    /// Stress asked for (Pa).
    stress: f64,
    /// How long the load took to arrive (s).
    arrived: Option<f64>,
    next_sample: f64,
    steps: u64,
    max_steps: u64,
    servos: ServoWatch,
}

impl State {
    pub fn start(plan: &scene::Consolidate, context: &mut Context) -> Result<State> {
        let axis = Axis::of(plan.wall);
        let measured = "put a cycle stage and a permeability stage of the same axis before it";
        let missing =
            |what: &str| InputError::new(format!("a consolidate stage without {what}"), measured);
        let cycles =
            last_cycles(context.outcomes, axis).ok_or_else(|| missing("a measured modulus"))?;
        let modulus = cycles.modulus_pa;
        let layers = cycles
            .wall_layer_settlement
            .ok_or_else(|| missing("what the pores at the walls settle by"))?;
        let permeability = last_permeability(context.outcomes, axis)
            .ok_or_else(|| missing("a measured permeability along its axis"))?
            .permeability_m2;
        context.saturate()?;
        let (viscosity, drained_walls, outside) = drainage(context, plan.wall)?;

        let before = context.coupled.dem().wall_stress(plan.wall);
        context.coupled.controls().set_control(plan.wall, servo(plan))?;
        let dem = context.coupled.dem();
        // Of the stress on the wall, the pressure where the fluid leaves is no load on the spheres.
        let load = plan.stress - outside - before;
        let height = dem.box_().size()[axis.index()];
        let drainage_path = height / drained_walls.len() as f64;
        let of = |walls: &[WallId]| walls.iter().map(|wall| layers[wall.index() % 2]).sum();
        let (drained_settlement, sealed_settlement) =
            (of(&drained_walls), of(sealed(&drained_walls).as_slice()));
        Ok(State {
            result: Consolidation {
                wall: plan.wall,
                load_pa: load,
                height_m: height,
                drained_walls,
                drainage_path_m: drainage_path,
                modulus_pa: modulus,
                permeability_m2: permeability,
                c_v_m2_s: permeability * modulus / viscosity,
                final_settlement_m: height * (1.0 - (-load / modulus).exp()),
                drained_share: 0.0,
                sealed_share: 0.0,
                drained_settlement,
                sealed_settlement,
                samples: vec![],
                profiles: vec![],
            },
            outside,
            until: plan.until_tv,
            profiles_left: plan.profiles.clone(),
            start_time: context.clock.time,
            start_position: dem.walls()[plan.wall].position,
            stress: plan.stress,
            arrived: None,
            next_sample: FIRST,
            steps: 0,
            max_steps: plan.max_steps,
            servos: ServoWatch::default(),
        })
    }

    fn time_factor(&self, clock: &Clock) -> f64 {
        self.result.c_v_m2_s * (clock.time - self.start_time) / self.result.drainage_path_m.powi(2)
    }

    pub fn so_far(&self) -> &Consolidation {
        &self.result
    }

    pub fn progress(&self, clock: &Clock) -> f64 {
        (self.time_factor(clock) / self.until).min(1.0)
    }

    pub fn restore(
        &mut self,
        coupled: &mut Coupled,
        plan: &scene::Consolidate,
        changes: &Changes,
        clock: &Clock,
    ) -> Result<()> {
        self.max_steps = plan.max_steps;
        self.until = plan.until_tv;
        let now = self.time_factor(clock);
        self.profiles_left = plan.profiles.iter().copied().filter(|&at| at > now).collect();
        if changes.in_stage("max_velocity") {
            coupled.controls().set_control(plan.wall, servo(plan))?;
        }
        Ok(())
    }

    pub fn advance(&mut self, context: &mut Context) -> Result<Progress> {
        context.step()?;
        self.steps += 1;
        let now = self.time_factor(context.clock);
        self.servos.look(context, self.progress(context.clock));
        let Consolidation { wall, load_pa, .. } = self.result;
        let missing = (context.coupled.wall_stress(wall) - self.stress).abs();
        if self.arrived.is_none() && missing <= ARRIVED * load_pa.abs() {
            self.arrived = Some(context.clock.time - self.start_time);
        }
        let Some(flow) = context.coupled.storage_flow() else { return Ok(Progress::Running) };
        if self.steps == 1 {
            let heights =
                |walls: &[WallId]| walls.iter().map(|&w| wall_layers::height(flow, w)).sum();
            let drained = &self.result.drained_walls;
            let (drained_share, sealed_share) =
                (heights(drained), heights(sealed(drained).as_slice()));
            (self.result.drained_share, self.result.sealed_share) = (drained_share, sealed_share);
        }
        let over = now >= self.until;
        if now >= self.next_sample || over {
            let sample = self.sample(now, context.coupled, flow);
            self.result.samples.push(sample);
            self.next_sample = (now * (1.0 + SPACING)).max(now + FINEST);
        }
        while self.profiles_left.first().is_some_and(|&at| now >= at) {
            self.profiles_left.remove(0);
            self.result.profiles.push(self.profile(now, flow));
        }
        if over {
            self.servos.warn(context);
            self.warn_of_late_load(context);
            return Ok(Progress::finished(Outcome::Consolidate(self.result.clone())));
        }
        if self.steps >= self.max_steps {
            return Err(StageError::TimeFactorNotReached {
                steps: self.steps,
                time_factor: now,
                goal: self.until,
            }
            .into());
        }
        Ok(Progress::Running)
    }

    fn warn_of_late_load(&self, context: &mut Context) {
        let Consolidation { wall, drainage_path_m, c_v_m2_s, .. } = self.result;
        let consolidation = drainage_path_m.powi(2) / c_v_m2_s;
        let late = self.arrived.is_none_or(|after| after > LATE * consolidation);
        if late {
            let stage = context.stage.name.clone();
            let late = LateLoad { stage, wall, arrived: self.arrived, consolidation };
            warn(context.warnings, Warning::LateLoad(late));
        }
    }

    fn sample(&self, time_factor: f64, coupled: &Coupled, flow: &Flow) -> ConsolidationSample {
        let wall = self.result.wall;
        let position = coupled.dem().walls()[wall].position;
        let settlement = wall.inward() * (position - self.start_position);
        ConsolidationSample {
            time_factor,
            settlement_m: settlement,
            degree: settlement / self.result.final_settlement_m,
            base_pressure: (self.farthest_pressure(flow) - self.outside) / self.result.load_pa,
        }
    }

    /// Mean pressure of the pores that are the farthest from where fluid leaves (Pa).
    fn farthest_pressure(&self, flow: &Flow) -> f64 {
        if !self.result.drains_at_both_ends() {
            return mean_pressure_at(flow, self.result.drained_walls[0].opposite());
        }
        let pores = self.pores(flow).filter(|(depth, _, _)| (depth - 0.5).abs() < MIDDLE / 2.0);
        let (weighted, volume) =
            pores.fold((0.0, 0.0), |(s, v), (_, volume, p)| (s + volume * p, v + volume));
        weighted / volume
    }

    /// Of each pore: distance from the drained wall over the height (1), volume (m³), pressure (Pa).
    fn pores<'f>(&self, flow: &'f Flow) -> impl Iterator<Item = (f64, f64, f64)> + 'f {
        let wall = self.result.drained_walls[0];
        let (axis, network) = (wall.axis(), flow.network());
        let (at, height) = (network.bounds.wall(wall), network.bounds.size()[axis]);
        let depth = move |center: &Vec3| wall.inward() * (center[axis] - at) / height;
        let pores = network.center.iter().zip(&network.volume).zip(flow.pressure());
        pores.map(move |((center, &volume), &pressure)| (depth(center), volume, pressure))
    }

    fn profile(&self, time_factor: f64, flow: &Flow) -> Profile {
        let mut sums = [(0.0, 0.0); SLABS];
        for (depth, volume, pressure) in self.pores(flow) {
            let slab = (depth * SLABS as f64).clamp(0.0, SLABS as f64 - 1.0) as usize;
            sums[slab].0 += volume * (pressure - self.outside);
            sums[slab].1 += volume;
        }
        let filled = (0..SLABS).filter(|&k| sums[k].1 > 0.0);
        let (depth, pressure) = filled
            .map(|k| ((k as f64 + 0.5) / SLABS as f64, sums[k].0 / sums[k].1 / self.result.load_pa))
            .unzip();
        Profile { time_factor, depth, pressure }
    }
}

fn servo(plan: &scene::Consolidate) -> WallControl {
    WallControl::Servo { stress: plan.stress, max_velocity: plan.max_velocity }
}

/// The last finished measurement of the oedometric modulus along an axis.
fn last_cycles(outcomes: &[StageOutcome], axis: Axis) -> Option<&LoadCycles> {
    outcomes.iter().rev().find_map(|o| match &o.outcome {
        Outcome::Cycle(cycles) if Axis::of(cycles.wall) == axis => Some(cycles),
        _ => None,
    })
}

/// The last finished measurement of the permeability along an axis.
fn last_permeability(outcomes: &[StageOutcome], axis: Axis) -> Option<&PermeabilityTest> {
    outcomes.iter().rev().find_map(|o| match &o.outcome {
        Outcome::Permeability(test) if test.axis == axis.name() => Some(test),
        _ => None,
    })
}

/// The fluid's viscosity, the drained walls, the loaded one first, and the
/// pressure there: they must be ends of the loaded axis for the theory of
/// one-dimensional drainage to hold.
fn drainage(context: &Context, loaded: WallId) -> Result<(f64, Vec<WallId>, f64)> {
    let fluid = context.plan.fluid.as_ref();
    let mut walls: Vec<(WallId, f64)> =
        fluid.into_iter().flat_map(|f| f.pressure_walls()).collect();
    walls.sort_by_key(|(wall, _)| *wall != loaded);
    match (fluid, walls.first()) {
        (Some(fluid), Some(&(_, outside)))
            if walls.iter().all(|(w, p)| w.axis() == loaded.axis() && *p == outside) =>
        {
            Ok((fluid.fluid.viscosity, walls.into_iter().map(|(wall, _)| wall).collect(), outside))
        }
        _ => Err(InputError::new(
            "a consolidate stage needs one-dimensional drainage",
            format!("impose one pressure on {loaded}, {} or both alone", loaded.opposite()),
        )
        .into()),
    }
}

/// The end of the loaded axis that does not drain, if there is one.
fn sealed(drained: &[WallId]) -> Option<WallId> {
    match drained {
        [wall] => Some(wall.opposite()),
        _ => None,
    }
}

/// Mean pressure by volume of the pores that touch a wall (Pa).
fn mean_pressure_at(flow: &Flow, wall: WallId) -> f64 {
    let (volume, pressure) = (&flow.network().volume, flow.pressure());
    let (weighted, volume) = wall_layers::at_wall(flow.network(), wall)
        .fold((0.0, 0.0), |(s, v), i| (s + volume[i] * pressure[i], v + volume[i]));
    weighted / volume
}
