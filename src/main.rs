//! The program `dempfv`: arguments in, results and exit status out.
//!
//! Exit status: 0 done; 2 the input is wrong (one message, nothing written); 3 the
//! simulation cannot go on.
#![warn(missing_docs)]

mod address_space;
mod commands;
mod evidence;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::Parser;
use commands::{Cli, Context};

fn main() -> ExitCode {
    address_space::start_without_blas_threads();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    let result = Context::new(&cli.options)
        .map_err(commands::Error::from)
        // On a thread of the pool: a caller from outside would hand each piece of work over
        // and wait for it, several times a step.
        .and_then(|context| rayon::scope(|_| commands::execute(cli.command, &context)));
    match result {
        Ok(status) => status,
        Err(error) => {
            // A closed stderr must not turn an error into a panic.
            let _ = writeln!(io::stderr(), "error: {error}");
            ExitCode::from(if error.is_input() { 2 } else { 3 })
        }
    }
}

/// What clap has to say: help as it is, an error in one line.
fn usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        // A closed stdout must not turn help into a panic.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    let text = error.render().to_string();
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let message: Vec<&str> = lines
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"))
        .collect();
    let _ = writeln!(io::stderr(), "{}; see --help", message.join("; "));
    ExitCode::from(2)
}
