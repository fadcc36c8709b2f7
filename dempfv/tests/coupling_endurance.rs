//! Long runs and many short ones, with a background that is always busy: no
//! deadlock, no thread left behind, and no memory that grows.

mod common;
mod moving;

use std::sync::Mutex;
use std::thread;
use std::time::{Duration, Instant};

use dempfv::coupling::{Acceleration, RemeshMode};
use moving::{DT, course, every, mode, moving};

/// Memory and threads are the process's: one test at a time.
static ALONE: Mutex<()> = Mutex::new(());

/// A number from `/proc/self/status`: kilobytes of memory, or threads.
fn status(key: &str) -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = text.lines().find_map(|l| l.strip_prefix(key)).unwrap();
    line.trim_start_matches(':').split_whitespace().next().unwrap().parse().unwrap()
}

fn everything() -> Acceleration {
    Acceleration { parallel_tasks: true, ..mode(RemeshMode::Background) }
}

/// 10,000 steps that each take a network from the background and order the
/// next. A leak of one network in a hundred would be some 20 MB: a network of
/// 27 spheres holds 150 pores and 200 kB.
#[test]
fn ten_thousand_steps_with_a_busy_background() {
    let _alone = ALONE.lock().unwrap();
    let mut coupled = moving(3, every(1), everything());
    course(&mut coupled, 2_000, 0.1 * DT);
    let before = status("VmRSS");
    course(&mut coupled, 8_000, 0.1 * DT);
    let grown = status("VmRSS").saturating_sub(before);
    assert_eq!(coupled.remeshes(), 10_000);
    assert_eq!(coupled.remesh_counts().failures, 0);
    assert!(grown < 8_000, "{grown} kB more after 8,000 steps");
}

/// 200 simulations that end at every moment of the interval: before the
/// background has anything to do, while it works, and after.
#[test]
fn two_hundred_starts_and_ends() {
    let _alone = ALONE.lock().unwrap();
    let cycle = |k: usize| {
        let mut coupled = moving(3, every(6), everything());
        course(&mut coupled, 1 + k % 17, DT);
        if k.is_multiple_of(3) {
            coupled.drain();
        }
    };
    (0..20).for_each(cycle);
    settle();
    let (memory, threads) = (status("VmRSS"), status("Threads"));
    (0..200).for_each(cycle);
    settle();
    let grown = status("VmRSS").saturating_sub(memory);
    assert!(status("Threads") <= threads, "{} threads, before {threads}", status("Threads"));
    assert!(grown < 8_000, "{grown} kB more after 200 cycles");
}

/// Waits for the helpers of pools that were dropped: they end on their own,
/// soon after.
fn settle() {
    let start = Instant::now();
    let mut least = status("Threads");
    while start.elapsed() < Duration::from_millis(300) {
        thread::sleep(Duration::from_millis(20));
        least = least.min(status("Threads"));
    }
}
