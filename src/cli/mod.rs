//! The command line: one file per subcommand.
//!
//! Data goes to stdout or files, progress and messages to stderr. Exit codes: 0 it ran, whatever
//! the robot did; 1 it could not run, or some row is `planner_error` or `internal_error`; 2 bad usage or scenario,
//! nothing was written; 3 a requirement was not met; 75 the folder of results is in use, try again later; 130 interrupted by
//! Ctrl-C, 143 by SIGTERM.

mod analyze;
mod check;
mod draw;
mod explain;
mod failures;
mod interrupt;
mod isolated;
mod json;
mod map;
mod memory;
mod plan;
mod planners;
mod plot;
mod report;
mod reproduce;
mod run;
mod scenarios;
mod schema;
mod traced;
mod verify;

use crate::command;
use crate::comparison::Format;
use crate::guard::guard;
use crate::results::layout::WIDE;
use crate::scenario::ScenarioError;
use crate::settings::choice::nearest;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser, Subcommand};
use std::ffi::OsString;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Drives a robot through seeded 2-D worlds with any global × any local planner and writes what came of it as CSV.
#[derive(Debug, Parser)]
#[command(name = "simrun", version, args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
#[command(after_help = "Exit codes: 0 ran (whatever the robot did), 1 failed to run or some episode crashed, \
                        2 bad usage or scenario (nothing written), 3 a requirement was not met, \
                        75 the folder is in use by another run (--wait-lock waits), \
                        130 interrupted (the same command goes on).")]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    run: run::Args,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run scenarios (the same as naming them without a subcommand).
    Run(run::Args),
    /// Check scenarios without running them; --resolved prints them with every default.
    Check(check::Args),
    /// Plan on a map file, without a robot: one row per query and planner.
    Plan(plan::Args),
    /// List the planners, or describe one with its parameters.
    Planners(planners::Args),
    /// Run a scenario twice with different thread counts and compare every byte; of a folder, compare its tables with their hashes.
    Verify(verify::Args),
    /// Compare the stacks of a run on the same worlds, or a run with an older one.
    Analyze(analyze::Args),
    /// Run the tables of a paper and judge its claims.
    Reproduce(reproduce::Args),
    /// Draw one episode as SVG.
    Draw(draw::Args),
    /// List the failed episodes of a folder of results by their cause, with the commands that drive them again.
    Failures(failures::Args),
    /// Write one page on folders of results: tables, charts, and a gallery of episodes that can be replayed, failures first.
    Report(report::Args),
    /// Plot results as figures for papers: sweeps, stacks, pairs, any column over any other.
    Plot(plot::Args),
    /// Explain a key of scenario files: meaning, unit, default, range, allowed values, an example.
    Explain(explain::Args),
    /// Print the JSON Schema of scenario files, for editors.
    Schema(schema::Args),
    /// Describe a map file, or write it in another format.
    Map(map::Args),
    /// Drive blocks for another simrun, which asks for them over a pipe.
    #[command(hide = true)]
    DriveBlocks(isolated::Args),
}

/// Reason why a command did not succeed.
#[derive(Clone, Debug)]
enum Failure {
    /// Bad usage or scenario: exit code 2, nothing written.
    Usage(String),
    /// Faults of a scenario, with their places: exit code 2, nothing written.
    Scenario(ScenarioError),
    /// Several of the two: exit code 2, nothing written.
    Several(Vec<Failure>),
    /// It could not run, or some episode crashed: exit code 1.
    Run(String),
    /// A requirement was not met: exit code 3.
    Requirement(String),
    /// Another run holds the folder of results: exit code 75, EX_TEMPFAIL of sysexits.h.
    Busy(String),
    /// It was interrupted, what was finished is kept: this exit code.
    Interrupted(String, u8),
}

impl Failure {
    fn run(error: impl std::fmt::Display) -> Self {
        Self::Run(format!("error: {error}"))
    }

    fn usage(error: impl std::fmt::Display) -> Self {
        Self::Usage(format!("error: {error}"))
    }

    /// All of these as one; nothing is wrong if there is none.
    fn all(mut failures: Vec<Self>) -> Result<(), Self> {
        match failures.len() {
            0 => Ok(()),
            1 => Err(failures.remove(0)),
            _ => Err(Self::Several(failures)),
        }
    }

    fn exit_code(&self) -> u8 {
        match self {
            Self::Run(_) => 1,
            Self::Usage(_) | Self::Scenario(_) | Self::Several(_) => 2,
            Self::Requirement(_) => 3,
            Self::Busy(_) => 75,
            Self::Interrupted(_, code) => *code,
        }
    }

    /// What people are told.
    fn message(&self) -> String {
        match self {
            Self::Run(message)
            | Self::Usage(message)
            | Self::Requirement(message)
            | Self::Busy(message)
            | Self::Interrupted(message, _) => message.clone(),
            Self::Scenario(refused) => refused.render(colour()),
            Self::Several(failures) => failures.iter().map(Self::message).collect::<Vec<String>>().join("\n\n"),
        }
    }
}

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    let cli = match Cli::try_parse_from(&arguments) {
        Ok(cli) => cli,
        Err(mut error) => {
            // An unknown option often belongs to the subcommand that was meant.
            if error.kind() == ErrorKind::UnknownArgument
                && let Some(meant) = arguments.get(1).and_then(|word| misspelt_command(Path::new(word)))
            {
                error.insert(ContextKind::SuggestedSubcommand, ContextValue::String(meant));
            }
            let _ = error.print();
            if error.use_stderr() {
                let _ = json::refuse(&arguments, &Failure::Usage(error.render().to_string()));
            }
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    // A fault of our own is said in one line, as every error is.
    let result = guard(|| run(cli, &arguments))
        .unwrap_or_else(|panic| Err(Failure::Run(format!("error: simrun itself has failed: {panic}"))));
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            say(&failure.message());
            ExitCode::from(failure.exit_code())
        }
    }
}

fn run(cli: Cli, arguments: &[OsString]) -> Result<(), Failure> {
    match cli.command {
        None => match refuse_misspelt_command(&cli.run) {
            Ok(()) => run::main(&cli.run),
            Err(failure) => json::refuse(arguments, &failure).and(Err(failure)),
        },
        Some(Command::Run(args)) => run::main(&args),
        Some(Command::Check(args)) => check::main(&args),
        Some(Command::Plan(args)) => plan::main(&args),
        Some(Command::Planners(args)) => planners::main(&args),
        Some(Command::Verify(args)) => verify::main(&args),
        Some(Command::Analyze(args)) => analyze::main(&args),
        Some(Command::Reproduce(args)) => reproduce::main(&args),
        Some(Command::Draw(args)) => draw::main(&args),
        Some(Command::Failures(args)) => failures::main(&args),
        Some(Command::Report(args)) => report::main(&args),
        Some(Command::Plot(args)) => plot::main(&args),
        Some(Command::Explain(args)) => explain::main(&args),
        Some(Command::Schema(args)) => schema::main(&args),
        Some(Command::Map(args)) => map::main(&args),
        Some(Command::DriveBlocks(args)) => isolated::main(&args),
    }
}

/// The subcommand that a word is most like, if the word names no file and looks like no file's name.
fn misspelt_command(word: &Path) -> Option<String> {
    if word.exists() || word.extension().is_some() || word.components().count() != 1 {
        return None;
    }
    let command = Cli::command();
    let known: Vec<&str> =
        command.get_subcommands().filter(|command| !command.is_hide_set()).map(clap::Command::get_name).collect();
    nearest(word.to_str()?, &known).map(str::to_owned)
}

/// Scenarios may be named without a subcommand, so a misspelt subcommand looks like a scenario: this tells them apart.
fn refuse_misspelt_command(run: &run::Args) -> Result<(), Failure> {
    let Some((word, meant)) = run.scenarios().iter().find_map(|word| Some((word, misspelt_command(word)?))) else {
        return Ok(());
    };
    Err(Failure::Usage(format!(
        "error: there is no subcommand and no scenario file `{}`\nhelp: did you mean `simrun {meant}`?",
        word.display()
    )))
}

/// Where a command writes its text.
#[derive(Debug, Default, clap::Args)]
struct Out {
    /// Write to this file instead of stdout; `-` is stdout.
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl Out {
    /// The file to write; `None` for stdout.
    fn file(&self) -> Option<&Path> {
        self.out.as_deref().filter(|file| file.as_os_str() != "-")
    }

    /// Characters that a line may have.
    fn width(&self) -> usize {
        self.file().map_or_else(width, |_| WIDE)
    }

    /// Writes the whole text.
    fn write(&self, text: &str) -> Result<(), Failure> {
        match self.file() {
            Some(file) => std::fs::write(file, text).map_err(|error| cannot_write(file, &error)),
            None => print(text),
        }
    }

    /// Opens the output for writing in parts.
    fn open(&self) -> Result<Box<dyn Write>, Failure> {
        match self.file() {
            Some(file) => match std::fs::File::create(file) {
                Ok(opened) => Ok(Box::new(opened)),
                Err(error) => Err(cannot_write(file, &error)),
            },
            None => Ok(Box::new(io::stdout().lock())),
        }
    }
}

fn cannot_write(file: &Path, error: &io::Error) -> Failure {
    Failure::Run(format!("error: cannot write {}: {error}", file.display()))
}

/// A message for the person at the terminal. A closed stderr is no reason to fail.
fn say(message: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", message.trim_end());
}

/// Data to stdout.
fn print(data: &str) -> Result<(), Failure> {
    match io::stdout().lock().write_all(data.as_bytes()) {
        // Somebody read enough of it, as `head` does.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other.map_err(Failure::run),
    }
}

/// Characters that a line of stdout may have: what `COLUMNS` says, else what the terminal has, else any number.
fn width() -> usize {
    // Less cannot be read.
    const LEAST: usize = 40;
    let asked = std::env::var("COLUMNS").ok().and_then(|columns| columns.trim().parse().ok());
    let columns = asked.or_else(|| Some(usize::from(console::Term::stdout().size_checked()?.1)));
    columns.filter(|&columns| columns > 0).map_or(WIDE, |columns: usize| columns.max(LEAST))
}

/// A first line for tables of papers: the command that made them, as a comment of LaTeX. Other formats begin without one.
fn command_comment(format: Format) -> String {
    if format != Format::Latex {
        return String::new();
    }
    let words = std::iter::once("simrun".into()).chain(std::env::args_os().skip(1));
    format!("% simrun {}: {}\n", env!("CARGO_PKG_VERSION"), command::line::<OsString>(words))
}

/// Whether messages may be coloured.
fn colour() -> bool {
    io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}
