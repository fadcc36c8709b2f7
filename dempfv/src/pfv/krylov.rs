//! The largest eigenvalue of an operator that can only be applied: Arnoldi's
//! method on one vector per sphere.

use rayon::prelude::*;

use super::PfvError;
use crate::Vec3;

/// Largest number of applications.
const MAX_APPLICATIONS: usize = 24;
/// Fewest, so that a mode which the start hardly contains comes forth.
const MIN_APPLICATIONS: usize = 6;
/// Share of the eigenvalue that the residual may have at the end.
const RESIDUAL_RATIO: f64 = 0.01;
/// Share of noise beside a start that is given.
const NOISE_RATIO: f64 = 0.3;
/// Squarings of the projected operator that leave its dominant eigenvector:
/// with 2¹² applications, eigenvalues 1 % apart are separated to 1e-18.
const SQUARINGS: u32 = 12;
/// Entries of a partial sum. Sums have this shape for any number of threads.
const PARTIAL_SUM_ENTRIES: usize = 4_096;
/// From this many vectors on, sharing work between threads pays.
const SERIAL_ENTRIES: usize = 4 * PARTIAL_SUM_ENTRIES;

/// An eigenpair, or what was found of it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Eigenpair {
    /// The eigenvalue.
    pub value: f64,
    /// Length of the residual for the vector below.
    pub residual: f64,
    /// The eigenvector, of length 1.
    pub vector: Vec<Vec3>,
    /// Applications of the operator.
    pub applications: u32,
}

/// The eigenvalue of largest modulus of an operator on vectors of length
/// `size`, whose large eigenvalues are real: the operators here are nearly
/// symmetric. A start that is nearly an eigenvector saves applications.
///
/// Once value and residual together are less than `negligible`, that is
/// enough to know.
///
/// For a symmetric operator there is an eigenvalue within the residual of the
/// value; as the subspace also holds noise, that is the largest in practice
/// (Zhou, Saad, Tiago and Chelikowsky 2006 bound spectra this way).
///
/// # Errors
/// Those of the operator.
pub(super) fn largest(
    size: usize,
    start: Option<&[Vec3]>,
    negligible: f64,
    mut apply: impl FnMut(&[Vec3], &mut [Vec3]) -> Result<(), PfvError>,
) -> Result<Eigenpair, PfvError> {
    let mut basis = vec![first_vector(size, start)];
    let mut projected = [[0.0; MAX_APPLICATIONS]; MAX_APPLICATIONS];
    loop {
        let n = basis.len();
        let mut next = vec![Vec3::zeros(); size];
        apply(&basis[n - 1], &mut next)?;
        for (row, v) in projected.iter_mut().zip(&basis) {
            row[n - 1] = dot(v, &next);
            add_scaled(&mut next, -row[n - 1], v);
        }
        let left = dot(&next, &next).sqrt();
        let (value, weights) = dominant(&projected, n);
        let residual = (left * weights[n - 1]).abs();
        // What is left of a vector of this length is round-off.
        let complete = left <= 1e-12 * value.abs() || n == 3 * size;
        let enough =
            residual <= RESIDUAL_RATIO * value.abs() || value.abs() + residual < negligible;
        if complete || n == MAX_APPLICATIONS || (n >= MIN_APPLICATIONS && enough) {
            let mut vector = vec![Vec3::zeros(); size];
            for (v, &weight) in basis.iter().zip(&weights) {
                add_scaled(&mut vector, weight, v);
            }
            return Ok(Eigenpair { value, residual, vector, applications: n as u32 });
        }
        projected[n][n - 1] = left;
        scale(&mut next, 1.0 / left);
        basis.push(next);
    }
}

/// The start given with some noise, or noise alone; of length 1.
fn first_vector(size: usize, start: Option<&[Vec3]>) -> Vec<Vec3> {
    let mut first: Vec<Vec3> =
        (0..size as u64).map(|i| Vec3::from_fn(|k, _| noise(3 * i + k as u64))).collect();
    let length = dot(&first, &first).sqrt();
    let known = start.filter(|s| s.len() == size);
    scale(&mut first, if known.is_some() { NOISE_RATIO / length } else { 1.0 / length });
    if let Some(start) = known {
        add_scaled(&mut first, 1.0, start);
        let length = dot(&first, &first).sqrt();
        scale(&mut first, 1.0 / length);
    }
    first
}

/// A fixed sequence of numbers in [-1, 1) without order (splitmix64).
fn noise(i: u64) -> f64 {
    let mut z = (i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

type Small = [[f64; MAX_APPLICATIONS]; MAX_APPLICATIONS];

/// The eigenvalue of largest modulus of the first `n` rows and columns, and
/// its eigenvector: a high power of the matrix has no other column.
fn dominant(matrix: &Small, n: usize) -> (f64, [f64; MAX_APPLICATIONS]) {
    let mut power = *matrix;
    for _ in 0..SQUARINGS {
        let largest = power.as_flattened().iter().fold(0.0f64, |m, x| m.max(x.abs()));
        if largest == 0.0 {
            break;
        }
        let mut square = [[0.0; MAX_APPLICATIONS]; MAX_APPLICATIONS];
        for (row, into) in power.iter().zip(&mut square).take(n) {
            for (&x, other) in row.iter().zip(&power).take(n) {
                let x = x / (largest * largest);
                into.iter_mut().zip(other).for_each(|(sum, y)| *sum += x * y);
            }
        }
        power = square;
    }
    let length = |k: usize| power.iter().map(|row| row[k] * row[k]).sum::<f64>();
    let column = (1..n).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    let norm = length(column).sqrt();
    let mut vector = [0.0; MAX_APPLICATIONS];
    if norm > 0.0 {
        vector.iter_mut().zip(&power).for_each(|(v, row)| *v = row[column] / norm);
    } else {
        vector[0] = 1.0;
    }
    let image =
        |row: &[f64; MAX_APPLICATIONS]| row.iter().zip(&vector).map(|(a, v)| a * v).sum::<f64>();
    let value = matrix.iter().zip(&vector).map(|(row, v)| v * image(row)).sum();
    (value, vector)
}

fn dot(a: &[Vec3], b: &[Vec3]) -> f64 {
    let part = |(a, b): (&[Vec3], &[Vec3])| a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>();
    if a.len() < SERIAL_ENTRIES {
        return a.chunks(PARTIAL_SUM_ENTRIES).zip(b.chunks(PARTIAL_SUM_ENTRIES)).map(part).sum();
    }
    let parts: Vec<f64> = a
        .par_chunks(PARTIAL_SUM_ENTRIES)
        .zip(b.par_chunks(PARTIAL_SUM_ENTRIES))
        .map(part)
        .collect();
    parts.iter().sum()
}

fn add_scaled(to: &mut [Vec3], factor: f64, v: &[Vec3]) {
    let add = |(to, v): (&mut [Vec3], &[Vec3])| {
        to.iter_mut().zip(v).for_each(|(to, v)| *to += factor * v);
    };
    if to.len() < SERIAL_ENTRIES {
        add((to, v));
    } else {
        to.par_chunks_mut(PARTIAL_SUM_ENTRIES).zip(v.par_chunks(PARTIAL_SUM_ENTRIES)).for_each(add);
    }
}

fn scale(v: &mut [Vec3], factor: f64) {
    v.iter_mut().for_each(|x| *x *= factor);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eigenvalues evenly in [0, 1) and, on one component, `top`.
    fn band(top: f64) -> impl FnMut(&[Vec3], &mut [Vec3]) -> Result<(), PfvError> {
        move |x, y| {
            let size = x.len() as f64;
            for (i, (x, y)) in x.iter().zip(y.iter_mut()).enumerate() {
                *y = (i as f64 / size) * x;
            }
            y[7].y = top * x[7].y;
            Ok(())
        }
    }

    #[test]
    fn an_eigenvalue_above_a_band_is_found_with_its_vector() {
        for size in [10, 1_000, 20_000] {
            let found = largest(size, None, 0.0, band(1.3)).unwrap();
            assert!((found.value - 1.3).abs() < 1e-3, "{} of {size}", found.value);
            assert!(found.residual <= RESIDUAL_RATIO * found.value);
            assert!(found.vector[7].y.abs() > 0.999);
        }
    }

    /// The top of a dense band: below it by no more than the residual tells.
    #[test]
    fn the_residual_covers_what_is_missing() {
        let found = largest(5_000, None, 0.0, band(0.5)).unwrap();
        assert!(found.value < 1.0 && found.value + found.residual > 0.995, "{found:?}");
    }

    /// The old eigenvector as start, and a mode elsewhere that has overtaken.
    #[test]
    fn a_start_that_is_known_saves_applications_and_hides_nothing() {
        let cold = largest(1_000, None, 0.0, band(1.1)).unwrap();
        let warm = largest(1_000, Some(&cold.vector), 0.0, band(1.1)).unwrap();
        assert!(warm.applications < cold.applications);
        let mut old = vec![Vec3::zeros(); 1_000];
        old[500].x = 1.0;
        let overtaken = largest(1_000, Some(&old), 0.0, band(2.0)).unwrap();
        assert!((overtaken.value - 2.0).abs() < 0.01, "{}", overtaken.value);
    }

    /// One sphere has three components: the fourth vector is round-off.
    #[test]
    fn a_space_of_three_dimensions_is_exhausted() {
        let found = largest(1, None, 0.0, |x, y| {
            y[0] = Vec3::new(2.0 * x[0].x + 0.3 * x[0].y, x[0].y, 0.5 * x[0].z);
            Ok(())
        })
        .unwrap();
        assert!((found.value - 2.0).abs() < 1e-12, "{}", found.value);
        assert!(found.applications <= 3);
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bits() {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| largest(40_000, None, 0.0, band(1.05)).unwrap())
        };
        assert!(on(1) == on(3));
    }

    #[test]
    fn what_is_negligible_is_not_refined() {
        let rough = largest(5_000, None, 1.5, band(0.5)).unwrap();
        assert_eq!(rough.applications, MIN_APPLICATIONS as u32);
        assert!(rough.value + rough.residual > 0.95, "{rough:?}");
    }

    #[test]
    fn nothing_resists() {
        let zero = |_: &[Vec3], y: &mut [Vec3]| {
            y.fill(Vec3::zeros());
            Ok(())
        };
        assert_eq!(largest(5, None, 0.0, zero).unwrap().value, 0.0);
    }
}
