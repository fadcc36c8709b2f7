//! Asking for memory that is read soon.
//!
//! Processors find runs of memory by themselves, but within pages of 4 kB and with few lines
//! on their way at a time. Loops that read long runs once each ask ahead for themselves, in
//! step with what they read: asking for much at once holds up what is asked for already.

/// Has what lies so many entries ahead of these brought near.
#[inline(always)]
pub fn prefetch<T>(entries: &[T], ahead: isize) {
    #[cfg(target_arch = "x86_64")]
    for line in entries.chunks((64 / size_of::<T>()).max(1)) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every x86-64 has the instruction, and it may name any address: it reads
        // nothing.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(line.as_ptr().wrapping_offset(ahead).cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (entries, ahead);
}
