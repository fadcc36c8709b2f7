//! Permeability of the inside of a packing, without the looser layers at walls.

use super::Flow;
use crate::{Vec3, WallId};

/// Planes across the flow that the flux is taken at.
const PLANES: usize = 9;

impl Flow {
    /// Permeability (m²) of the part of the box that is farther than `margin` (m) from every wall: flux
    /// per area through planes across it, over the slope of the pressures in it. At a wall spheres
    /// lie in order and leave wide pores, which a small box has many of. `None` where
    /// [`Flow::permeability`] is, and where the margins leave nothing, or no pressure falls.
    pub fn core_permeability(&self, wall: WallId, margin: f64) -> Option<f64> {
        self.permeability(wall)?;
        let (axis, network) = (wall.axis(), self.network());
        let low = network.bounds.min.add_scalar(margin);
        let high = network.bounds.max.add_scalar(-margin);
        let size = high - low;
        if !size.iter().all(|&edge| edge > 0.0) {
            return None;
        }
        let across =
            |x: &Vec3| (0..3).filter(|&k| k != axis).all(|k| (low[k]..high[k]).contains(&x[k]));
        let (center, pressure) = (&network.center, self.pressure());
        let mut flow = 0.0;
        let throats = network.throats.pores.iter().zip(&network.throats.conductance);
        for (pores, conductance) in throats {
            let [i, j] = pores.map(|pore| pore as usize);
            let (a, b) = (center[i], center[j]);
            let way = b[axis] - a[axis];
            if way == 0.0 {
                continue;
            }
            let crossed = (0..PLANES).filter(|&k| {
                let plane = low[axis] + size[axis] * (k as f64 + 0.5) / PLANES as f64;
                let share = (plane - a[axis]) / way;
                (0.0..1.0).contains(&share) && across(&(a + share * (b - a)))
            });
            flow +=
                crossed.count() as f64 * way.signum() * conductance * (pressure[i] - pressure[j]);
        }
        let flux = flow / PLANES as f64 / (size.product() / size[axis]);
        let inside = |i: &usize| {
            let x = &center[*i];
            across(x) && (low[axis]..high[axis]).contains(&x[axis]) && network.volume[*i] > 0.0
        };
        let slope = slope(
            (0..network.pores())
                .filter(inside)
                .map(|i| (network.volume[i], center[i][axis], pressure[i])),
        );
        let permeability = -flux * self.fluid().viscosity / slope;
        permeability.is_finite().then_some(permeability)
    }
}

/// Slope of the straight line that is nearest to points of a weight, x and y.
fn slope(points: impl Iterator<Item = (f64, f64, f64)> + Clone) -> f64 {
    let mean = |of: fn(f64, f64) -> f64| {
        let (sum, weight) = points
            .clone()
            .fold((0.0, 0.0), |(s, w), (weight, x, y)| (s + weight * of(x, y), w + weight));
        sum / weight
    };
    let (x, y) = (mean(|x, _| x), mean(|_, y| y));
    (mean(|x, y| x * y) - x * y) / (mean(|x, _| x * x) - x * x)
}
