//! The linear systems that every solver gets: conductances of real networks, and a
//! right-hand side whose solution is known.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use dempfv::io::atomic;
use dempfv::pfv::{Network, Operators};
use dempfv::scene::load_packing;
use dempfv::solver::{SolverKind, SymmetricCsc};
use dempfv::{Aabb, InputError, Vec3};
use serde::{Deserialize, Serialize};

use super::network::fluid;
use super::solver_failed;
use crate::Error;
use crate::bench::sample::worst;

/// First number of the file, which is made of little-endian numbers of eight bytes.
const MAGIC: u64 = 0x6465_6d70_6676_0001;

/// Up to so many unknowns the solution is that of spheres that move: it takes a
/// factorization to find.
const REAL: usize = 1_000_000;

/// A matrix, its right-hand side, the solution and the pores' centres.
pub struct System {
    pub matrix: SymmetricCsc,
    pub rhs: Vec<f64>,
    pub solution: Vec<f64>,
    pub points: Vec<[f64; 3]>,
}

/// From which packing, into which file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Systemize {
    pub packing: PathBuf,
    pub file: PathBuf,
}

/// Its size.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Made {
    pub unknowns: usize,
    pub entries: usize,
}

/// How far a solution is from the right one.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Errors {
    /// |b − A x|∞ / (|A|∞ |x|∞ + |b|∞), as the solvers' interface defines it.
    pub residual: f64,
    /// |b − A x|₂ / |b|₂.
    pub missing: f64,
    /// Largest error of a pressure over the largest pressure.
    pub forward: f64,
}

/// A network with its operators, and where its unknowns are.
pub struct Meshed {
    pub network: Network,
    pub operators: Operators,
    pub points: Vec<[f64; 3]>,
}

impl Meshed {
    /// The network of these spheres, drained at the top.
    ///
    /// # Errors
    /// They have none.
    pub fn new(position: &[Vec3], radius: &[f64], bounds: Aabb) -> Result<Meshed, Error> {
        let fluid = fluid();
        let (network, derivatives) =
            Network::new(position, radius, bounds, &fluid).map_err(dempfv::Error::from)?;
        let operators =
            Operators::new(&network, derivatives, fluid.boundary).map_err(dempfv::Error::from)?;
        let center = |&i: &u32| network.center[i as usize].into();
        let points = operators.pore_of.iter().map(center).collect();
        Ok(Meshed { network, operators, points })
    }
}

impl Systemize {
    /// Writes the file.
    ///
    /// # Errors
    /// What is wrong in the packing; the system refuses.
    pub fn write(&self) -> Result<Made, Error> {
        let system = System::new(&self.packing)?;
        system.write(&self.file)?;
        Ok(Made { unknowns: system.matrix.n, entries: system.matrix.nnz() })
    }
}

impl System {
    /// The network of a packing, in which the spheres are squeezed towards the drained top.
    fn new(packing: &Path) -> Result<System, Error> {
        let (packing, bounds) = load_packing(packing, None).map_err(dempfv::Error::from)?;
        let Meshed { network, operators, points } =
            Meshed::new(&packing.position, &packing.radius, bounds)?;
        let n = operators.unknowns();
        let solution = if n <= REAL {
            let velocity: Vec<Vec3> =
                packing.position.iter().map(|x| Vec3::new(0.0, bounds.min.y - x.y, 0.0)).collect();
            let mut rate = vec![0.0; network.pores()];
            operators.volume_rate(&velocity, &[0.0; 6], &mut rate).map_err(dempfv::Error::from)?;
            let still = vec![0.0; network.pores()];
            let mut rhs = vec![0.0; n];
            operators.residual(&still, &rate, &mut rhs).map_err(dempfv::Error::from)?;
            solve(&operators.matrix, &points, &rhs)?
        } else {
            let high = bounds.max.y - bounds.min.y;
            points
                .iter()
                .map(|p| (1.0 - ((p[1] - bounds.min.y) / high).powi(2)) * (1.0 + 0.1 * p[0] / high))
                .collect()
        };
        let matrix = operators.matrix;
        let rhs = product(&matrix, &solution).iter().map(|[high, low]| high + low).collect();
        Ok(System { matrix, rhs, solution, points })
    }

    fn write(&self, path: &Path) -> Result<(), Error> {
        let System { matrix, rhs, solution, points } = self;
        let head = [MAGIC, matrix.n as u64, matrix.nnz() as u64];
        let index = matrix.col_ptr.iter().chain(&matrix.row_idx).map(|&i| i as u64);
        let real = matrix.values.iter().chain(rhs).chain(solution).chain(points.iter().flatten());
        Ok(atomic::write_with(path, |file| {
            let mut file = std::io::BufWriter::new(file);
            for number in head.into_iter().chain(index).chain(real.map(|v| v.to_bits())) {
                file.write_all(&number.to_le_bytes())?;
            }
            file.flush()
        })?)
    }

    /// Reads the file.
    ///
    /// # Errors
    /// It is not there, or is none of a system.
    pub fn read(path: &Path) -> Result<System, Error> {
        let bytes = fs::read(path).map_err(|e| dempfv::Error::io(path, e))?;
        let wrong = || InputError::new("no system of equations", "remove it").in_file(path);
        let mut numbers = bytes.as_chunks::<8>().0.iter().map(|c| u64::from_le_bytes(*c));
        let mut next = || numbers.next().ok_or_else(wrong);
        if next()? != MAGIC {
            return Err(wrong().into());
        }
        let (n, entries) = (next()? as usize, next()? as usize);
        if bytes.len() != 8 * (4 + 6 * n + 2 * entries) {
            return Err(wrong().into());
        }
        let mut many = |count: usize| (0..count).map(|_| next()).collect::<Result<Vec<_>, _>>();
        let index = |v: Vec<u64>| v.into_iter().map(|i| i as i64).collect();
        let real = |v: Vec<u64>| v.into_iter().map(f64::from_bits).collect::<Vec<f64>>();
        let (col_ptr, row_idx) = (index(many(n + 1)?), index(many(entries)?));
        let matrix = SymmetricCsc { n, col_ptr, row_idx, values: real(many(entries)?) };
        let (rhs, solution) = (real(many(n)?), real(many(n)?));
        let points = real(many(3 * n)?).as_chunks::<3>().0.to_vec();
        Ok(System { matrix, rhs, solution, points })
    }

    /// How far the solution in a file of 64-bit numbers is from the right one. Residuals are
    /// summed up in twice the working precision.
    ///
    /// # Errors
    /// The file is not there or has another size.
    pub fn judge(&self, path: &Path) -> Result<Errors, Error> {
        let bytes = fs::read(path).map_err(|e| dempfv::Error::io(path, e))?;
        let x: Vec<f64> = bytes.as_chunks::<8>().0.iter().map(|c| f64::from_le_bytes(*c)).collect();
        if x.len() != self.matrix.n {
            return Err(InputError::new("no solution of the system", "remove it")
                .in_file(path)
                .into());
        }
        let product = product(&self.matrix, &x);
        let norm = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
        let pairs = product.iter().zip(&self.rhs);
        let rest: Vec<f64> = pairs.map(|([high, low], b)| (b - high) - low).collect();
        let largest = |v: &[f64]| worst(v.iter().copied());
        let scale = self.matrix.norm_inf() * largest(&x) + largest(&self.rhs);
        let error = worst(x.iter().zip(&self.solution).map(|(x, s)| x - s));
        Ok(Errors {
            residual: largest(&rest) / scale,
            missing: norm(&rest) / norm(&self.rhs),
            forward: error / largest(&self.solution),
        })
    }
}

fn solve(a: &SymmetricCsc, points: &[[f64; 3]], b: &[f64]) -> Result<Vec<f64>, Error> {
    let kind = SolverKind::default();
    let failed = |e| solver_failed(kind.name(), &e);
    let mut factor = kind
        .backend()
        .analyze(a, Some(points))
        .and_then(|symbolic| symbolic.factor(a))
        .map_err(failed)?;
    let mut x = vec![0.0; a.n];
    factor.solve(b, &mut x).map_err(failed)?;
    Ok(x)
}

/// A x in about twice the working precision: high and low parts.
fn product(a: &SymmetricCsc, x: &[f64]) -> Vec<[f64; 2]> {
    let mut y = vec![[0.0; 2]; a.n];
    for j in 0..a.n {
        for k in a.col_ptr[j] as usize..a.col_ptr[j + 1] as usize {
            let (i, value) = (a.row_idx[k] as usize, a.values[k]);
            add(&mut y[i], value, x[j]);
            if i != j {
                add(&mut y[j], value, x[i]);
            }
        }
    }
    y
}

/// Adds a product to a sum of two parts (Dekker 1971; Knuth).
fn add(sum: &mut [f64; 2], a: f64, b: f64) {
    let product = a * b;
    let lost = a.mul_add(b, -product);
    let total = sum[0] + product;
    let part = total - sum[0];
    let rounded = (sum[0] - (total - part)) + (product - part);
    let low = sum[1] + rounded + lost;
    let high = total + low;
    *sum = [high, low - (high - total)];
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (10¹⁶ + 1) − 10¹⁶ has no digit left in double precision.
    #[test]
    fn sums_keep_what_double_precision_loses() {
        let mut sum = [0.0; 2];
        add(&mut sum, 1e8, 1e8);
        add(&mut sum, 1.0, 1.0);
        add(&mut sum, -1e8, 1e8);
        assert_eq!(sum[0] + sum[1], 1.0);
        // 1 + 2⁻⁵² squared, less its rounded value: 2⁻¹⁰⁴ is lost in the product.
        let mut sum = [0.0; 2];
        let x = 1.0 + f64::EPSILON;
        add(&mut sum, x, x);
        add(&mut sum, -1.0, x * x);
        assert_eq!(sum[0] + sum[1], f64::EPSILON * f64::EPSILON);
    }
}
