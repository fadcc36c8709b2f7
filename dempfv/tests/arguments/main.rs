//! Every public function that takes arguments, with arguments that cannot be right: wrong lengths,
//! numbers that are none, negative, huge. It must return an error that names the argument, or what
//! its documentation says instead; and never panic.
//!
//! The tables are complete: `every_public_function_has_a_row` reads the sources.

mod bodies;
mod cell;
mod coupling;
mod dem;
#[path = "../dem_support/mod.rs"]
mod dem_support;
mod exempt;
mod files;
mod pfv;
mod scan;
mod scene;
mod solver;

use std::collections::BTreeSet;
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Numbers that no length, mass or time step has.
pub const NO_LENGTHS: [f64; 5] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0];

/// What calls came to that were not refused as they should be.
#[derive(Default)]
pub struct Table {
    functions: BTreeSet<&'static str>,
    faults: Vec<String>,
}

impl Table {
    /// The call must return an error whose message has this word.
    pub fn refuses<T, E: Display>(
        &mut self,
        function: &'static str,
        word: &str,
        call: impl FnOnce() -> Result<T, E>,
    ) {
        self.functions.insert(function);
        let fault = match catch_unwind(AssertUnwindSafe(call)) {
            Err(_) => "panicked".to_owned(),
            Ok(Ok(_)) => "accepted it".to_owned(),
            Ok(Err(error)) => {
                let message = error.to_string();
                if message.contains(word) {
                    return;
                }
                format!("said: {message}")
            }
        };
        self.faults.push(format!("{function}, `{word}`: {fault}"));
    }

    /// The call must come to what the documentation says in the place of an error.
    pub fn gives(&mut self, function: &'static str, what: &str, call: impl FnOnce() -> bool) {
        self.functions.insert(function);
        let fault = match catch_unwind(AssertUnwindSafe(call)) {
            Ok(true) => return,
            Ok(false) => "does not hold",
            Err(_) => "panicked",
        };
        self.faults.push(format!("{function}, {what}: {fault}"));
    }

    /// The call must panic, as its documentation says: an index that there is not.
    pub fn panics<T>(&mut self, function: &'static str, call: impl FnOnce() -> T) {
        self.functions.insert(function);
        if catch_unwind(AssertUnwindSafe(call)).is_ok() {
            self.faults.push(format!("{function}: accepted an index that there is not"));
        }
    }

    fn check(&self) {
        assert!(self.faults.is_empty(), "{}", self.faults.join("\n"));
    }
}

#[test]
fn the_mechanics_refuse_what_cannot_be_right() {
    dem::table().check();
}

#[test]
fn clumps_and_motions_refuse_what_cannot_be_right() {
    bodies::table().check();
}

#[test]
fn cells_refuse_what_cannot_be_right() {
    cell::table().check();
}

#[test]
fn the_fluid_refuses_what_cannot_be_right() {
    pfv::table().check();
}

#[test]
fn coupled_runs_refuse_what_cannot_be_right() {
    coupling::table().check();
}

#[test]
fn the_solvers_refuse_what_cannot_be_right() {
    solver::table().check();
}

#[test]
fn files_refuse_what_cannot_be_right() {
    files::table().check();
}

#[test]
fn plans_and_theory_refuse_what_cannot_be_right() {
    scene::table().check();
}

/// Whoever adds a public function adds a row for it, or says in `exempt.rs` why there is none.
#[test]
fn every_public_function_has_a_row() {
    let tables = [
        dem::table(),
        bodies::table(),
        cell::table(),
        pfv::table(),
        coupling::table(),
        solver::table(),
        files::table(),
        scene::table(),
    ];
    let rows: BTreeSet<&str> = tables.iter().flat_map(|t| t.functions.iter().copied()).collect();
    let exempt: BTreeSet<&str> =
        exempt::EXEMPT.iter().flat_map(|(names, _)| *names).copied().collect();
    let found = scan::public_functions();
    let has_row = |name: &String| {
        let owner = name.rsplit_once("::").map_or("", |(owner, _)| owner);
        rows.contains(name.as_str()) || exempt.contains(name.as_str()) || exempt.contains(owner)
    };
    let missing: Vec<&String> = found.iter().filter(|name| !has_row(name)).collect();
    assert!(missing.is_empty(), "public functions without a row: {missing:#?}");
    let is_there = |name: &&&str| {
        let owner = format!("{name}::");
        found.iter().any(|f| f == **name || f.starts_with(&owner))
    };
    let gone: Vec<&&str> = rows.union(&exempt).filter(|name| !is_there(name)).collect();
    assert!(gone.is_empty(), "rows for what is no public function: {gone:#?}");
}
