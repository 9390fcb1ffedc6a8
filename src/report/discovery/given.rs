//! What a reader of findings must know of how the data were given.

use crate::data::Recording;
use std::path::{Path, PathBuf};

/// The recordings of a discovery as they were given.
#[derive(Clone, Debug)]
pub struct GivenRecordings {
    /// File and number there of each trial, in the order of the joined recording.
    pub trials: Vec<(PathBuf, u64)>,
    /// Whether recordings were added on the way.
    pub is_extended: bool,
    /// Whether the baseline holds trials of the measured recordings.
    pub shares_baseline: bool,
}

/// Limitation if the baseline shares trials with the recording.
const OWN_BASELINE: &str = "The baseline contains trials of the measured recording: errors that \
                            both share are not attributed to an effect, and trials used for \
                            calibration are no independent test.";

impl GivenRecordings {
    /// Recordings from `files`, read as `parts`.
    pub fn new(
        files: &[&Path],
        parts: &[Recording],
        baseline: Option<&Recording>,
    ) -> GivenRecordings {
        let trials = files.iter().zip(parts).flat_map(|(file, part)| numbered(file, part));
        let shares = |baseline: &Recording| {
            parts.iter().any(|part| baseline.holds(part) || part.holds(baseline))
        };
        GivenRecordings {
            trials: trials.collect(),
            is_extended: false,
            shares_baseline: baseline.is_some_and(shares),
        }
    }

    /// The files, each once.
    pub(super) fn files(&self) -> Vec<String> {
        let mut files: Vec<String> =
            self.trials.iter().map(|(file, _)| file.display().to_string()).collect();
        files.dedup();
        files
    }

    /// With a recording that was added before the others, as [`crate::data::Recording::joined`]
    /// has it.
    pub fn extend(&mut self, file: &Path, recording: &Recording) {
        self.trials.splice(0..0, numbered(file, recording));
        self.is_extended = true;
    }

    /// The limitations in sentences; `measured`: all recordings, joined. They name each trial's
    /// file where the trials were renumbered or recordings added.
    pub fn limitations(&self, measured: &Recording) -> Vec<String> {
        let now: Vec<u64> = measured.trials().into_iter().map(|(number, _)| number).collect();
        let is_renumbered = now.iter().zip(&self.trials).any(|(now, (_, before))| now != before);
        let renumbered = (self.is_extended || is_renumbered).then(|| self.renumbered(&now));
        let own_baseline = self.shares_baseline.then(|| OWN_BASELINE.to_owned());
        renumbered.into_iter().chain(own_baseline).collect()
    }

    fn renumbered(&self, now: &[u64]) -> String {
        let numbers: Vec<(&Path, u64)> =
            self.trials.iter().zip(now).map(|((file, _), now)| (file.as_path(), *now)).collect();
        let each = numbers.chunk_by(|(a, _), (b, _)| a == b).map(|of| {
            let name = of[0].0.file_name().unwrap_or(of[0].0.as_os_str()).to_string_lossy();
            format!("{} to {} are from {name}", of[0].1, of[of.len() - 1].1)
        });
        format!("Trials were renumbered: {}.", each.collect::<Vec<_>>().join(", "))
    }
}

/// The files of a question, and what else was asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DiscoverySources {
    /// The model.
    pub model: String,
    /// The recordings.
    pub measured: Vec<String>,
    /// The recording of the robot as built.
    pub baseline: Option<String>,
    /// Further options of the command.
    pub options: Vec<String>,
}

impl DiscoverySources {
    /// Those of a model file, the recordings and the file of a baseline.
    pub fn new(
        model: &Path,
        given: &GivenRecordings,
        baseline: Option<&Path>,
        options: Vec<String>,
    ) -> DiscoverySources {
        DiscoverySources {
            model: model.display().to_string(),
            measured: given.files(),
            baseline: baseline.map(|file| file.display().to_string()),
            options,
        }
    }

    /// The command that asks again.
    pub(super) fn command(&self) -> String {
        let baseline = self.baseline.iter().map(|file| format!(" --baseline {file}"));
        let options = self.options.iter().map(|option| format!(" {option}"));
        let further: String = baseline.chain(options).collect();
        let (model, measured) = (&self.model, self.measured.join(" "));
        format!("spinebench discover --model {model} --measured {measured}{further} --out DIR")
    }
}

/// The trials of a recording with its file.
fn numbered(file: &Path, recording: &Recording) -> Vec<(PathBuf, u64)> {
    recording.trials().into_iter().map(|(number, _)| (file.to_owned(), number)).collect()
}
