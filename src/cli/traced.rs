//! The drive that a trace is of, driven again from what the trace's header says.

use super::Failure;
use super::scenarios::{AtPoint, Changes};
use crate::experiment::Experiment;
use crate::results::Row;
use crate::trace::Header;
use std::path::{Path, PathBuf};

/// A trace's file with its header.
#[derive(Debug)]
pub(super) struct Traced {
    file: PathBuf,
    header: Header,
}

impl Traced {
    /// The trace in `file`; `None` if its name does not end in `.csv`, as that of a scenario.
    pub(super) fn of(file: &Path) -> Result<Option<Self>, Failure> {
        if file.extension().is_none_or(|extension| extension != "csv") {
            return Ok(None);
        }
        let shown = file.display();
        let header = Header::read(file).map_err(|error| Failure::usage(format!("cannot read `{shown}`: {error}")))?;
        let header = header.ok_or_else(|| {
            Failure::usage(format!(
                "`{shown}` does not begin with the lines `# scenario: …`, `# seed: …` of a trace, so that nothing says which drive it is"
            ))
        })?;
        Ok(Some(Self { file: file.to_owned(), header }))
    }

    /// The experiment, the point and the episode; the experiment has the one stack of the trace.
    pub(super) fn load(&self) -> Result<(Experiment, u32, u64), Failure> {
        let Header { scenario, edits, stack, point, episode, .. } = &self.header;
        let changes = Changes::of_one_stack(edits.clone(), stack.clone());
        let experiment = changes.load(&self.find(Path::new(scenario)))?;
        let point = AtPoint { point: *point }.driven(&experiment)?;
        Ok((experiment, point, *episode))
    }

    /// The scenario's file: as it was named, from here or from a folder above the trace, where the command was given that wrote it.
    fn find(&self, scenario: &Path) -> PathBuf {
        let file = self.file.canonicalize().unwrap_or_else(|_| self.file.clone());
        let above = file.ancestors().skip(1).map(|folder| folder.join(scenario)).find(|path| path.exists());
        above.filter(|_| !scenario.exists()).unwrap_or_else(|| scenario.to_owned())
    }

    /// Refuses a drive that is not that of the trace.
    pub(super) fn check(&self, experiment: &Experiment, row: &Row) -> Result<(), Failure> {
        let (there, here) = (&self.header, experiment.trace_header(row));
        if there.trace_digest == here.trace_digest {
            return Ok(());
        }
        let mut reasons = Vec::new();
        if there.settings_hash != here.settings_hash {
            reasons.push(format!("the scenario `{}` has been changed", there.scenario));
        }
        if there.build != here.build {
            reasons.push(format!("the build of simrun: {} there, {} here", there.build, here.build));
        }
        if reasons.is_empty() {
            reasons.push("a file that the scenario names has been changed, or the trace's header".to_owned());
        }
        let file = self.file.display();
        Err(Failure::run(format!("driven again, `{file}` comes out otherwise: {}", reasons.join("; "))))
    }
}
