//! An error message when memory runs out.
//!
//! Rust aborts where an allocation fails: without our exit code, and without a message to those who wait for
//! a render in a queue. Files are replaced only when they are complete, so there is nothing to save, and the
//! process can end at once; a `.partial` may stay behind. Code that would have handled the failure itself
//! (`try_reserve`, which reads of whole files use) ends here too, without the name of the file.

use std::alloc::{GlobalAlloc, Layout, System};

/// The system's allocator; if it fails, the process ends with [`BAD_INPUT`](crate::cli::BAD_INPUT).
pub struct Telling;

// SAFETY: every call is handed to the system's allocator as it came, and what that returns is returned.
unsafe impl GlobalAlloc for Telling {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promises are those of the same function of `System`.
        checked(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        checked(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above.
        checked(unsafe { System.realloc(pointer, layout, size) }, size)
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

fn checked(pointer: *mut u8, size: usize) -> *mut u8 {
    if pointer.is_null() {
        // Neither needs memory of its own.
        eprintln!("error: out of memory: {size} bytes more are not to be had");
        std::process::exit(i32::from(crate::cli::BAD_INPUT));
    }
    pointer
}
