//! A panic inside a reader becomes an error that names the file.
//!
//! Decoders of other crates meet files nobody tried them on, and some of them panic. Every door of
//! [`format`](crate::format), and every reader elsewhere that calls a decoder, runs inside [`guarded`]. Not handled:
//! what unwinding cannot catch, such as a stack overflow or a panic in a thread that a decoder starts itself.
//! Decoders are therefore configured to start none.
//!
//! The standard panic hook prints, and the library must not. [`silence`] puts a hook in place that
//! says nothing about panics of threads that are inside a guard, and keeps where they happened for
//! the error; all other panics go to the hook that was there before. The program calls it once, at
//! its start; a program that uses the library chooses for itself.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook, take_hook};
use std::path::Path;
use std::sync::Once;

use crate::error::{Error, Result};

/// The place of every error that a guard makes of a panic.
pub const PLACE: &str = "reader";

thread_local! {
    /// Guards this thread is inside of.
    static DEPTH: Cell<u32> = const { Cell::new(0) };
    /// Where the last guarded panic happened.
    static ORIGIN: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Runs a reader of `path`; its panic becomes an error, and every fault of data names the file.
pub fn guarded<T>(path: &Path, read: impl FnOnce() -> Result<T>) -> Result<T> {
    let inside = Inside::enter();
    // Unwind safe: what the reader builds is dropped with it. What it borrows is read only, or is an
    // open file whose owner ends with the error.
    let result = catch_unwind(AssertUnwindSafe(read));
    drop(inside);
    result
        .unwrap_or_else(|payload| Err(fault(&*payload)))
        .map_err(|error| error.in_file(path))
}

/// Marks a thread as inside a guard for as long as it lives.
struct Inside;

impl Inside {
    fn enter() -> Self {
        DEPTH.set(DEPTH.get() + 1);
        Self
    }
}

impl Drop for Inside {
    fn drop(&mut self) {
        DEPTH.set(DEPTH.get() - 1);
    }
}

fn fault(payload: &(dyn Any + Send)) -> Error {
    let said = payload
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message");
    let origin = ORIGIN.take();
    let at = match origin.as_str() {
        "" => String::new(),
        origin => format!(" ({origin})"),
    };
    Error::data(PLACE, format!("it failed: {said}{at}"))
        .expected("a sound file")
        .advice("the file is damaged, or holds what its reader cannot take; write it again")
}

/// Lets guarded panics pass in silence, from now on and in all threads; calling it again does nothing.
pub fn silence() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |panic| match DEPTH.get() {
            0 => before(panic),
            _ => ORIGIN.set(origin(panic)),
        }));
    });
}

/// The source line of a panic, from the name of its crate on.
fn origin(panic: &PanicHookInfo<'_>) -> String {
    let Some(location) = panic.location() else {
        return String::new();
    };
    let file = location.file();
    let file = file
        .split_once("/registry/src/")
        .and_then(|(_, file)| file.split_once('/'))
        .map_or(file, |(_, file)| file);
    format!("{file}:{}", location.line())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    #[test]
    fn a_panic_becomes_an_error_that_names_the_file() {
        silence();
        let error = guarded::<()>(Path::new("a.png"), || panic!("no {}", "palette"));
        let text = error.unwrap_err().to_string();
        assert!(
            text.starts_with("a.png: reader: it failed: no palette (src"),
            "{text}"
        );
        assert!(text.contains("guard.rs:"), "{text}");
        assert_eq!(guarded(Path::new("a.png"), || Ok(7)).unwrap(), 7);
        assert_eq!(DEPTH.get(), 0);
    }

    #[test]
    fn guards_hold_in_threads_of_the_pool() {
        silence();
        let refused = (0..64).into_par_iter().map(|file| {
            let path = format!("{file}.png");
            guarded::<()>(Path::new(&path), || panic!("{file}"))
                .unwrap_err()
                .to_string()
                .starts_with(&path)
        });
        assert!(refused.collect::<Vec<_>>().iter().all(|&named| named));
    }
}
