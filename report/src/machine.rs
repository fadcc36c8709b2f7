//! The machine and the day, for reports.

use std::fs;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use super::format::bytes;

/// Processor, cores, memory and kernel, in words; what the system does not tell is left
/// out.
pub fn description() -> String {
    let cores = std::thread::available_parallelism().ok();
    // The version, without what its builder has added.
    let kernel = read("/proc/sys/kernel/osrelease");
    let kernel = kernel.split(|c: char| !c.is_ascii_digit() && c != '.').next().unwrap_or("");
    [
        processor(),
        cores.map(|n| if n.get() == 1 { "1 core".to_owned() } else { format!("{n} cores") }),
        memory().map(|size| format!("{} of memory", bytes(size))),
        after(&read("/etc/os-release"), "PRETTY_NAME=").map(|name| name.replace('"', "")),
        Some(format!("Linux {kernel}")).filter(|_| !kernel.is_empty()),
    ]
    .into_iter()
    .flatten()
    .collect::<Vec<_>>()
    .join(", ")
}

/// How many cores other programs keep busy: the mean over a time in which this one sleeps.
/// `None` where the system does not tell.
pub fn busy_cores(over: Duration) -> Option<f64> {
    let cores = std::thread::available_parallelism().ok()?.get();
    let before = busy_share(&fs::read_to_string("/proc/stat").ok()?)?;
    std::thread::sleep(over);
    let after = busy_share(&fs::read_to_string("/proc/stat").ok()?)?;
    let [busy, all] = [after[0] - before[0], after[1] - before[1]];
    (all > 0.0).then(|| busy / all * cores as f64)
}

/// Ticks of all cores that were busy, and of all, from /proc/stat.
fn busy_share(stat: &str) -> Option<[f64; 2]> {
    // user, nice, system, idle, waiting for a device, interrupts, ..., stolen; guests are
    // counted in user already.
    let ticks: Vec<f64> = stat
        .lines()
        .next()?
        .strip_prefix("cpu ")?
        .split_whitespace()
        .take(8)
        .map_while(|word| word.parse().ok())
        .collect();
    let all: f64 = ticks.iter().sum();
    Some([all - ticks.get(3)? - ticks.get(4)?, all])
}

/// The processor, as the system calls it.
pub fn processor() -> Option<String> {
    after(&read("/proc/cpuinfo"), "model name")
}

/// Size of the memory (bytes).
pub fn memory() -> Option<f64> {
    let size = after(&read("/proc/meminfo"), "MemTotal")?;
    Some(1024.0 * size.strip_suffix("kB")?.trim().parse::<f64>().ok()?)
}

fn read(path: &str) -> String {
    fs::read_to_string(path).unwrap_or_default()
}

/// What stands behind a key, on the first line that begins with it.
fn after(text: &str, key: &str) -> Option<String> {
    let rest = text.lines().find_map(|line| line.strip_prefix(key))?;
    Some(rest.trim_start_matches([' ', '\t', ':']).trim().to_owned())
}

/// Key of the most memory that a process has held.
pub const PEAK: &str = "VmHWM:";
/// Key of the memory that a process holds.
pub const HELD: &str = "VmRSS:";

/// Memory of this process by one of the system's keys, in bytes.
pub fn own_memory(key: &str) -> Option<u64> {
    let size = after(&fs::read_to_string("/proc/self/status").ok()?, key)?;
    Some(size.strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}

/// From here on the most memory that this process has held is that of what follows; where
/// the system refuses, it stays.
pub fn forget_peak() {
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// Today in UTC, as in 2026-11-22.
pub fn today() -> String {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let (year, month, day) = date(now.as_secs() / 86_400);
    format!("{year}-{month:02}-{day:02}")
}

/// Year, month and day, so many days after 1970-01-01.
fn date(mut days: u64) -> (u64, usize, u64) {
    let is_leap = |y: u64| y.is_multiple_of(4) && (!y.is_multiple_of(100) || y.is_multiple_of(400));
    let mut year = 1970;
    while days >= 365 + u64::from(is_leap(year)) {
        days -= 365 + u64::from(is_leap(year));
        year += 1;
    }
    let february = 28 + u64::from(is_leap(year));
    let mut month = 1;
    for length in [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31] {
        if days < length {
            break;
        }
        days -= length;
        month += 1;
    }
    (year, month, days + 1)
}

#[cfg(test)]
mod tests {
    use super::{busy_share, date};

    /// The first line is that of all cores: 10 + 1 + 5 + 0 + 2 + 0 + 4 ticks busy of 60.
    #[test]
    fn busy_ticks_are_told_from_idle_ones() {
        let stat = "cpu  10 1 5 30 8 0 2 4 3 0\ncpu0 1 2 3 4 5 6 7 8 9 0\n";
        assert_eq!(busy_share(stat), Some([22.0, 60.0]));
        assert_eq!(busy_share("cpu 1 2"), None);
        assert_eq!(busy_share(""), None);
    }

    /// Days from `date -u -d 2024-02-29 +%s` and the like, over 86,400.
    #[test]
    fn days_become_dates() {
        assert_eq!(date(0), (1970, 1, 1));
        assert_eq!(date(11_016), (2000, 2, 29));
        assert_eq!(date(19_782), (2024, 2, 29));
        assert_eq!(date(19_783), (2024, 3, 1));
        assert_eq!(date(20_453), (2025, 12, 31));
        assert_eq!(date(20_454), (2026, 1, 1));
    }
}
