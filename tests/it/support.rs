//! Helpers shared by the modules of this binary: the command, the folders of the repository, data beside it.

use std::ffi::OsStr;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The folder of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Whether the references are to be written anew instead of compared with (`SIMRUN_BLESS` is set).
pub fn is_blessing() -> bool {
    std::env::var_os("SIMRUN_BLESS").is_some()
}

/// Whether the long forms of the tests are asked for (`SIMRUN_FULL=1`).
pub fn is_full() -> bool {
    std::env::var_os("SIMRUN_FULL").is_some_and(|value| value == "1")
}

/// The command, in a folder of its own, without colours.
pub fn simrun(folder: &Path) -> Simrun {
    let mut command = Command::new(env!("CARGO_BIN_EXE_simrun"));
    command.current_dir(folder).env("NO_COLOR", "1").env_remove("COLUMNS");
    Simrun(command)
}

/// A call of simrun that can be made again and again.
pub struct Simrun(Command);

/// Exit code and output of a call of simrun.
#[derive(Debug)]
pub struct Answer {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Simrun {
    pub fn arg(&mut self, argument: impl AsRef<OsStr>) -> &mut Self {
        self.0.arg(argument);
        self
    }

    pub fn env(&mut self, name: &str, value: &str) -> &mut Self {
        self.0.env(name, value);
        self
    }

    pub fn args(&mut self, arguments: impl IntoIterator<Item: AsRef<OsStr>>) -> &mut Self {
        self.0.args(arguments);
        self
    }

    /// Runs it to its end.
    pub fn answer(&mut self) -> Answer {
        let output = self.0.output().expect("simrun starts");
        let text = |bytes| String::from_utf8(bytes).expect("simrun prints UTF-8");
        let code = output.status.code().expect("simrun ends by itself");
        Answer { code, stdout: text(output.stdout), stderr: text(output.stderr) }
    }

    /// Runs it to its end, which must come with this code.
    #[track_caller]
    pub fn ends_with(&mut self, code: i32) -> Answer {
        let answer = self.answer();
        assert_eq!(answer.code, code, "{:?}\n{}{}", self.0, answer.stdout, answer.stderr);
        answer
    }
}

/// Every file of a folder and of the folders in it whose name ends in `.ENDING`, in the order of their paths.
pub fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|found| found == ending) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// A folder of the benchmark data beside the repository. Where it is missing, the output of the tests says that the
/// calling test was skipped.
pub fn benchmarks(folder: &str) -> Option<PathBuf> {
    let found = root().join("../shared/benchmarks").join(folder);
    if found.is_dir() {
        return Some(found);
    }
    let thread = std::thread::current();
    let test = thread.name().filter(|name| *name != "main").unwrap_or("a test");
    let line = format!("skipped: {test}: needs ../shared/benchmarks/{folder}\n");
    // Not eprintln!, which libtest swallows where a test passes.
    std::io::stderr().write_all(line.as_bytes()).expect("stderr is open");
    None
}
