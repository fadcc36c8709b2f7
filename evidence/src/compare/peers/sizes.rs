//! What is measured: packings that the project ships, and copies of them side by side.

use std::path::{Path, PathBuf};

use dempfv::io::packing::{self, Packing};
use dempfv::scene::load_packing;
use dempfv::{Aabb, InputError};

use crate::Error;
use crate::bench::Bench;

/// A packing, or copies of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// Number of spheres.
    pub spheres: usize,
    base: &'static str,
    copies: [u32; 3],
}

const fn size(spheres: usize, base: &'static str, copies: [u32; 3]) -> Size {
    Size { spheres, base, copies }
}

const N1: Size = size(1_000, "oedometer-1000.txt", [1; 3]);
const N5: Size = size(5_000, "oedometer-5000.txt", [1; 3]);
const N20: Size = size(20_000, "oedometer-20000.txt", [1; 3]);
const N40: Size = size(40_000, "oedometer-5000.txt", [2; 3]);
const N135: Size = size(135_000, "oedometer-5000.txt", [3; 3]);
/// Two million unknown pressures, as the paper's largest.
const N360: Size = size(360_000, "oedometer-20000.txt", [3, 3, 2]);

/// Which sizes each row of the contest is measured on.
pub struct Sizes {
    /// Steps without fluid.
    pub dry: &'static [Size],
    /// Coupled steps.
    pub coupled: &'static [Size],
    /// Networks.
    pub network: &'static [Size],
    /// Solves in the time loop.
    pub inside: &'static [Size],
    /// Linear systems.
    pub linear: &'static [Size],
}

/// The sizes that the contest is about.
pub const FULL: Sizes = Sizes {
    dry: &[N20],
    coupled: &[N5, N20, N135],
    network: &[N20],
    inside: &[N20, N40, N135],
    linear: &[N20, N40, N135, N360],
};

/// Small ones: whether everything works, in a minute.
pub const QUICK: Sizes =
    Sizes { dry: &[N1], coupled: &[N1], network: &[N1], inside: &[N1], linear: &[N1, N5] };

/// A packing on disk.
#[derive(Clone, Debug)]
pub struct Placed {
    pub spheres: usize,
    pub path: PathBuf,
    pub bounds: Aabb,
    /// What it is made of.
    pub origin: String,
}

impl Size {
    /// Its file; copies are put together in the first call.
    ///
    /// # Errors
    /// The packings are not there.
    pub fn place<P>(&self, bench: &Bench<P>) -> Result<Placed, Error> {
        let base = Path::new("packings").join(self.base);
        let base =
            std::path::absolute(&base).and_then(|p| p.metadata().map(|_| p)).map_err(|e| {
                let what = format!("{}: {e}", base.display());
                dempfv::Error::from(InputError::new(what, "start in a checkout of the project"))
            })?;
        let [x, y, z] = self.copies;
        if self.copies == [1; 3] {
            let (packing, bounds) = load_packing(&base, None).map_err(dempfv::Error::from)?;
            return Ok(Placed {
                spheres: packing.len(),
                path: base,
                bounds,
                origin: self.base.to_owned(),
            });
        }
        let (one, bounds) = load_packing(&base, None).map_err(dempfv::Error::from)?;
        let tiled = Packing { bounds: Some(bounds), ..one }.tiled(self.copies);
        let tiled = tiled.map_err(dempfv::Error::from)?;
        let bounds = tiled.bounds.unwrap_or(bounds);
        let path = bench.folder.join("scenes").join(format!("tiled-{}.txt", self.spheres));
        let path = std::path::absolute(&path).map_err(|e| dempfv::Error::io(&path, e))?;
        let origin = format!("{x} × {y} × {z} copies of {}", self.base);
        if !path.is_file() {
            let comment = format!("{origin}; metres");
            packing::write(&path, &tiled.position, &tiled.radius, Some(&bounds), &comment)?;
        }
        Ok(Placed { spheres: tiled.len(), path, bounds, origin })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names say how many spheres a packing has.
    #[test]
    fn copies_make_up_the_number_of_spheres() {
        for sizes in [FULL, QUICK] {
            let all = [sizes.dry, sizes.coupled, sizes.network, sizes.inside, sizes.linear];
            for size in all.concat() {
                let digits: String = size.base.chars().filter(char::is_ascii_digit).collect();
                let base: u32 = digits.parse().unwrap();
                assert_eq!(size.spheres as u32, base * size.copies.iter().product::<u32>());
            }
        }
    }
}
