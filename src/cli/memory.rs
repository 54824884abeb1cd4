//! `--memory-limit`: how much memory a run may take, and what it is where nobody says.

use super::isolated::Isolate;
use crate::experiment::threads_available;
use crate::files;
use crate::scenario::{Room, ScenarioFile};
use std::path::Path;

/// Longest text that the system says about itself, bytes.
const SAID_BYTES_MAX: u64 = 1 << 16;

/// How much memory a run may take.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
pub(super) struct MemoryLimit {
    /// Refuse a scenario whose run would take more memory, all threads together, for example 4GiB or 500MB; half of what there is by
    /// default.
    #[arg(long, value_name = "SIZE", value_parser = bytes)]
    memory_limit: Option<u64>,
}

impl MemoryLimit {
    /// It as arguments.
    pub(super) fn arguments(&self) -> impl Iterator<Item = String> {
        self.memory_limit.into_iter().map(|bytes| format!("--memory-limit={bytes}"))
    }

    /// The file with this limit, for a run on so many threads; on every processor unless `threads` is given.
    pub(super) fn set(&self, file: ScenarioFile, threads: Option<usize>, isolate: &Isolate) -> ScenarioFile {
        let threads = threads.unwrap_or_else(threads_available).max(1) as u64;
        let processes = isolate.processes(threads);
        match self.memory_limit.or_else(half_of_what_there_is) {
            Some(bytes) => file.within(Room { bytes, threads, processes }),
            None => file,
        }
    }
}

/// A number of bytes: a number with a unit, of which the binary ones end in `iB` or are a single letter.
fn bytes(text: &str) -> Result<u64, String> {
    const UNITS: [(&str, u64); 16] = [
        ("", 1),
        ("b", 1),
        ("k", 1 << 10),
        ("kib", 1 << 10),
        ("kb", 1000),
        ("m", 1 << 20),
        ("mib", 1 << 20),
        ("mb", 1_000_000),
        ("g", 1 << 30),
        ("gib", 1 << 30),
        ("gb", 1_000_000_000),
        ("t", 1 << 40),
        ("tib", 1 << 40),
        ("tb", 1_000_000_000_000),
        ("p", 1 << 50),
        ("pib", 1 << 50),
    ];
    let expected = || "expected a size such as 4GiB or 500MB".to_owned();
    let split = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let number: f64 = text[..split].parse().map_err(|_| expected())?;
    let unit = text[split..].trim().to_ascii_lowercase();
    let (_, scale) = UNITS.iter().find(|(name, _)| *name == unit).ok_or_else(expected)?;
    let bytes = number * *scale as f64;
    if bytes >= 1.0 && bytes < u64::MAX as f64 { Ok(bytes as u64) } else { Err(expected()) }
}

/// Half of the smallest of: the machine's memory, what the control group of this process may take, and its address space. `None`
/// where the system says none of them.
fn half_of_what_there_is() -> Option<u64> {
    let said = |file: &Path| files::text(file, SAID_BYTES_MAX).ok();
    let machine = said(Path::new("/proc/meminfo")).and_then(|text| total_of(&text));
    let groups = said(Path::new("/proc/self/cgroup")).unwrap_or_default();
    let of_groups = group_files(&groups).into_iter().filter_map(|file| said(Path::new(&file))?.trim().parse().ok());
    let address_space = said(Path::new("/proc/self/limits")).and_then(|text| address_space_of(&text));
    machine.into_iter().chain(of_groups).chain(address_space).min().map(|bytes| bytes / 2)
}

/// The machine's memory, from `/proc/meminfo`.
fn total_of(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// The files that may limit the memory of the control groups in `/proc/self/cgroup`, from this process's own up to the root.
fn group_files(groups: &str) -> Vec<String> {
    let mut files = Vec::new();
    for line in groups.lines() {
        let mut fields = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (fields.next(), fields.next()) else { continue };
        let (root, file) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            _ if controllers.split(',').any(|name| name == "memory") => {
                ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")
            }
            _ => continue,
        };
        files.extend(
            Path::new(path)
                .ancestors()
                .map(|group| format!("{root}{}/{file}", group.display().to_string().trim_end_matches('/'))),
        );
    }
    files
}

/// The limit of the address space, from `/proc/self/limits`; `None` without one.
fn address_space_of(limits: &str) -> Option<u64> {
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_as_people_write_them() {
        let sizes = ["4GiB", "4g", "500MB", "1.5 k", "17"].map(|text| bytes(text).unwrap());
        assert_eq!(sizes, [4 << 30, 4 << 30, 500_000_000, 1536, 17]);
        for wrong in ["", "GiB", "4 apples", "-1", "0", "1e3", "9999999999P"] {
            assert!(bytes(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn what_the_system_says_is_understood() {
        assert_eq!(total_of("MemFree: 1 kB\nMemTotal:       24609752 kB\n"), Some(24_609_752 * 1024));
        assert_eq!(
            group_files("0::/user.slice/a\n"),
            [
                "/sys/fs/cgroup/user.slice/a/memory.max",
                "/sys/fs/cgroup/user.slice/memory.max",
                "/sys/fs/cgroup/memory.max"
            ]
        );
        assert_eq!(
            group_files("5:cpu,memory:/x\n3:pids:/y\n"),
            ["/sys/fs/cgroup/memory/x/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.limit_in_bytes"]
        );
        assert_eq!(
            address_space_of("Max address space         1024000000           unlimited            bytes\n"),
            Some(1_024_000_000)
        );
        assert_eq!(
            address_space_of("Max address space         unlimited            unlimited            bytes\n"),
            None
        );
        assert!(half_of_what_there_is().is_some_and(|bytes| bytes > 1 << 20));
    }
}
