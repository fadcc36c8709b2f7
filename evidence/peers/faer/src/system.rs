//! The file that holds a system: little-endian numbers of eight bytes each.

use std::fs;
use std::path::Path;

/// First number of such a file.
const MAGIC: u64 = 0x6465_6d70_6676_0001;

/// A symmetric matrix by the columns of its lower triangle, and a right-hand side.
pub struct System {
    pub n: usize,
    pub col_ptr: Vec<usize>,
    pub row_idx: Vec<usize>,
    pub values: Vec<f64>,
    pub rhs: Vec<f64>,
}

impl System {
    /// Reads what the program `dempfv` has written: magic number, n, number of entries;
    /// column pointers, rows, values; then for each unknown its right-hand side.
    pub fn read(path: &Path) -> Result<System, String> {
        let bytes = fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let mut numbers = bytes.chunks_exact(8).map(|c| {
            // Chunks of exactly eight.
            u64::from_le_bytes(c.try_into().unwrap_or_default())
        });
        let mut next = || numbers.next().ok_or_else(|| format!("{} ends early", path.display()));
        if next()? != MAGIC {
            return Err(format!("{} holds no system", path.display()));
        }
        let (n, entries) = (next()? as usize, next()? as usize);
        if bytes.len() < 8 * (4 + 2 * n + 2 * entries) {
            return Err(format!("{} ends early", path.display()));
        }
        let mut many = |count: usize| (0..count).map(|_| next()).collect::<Result<Vec<_>, _>>();
        let index = |v: Vec<u64>| v.into_iter().map(|i| i as usize).collect();
        let real = |v: Vec<u64>| v.into_iter().map(f64::from_bits).collect();
        Ok(System {
            n,
            col_ptr: index(many(n + 1)?),
            row_idx: index(many(entries)?),
            values: real(many(entries)?),
            rhs: real(many(n)?),
        })
    }
}
