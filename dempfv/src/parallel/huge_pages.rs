//! Huge pages of memory for what is read as a whole again and again.

/// Asks the system to keep this memory in pages of 2 MiB, as far as it is made of whole ones
/// and not touched yet: a processor that reads hundreds of megabytes in a row then looks up
/// few pages. A system that has none keeps the memory as it is.
pub fn advise_huge_pages<T>(memory: &[T]) {
    #[cfg(target_os = "linux")]
    {
        let std::ops::Range { start, end } = memory.as_ptr_range();
        let start = (start as usize).next_multiple_of(HUGE_PAGE_BYTES);
        let len = (end as usize).saturating_sub(start) / HUGE_PAGE_BYTES * HUGE_PAGE_BYTES;
        if len > 0 {
            let start = std::ptr::with_exposed_provenance_mut(start);
            // SAFETY: the range lies in memory that is borrowed here, and the call changes
            // nothing of what is in it.
            unsafe { libc::madvise(start, len, libc::MADV_HUGEPAGE) };
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = memory;
}

/// Bytes of a huge page.
#[cfg(target_os = "linux")]
const HUGE_PAGE_BYTES: usize = 2 << 20;
