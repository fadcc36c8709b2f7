//! Runs many inputs through one function, and tells which of them it does not stand.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, Once};
use std::time::Duration;

use super::allocator;
use super::mutate::{Random, mutated};

/// Time for one input (s); the slowest takes well under one.
const PATIENCE: u64 = 30;
/// The most that an input may ask for in one piece (bytes): all of these are small.
const LARGEST: usize = 64 << 20;

/// What came of the inputs of a target.
#[derive(Debug, Default)]
pub struct Tally {
    pub accepted: u64,
    pub refused: u64,
}

thread_local! {
    /// What this thread is at: target and number of the input; no target in between.
    static CURRENT: Cell<(&'static str, u64)> = const { Cell::new(("", 0)) };
    /// Where the last panic was, and its message.
    static PANIC: RefCell<String> = const { RefCell::new(String::new()) };
}

/// What this thread is at, in words.
pub fn current() -> String {
    let (target, number) = CURRENT.get();
    format!("{target}, input {number}, seed {}", seed())
}

fn seed() -> u64 {
    environment("DEMPFV_SEED").unwrap_or(1)
}

fn environment(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// How many inputs a target gets: the environment's number times `share`, else a few.
pub fn inputs(few: u64, share: f64) -> u64 {
    environment("DEMPFV_INPUTS").map_or(few, |n| (n as f64 * share) as u64)
}

/// Mutations of `corpus`, `count` of them, each through `run`: `Ok` where it was taken, `Err`
/// where it was refused.
pub fn fuzz(
    target: &'static str,
    corpus: &[Vec<u8>],
    count: u64,
    run: impl Fn(&[u8]) -> Result<(), String>,
) {
    quiet_panics();
    let watchdog = Watchdog::new(target);
    let (mut tally, mut failures) = (Tally::default(), BTreeMap::new());
    for number in 0..count {
        let mut random = Random::new(seed() ^ number.wrapping_mul(0x9e37_79b9) ^ salt(target));
        let input = mutated(corpus, &mut random);
        watchdog.begin(number, &input);
        allocator::largest();
        CURRENT.set((target, number));
        let ended = panic::catch_unwind(AssertUnwindSafe(|| run(&input)));
        CURRENT.set(("", 0));
        let bytes = allocator::largest();
        let failure = match ended {
            Err(_) => Some(PANIC.take()),
            Ok(_) if bytes > LARGEST => Some(format!("an allocation of {bytes} bytes")),
            Ok(Ok(())) => {
                tally.accepted += 1;
                None
            }
            Ok(Err(_)) => {
                tally.refused += 1;
                None
            }
        };
        if let Some(why) = failure {
            failures.entry(why).or_insert_with(|| keep(target, number, &input));
        }
    }
    println!("fuzz: {target}: {count} inputs, {} taken, {} refused", tally.accepted, tally.refused);
    assert!(failures.is_empty(), "{target}: {failures:#?}");
    assert!(count < 100 || (tally.accepted > 0 && tally.refused > 0), "{target}: {tally:?}");
}

fn salt(target: &str) -> u64 {
    target.bytes().fold(7, |salt: u64, b| salt.wrapping_mul(31).wrapping_add(b.into()))
}

/// Keeps an input that did harm, for a look at it.
fn keep(target: &str, number: u64, input: &[u8]) -> PathBuf {
    let name = format!("fuzz-{}-{}-{number}", target.replace(' ', "-"), seed());
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, input).unwrap();
    path
}

/// Panics of inputs are caught and told at the end, by their place.
fn quiet_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| match CURRENT.get().0 {
            "" => before(info),
            _ => {
                PANIC.replace(info.to_string());
            }
        }));
    });
}

/// Ends the program when an input takes too long: a thread cannot be ended alone.
struct Watchdog {
    /// Number of the input, and the input.
    at: Arc<Mutex<(u64, Vec<u8>)>>,
    count: Arc<AtomicU64>,
}

impl Watchdog {
    fn new(target: &'static str) -> Watchdog {
        let at = Arc::new(Mutex::new((0, vec![])));
        let count = Arc::new(AtomicU64::new(0));
        let (seen, here) = (Arc::downgrade(&count), Arc::clone(&at));
        std::thread::spawn(move || {
            let mut last = (0, 0);
            while let Some(count) = seen.upgrade() {
                let now = count.load(Ordering::Relaxed);
                last = if last.0 == now { (now, last.1 + 1) } else { (now, 0) };
                if last.1 > PATIENCE {
                    let (number, input) = &*here.lock().unwrap();
                    let path = keep(target, *number, input);
                    eprintln!("{target}, input {number} hangs: {}", path.display());
                    std::process::abort();
                }
                drop(count);
                std::thread::sleep(Duration::from_secs(1));
            }
        });
        Watchdog { at, count }
    }

    fn begin(&self, number: u64, input: &[u8]) {
        let mut at = self.at.lock().unwrap();
        at.0 = number;
        at.1.clear();
        at.1.extend_from_slice(input);
        self.count.fetch_add(1, Ordering::Relaxed);
    }
}
