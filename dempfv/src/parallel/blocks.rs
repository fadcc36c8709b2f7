//! Sharing work by blocks of a fixed number of particles.
//!
//! Blocks make the shape of every sum independent of the number of threads:
//! what belongs to a block is computed by one thread, in order.

use rayon::join;

/// Particles per block. Larger blocks have fewer contacts across their
/// borders, smaller ones share out better.
pub const BLOCK: usize = 512;

/// From this many blocks on, handing work to another thread pays.
const PARALLEL_FROM: usize = 5;

/// Number of blocks of `n` particles.
pub fn block_count(n: usize) -> usize {
    n.div_ceil(BLOCK)
}

/// Borrowed arrays of a run of blocks that can be cut between two blocks.
pub trait Span: Send + Sized {
    /// Number of blocks.
    fn blocks(&self) -> usize;
    /// The first `blocks` blocks, and the rest.
    fn split(self, blocks: usize) -> (Self, Self);
}

/// Runs `work` on all blocks of `span`, on several threads where that pays,
/// and merges what it returns. `merge` must be associative and commutative to
/// the last bit (a logical or, a maximum).
pub fn for_blocks<S: Span, R: Send>(
    span: S,
    work: &(impl Fn(S) -> R + Sync),
    merge: &(impl Fn(R, R) -> R + Sync),
) -> R {
    let blocks = span.blocks();
    let threads = rayon::current_num_threads();
    if blocks < PARALLEL_FROM || threads == 1 {
        return work(span);
    }
    // A few pieces per thread even out unequal blocks.
    halve(span, blocks.div_ceil(4 * threads), work, merge)
}

fn halve<S: Span, R: Send>(
    span: S,
    leaf: usize,
    work: &(impl Fn(S) -> R + Sync),
    merge: &(impl Fn(R, R) -> R + Sync),
) -> R {
    let blocks = span.blocks();
    if blocks <= leaf {
        return work(span);
    }
    let (left, right) = span.split(blocks / 2);
    let (a, b) = join(|| halve(left, leaf, work, merge), || halve(right, leaf, work, merge));
    merge(a, b)
}

/// Cuts a slice after `n` entries, or at its end where it is shorter.
pub fn cut<T>(slice: &[T], n: usize) -> (&[T], &[T]) {
    slice.split_at(n.min(slice.len()))
}

/// Cuts a mutable slice after `n` entries, or at its end where it is shorter.
pub fn cut_mut<T>(slice: &mut [T], n: usize) -> (&mut [T], &mut [T]) {
    let n = n.min(slice.len());
    slice.split_at_mut(n)
}
