//! What a person sees while a command works: bars on stderr, none when it is piped; warnings;
//! errors.

use std::io::{IsTerminal, Write};
use std::sync::{Arc, Mutex, PoisonError};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::error::Error;
use crate::progress::Event;

/// The bar and the warnings of one run; clones share them.
#[derive(Clone)]
pub struct Terminal {
    quiet: bool,
    bar: ProgressBar,
    warnings: Arc<Mutex<Vec<String>>>,
}

impl Terminal {
    /// Bars show when stderr is a terminal and nobody asked for quiet.
    pub fn new(quiet: bool) -> Self {
        let visible = !quiet && std::io::stderr().is_terminal();
        let target = if visible {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        Self {
            quiet,
            bar: ProgressBar::with_draw_target(None, target),
            warnings: Arc::default(),
        }
    }

    /// Draws an event.
    pub fn show(&self, event: Event) {
        match event {
            Event::Begin { stage, total } => {
                self.bar.reset();
                self.bar.set_style(style(total));
                self.bar.set_length(total);
                self.bar.set_message(stage);
            }
            Event::Advance(units) => self.bar.inc(units),
            Event::End => self.bar.set_message(""),
            Event::Warn(text) => self.warn(text),
        }
    }

    fn warn(&self, text: String) {
        if !self.quiet {
            self.bar.suspend(|| {
                let _ = writeln!(std::io::stderr(), "warning: {text}");
            });
        }
        let mut warnings = self.warnings.lock().unwrap_or_else(PoisonError::into_inner);
        warnings.push(text);
    }

    /// Takes the bar away.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }

    /// Everything warned of so far.
    pub fn warnings(&self) -> Vec<String> {
        let warnings = self.warnings.lock().unwrap_or_else(PoisonError::into_inner);
        warnings.clone()
    }
}

fn style(total: u64) -> ProgressStyle {
    let template = if total == 0 {
        "{spinner} {msg} {elapsed}"
    } else {
        "{msg:28} [{bar:30}] {pos}/{len} {eta}"
    };
    ProgressStyle::with_template(template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ")
}

/// Prints an error on stderr.
pub fn print_error(error: &Error) {
    let _ = writeln!(std::io::stderr(), "error: {error}");
}

/// Prints on stderr what stopped a run and how to go on.
pub fn print_interruption(signal: &str, hint: &str) {
    let _ = writeln!(
        std::io::stderr(),
        "error: interrupted by {signal}\n  hint: {hint}"
    );
}
