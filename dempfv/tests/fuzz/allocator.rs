//! The largest allocation of each input: a header must not blow it up.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// From here on the system may refuse, and that ends the program: told while it can be.
const ABSURD: usize = 1 << 36;

thread_local! {
    static LARGEST: Cell<usize> = const { Cell::new(0) };
}

struct Watched;

#[global_allocator]
static WATCHED: Watched = Watched;

fn note(size: usize) {
    // At the end of a thread there may be no cell any more.
    let _ = LARGEST.try_with(|largest| largest.set(largest.get().max(size)));
    if size > ABSURD {
        eprintln!("an input asks for {size} bytes: {}", super::harness::current());
    }
}

// SAFETY: all is handed to the system's allocator as it came.
unsafe impl GlobalAlloc for Watched {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note(layout.size());
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        note(layout.size());
        // SAFETY: the caller's promise.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note(size);
        // SAFETY: the caller's promise.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// The largest allocation of this thread since this was called last (bytes).
pub fn largest() -> usize {
    LARGEST.with(|largest| largest.replace(0))
}
