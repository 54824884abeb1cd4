//! Ctrl-C and SIGTERM. The first one lets the worlds in hand be finished and written, and says how to go on; the second one ends the
//! process at once, which loses those worlds and nothing else.

use super::{Failure, say};
use crate::command;
use indicatif::ProgressBar;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use signal_hook::iterator::Signals;
use std::io;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// The signals that end a run, with the exit codes of a shell: 128 and the signal's number.
const ENDINGS: [(i32, u8); 2] = [(SIGINT, 130), (SIGTERM, 143)];

/// Whether somebody wants the run to end.
#[derive(Debug)]
pub(super) struct Interrupt {
    /// The exit code; 0 until then.
    code: Arc<AtomicUsize>,
    /// What is drawn on the terminal: it moves aside for the message.
    bar: Arc<Mutex<ProgressBar>>,
}

impl Interrupt {
    /// Listens from the first call on until the process ends.
    pub(super) fn listen() -> Result<&'static Self, Failure> {
        static LISTENS: OnceLock<io::Result<Interrupt>> = OnceLock::new();
        let listens = LISTENS.get_or_init(Self::new).as_ref();
        listens.map_err(|error| Failure::Run(format!("error: cannot listen for Ctrl-C: {error}")))
    }

    fn new() -> io::Result<Self> {
        let is_second = Arc::new(AtomicBool::new(false));
        let code = Arc::new(AtomicUsize::new(0));
        for (signal, exit) in ENDINGS {
            // In the handler itself, in this order: the second signal ends the process even while the thread below waits for the terminal.
            flag::register_conditional_shutdown(signal, i32::from(exit), Arc::clone(&is_second))?;
            flag::register_usize(signal, Arc::clone(&code), usize::from(exit))?;
            flag::register(signal, Arc::clone(&is_second))?;
        }
        let bar = Arc::new(Mutex::new(ProgressBar::hidden()));
        let mut signals = Signals::new(ENDINGS.map(|(signal, _)| signal))?;
        let shown = Arc::clone(&bar);
        std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
            if signals.forever().next().is_some() {
                let bar = shown.lock().unwrap_or_else(PoisonError::into_inner).clone();
                bar.suspend(|| say("finishing the worlds in hand; the same signal once more ends at once"));
            }
        })?;
        Ok(Self { code, bar })
    }

    /// Names the progress bar that messages must not tear.
    pub(super) fn beside(&self, bar: &ProgressBar) {
        *self.bar.lock().unwrap_or_else(PoisonError::into_inner) = bar.clone();
    }

    /// The exit code that was asked for, if it was.
    pub(super) fn code(&self) -> Option<u8> {
        u8::try_from(self.code.load(Ordering::SeqCst)).ok().filter(|&code| code > 0)
    }

    /// The failure of a command that was interrupted, which begins with what was kept, in words.
    pub(super) fn failure(code: u8, kept: &str) -> Failure {
        // Without --force: it would throw away what was kept.
        let words = std::env::args_os().filter(|word| word != "--force");
        Failure::Interrupted(
            format!("interrupted: {kept}. The same command goes on:\n  {}", command::line(words)),
            code,
        )
    }
}
