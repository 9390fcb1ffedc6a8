//! `spinebench view`.

use super::live::LiveModel;
use super::path_scenes::path_scenes;
use super::server::{ServedPage, ViewServer};
use crate::cli::models::several::poses_at_rest;
use crate::cli::program::outputs::{check_ending, check_file};
use crate::cli::program::shared::print_all;
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::data::scene::Scene;
use spinebench::data::{Recording, write_atomic};
use spinebench::effects::Model;
use spinebench::report::scene::{FilmStrip, film, player_page};
use spinebench::report::style::training_label;
use spinebench::runner::Progress;
use spinebench::specs::{Experiment, read_model};
use spinebench::tasks::{scene_of_measurement, scene_of_recording};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Show a robot in three dimensions in the browser: a model with sliders for its commands, a
/// recording next to its simulation, or a tracked path of published results.
#[derive(Args)]
pub(crate) struct ViewCommand {
    /// A model file, recordings (CSV or Parquet), or a folder such as results/fig8.
    #[arg(required = true, value_name = "MODEL.yaml|REC.csv|RESULTS")]
    shown: Vec<PathBuf>,
    /// Model to simulate with a recording's commands; repeatable, shown side by side.
    #[arg(long, value_name = "MODEL.yaml")]
    model: Vec<PathBuf>,
    /// Trial of a recording to show [default: the first].
    #[arg(long, value_name = "N")]
    trial: Option<u64>,
    /// Policy to show, for a folder of results; repeatable [default: all].
    #[arg(long, value_name = "NAME")]
    policy: Vec<String>,
    /// Training of the networks to show, for a folder of results, `paper` or `converged` [default:
    /// the paper's].
    #[arg(long, value_name = "NAME")]
    training: Option<String>,
    /// Treat every row of a recording as a pose at rest.
    #[arg(long = "static")]
    at_rest: bool,
    /// Local port of the server; 0 selects a free port.
    #[arg(long, value_name = "N", default_value_t = 0)]
    port: u16,
    /// Print the address without opening a browser.
    #[arg(long)]
    no_open: bool,
    /// Write a GIF instead of serving a page: one row per recording or folder.
    #[arg(long, value_name = "OUT.gif")]
    record: Option<PathBuf>,
    /// Duration of the GIF, s.
    #[arg(long, value_name = "S", default_value_t = 10.0, requires = "record")]
    seconds: f64,
}

/// Frames of a scene, at most.
const MAX_FRAMES: usize = 600;
/// Bytes of a GIF, at most.
const GIF_BYTES: usize = 16 << 20;

impl ViewCommand {
    pub(crate) fn execute(self, progress: &Progress) -> CommandResult {
        self.check()?;
        if let [file] = self.shown.as_slice()
            && is_model(file)
        {
            let model = read_model(file).map_err(|error| not_a_model(file, &error.to_string()))?;
            return self.serve(Arc::new(LiveModel::new(&file.display().to_string(), model)));
        }
        progress.step("simulating");
        let strips = self.strips(progress)?;
        progress.done();
        if let Some(out) = &self.record {
            progress.step("drawing");
            let bytes = film(&strips, self.seconds).map_err(CommandError::failed)?;
            progress.done();
            write_atomic(out, &bytes).map_err(CommandError::bad_input)?;
            progress.say(&format!("wrote {}: {} KB", out.display(), bytes.len().div_ceil(1024)));
            return Ok(());
        }
        let [strip] = strips.as_slice() else {
            refuse!("found {} recordings, expected one, or --record", strips.len());
        };
        let note = if self.shown[0].is_dir() {
            "The robot under the recorded commands, simulated again without noise."
        } else {
            "The model simulated with the recorded commands, and the measured tip."
        };
        let page = player_page(&strip.heading, note, &strip.scenes);
        self.serve(Arc::new(FixedPage(page)))
    }

    /// Refuses what does not go together.
    fn check(&self) -> CommandResult {
        let model = self.shown.iter().find(|file| is_model(file));
        match (model, &self.record) {
            (Some(file), Some(_)) => {
                refuse!(
                    "{}: found a model, expected recordings or results to --record",
                    file.display()
                )
            }
            (Some(file), None) if self.shown.len() > 1 || !self.model.is_empty() => {
                refuse!(
                    "{}: found a model and other files, expected the model alone",
                    file.display()
                )
            }
            _ => {}
        }
        if !(self.seconds >= 0.5 && self.seconds <= 120.0) {
            refuse!("--seconds: found {}, expected 0.5 to 120", self.seconds);
        }
        let Some(out) = &self.record else { return Ok(()) };
        check_ending(out, &["gif"])?;
        check_file(out, GIF_BYTES)
    }

    /// The scenes of each file or folder.
    fn strips(&self, progress: &Progress) -> Result<Vec<FilmStrip>, CommandError> {
        let models = self
            .model
            .iter()
            .map(|file| read_model(file).map(|model| (model_name(file, &model), model)));
        let models: Vec<(String, Model)> =
            models.collect::<Result<_, _>>().map_err(CommandError::bad_input)?;
        let strip = |shown: &PathBuf| {
            if shown.is_dir() {
                let training = self.training.as_deref();
                let path = path_scenes(shown, training, &self.policy, MAX_FRAMES)?;
                let name = shown.file_name().unwrap_or_default().to_string_lossy();
                let networks = training_label(&path.training);
                let repetition = path.seed + 1;
                return Ok(FilmStrip {
                    heading: format!(
                        "Tracking a path ({name}, {networks}, repetition {repetition})"
                    ),
                    scenes: path.scenes,
                });
            }
            self.recorded(shown, &models, progress)
        };
        self.shown.iter().map(strip).collect()
    }

    /// One trial of a recording under each model.
    fn recorded(
        &self,
        file: &Path,
        models: &[(String, Model)],
        progress: &Progress,
    ) -> Result<FilmStrip, CommandError> {
        let read = if self.at_rest { Recording::read_poses } else { Recording::read_as_marked };
        let recording = read(file).map_err(CommandError::bad_input)?;
        let at_rest = poses_at_rest(self.at_rest, [(file, &recording)], progress)?;
        let trials = recording.trials();
        let number = self.trial.or(trials.first().map(|(number, _)| *number)).unwrap_or_default();
        let Some((_, rows)) = trials.into_iter().find(|(trial, _)| *trial == number) else {
            refuse!("--trial: found {number}, expected a trial of {}", file.display());
        };
        let rows: Vec<usize> = rows.collect();
        let trial: Recording = recording.rows(&rows);
        let mut scenes: Vec<Scene> = Vec::new();
        for (name, model) in models {
            let scene = scene_of_recording(name, file, &trial, model, at_rest);
            scenes.push(scene.map_err(CommandError::bad_input)?.thinned(MAX_FRAMES));
        }
        if models.is_empty() {
            scenes.push(scene_of_measurement("measured", &trial, at_rest).thinned(MAX_FRAMES));
        }
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let heading = if models.is_empty() {
            format!("{name}, trial {number}")
        } else {
            format!("{name}, trial {number}: model and measured tip")
        };
        Ok(FilmStrip { heading, scenes })
    }

    /// Serves a page until the program is ended.
    fn serve(&self, page: Arc<dyn ServedPage>) -> CommandResult {
        let server = ViewServer::open(self.port).map_err(|error| {
            CommandError::BadInput(format!(
                "--port: found {} ({error}), expected a free port",
                self.port
            ))
        })?;
        let url = server.url().map_err(CommandError::failed)?;
        print_all(
            format!("{url}\nOnly this computer can open it. Ctrl-C ends the program.\n").as_bytes(),
        );
        if !self.no_open {
            open_browser(&url);
        }
        server.serve(page).map_err(CommandError::failed)
    }
}

/// A page that needs no answers.
struct FixedPage(String);

impl ServedPage for FixedPage {
    fn page(&self) -> &str {
        &self.0
    }
}

/// Why a file is no model; in few words where it is an experiment.
fn not_a_model(file: &Path, why: &str) -> CommandError {
    if Experiment::read(file, &[]).is_err() {
        return CommandError::bad_input(why);
    }
    let shown = file.display();
    CommandError::BadInput(format!(
        "{shown}: found an experiment, expected a model; to see its robot, pass its folder of \
         results, such as results/fig8"
    ))
}

fn is_model(file: &Path) -> bool {
    let ending = file.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| ending == "yaml" || ending == "yml")
}

/// The model's file with its effects.
fn model_name(file: &Path, model: &Model) -> String {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let effects: Vec<&str> = model.effects.iter().map(|effect| effect.card().name).collect();
    if effects.is_empty() {
        name.into_owned()
    } else {
        format!("{name} with {}", effects.join(", "))
    }
}

/// Asks the desktop to open a page; without one the printed address has to do.
fn open_browser(url: &str) {
    let opener = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };
    let quiet = std::process::Stdio::null;
    let _ = std::process::Command::new(opener)
        .arg(url)
        .stdin(quiet())
        .stdout(quiet())
        .stderr(quiet())
        .spawn();
}
