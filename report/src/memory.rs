//! How much memory this process may still take.

use std::fs;
use std::path::Path;

/// Memory that is left, by what bounds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// Bytes.
    pub bytes: f64,
    /// What bounds it, in words.
    pub bound: &'static str,
}

/// The smallest of what the machine has left, what `ulimit -v` leaves, and the limits of the
/// control groups that this process is in. `None` where the system does not tell.
pub fn room() -> Option<Room> {
    let groups = control_groups(&read("/proc/self/cgroup"));
    [
        free(&read("/proc/meminfo")),
        address_space(&read("/proc/self/limits"), &read("/proc/self/status")),
    ]
    .into_iter()
    .chain(groups.iter().map(|file| group_limit(&read(file))))
    .flatten()
    .min_by(|a, b| a.bytes.total_cmp(&b.bytes))
}

fn read(path: impl AsRef<Path>) -> String {
    fs::read_to_string(path).unwrap_or_default()
}

/// Free memory and what can be freed at once, with the swap space.
fn free(meminfo: &str) -> Option<Room> {
    let bytes = kilobytes(meminfo, "MemAvailable:")? + kilobytes(meminfo, "SwapFree:")?;
    Some(Room { bytes, bound: "free on this machine" })
}

fn address_space(limits: &str, status: &str) -> Option<Room> {
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: f64 = line.split_whitespace().next()?.parse().ok()?;
    let bytes = (limit - kilobytes(status, "VmSize:")?).max(0.0);
    Some(Room { bytes, bound: "left by ulimit -v" })
}

/// The limit of a group; what its processes hold already is not taken off, since most of that is
/// files that can be dropped.
fn group_limit(text: &str) -> Option<Room> {
    Some(Room { bytes: text.trim().parse().ok()?, bound: "allowed by the control group" })
}

/// Files with the limits of the groups that hold a process, and of those above them.
fn control_groups(cgroup: &str) -> Vec<String> {
    let mut files = vec![];
    for line in cgroup.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (parts.next(), parts.next()) else { continue };
        let (root, file) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            "memory" => ("/sys/fs/cgroup/memory", "memory.limit_in_bytes"),
            _ => continue,
        };
        let above = Path::new(path).ancestors().filter_map(Path::to_str);
        files.extend(above.map(|path| format!("{root}{}/{file}", path.trim_end_matches('/'))));
    }
    files
}

fn kilobytes(text: &str, key: &str) -> Option<f64> {
    let rest = text.lines().find_map(|line| line.strip_prefix(key))?;
    Some(1024.0 * rest.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_as_the_kernel_writes_them() {
        let meminfo = "MemTotal: 24 kB\nMemAvailable:   16 kB\nSwapFree:  4 kB\n";
        assert_eq!(free(meminfo).unwrap().bytes, 20.0 * 1024.0);
        let limits = "Max address space         307200000            unlimited            bytes\n";
        let left = address_space(limits, "VmSize:\t  200000 kB\n").unwrap();
        assert_eq!(left.bytes, 102_400_000.0);
        let unlimited =
            "Max address space         unlimited            unlimited            bytes\n";
        assert_eq!(address_space(unlimited, "VmSize:\t  200000 kB\n"), None);
        assert_eq!(group_limit("1073741824\n").unwrap().bytes, 1_073_741_824.0);
        assert_eq!(group_limit("max\n"), None);
    }

    #[test]
    fn groups_are_found_with_those_above_them() {
        assert_eq!(
            control_groups("0::/user/run\n"),
            [
                "/sys/fs/cgroup/user/run/memory.max",
                "/sys/fs/cgroup/user/memory.max",
                "/sys/fs/cgroup/memory.max"
            ]
        );
        let first = "8:pids:/\n4:memory:/\n1:name=systemd:/\n";
        assert_eq!(control_groups(first), ["/sys/fs/cgroup/memory/memory.limit_in_bytes"]);
    }
}
