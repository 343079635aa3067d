//! What the terminal shows while a command works: bars on stderr, none when it is piped; with `--verbose` a line per
//! stage; warnings; errors. Colours are for terminals only, and none where `NO_COLOR` is set.

use std::io::{IsTerminal, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use clap::builder::styling::{AnsiColor, Style};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::Value;

use crate::progress::Event;

/// The bar and the warnings of one run; clones share them.
#[derive(Clone)]
pub struct Terminal {
    quiet: bool,
    verbose: bool,
    bar: ProgressBar,
    /// The stage that runs, and since when.
    stage: Arc<Mutex<Option<(String, Instant)>>>,
    warnings: Arc<Mutex<Vec<String>>>,
}

impl Terminal {
    /// Bars show when stderr is a terminal and nobody asked for quiet.
    pub fn new(quiet: bool, verbose: bool) -> Self {
        let visible = !quiet && std::io::stderr().is_terminal();
        let target = if visible {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        Self {
            quiet,
            verbose,
            stage: Arc::default(),
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
                self.bar.set_message(stage.clone());
                *self.running() = Some((stage, Instant::now()));
            }
            Event::Advance(units) => self.bar.inc(units),
            Event::End => {
                self.bar.set_message("");
                self.tell_stage();
            }
            Event::Warn(text) => self.warn(text),
        }
    }

    fn running(&self) -> MutexGuard<'_, Option<(String, Instant)>> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Says how long the stage took that has ended.
    fn tell_stage(&self) {
        let Some((stage, start)) = self.running().take() else {
            return;
        };
        if self.verbose {
            let seconds = start.elapsed().as_secs_f64();
            self.bar.suspend(|| {
                let _ = writeln!(std::io::stderr(), "{stage}: {seconds:.2} s");
            });
        }
    }

    fn warn(&self, text: String) {
        if !self.quiet {
            self.bar.suspend(|| {
                let _ = writeln!(anstream::stderr(), "{CAUTION}warning:{CAUTION:#} {text}");
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

/// Red and bold, where the terminal shows it and nobody asked for none (`NO_COLOR`).
const ALARM: Style = AnsiColor::Red.on_default().bold();
/// The same for warnings.
const CAUTION: Style = AnsiColor::Yellow.on_default().bold();

/// Prints an error on stderr.
pub fn print_error(says: &str) {
    let _ = writeln!(anstream::stderr(), "{ALARM}error:{ALARM:#} {says}");
}

/// Prints a report of a failed run on stdout, for a program.
pub fn print_report(report: &Value) {
    let _ = writeln!(std::io::stdout(), "{report:#}");
}

/// Prints the help or the version that was asked for, or what the parser itself says.
pub fn print_help(message: &clap::Error) {
    let _ = message.print();
}

/// Prints on stderr what stopped a run and how to continue.
pub fn print_interruption(signal: &str, hint: &str) {
    print_error(&format!("interrupted by {signal}\n  hint: {hint}"));
}
