//! The figures: what each needs, and its section of the page.

mod alone;
mod build;
mod gain;
mod parts;
mod remesh;
mod speed;

use std::path::Path;

use super::measured::{Measured, Row};
use super::specimens::{ALONE, Specimen};
use super::timing::{Mode, Timing};
use crate::Error;
use crate::paper::draw::Curve;

pub use gain::gain;
pub use speed::{acceleration, composed_of, interval};

/// The figures of the paper that time something.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Figure {
    /// Pressures against the remesh interval, what they cost, and replicates
    #[value(name = "2")]
    Remesh,
    /// No acceleration against all of them
    #[value(name = "5")]
    Acceleration,
    /// Analyze and factor, by device
    #[value(name = "6")]
    Factor,
    /// Allocate and build
    #[value(name = "7")]
    Build,
    /// Time per iteration, remesh interval of eq. 15, Cundall number
    #[value(name = "8")]
    Speed,
    /// Gain of the parallel tasks
    #[value(name = "9")]
    Gain,
    /// Solve, volumes and forces
    #[value(name = "10")]
    Parts,
}

impl Figure {
    /// Every figure, in the paper's order.
    pub const ALL: [Figure; 7] = [
        Figure::Remesh,
        Figure::Acceleration,
        Figure::Factor,
        Figure::Build,
        Figure::Speed,
        Figure::Gain,
        Figure::Parts,
    ];

    /// The runs of a specimen that it needs.
    pub fn modes(self, specimen: &Specimen) -> Vec<Mode> {
        let alone = ALONE.contains(&specimen.spheres);
        match self {
            Figure::Acceleration if alone => Mode::ALL.to_vec(),
            _ if !specimen.is_cube() => vec![],
            Figure::Remesh | Figure::Build => vec![],
            Figure::Acceleration => {
                vec![Mode::OneCore, Mode::Plain, Mode::Accelerated, Mode::Cholmod]
            }
            Figure::Factor | Figure::Parts => vec![Mode::OneCore, Mode::AllCores, Mode::Cholmod],
            Figure::Speed => {
                vec![Mode::OneCore, Mode::AllCores, Mode::Accelerated, Mode::Cholmod]
            }
            Figure::Gain => vec![Mode::AllCores, Mode::Tasks],
        }
    }

    /// Its section of the page; its pictures go into the folder.
    ///
    /// # Errors
    /// When a picture cannot be written.
    pub fn section(self, measured: &Measured, folder: &Path) -> Result<String, Error> {
        match self {
            Figure::Remesh => remesh::section(measured, folder),
            Figure::Acceleration => {
                Ok(speed::acceleration_section(measured, folder)? + &alone::section(measured))
            }
            Figure::Factor => build::factor_section(measured, folder),
            Figure::Build => build::build_section(measured, folder),
            Figure::Speed => speed::section(measured, folder),
            Figure::Gain => gain::section(measured, folder),
            Figure::Parts => parts::section(measured, folder),
        }
    }
}

/// Label of the axis of all figures over the size.
const UNKNOWNS: &str = "Unknown pressures";

/// A device that runs were made on; with the default solver, but for those whose name has
/// another.
#[derive(Clone, Copy)]
enum Device<'a> {
    OneCore,
    AllCores,
    /// One core, with CHOLMOD.
    Cholmod,
    /// CHOLMOD, with the factorization on this one.
    Gpu(&'a str),
}

impl<'a> Device<'a> {
    /// Every device that there are runs on.
    fn all(measured: &'a Measured) -> Vec<Device<'a>> {
        let gpus = measured.gpus().into_iter().map(Device::Gpu);
        [Device::OneCore, Device::AllCores, Device::Cholmod].into_iter().chain(gpus).collect()
    }

    fn name(self, measured: &Measured) -> String {
        match self {
            Device::OneCore => "1 core".to_owned(),
            Device::AllCores => measured.all_cores(),
            Device::Cholmod => "CHOLMOD, 1 core".to_owned(),
            Device::Gpu(name) => name.to_owned(),
        }
    }

    /// A specimen's run on it.
    fn timing(self, row: &'a Row) -> Option<&'a Timing> {
        match self {
            Device::OneCore => row.timing(Mode::OneCore),
            Device::AllCores => row.timing(Mode::AllCores),
            Device::Cholmod => row.timing(Mode::Cholmod),
            Device::Gpu(name) => row.on_gpu(name).map(|on| &on.with_gpu),
        }
    }
}

/// A curve for each device.
fn by_device(measured: &Measured, value: impl Fn(&Timing) -> f64 + Copy) -> Vec<Curve> {
    let curve = |device: Device| {
        let points = measured.over_unknowns(move |row| device.timing(row).map(value));
        Curve::new(device.name(measured), points)
    };
    Device::all(measured).into_iter().map(curve).collect()
}
