//! Driving in child processes: a child that hangs, aborts or eats all memory costs one row and not the run.
//!
//! Each thread has a child of its own, used from block to block. The child is told a block and the first stack that is still
//! missing, and says when it has the world and then each answer. One that says nothing for too long is killed, one that has
//! died is replaced; the next child goes on with the stack behind.
//!
//! Messages are frames: the mark, the length and a postcard. The child reads its input in a thread of its own: when that ends, the
//! parent is gone, and so is the child, whatever it is busy with.

use super::fault::{Fault, Phase};
use super::{Experiment, RunError, Worker};
use crate::digest::Fnv1a;
use crate::episode::Outcome;
use crate::results::Answer;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::Duration;

/// Begins every frame.
const MARK: [u8; 4] = *b"sim\x01";
/// Longest frame, bytes.
const FRAME_BYTES_MAX: u32 = 1 << 26;
/// How often a child is started anew for one block without having said anything.
const STARTS_MAX: u32 = 3;

/// How children are started, and when they are given up.
pub struct Isolation<'a> {
    /// Makes the command of a process that calls [`serve`] with the same experiment.
    pub command: &'a (dyn Fn() -> Command + Sync),
    /// Time without a word after which a child is killed, s; `None` waits for ever.
    pub give_up_after_s: Option<f64>,
}

impl core::fmt::Debug for Isolation<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Isolation").field("give_up_after_s", &self.give_up_after_s).finish_non_exhaustive()
    }
}

/// What a child is asked to do: the stacks of a block from one on.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Request {
    point: u32,
    episode: u64,
    from: usize,
}

/// What a child says.
#[derive(Debug, Serialize, Deserialize)]
enum Said {
    /// It is ready; the digest of its experiment.
    Ready(u64),
    /// It knows the world of the block.
    World,
    /// The answer of the next stack.
    Answer(Vec<u8>),
    /// It cannot go on, as a run without children could not.
    Failed(String),
}

/// Why a child says nothing more.
enum End {
    Died(String),
    GaveUp,
}

fn write_frame(output: &mut impl Write, message: &impl Serialize) -> io::Result<()> {
    let bytes = postcard::to_stdvec(message).map_err(io::Error::other)?;
    let length = u32::try_from(bytes.len()).map_err(io::Error::other)?;
    let frame = [&MARK[..], &length.to_le_bytes(), &bytes].concat();
    output.write_all(&frame)?;
    output.flush()
}

/// The next message. Whatever else stands before its mark is passed over: it is not ours.
fn read_frame<M: DeserializeOwned>(input: &mut impl Read) -> io::Result<M> {
    let mut window = [0; MARK.len()];
    while window != MARK {
        window.rotate_left(1);
        input.read_exact(&mut window[MARK.len() - 1..])?;
    }
    let mut length = [0; 4];
    input.read_exact(&mut length)?;
    let length = u32::from_le_bytes(length);
    if length > FRAME_BYTES_MAX {
        return Err(io::Error::other("a frame that is too long"));
    }
    let mut bytes = vec![0; length as usize];
    input.read_exact(&mut bytes)?;
    postcard::from_bytes(&bytes).map_err(io::Error::other)
}

impl Experiment {
    /// What parent and child must agree on.
    fn fingerprint(&self) -> u64 {
        let mut digest = Fnv1a::default();
        digest.bytes(self.scenario.to_yaml().as_bytes());
        self.stack_names().iter().for_each(|name| digest.bytes(name.as_bytes()));
        let maps = self.points.iter().filter_map(|point| point.surroundings.fixed_map.as_ref());
        maps.for_each(|map| digest.word(map.digest()));
        digest.value()
    }
}

/// Drives what the parent asks for until it asks no more, with the traces to the folder `traces` if given.
///
/// # Errors
/// If the parent does not listen.
pub fn serve(
    experiment: &Experiment,
    traces: Option<&Path>,
    mut input: impl Read + Send + 'static,
    output: &mut impl Write,
) -> io::Result<()> {
    let (sender, requests) = mpsc::channel();
    std::thread::spawn(move || {
        while let Ok(request) = read_frame::<Request>(&mut input) {
            if sender.send(request).is_err() {
                return;
            }
        }
        #[expect(clippy::exit, reason = "nobody waits for what this process may still be busy with")]
        std::process::exit(0);
    });
    write_frame(output, &Said::Ready(experiment.fingerprint()))?;
    let mut worker = Worker::default();
    for Request { point, episode, from } in requests {
        let mut broken = None;
        let driven = experiment.drive_block(&mut worker, (point, episode, from), traces, |answer| {
            let said = answer.map_or(Said::World, |answer| Said::Answer(answer.to_bytes()));
            broken = write_frame(output, &said).err();
            broken.is_none()
        });
        broken.map_or(Ok(()), Err)?;
        if let Err(error) = driven {
            write_frame(output, &Said::Failed(error.to_string()))?;
        }
    }
    Ok(())
}

/// A child process that drives.
struct Driver {
    process: Child,
    requests: ChildStdin,
    said: Receiver<Said>,
}

impl Driver {
    fn start(isolation: &Isolation<'_>, fingerprint: u64) -> Result<Self, RunError> {
        let failed = |what: String| RunError::Child { message: what };
        let mut command = (isolation.command)();
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        // A Ctrl-C at the terminal is for the parent, which ends its blocks in order.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut process = command.spawn().map_err(|error| failed(format!("cannot start a child process: {error}")))?;
        let (Some(requests), Some(mut answers)) = (process.stdin.take(), process.stdout.take()) else {
            return Err(failed("a child process without pipes".to_owned()));
        };
        let (sender, said) = mpsc::channel();
        std::thread::spawn(move || {
            while let Ok(message) = read_frame(&mut answers) {
                if sender.send(message).is_err() {
                    return;
                }
            }
        });
        let mut driver = Self { process, requests, said };
        match driver.said.recv() {
            Ok(Said::Ready(found)) if found == fingerprint => Ok(driver),
            Ok(Said::Ready(_)) => {
                Err(failed("the scenario or a file that it names has changed since the run began".to_owned()))
            }
            Ok(_) | Err(_) => Err(failed(format!("a child process did not get ready: {}", driver.how_it_ended()))),
        }
    }

    fn ask(&mut self, request: Request) -> io::Result<()> {
        write_frame(&mut self.requests, &request)
    }

    fn next(&mut self, limit_s: Option<f64>) -> Result<Said, End> {
        let said = match limit_s {
            Some(limit_s) => self.said.recv_timeout(Duration::from_secs_f64(limit_s)),
            None => self.said.recv().map_err(|_| RecvTimeoutError::Disconnected),
        };
        said.map_err(|error| match error {
            RecvTimeoutError::Timeout => End::GaveUp,
            RecvTimeoutError::Disconnected => End::Died(self.how_it_ended()),
        })
    }

    /// In words. Its pipe is closed, so it has ended or will soon.
    fn how_it_ended(&mut self) -> String {
        match self.process.wait() {
            Ok(status) => in_words(status),
            Err(error) => format!("its process is lost: {error}"),
        }
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        // Both fail only for a process that has ended.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// How a process ended.
fn in_words(status: ExitStatus) -> String {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        let named = match signal {
            4 => "SIGILL",
            6 => "SIGABRT, as after a stack overflow, a failed allocation or an abort",
            7 => "SIGBUS",
            8 => "SIGFPE",
            9 => "SIGKILL, as by the system when memory runs out",
            11 => "SIGSEGV",
            15 => "SIGTERM",
            24 => "SIGXCPU",
            31 => "SIGSYS",
            _ => return format!("its process was ended by signal {signal}"),
        };
        return format!("its process was ended by {named}");
    }
    match status.code() {
        Some(code) => format!("its process ended by itself with exit code {code}"),
        None => "its process ended by itself".to_owned(),
    }
}

/// Drives blocks in a child.
pub(super) struct Isolated<'a> {
    experiment: &'a Experiment,
    isolation: &'a Isolation<'a>,
    fingerprint: u64,
    driver: Option<Driver>,
}

impl<'a> Isolated<'a> {
    pub(super) fn new(experiment: &'a Experiment, isolation: &'a Isolation<'a>) -> Self {
        Self { experiment, isolation, fingerprint: experiment.fingerprint(), driver: None }
    }

    /// As [`Experiment::run_block`].
    pub(super) fn run_block(&mut self, point: u32, episode: u64) -> Result<Vec<Answer>, RunError> {
        let stacks = self.experiment.stacks(point).len();
        let mut answers = Vec::with_capacity(stacks);
        let mut starts = 0;
        while answers.len() < stacks {
            let mut driver = match self.driver.take() {
                Some(driver) => driver,
                None => {
                    starts += 1;
                    Driver::start(self.isolation, self.fingerprint)?
                }
            };
            if let Err(error) = driver.ask(Request { point, episode, from: answers.len() }) {
                if starts < STARTS_MAX {
                    continue;
                }
                return Err(RunError::Child { message: format!("a child process does not listen: {error}") });
            }
            match self.listen(&mut driver, (point, episode), &mut answers)? {
                Ok(()) => self.driver = Some(driver),
                Err((phase, end)) => {
                    // Without a world no stack has anything to drive in.
                    let lost = if phase == Phase::WorldGeneration { stacks - answers.len() } else { 1 };
                    for _ in 0..lost {
                        answers.push(self.lost(phase, &end, (point, episode), answers.len()));
                    }
                    starts = 0;
                }
            }
        }
        Ok(answers)
    }

    /// Takes answers until the block is whole or the child has ended, in which part of its work.
    fn listen(
        &self,
        driver: &mut Driver,
        (point, episode): (u32, u64),
        answers: &mut Vec<Answer>,
    ) -> Result<Result<(), (Phase, End)>, RunError> {
        let experiment = self.experiment;
        let mut phase = Phase::WorldGeneration;
        while answers.len() < experiment.stacks(point).len() {
            match driver.next(self.isolation.give_up_after_s) {
                Ok(Said::World) => phase = Phase::Drive,
                Ok(Said::Answer(bytes)) => {
                    let read = Answer::from_bytes(&bytes, experiment.swept());
                    let answer = read.filter(|answer| (answer.row.point, answer.row.episode) == (point, episode));
                    match answer {
                        Some(answer) => answers.push(answer),
                        None => return Ok(Err((phase, End::Died("its answer cannot be read".to_owned())))),
                    }
                }
                Ok(Said::Failed(message)) => return Err(RunError::Child { message }),
                Ok(Said::Ready(_)) => return Ok(Err((phase, End::Died("it began anew".to_owned())))),
                Err(end) => return Ok(Err((phase, end))),
            }
        }
        Ok(Ok(()))
    }

    /// The answer for a stack whose child has ended.
    fn lost(&self, phase: Phase, end: &End, (point, episode): (u32, u64), stack: usize) -> Answer {
        match end {
            End::Died(message) => {
                self.experiment.faulty(&Fault { phase, message: message.clone() }, (point, episode, stack), None)
            }
            End::GaveUp => {
                let waited_s = self.isolation.give_up_after_s.unwrap_or_default();
                let message = format!("{}: gave up after {waited_s} s", phase.name());
                self.experiment.undriven(Outcome::GaveUp { message }, (point, episode, stack), None)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_found_behind_what_is_not_ours() {
        let mut pipe = b"a planner prints si sim and more\n".to_vec();
        write_frame(&mut pipe, &Said::Ready(7)).unwrap();
        write_frame(&mut pipe, &Said::World).unwrap();
        let mut input = pipe.as_slice();
        assert!(matches!(read_frame::<Said>(&mut input).unwrap(), Said::Ready(7)));
        assert!(matches!(read_frame::<Said>(&mut input).unwrap(), Said::World));
        assert_eq!(read_frame::<Said>(&mut input).unwrap_err().kind(), io::ErrorKind::UnexpectedEof);
    }

    #[test]
    fn a_length_that_cannot_be_takes_no_memory() {
        let pipe = [&MARK[..], &u32::MAX.to_le_bytes()].concat();
        assert!(read_frame::<Said>(&mut pipe.as_slice()).unwrap_err().to_string().contains("too long"));
    }

    #[cfg(unix)]
    #[test]
    fn the_signal_that_ended_a_process_is_named() {
        use std::os::unix::process::ExitStatusExt as _;
        let said = [6, 9, 11, 64].map(|signal| in_words(ExitStatus::from_raw(signal)));
        assert!(said[0].contains("SIGABRT") && said[1].contains("SIGKILL") && said[2].contains("SIGSEGV"), "{said:?}");
        assert_eq!(said[3], "its process was ended by signal 64");
        assert_eq!(in_words(ExitStatus::from_raw(3 << 8)), "its process ended by itself with exit code 3");
    }
}
