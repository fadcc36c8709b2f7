//! The program `dempfv`: arguments in, results and exit status out.
//!
//! Exit status: 0 done; 2 the input is wrong (one message, nothing written); 3 the
//! simulation cannot go on.
#![warn(missing_docs)]

mod commands;
mod report;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::Parser;
use commands::{Cli, Context};

fn main() -> ExitCode {
    let cli = Cli::parse();
    let result =
        Context::new(&cli.options).and_then(|context| commands::execute(cli.command, &context));
    match result {
        Ok(status) => status,
        Err(error) => {
            // A closed stderr must not turn an error into a panic.
            let _ = writeln!(io::stderr(), "error: {error}");
            ExitCode::from(if error.is_input() { 2 } else { 3 })
        }
    }
}
