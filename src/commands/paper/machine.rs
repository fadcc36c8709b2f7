//! The machine that measurements are made on.

use std::fmt;

/// What its times depend on.
pub struct Machine {
    /// Its processor, as the system calls it.
    pub processor: String,
    /// Its memory (bytes); 0 if the system does not tell.
    pub memory: f64,
    /// Cores that the measurements use.
    pub threads: usize,
}

impl Machine {
    /// This machine.
    pub fn here(threads: usize) -> Machine {
        let read = |path| std::fs::read_to_string(path).unwrap_or_default();
        let processors = read("/proc/cpuinfo");
        let processor = value(&processors, "model name").unwrap_or("unknown processor");
        let memory = read("/proc/meminfo");
        let memory = value(&memory, "MemTotal").and_then(|v| v.strip_suffix("kB"));
        Machine {
            processor: processor.to_owned(),
            memory: memory.and_then(|v| v.trim().parse().ok()).map_or(0.0, |kb: f64| kb * 1024.0),
            threads,
        }
    }
}

/// What stands behind a key and a colon.
fn value<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let line = text.lines().find(|line| line.starts_with(key))?;
    line.split_once(':').map(|(_, value)| value.trim())
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {}", self.threads, self.processor)
    }
}
