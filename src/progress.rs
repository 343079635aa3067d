//! Progress and cancellation of long work: the caller receives events and may ask to stop.
//!
//! The library never prints: it calls back with [`Event`]s, and the command line draws bars.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::{Error, Result};

/// What a step reports while it works.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// A stage begins; `total` units of work will follow (0: unknown).
    Begin {
        /// What the user reads, as "filter bank".
        stage: String,
        /// Units of work in all.
        total: u64,
    },
    /// So many more units are done.
    Advance(u64),
    /// The stage is over.
    End,
    /// Something the user should know before hours of work are wasted.
    Warn(String),
}

/// Receives [`Event`]s and carries the stop flag.
#[derive(Clone, Copy)]
pub struct Progress<'a> {
    listener: &'a (dyn Fn(Event) + Sync),
    interrupted: Option<&'a AtomicBool>,
}

impl<'a> Progress<'a> {
    /// Reports to `listener`; stops with [`Error::Interrupted`] once `interrupted` is set.
    pub fn new(listener: &'a (dyn Fn(Event) + Sync), interrupted: Option<&'a AtomicBool>) -> Self {
        Self {
            listener,
            interrupted,
        }
    }

    /// Discards all events and never stops.
    pub fn silent() -> Progress<'static> {
        Progress {
            listener: &|_| {},
            interrupted: None,
        }
    }

    /// A stage of `total` units begins.
    pub fn begin(&self, stage: impl Into<String>, total: u64) {
        (self.listener)(Event::Begin {
            stage: stage.into(),
            total,
        });
    }

    /// `units` more are done; fails when the caller asked to stop.
    pub fn advance(&self, units: u64) -> Result<()> {
        (self.listener)(Event::Advance(units));
        self.check()
    }

    /// The stage is over.
    pub fn end(&self) {
        (self.listener)(Event::End);
    }

    /// Tells the user something that does not stop the work.
    pub fn warn(&self, text: impl Into<String>) {
        (self.listener)(Event::Warn(text.into()));
    }

    /// Fails with [`Error::Interrupted`] when the caller asked to stop.
    #[inline]
    pub fn check(&self) -> Result<()> {
        match self.is_interrupted() {
            true => Err(Error::Interrupted),
            false => Ok(()),
        }
    }

    /// Whether the caller asked to stop. For loops that cannot fail: they leave off, and whoever
    /// called them throws away what they made and asks [`check`](Self::check).
    #[inline]
    pub fn is_interrupted(&self) -> bool {
        self.interrupted
            .is_some_and(|flag| flag.load(Ordering::Relaxed))
    }
}
