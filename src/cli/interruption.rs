//! Signals that ask to stop: a flag for the stages, an exit code, and a bound on how long it takes.
//!
//! The first signal sets a flag. Stages test it and return [`Error::Interrupted`], removing their partial files on
//! the way. A thread watches: when the command has not returned after [`GRACE`], it ends the process itself. What
//! then remains on disk is what a kill leaves: hidden partial files, never a partial file under a final name. A
//! second signal ends the process at once.
//!
//! [`Error::Interrupted`]: crate::error::Error::Interrupted

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::low_level;

use crate::cli::terminal::Terminal;
use crate::error::{Error, Result};

/// How long a command may take to return after a signal. Promised are 2 s, exit of the process included.
const GRACE: Duration = Duration::from_millis(1000);
/// Signals this soon after the first count as the same: `timeout` and a closed terminal send two.
const SAME: Duration = Duration::from_millis(20);
/// How often the watching thread looks for a second signal.
const POLL: Duration = Duration::from_millis(20);
/// How long the message may take, when the watching thread ends the process.
const MESSAGE: Duration = Duration::from_millis(200);

/// Whether and by what a run was asked to stop; clones share it.
#[derive(Clone)]
pub struct Interruption {
    terminal: Terminal,
    /// What to type to continue.
    hint: &'static str,
    requested: Arc<AtomicBool>,
    /// The first signal; 0 before.
    signal: Arc<AtomicI32>,
    /// Set by whoever has the last word: the command or the watching thread.
    ended: Arc<AtomicBool>,
}

impl Interruption {
    /// Starts to listen for signals.
    pub fn listen(terminal: &Terminal, hint: &'static str) -> Result<Self> {
        let interruption = Self {
            terminal: terminal.clone(),
            hint,
            requested: Arc::default(),
            signal: Arc::default(),
            ended: Arc::default(),
        };
        let watched = interruption.clone();
        let signals = system::Signals::new().map_err(Error::io(Path::new("signals"), "handle"))?;
        thread::Builder::new()
            .name("signals".into())
            .spawn(move || watched.watch(signals))
            .map_err(Error::io(Path::new("signals"), "watch"))?;
        Ok(interruption)
    }

    /// Set once the run was asked to stop.
    pub fn flag(&self) -> &AtomicBool {
        &self.requested
    }

    /// The command returned and has the last word; waits for the process to end if it is too late.
    pub fn end(&self) {
        while self.ended.swap(true, Ordering::SeqCst) {
            thread::sleep(GRACE);
        }
    }

    /// Says what stopped the run and how to continue.
    pub fn tell(&self) {
        self.terminal.clear();
        let name = match self.signal.load(Ordering::SeqCst) {
            SIGINT => "SIGINT",
            SIGTERM => "SIGTERM",
            _ => "SIGHUP",
        };
        super::terminal::print_interruption(name, self.hint);
    }

    /// The exit code of a run that a signal stopped, by the convention of shells.
    pub fn exit_code(&self) -> u8 {
        exit_code(self.signal.load(Ordering::SeqCst))
    }

    fn watch(&self, mut signals: system::Signals) {
        let first = signals.wait();
        self.signal.store(first, Ordering::SeqCst);
        self.requested.store(true, Ordering::SeqCst);
        let begun = Instant::now();
        thread::sleep(SAME);
        signals.next();
        loop {
            if let Some(second) = signals.next() {
                low_level::exit(exit_code(second).into());
            }
            if begun.elapsed() >= GRACE && !self.ended.swap(true, Ordering::SeqCst) {
                self.end_process();
            }
            thread::sleep(POLL);
        }
    }

    /// Ends the process in place of a command that does not return. The message is written by another
    /// thread, as a stage may hold the terminal.
    fn end_process(&self) {
        let speaker = self.clone();
        let (told, wait) = mpsc::channel();
        let speak = move || {
            speaker.tell();
            let _ = told.send(());
        };
        if thread::Builder::new().spawn(speak).is_ok() {
            let _ = wait.recv_timeout(MESSAGE);
        }
        low_level::exit(self.exit_code().into());
    }
}

fn exit_code(signal: i32) -> u8 {
    128 + (signal & 0x7f) as u8
}

#[cfg(unix)]
mod system {
    //! Signals as Unix has them.

    use std::io;

    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator;

    /// SIGINT, SIGTERM and, unless it was ignored at the start (`nohup`), SIGHUP.
    pub struct Signals(iterator::Signals);

    impl Signals {
        pub fn new() -> io::Result<Self> {
            let hangup = (!is_ignored(SIGHUP)).then_some(SIGHUP);
            let signals = [SIGINT, SIGTERM].into_iter().chain(hangup);
            iterator::Signals::new(signals).map(Self)
        }

        /// The next signal, waited for.
        pub fn wait(&mut self) -> i32 {
            self.0.forever().next().unwrap_or(SIGTERM)
        }

        /// One of the signals that came since; the others are forgotten.
        pub fn next(&mut self) -> Option<i32> {
            self.0.pending().last()
        }
    }

    /// Whether the process was started with a signal ignored.
    fn is_ignored(signal: i32) -> bool {
        #[expect(
            unsafe_code,
            reason = "there is no safe way to ask; without a new action sigaction only fills `old`"
        )]
        unsafe {
            let mut old: libc::sigaction = std::mem::zeroed();
            libc::sigaction(signal, std::ptr::null(), &raw mut old) == 0
                && old.sa_sigaction == libc::SIG_IGN
        }
    }
}

#[cfg(not(unix))]
mod system {
    //! Signals where they only set flags.

    use std::io;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::thread;

    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::flag;

    /// SIGINT and SIGTERM.
    pub struct Signals([(i32, Arc<AtomicBool>); 2]);

    impl Signals {
        pub fn new() -> io::Result<Self> {
            let signals = [SIGINT, SIGTERM].map(|signal| (signal, Arc::default()));
            for (signal, came) in &signals {
                flag::register(*signal, Arc::clone(came))?;
            }
            Ok(Self(signals))
        }

        /// The next signal, waited for.
        pub fn wait(&mut self) -> i32 {
            loop {
                if let Some(signal) = self.next() {
                    return signal;
                }
                thread::sleep(super::POLL);
            }
        }

        /// One of the signals that came since; the others are forgotten.
        pub fn next(&mut self) -> Option<i32> {
            let came = |(signal, came): &(i32, Arc<AtomicBool>)| {
                came.swap(false, Ordering::SeqCst).then_some(*signal)
            };
            self.0.iter().filter_map(came).last()
        }
    }
}
