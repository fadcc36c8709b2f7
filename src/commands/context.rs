//! What every subcommand gets: threads, where reports go, interruption, progress.

use std::fmt::Display;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use dempfv::io::atomic;
use dempfv::{Error, InputError};
use dempfv_report::json;
use dempfv_report::progress::Progress;
use serde::Serialize;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag;

use super::INTERRUPTED;

/// Options that every subcommand takes.
#[derive(clap::Args)]
pub struct Options {
    /// Threads to compute with; all cores if not given. Results do not depend on it
    #[arg(long, value_name = "N", global = true, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,

    /// Write the result as JSON to this file (replacing it), or `-` for stdout
    #[arg(long, value_name = "FILE", global = true)]
    pub json: Option<PathBuf>,
}

/// What a subcommand works with.
pub struct Context {
    /// Number of threads that share the work.
    pub threads: usize,
    json: Option<PathBuf>,
}

impl Context {
    /// Starts the threads.
    ///
    /// # Errors
    /// [`Error::Input`] when that many threads cannot be started, or the folder of the
    /// JSON file is not there: it is better known before the work than after.
    pub fn new(options: &Options) -> Result<Context, Error> {
        // Commands run on one of these threads: as much room as a program's first thread has.
        let mut pool = rayon::ThreadPoolBuilder::new().stack_size(8 << 20);
        if let Some(threads) = options.threads {
            pool = pool.num_threads(threads.into());
        }
        pool.build_global().map_err(|e| {
            InputError::new(format!("cannot start the threads: {e}"), "give a smaller --threads")
        })?;
        if let Some(path) = &options.json {
            check_folder(path)?;
        }
        Ok(Context { threads: rayon::current_num_threads(), json: options.json.clone() })
    }

    /// True when the report goes to a file or to stdout as JSON.
    pub fn has_json(&self) -> bool {
        self.json.is_some()
    }

    /// True when stdout belongs to the JSON report, and nothing else may be printed there.
    pub fn is_json_on_stdout(&self) -> bool {
        self.json.as_deref() == Some(Path::new("-"))
    }

    /// Hands out a report: as text on stdout and as JSON where `--json` says; as JSON
    /// alone for `--json -`.
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be written. A reader that closes the pipe early is no
    /// error.
    pub fn deliver<R: Display + Serialize>(&self, report: &R) -> Result<(), Error> {
        if let Some(path) = self.json.as_deref().filter(|_| !self.is_json_on_stdout()) {
            json::write(path, report)?;
        }
        let text = if self.is_json_on_stdout() { json::text(report)? } else { report.to_string() };
        let mut stdout = io::stdout().lock();
        match writeln!(stdout, "{}", text.trim_end()).and_then(|()| stdout.flush()) {
            Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(Error::io("stdout", e)),
            _ => Ok(()),
        }
    }

    /// Progress on stderr; silent when stderr is no terminal.
    pub fn progress(&self) -> Progress {
        Progress::new()
    }

    /// A flag that the first Ctrl-C (or SIGTERM) raises, for commands that then write what
    /// they have and stop; the second ends the program at once. Commands that do not ask
    /// for the flag end at the first. SIGHUP, of a terminal that closes, is taken like these
    /// unless it is ignored, as `nohup` has it.
    ///
    /// # Errors
    /// [`Error::Io`] when the system refuses the handler.
    pub fn interruption(&self) -> Result<Arc<AtomicBool>, Error> {
        let raised = Arc::new(AtomicBool::new(false));
        let hangup = (!ignores(SIGHUP)).then_some(SIGHUP);
        for signal in [SIGINT, SIGTERM].into_iter().chain(hangup) {
            // In this order: the second signal finds the flag that the first has raised.
            flag::register_conditional_shutdown(signal, INTERRUPTED.into(), Arc::clone(&raised))
                .and_then(|_| flag::register(signal, Arc::clone(&raised)))
                .map_err(|e| Error::io("signal handler", e))?;
        }
        Ok(raised)
    }
}

/// Whether this process was started with a signal ignored; false where the system does not tell.
fn ignores(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

fn check_folder(path: &Path) -> Result<(), InputError> {
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
    match folder {
        Some(folder) if !folder.is_dir() => Err(InputError::new(
            format!("--json {}: there is no folder {}", path.display(), folder.display()),
            "make the folder, or name another file",
        )),
        _ if path.is_dir() => Err(InputError::new(
            format!("--json {} is a folder", path.display()),
            "name a file in it",
        )),
        _ if *path == *"-" || path.exists() => Ok(()),
        // Better known before the work than after.
        _ => atomic::AtomicFile::create(path).map(drop).map_err(|e| {
            InputError::new(format!("--json: {e}"), "name a file in a folder that you may write to")
        }),
    }
}
