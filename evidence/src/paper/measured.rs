//! All that is known so far, whichever call has measured it.

use super::built::{self, Built};
use super::factored::{self, Factored};
use super::gpu::{self, OnGpu};
use super::remesh::{self, Remesh};
use super::specimens::{SPECIMENS, Specimen};
use super::timing::{self, Mode, Timing};
use crate::Error;
use crate::bench::Bench;

/// What is known of one specimen.
pub struct Row {
    /// The specimen.
    pub specimen: Specimen,
    /// Its run in each mode, by [`Mode`].
    timings: [Option<Timing>; Mode::ALL.len()],
    /// Its network on one core, and on all.
    pub built: [Option<Built>; 2],
    /// Its factorization with the BLAS on all cores.
    pub factored: Option<Factored>,
    /// What was measured on machines with a GPU.
    pub gpu: Vec<OnGpu>,
}

/// What is known in all.
pub struct Measured {
    /// Number of all cores.
    pub threads: usize,
    /// The cubes, small ones first.
    pub rows: Vec<Row>,
    /// The specimen that is none.
    pub alone: Vec<Row>,
    /// Figure 2.
    pub remesh: Option<Remesh>,
}

impl Measured {
    /// Collects what was measured.
    ///
    /// # Errors
    /// A file of a run with a GPU is none.
    pub fn collect(bench: &Bench, threads: usize) -> Result<Measured, Error> {
        let rows = SPECIMENS.iter().map(|specimen| Row::collect(bench, specimen, threads));
        let rows: Vec<Row> = rows.collect::<Result<_, _>>()?;
        let (rows, alone) = rows.into_iter().partition(|row| row.specimen.is_cube());
        Ok(Measured { threads, rows, alone, remesh: remesh::known(bench, threads)? })
    }

    /// Points of a curve over the number of unknowns.
    pub fn over_unknowns<'a>(
        &'a self,
        value: impl Fn(&Row) -> Option<f64> + 'a,
    ) -> impl Iterator<Item = Option<(f64, f64)>> + 'a {
        self.rows.iter().map(move |row| Some((row.unknowns()?, value(row)?)))
    }

    /// The largest specimen for which something is known.
    pub fn largest<T>(&self, value: impl Fn(&Row) -> Option<T>) -> Option<(&Row, T)> {
        self.rows.iter().rev().find_map(|row| Some((row, value(row)?)))
    }

    /// What is known of the specimen with so many spheres.
    pub fn row(&self, spheres: u32) -> Option<&Row> {
        self.rows.iter().chain(&self.alone).find(|row| row.specimen.spheres == spheres)
    }

    /// Names of the GPUs that there are runs of.
    pub fn gpus(&self) -> Vec<&str> {
        let mut names: Vec<&str> =
            self.rows.iter().flat_map(|row| &row.gpu).map(|on| on.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// How all cores are called.
    pub fn all_cores(&self) -> String {
        match self.threads {
            1 => "1 core".to_owned(),
            n => format!("{n} cores"),
        }
    }
}

impl Row {
    fn collect(bench: &Bench, specimen: &Specimen, threads: usize) -> Result<Row, Error> {
        let mut timings = [const { None }; Mode::ALL.len()];
        for mode in Mode::ALL {
            timings[mode as usize] = timing::known(bench, specimen, mode, mode.threads(threads))?;
        }
        let built = [built::known(bench, specimen, 1)?, built::known(bench, specimen, threads)?];
        let factored = factored::known(bench, specimen, threads)?;
        let gpu = gpu::known(&bench.folder, specimen)?;
        Ok(Row { specimen: *specimen, timings, built, factored, gpu })
    }

    /// The run in a mode.
    pub fn timing(&self, mode: Mode) -> Option<&Timing> {
        self.timings[mode as usize].as_ref()
    }

    /// What was measured on this GPU.
    pub fn on_gpu(&self, name: &str) -> Option<&OnGpu> {
        self.gpu.iter().find(|on| on.name == name)
    }

    /// Every run.
    pub fn all(&self) -> impl Iterator<Item = &Timing> {
        self.timings.iter().flatten().chain(self.gpu.iter().map(|on| &on.with_gpu))
    }

    /// Number of unknown pressures, once a run has counted them.
    pub fn unknowns(&self) -> Option<f64> {
        self.all().next().map(|timing| timing.number("unknowns"))
    }

    /// Number of unknown pressures as a cell of a table.
    pub fn name(&self) -> String {
        dempfv_report::format::count(self.specimen.spheres.into())
    }
}
