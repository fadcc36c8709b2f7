//! What times depend on, beside the libraries.

use std::fmt;

use dempfv_report::machine;

/// The machine that measurements are made on.
pub struct Machine {
    /// Its processor, as the system calls it.
    processor: String,
    /// Its memory (bytes), if the system tells.
    pub memory: Option<f64>,
    /// Cores that the measurements use.
    pub threads: usize,
}

impl Machine {
    /// This machine.
    pub fn here(threads: usize) -> Machine {
        let processor = machine::processor().unwrap_or_else(|| "an unknown processor".to_owned());
        Machine { processor, memory: machine::memory(), threads }
    }

    /// A machine with so many cores and so much memory (bytes).
    #[cfg(test)]
    pub fn with(threads: usize, memory: f64) -> Machine {
        Machine { processor: String::new(), memory: Some(memory), threads }
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cores = if self.threads == 1 { "1 core" } else { &format!("{} cores", self.threads) };
        write!(f, "{cores} of {}", self.processor)
    }
}
