//! The specimens: cubes of spheres with the sizes of the paper's, from a thousand spheres
//! to two million unknown pressures.

use std::path::{Path, PathBuf};
use std::process::Command;

use dempfv::InputError;

use crate::Error;
use crate::bench::Bench;

/// Stress that all of them have settled at (Pa).
pub const STRESS: f64 = 1e3;

/// A packing that the project ships, or copies of one side by side, settled again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specimen {
    /// Number of spheres.
    pub spheres: u32,
    /// The packing that it consists of.
    base: &'static str,
    /// Copies of it along x, y and z.
    copies: [u32; 3],
    /// Steps that are timed after a remesh.
    pub steps: u64,
    /// Times that they are timed.
    pub repeats: usize,
}

/// Every specimen, small ones first: cubes, and one for [`ALONE`].
pub const SPECIMENS: [Specimen; 7] = [
    specimen(1_000, "oedometer-1000.txt", [1, 1, 1], 600, 3),
    specimen(5_000, "oedometer-5000.txt", [1, 1, 1], 300, 3),
    specimen(20_000, "oedometer-20000.txt", [1, 1, 1], 120, 3),
    specimen(30_000, "oedometer-5000.txt", [1, 2, 3], 100, 3),
    specimen(40_000, "oedometer-5000.txt", [2, 2, 2], 80, 3),
    specimen(160_000, "oedometer-20000.txt", [2, 2, 2], 40, 1),
    specimen(343_000, "oedometer-1000.txt", [7, 7, 7], 25, 1),
];

/// Numbers of spheres that each acceleration is measured on its own with.
pub const ALONE: [u32; 2] = [5_000, 30_000];

const fn specimen(
    spheres: u32,
    base: &'static str,
    copies: [u32; 3],
    steps: u64,
    repeats: usize,
) -> Specimen {
    Specimen { spheres, base, copies, steps, repeats }
}

/// The specimens with these numbers of spheres; all if none is named.
///
/// # Errors
/// There is no specimen with one of these numbers.
pub fn chosen(sizes: &[u32]) -> Result<Vec<Specimen>, InputError> {
    let known = SPECIMENS.map(|s| s.spheres);
    if let Some(size) = sizes.iter().find(|size| !known.contains(size)) {
        let what = format!("--sizes {size}: there is no specimen of so many spheres");
        let known = known.map(|n| n.to_string()).join(", ");
        return Err(InputError::new(what, format!("the sizes are {known}")));
    }
    let wanted = |s: &Specimen| sizes.is_empty() || sizes.contains(&s.spheres);
    Ok(SPECIMENS.into_iter().filter(wanted).collect())
}

impl Specimen {
    /// True for a cube, as the paper's are.
    pub fn is_cube(&self) -> bool {
        self.copies[0] == self.copies[1] && self.copies[1] == self.copies[2]
    }

    /// What it is made of.
    pub fn origin(&self) -> String {
        match self.copies {
            [1, 1, 1] => self.base.to_owned(),
            [x, y, z] => format!("{x} × {y} × {z} copies of {}", self.base),
        }
    }

    /// The packing file that it consists of.
    ///
    /// # Errors
    /// It is not there.
    pub fn base(&self) -> Result<PathBuf, InputError> {
        shipped(self.base)
    }

    /// The packing file of this specimen. Copies are put together and settled in the first
    /// call, and kept.
    ///
    /// # Errors
    /// The packings are not there, or the copies do not settle.
    pub fn packing(&self, bench: &Bench) -> Result<PathBuf, Error> {
        let base = self.base()?;
        if self.copies == [1; 3] {
            return Ok(base);
        }
        let folder = bench.folder.join("packings").join(self.spheres.to_string());
        let file = folder.join("packing.txt");
        // It is put in its place when it is complete.
        if !file.is_file() {
            let step = format!("settle-{}", self.spheres);
            let copies = self.copies.map(|n| n.to_string());
            let mut command = Command::new(bench.program(&step)?);
            command.args(["pack", "--tile"]).args(copies).arg(&base);
            command.args(["--stress", &STRESS.to_string(), "--out"]).arg(&folder);
            bench.run_logged(&step, "dempfv", &mut command)?;
        }
        Ok(file)
    }
}

/// A packing of a checkout, by absolute path: scenes that name it lie elsewhere.
fn shipped(name: &str) -> Result<PathBuf, InputError> {
    let path = Path::new("packings").join(name);
    std::path::absolute(&path).and_then(|p| p.metadata().map(|_| p)).map_err(|e| {
        let what = format!("{}: {e}", path.display());
        InputError::new(what, "start in a checkout of the project")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names say how many spheres a packing has; six times as many pores, less what
    /// the walls cut off, are the paper's largest: 2.1 million unknowns.
    #[test]
    fn copies_make_up_the_number_of_spheres() {
        for s in SPECIMENS {
            let digits: String = s.base.chars().filter(char::is_ascii_digit).collect();
            let base: u32 = digits.parse().unwrap();
            assert_eq!(s.spheres, base * s.copies.iter().product::<u32>(), "{}", s.origin());
        }
        assert!(SPECIMENS.is_sorted_by_key(|s| s.spheres));
        assert!(SPECIMENS.iter().filter(|s| s.is_cube()).count() >= 6);
        assert_eq!(chosen(&ALONE).unwrap().len(), ALONE.len());
    }

    #[test]
    fn unknown_sizes_are_refused() {
        assert_eq!(chosen(&[]).unwrap().len(), SPECIMENS.len());
        assert_eq!(chosen(&[20_000]).unwrap(), [SPECIMENS[2]]);
        assert!(chosen(&[1_000, 1_001]).unwrap_err().to_string().contains("--sizes 1001"));
    }
}
