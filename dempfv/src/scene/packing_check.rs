//! Is a packing one that can be simulated?

use std::path::Path;

use super::cell::{CellShape, too_small};
use super::wrong::Wrong;
use crate::domain::{Aabb, Cell, Vec3, WallId};
use crate::input::InputError;
use crate::io::packing::Packing;

/// A sphere may reach through a wall by this share of its radius: contacts overlap, of soft
/// spheres much.
const REACH: f64 = 0.4;

/// Spheres whose centres are nearer than this share of the smallest radius coincide.
const COINCIDENT: f64 = 1e-9;

/// Reads a packing file and checks it ([`validate_packing`]) against `bounds`, else
/// against its own box; without either, its box is the tight one.
///
/// # Errors
/// What is wrong, with file and line.
pub fn load_packing(path: &Path, bounds: Option<Aabb>) -> Result<(Packing, Aabb), InputError> {
    let packing = Packing::read(path)?;
    if packing.cell.is_some() {
        let what = "the packing is of a periodic cell: its spheres reach past the faces";
        let remedy =
            "run it in a scene with a table [cell], or take the line `# cell` out and give a box";
        return Err(InputError::new(what, remedy).in_file(path));
    }
    let bounds = bounds
        .or_else(|| packing.bounds_or_tight())
        .ok_or_else(|| count_fault(0, 0).in_file(path))?;
    let lines = Some(packing.line.as_slice());
    validate_packing(&packing.position, &packing.radius, lines, &bounds, Some(path))?;
    Ok((packing, bounds))
}

/// Reads a packing file and the periodic cell that it states; `None` where it states none.
///
/// # Errors
/// What is wrong, with file and line.
pub fn load_periodic_packing(path: &Path) -> Result<Option<(Packing, Cell)>, InputError> {
    let states_cell = Packing::read(path)?.cell.is_some();
    if !states_cell {
        return Ok(None);
    }
    let (packing, _) = load_packing_in_cell(path, CellShape::OfPacking)?;
    let cell = packing.cell;
    Ok(cell.map(|cell| (packing, cell)))
}

/// Reads a packing file for a periodic cell: that of the scene, else the file's own, which is the
/// packing's then. Returns the box around the cell with it.
///
/// # Errors
/// What is wrong, with file and line.
pub(super) fn load_packing_in_cell(
    path: &Path,
    shape: CellShape,
) -> Result<(Packing, Aabb), InputError> {
    let mut packing = Packing::read(path)?;
    let cell = match (shape, packing.cell) {
        (CellShape::Edges(cell), _) | (CellShape::OfPacking, Some(cell)) => cell,
        (CellShape::OfPacking, None) => {
            let what = "[cell] gives no edges, and the packing has no line `# cell`";
            let remedy = "give `size` or `edges` in [cell]";
            return Err(InputError::new(what, remedy).in_file(path));
        }
    };
    packing.cell = Some(cell);
    let largest = packing.radius.iter().copied().fold(0.0, f64::max);
    let mean = packing.radius.iter().sum::<f64>() / packing.len() as f64;
    if let Some(Wrong { problem, remedy }) = too_small(&cell, largest, mean) {
        return Err(InputError::new(format!("the cell {problem}"), remedy).in_file(path));
    }
    let inside: Vec<Vec3> = packing.position.iter().map(|x| cell.wrap(x).0).collect();
    match coincident(&inside, &packing.radius) {
        None => Ok((packing, cell.bounds())),
        Some((i, j)) => {
            let what = format!("sphere {j} is in the same place as sphere {i}, or as a copy of it");
            let error = InputError::new(what, "remove one of the two").in_file(path);
            Err(match packing.line.get(j) {
                Some(&line) => error.at_line(line),
                None => error,
            })
        }
    }
}

/// Checks the spheres of a packing: at least one, finite positions, positive radii, inside
/// the box, which is one (the centre, and all but 40 % of a radius), no two in the same place.
///
/// Positions and radii in m. Spheres are numbered from 0; `lines` are their lines in
/// `file`, from 1, where both are known. Takes n log n time.
///
/// # Errors
/// The first sphere that is wrong, with its number and, where known, its line.
///
/// ```
/// use dempfv::{Aabb, Vec3, scene::validate_packing};
/// let unit = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
/// let centre = [Vec3::repeat(0.5), Vec3::new(0.5, 1.2, 0.5)];
/// assert!(validate_packing(&centre[..1], &[0.5], None, &unit, None).is_ok());
/// let error = validate_packing(&centre, &[0.1, 0.1], None, &unit, None).unwrap_err();
/// assert!(error.what.starts_with("sphere 1 "));
/// ```
pub fn validate_packing(
    positions: &[Vec3],
    radii: &[f64],
    lines: Option<&[usize]>,
    bounds: &Aabb,
    file: Option<&Path>,
) -> Result<(), InputError> {
    let place = |error: InputError, sphere: Option<usize>| {
        let error = match file {
            Some(file) => error.in_file(file),
            None => error,
        };
        match sphere.and_then(|i| lines?.get(i)) {
            Some(&line) => error.at_line(line),
            None => error,
        }
    };
    if positions.is_empty() || positions.len() != radii.len() {
        return Err(place(count_fault(positions.len(), radii.len()), None));
    }
    if let Some(wrong) = box_wrong(bounds) {
        let what = format!("`max` of the box {}", wrong.problem);
        return Err(place(InputError::new(what, wrong.remedy), None));
    }
    for (i, (x, &r)) in positions.iter().zip(radii).enumerate() {
        check_sphere(i, x, r, bounds).map_err(|e| place(e, Some(i)))?;
    }
    match coincident(positions, radii) {
        None => Ok(()),
        Some((i, j)) => Err(place(
            InputError::new(
                format!("sphere {j} is in the same place as sphere {i}"),
                "remove one of the two",
            ),
            Some(j),
        )),
    }
}

const LINE_FORM: &str = "give one line `x y z r` (m) for each sphere";

fn count_fault(positions: usize, radii: usize) -> InputError {
    let what = match positions {
        0 => "the packing has no sphere".to_owned(),
        n => format!("the packing has {n} positions and {radii} radii"),
    };
    InputError::new(what, LINE_FORM)
}

fn check_sphere(i: usize, x: &Vec3, r: f64, bounds: &Aabb) -> Result<(), InputError> {
    if !(r.is_finite() && r > 0.0) {
        return Err(InputError::new(
            format!("sphere {i} has the radius {r}"),
            "give a radius above 0 in m",
        ));
    }
    if let Some(axis) = (0..3).find(|&a| !x[a].is_finite()) {
        return Err(InputError::new(
            format!("sphere {i} has {} = {}", ["x", "y", "z"][axis], x[axis]),
            "give a finite position in m",
        ));
    }
    for wall in WallId::ALL {
        // Distance of the centre from the wall's plane, positive inside.
        let depth = (x[wall.axis()] - bounds.wall(wall)) * wall.inward();
        if depth < 0.0 {
            return Err(InputError::new(
                format!(
                    "sphere {i} is outside the box: its centre is {:.4e} m beyond {wall}",
                    -depth
                ),
                "move it inside, or give a larger box",
            ));
        }
        if depth < r * (1.0 - REACH) {
            return Err(InputError::new(
                format!(
                    "sphere {i} is outside the box: it pokes through {wall} by {:.1} % of its radius",
                    100.0 * (1.0 - depth / r)
                ),
                format!(
                    "move it inside, or give the box that the packing was made in: up to {:.0} % is a contact of \
                     soft spheres",
                    100.0 * REACH
                ),
            ));
        }
    }
    Ok(())
}

/// What is wrong with a box.
pub(super) fn box_wrong(bounds: &Aabb) -> Option<Wrong> {
    let Aabb { min, max } = bounds;
    let finite = min.iter().chain(max.iter()).all(|x| x.is_finite());
    if !finite {
        return Some(Wrong::new("or `min` is not finite", "give finite numbers in m"));
    }
    let Some(axis) = (0..3).find(|&a| min[a] >= max[a]) else {
        let volume = bounds.volume();
        let wrong = || Wrong::new(format!("has a volume of {volume:e} m³"), "give edges in metres");
        return (!volume.is_normal()).then(wrong);
    };
    Some(Wrong::new(
        format!("has {} = {}, not above {} of `min`", ["x", "y", "z"][axis], max[axis], min[axis]),
        "give a `max` above `min` on every axis",
    ))
}

/// Two spheres in the same place, the smaller number first.
fn coincident(positions: &[Vec3], radii: &[f64]) -> Option<(usize, usize)> {
    let reach = COINCIDENT * radii.iter().copied().fold(f64::INFINITY, f64::min);
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    coincident_along(0, positions, reach, &mut order)
}

/// Sorts along one axis, cuts where neighbours are farther apart than `reach`, and goes on
/// with each piece along the next axis: two spheres nearer than `reach` stay together.
fn coincident_along(
    axis: usize,
    positions: &[Vec3],
    reach: f64,
    order: &mut [u32],
) -> Option<(usize, usize)> {
    let at = |i: u32| positions[i as usize][axis.min(2)];
    if axis == 3 {
        return nearest_pair(positions, reach, order);
    }
    order.sort_unstable_by(|&a, &b| at(a).total_cmp(&at(b)).then(a.cmp(&b)));
    order
        .chunk_by_mut(|&a, &b| at(b) - at(a) <= reach)
        .filter(|piece| piece.len() > 1)
        .find_map(|piece| coincident_along(axis + 1, positions, reach, piece))
}

/// Two of a piece (sorted along z) that are nearer than `reach`.
fn nearest_pair(positions: &[Vec3], reach: f64, piece: &[u32]) -> Option<(usize, usize)> {
    piece.iter().enumerate().find_map(|(k, &i)| {
        let x = &positions[i as usize];
        piece[k + 1..]
            .iter()
            .take_while(|&&j| positions[j as usize].z - x.z <= reach)
            .find(|&&j| (positions[j as usize] - x).norm() <= reach)
            .map(|&j| (i.min(j) as usize, i.max(j) as usize))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Aabb = Aabb { min: Vec3::new(0.0, 0.0, 0.0), max: Vec3::new(1.0, 1.0, 1.0) };

    fn lattice(n: usize) -> (Vec<Vec3>, Vec<f64>) {
        let h = 1.0 / n as f64;
        let at = |i: usize| h * (i as f64 + 0.5);
        let positions: Vec<Vec3> =
            (0..n * n * n).map(|i| Vec3::new(at(i % n), at(i / n % n), at(i / n / n))).collect();
        let radii = vec![0.5 * h; positions.len()];
        (positions, radii)
    }

    fn fault(positions: &[Vec3], radii: &[f64]) -> InputError {
        let lines: Vec<usize> = (0..radii.len()).map(|i| i + 3).collect();
        validate_packing(positions, radii, Some(&lines), &UNIT, Some(Path::new("p.txt")))
            .unwrap_err()
    }

    /// A lattice has whole planes of equal coordinates, the worst case for sorting.
    #[test]
    fn a_lattice_is_fine_and_one_doubled_sphere_in_it_is_found() {
        let (mut positions, mut radii) = lattice(20);
        assert_eq!(validate_packing(&positions, &radii, None, &UNIT, None), Ok(()));
        positions.push(positions[4711] + Vec3::repeat(1e-13));
        radii.push(radii[0]);
        let error = fault(&positions, &radii);
        assert_eq!(error.what, "sphere 8000 is in the same place as sphere 4711");
        assert_eq!(error.line, Some(8003));
    }

    /// A small sphere inside a large one is legal, however near the centres.
    #[test]
    fn a_small_sphere_inside_a_large_one_is_no_coincidence() {
        let positions = [Vec3::repeat(0.5), Vec3::repeat(0.5 + 1e-6)];
        assert_eq!(validate_packing(&positions, &[0.4, 1e-4], None, &UNIT, None), Ok(()));
    }

    #[test]
    fn each_fault_names_its_sphere_and_line() {
        let inside = Vec3::repeat(0.5);
        let cases: [(Vec3, f64, &str); 6] = [
            (inside, f64::NAN, "sphere 1 has the radius NaN"),
            (inside, -0.1, "sphere 1 has the radius -0.1"),
            (inside, 0.0, "sphere 1 has the radius 0"),
            (Vec3::new(0.5, f64::NAN, 0.5), 0.1, "sphere 1 has y = NaN"),
            (Vec3::new(0.5, 0.5, 1.25), 0.1, "its centre is 2.5000e-1 m beyond z_max"),
            (Vec3::new(0.05, 0.5, 0.5), 0.1, "pokes through x_min by 50.0 % of its radius"),
        ];
        for (x, r, expected) in cases {
            let error = fault(&[Vec3::repeat(0.3), x], &[0.1, r]);
            assert!(error.what.contains(expected), "{error}");
            assert_eq!(error.line, Some(4));
            assert!(!error.remedy.is_empty());
        }
        let overlap = [Vec3::new(0.0601, 0.5, 0.5)];
        assert_eq!(validate_packing(&overlap, &[0.1], None, &UNIT, None), Ok(()));
        assert_eq!(fault(&[], &[]).what, "the packing has no sphere");
    }
}
