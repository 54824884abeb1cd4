//! Panics become values: what was said and where, without a word on the terminal.
//!
//! One bad piece of work must not end all others. Whatever runs under [`guard`] may panic; the caller makes a row of it. What the
//! piece has changed may be half done and must be thrown away.

use std::cell::{Cell, RefCell};
use std::fmt;
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::Once;

/// Longest text of a panic that is kept, characters.
const TEXT_CHARS_MAX: usize = 300;

/// A panic that was caught.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Panic {
    /// Its message, at most 300 characters.
    pub message: String,
    /// The line of source at which it began, as in `src/map/grid.rs:40`; the same on every machine.
    pub place: Option<String>,
}

impl fmt::Display for Panic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.place {
            Some(place) => write!(f, "{} ({place})", self.message),
            None => f.write_str(&self.message),
        }
    }
}

thread_local! {
    /// How many guards this thread is inside of.
    static DEPTH: Cell<u32> = const { Cell::new(0) };
    /// Place of the last panic inside a guard.
    static PLACE: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// The answer of `work`, or its panic.
///
/// The first call sets the panic hook of the process: panics of other threads and outside of guards go on to the hook that was set
/// before.
///
/// # Errors
/// If `work` panics.
pub fn guard<T>(work: impl FnOnce() -> T) -> Result<T, Panic> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info: &PanicHookInfo<'_>| {
            if DEPTH.get() == 0 {
                before(info);
            } else {
                PLACE.replace(info.location().map(|at| place(at.file(), at.line())));
            }
        }));
    });
    DEPTH.set(DEPTH.get() + 1);
    let answer = panic::catch_unwind(AssertUnwindSafe(work));
    DEPTH.set(DEPTH.get() - 1);
    answer.map_err(|payload| {
        let text = payload.downcast_ref::<&str>().copied().or(payload.downcast_ref::<String>().map(String::as_str));
        let message = text.unwrap_or("a panic without a message").chars().take(TEXT_CHARS_MAX).collect();
        Panic { message, place: PLACE.take() }
    })
}

/// File and line, the file from its crate's folder on: where crates and compilers are kept differs between machines.
fn place(file: &str, line: u32) -> String {
    let parts: Vec<&str> = file.split(['/', '\\']).collect();
    let from = parts.iter().rposition(|part| *part == "src").unwrap_or_default().saturating_sub(1);
    format!("{}:{line}", parts[from..].join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_panic_is_handed_on() {
        assert_eq!(guard(|| 7), Ok(7));
    }

    #[test]
    fn a_panic_is_its_message_and_its_place() {
        let line = line!() + 1;
        let caught = guard(|| panic!("lost at {}", 5)).unwrap_err();
        assert_eq!(
            (caught.message.as_str(), caught.to_string()),
            ("lost at 5", format!("lost at 5 (src/guard.rs:{line})"))
        );
        let caught = guard(|| panic::panic_any(42_u8)).unwrap_err();
        assert_eq!(caught.message, "a panic without a message");
        assert_eq!(guard(|| panic!("{}", "x".repeat(5000))).unwrap_err().message.len(), TEXT_CHARS_MAX);
    }

    #[test]
    fn a_place_in_another_crate_begins_with_the_name_of_that_crate() {
        for (file, expected) in [
            ("src/map/grid.rs", "src/map/grid.rs:7"),
            ("/home/me/.cargo/registry/src/index-1/parry2d-0.1.0/src/query/gjk.rs", "parry2d-0.1.0/src/query/gjk.rs:7"),
            ("/rustc/0123/library/core/src/option.rs", "core/src/option.rs:7"),
            ("examples/own_planner.rs", "examples/own_planner.rs:7"),
        ] {
            assert_eq!(place(file, 7), expected);
        }
    }

    #[test]
    fn guards_may_stand_inside_of_guards() {
        let outer = guard(|| {
            let inner = guard(|| panic!("inner"));
            assert_eq!(inner.unwrap_err().message, "inner");
            panic!("outer");
        });
        assert_eq!(outer.unwrap_err().message, "outer");
        assert_eq!(DEPTH.get(), 0);
    }
}
