//! The memory of the process, as counted by its allocator and by the operating system.

use std::alloc::{GlobalAlloc, Layout, System};
use std::fmt;
use std::sync::atomic::{AtomicUsize, Ordering};

static ALLOCATED: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator with a count of the allocated bytes.
struct CountingAllocator;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATED.fetch_add(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller fulfils the requirements.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        ALLOCATED.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller fulfils the requirements.
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// Peak memory early in the run and after that.
#[derive(Debug, Default)]
pub struct Memory {
    early: Peak,
    later: Peak,
}

#[derive(Clone, Copy, Debug, Default)]
struct Peak {
    allocated: usize,
    /// 0 where the operating system is not queried.
    process: usize,
}

/// Share of the run that counts as early.
const EARLY: f64 = 0.1;

impl Memory {
    /// Samples the memory when this share of the run is over.
    pub fn look(&mut self, share: f64) {
        let peak = if share < EARLY { &mut self.early } else { &mut self.later };
        peak.allocated = peak.allocated.max(ALLOCATED.load(Ordering::Relaxed));
        peak.process = peak.process.max(process());
    }

    /// Fails when memory has grown by more than these bytes after the early part.
    pub fn check(&self, allocated: usize, process: usize) {
        assert!(self.early.allocated > 0, "the run was too short to look");
        assert!(self.later.allocated < self.early.allocated + allocated, "{self}");
        assert!(self.later.process <= self.early.process + process, "{self}");
    }
}

impl fmt::Display for Memory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kib = |bytes: usize| bytes / 1024;
        let Self { early, later } = self;
        write!(
            f,
            "memory: allocated at most {} KiB in the first tenth and {} KiB later; the process {} KiB \
             and {} KiB",
            kib(early.allocated),
            kib(later.allocated),
            kib(early.process),
            kib(later.process)
        )
    }
}

/// Resident memory of this process, bytes; 0 where there is no `/proc`.
fn process() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<usize>().ok());
    kib.map_or(0, |kib| kib * 1024)
}
