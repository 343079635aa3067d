//! Limits on one execution: memory, by an allocator that counts; time, by a thread that ends the
//! process and keeps the file.

use std::alloc::{GlobalAlloc, Layout, System};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// Bytes that one file may make a reader hold at once.
pub const MOST_MEMORY: usize = 512 << 20;
/// Seconds that one file may take.
pub const MOST_SECONDS: u64 = 5;
/// A single request this large is refused, which ends the process: no memory is put at risk.
const HOPELESS: usize = 8 << 30;

static HELD: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator, counting.
pub struct Counting;

fn grow(bytes: usize) {
    let held = HELD.fetch_add(bytes, Ordering::Relaxed) + bytes;
    PEAK.fetch_max(held, Ordering::Relaxed);
}

// Sound: every request goes to the system's allocator unchanged, or is refused with null.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if layout.size() > HOPELESS {
            return std::ptr::null_mut();
        }
        grow(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if layout.size() > HOPELESS {
            return std::ptr::null_mut();
        }
        grow(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if size > HOPELESS {
            return std::ptr::null_mut();
        }
        grow(size);
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// The execution under way.
struct Running {
    name: String,
    file: PathBuf,
    keep: PathBuf,
    begun: Instant,
}

/// Watches one execution after the other.
pub struct Watch {
    running: Arc<Mutex<Option<Running>>>,
    held: AtomicUsize,
}

impl Watch {
    /// Starts the thread that looks at the clock.
    pub fn start() -> Self {
        let running = Arc::new(Mutex::new(None::<Running>));
        let watched = Arc::clone(&running);
        thread::spawn(move || {
            loop {
                thread::sleep(Duration::from_millis(250));
                let late = |r: &Running| r.begun.elapsed() > Duration::from_secs(MOST_SECONDS);
                if let Some(running) = watched.lock().unwrap().as_ref().filter(|r| late(r)) {
                    let _ = fs::copy(&running.file, &running.keep);
                    let (name, keep) = (&running.name, running.keep.display());
                    let line = format!(
                        "{name}: still at it after {MOST_SECONDS} s; the file is kept as {keep}"
                    );
                    let _ = writeln!(std::io::stderr(), "{line}");
                    std::process::abort();
                }
            }
        });
        Self {
            running,
            held: AtomicUsize::new(0),
        }
    }

    /// An execution begins: `file` is read, and kept as `keep` if it takes too long.
    pub fn begin(&self, name: &str, file: &Path, keep: &Path) {
        *self.running.lock().unwrap() = Some(Running {
            name: name.into(),
            file: file.into(),
            keep: keep.into(),
            begun: Instant::now(),
        });
        let held = HELD.load(Ordering::Relaxed);
        self.held.store(held, Ordering::Relaxed);
        PEAK.store(held, Ordering::Relaxed);
    }

    /// The execution ended; the bytes it held at most.
    pub fn end(&self) -> usize {
        *self.running.lock().unwrap() = None;
        PEAK.load(Ordering::Relaxed)
            .saturating_sub(self.held.load(Ordering::Relaxed))
    }
}
