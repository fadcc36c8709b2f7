//! What contacts remember, carried over to a new neighbour list and into checkpoints.

use super::state::ContactHistory;

/// Histories that some of the entries of a block take over.
#[derive(Default)]
pub(super) struct Kept {
    /// Place of each entry.
    place: Vec<usize>,
    /// Their histories, one after the other.
    history: Vec<f64>,
}

impl Kept {
    pub fn clear(&mut self) {
        self.place.clear();
        self.history.clear();
    }

    pub fn push(&mut self, place: usize, history: &[f64]) {
        self.place.push(place);
        self.history.extend_from_slice(history);
    }

    /// Writes the histories to the entries from `start` on.
    pub fn put_back(&self, start: usize, touch: &mut [bool], history: &mut [f64], length: usize) {
        for (k, place) in self.place.iter().enumerate() {
            let to = start + place;
            touch[to] = true;
            history[to * length..][..length].copy_from_slice(&self.history[k * length..][..length]);
        }
    }
}

/// Calls `found` with the places in `old` and `new`, both sorted, of the
/// entries that they share and that touched.
pub(super) fn merge<T: Ord>(
    old: &[T],
    touched: &[bool],
    new: &[T],
    mut found: impl FnMut(usize, usize),
) {
    let mut b = 0;
    for (a, entry) in old.iter().enumerate().filter(|(a, _)| touched[*a]) {
        while b < new.len() && new[b] < *entry {
            b += 1;
        }
        if b < new.len() && new[b] == *entry {
            found(a, b);
        }
    }
}

/// The entries within reach, and their histories.
pub(super) fn history_of<T: Copy>(
    entries: &[T],
    touch: &[bool],
    history: &[f64],
    length: usize,
) -> ContactHistory<T> {
    let within = || (0..entries.len()).filter(|&k| touch[k]);
    ContactHistory {
        bodies: within().map(|k| entries[k]).collect(),
        numbers: within().flat_map(|k| &history[k * length..][..length]).copied().collect(),
    }
}
