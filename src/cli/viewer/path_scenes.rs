//! Scenes of the path of Fig. 8 from published results: the robot of the spec under the commands
//! of the first repetition, simulated again.

use crate::cli::CommandError;
use spinebench::data::scene::Scene;
use spinebench::data::{Actuation, Recording};
use spinebench::effects::Model;
use spinebench::plants::PlantSpec;
use spinebench::report::overview::PathScenes;
use spinebench::report::published_rows;
use spinebench::report::style::{policies_in_order, policy_label};
use spinebench::rows::experiment::TrackRow;
use spinebench::specs::Experiment;
use spinebench::tasks::scene_of_recording;
use std::path::Path;

/// The file of a folder of results that says what robot it was.
const SPEC: &str = "spec.yaml";
/// Networks that stop at the errors of the paper.
const PAPER_TRAINING: &str = "paper";

/// The scenes of the path under each of `policies` (all that there are, for none), for networks of
/// `training` (the paper's where there are any, for none), with at most `frames` frames each.
///
/// # Errors
/// [`CommandError::BadInput`] for a folder without such results, or with those of a robot that is
/// not simulated.
pub(crate) fn path_scenes(
    folder: &Path,
    training: Option<&str>,
    policies: &[String],
    frames: usize,
) -> Result<PathScenes, CommandError> {
    let spec = folder.join(SPEC);
    if !spec.is_file() {
        refuse!(
            "{}: found no {SPEC}, expected the folder of one experiment that tracks a path, such \
             as results/fig8",
            folder.display()
        );
    }
    let experiment = Experiment::read(&spec, &[]).map_err(CommandError::bad_input)?;
    let tracks = published_rows::<TrackRow>(folder).map_err(CommandError::bad_input)?;
    let moved = tracks.iter().filter(|row| !row.sample.pulls_m.is_empty());
    let mut trainings: Vec<&str> = moved.clone().map(|row| row.training.as_str()).collect();
    trainings.sort_by_key(|name| *name != PAPER_TRAINING);
    let training = training.or(trainings.first().copied()).unwrap_or_default();
    let of_training = || moved.clone().filter(|row| row.training == training);
    let seed = of_training().map(|row| row.seed).min().unwrap_or_default();
    let rows: Vec<&TrackRow> = of_training().filter(|row| row.seed == seed).collect();
    if rows.is_empty() {
        let found = folder.display();
        refuse!(
            "{found}: found no tracked path with commands, expected the results of a run that tracks a path"
        );
    }
    let model = model(&experiment, &spec)?;
    let known = policies_in_order(rows.iter().map(|row| row.policy.as_str()));
    if let Some(other) = policies.iter().find(|policy| !known.contains(&policy.as_str())) {
        refuse!(
            "{}: found no policy `{other}`, expected one of {}",
            folder.display(),
            known.join(", ")
        );
    }
    let chosen = known
        .into_iter()
        .filter(|policy| policies.is_empty() || policies.iter().any(|wanted| wanted == policy));
    let scenes: Result<Vec<Scene>, CommandError> = chosen
        .map(|policy| {
            let mut steps: Vec<&TrackRow> =
                rows.iter().copied().filter(|row| row.policy == policy).collect();
            steps.sort_by_key(|row| row.sample.step);
            scene(policy, &steps, &model, &spec).map(|scene| scene.thinned(frames))
        })
        .collect();
    Ok(PathScenes { training: training.to_owned(), seed, scenes: scenes? })
}

/// The robot on which the path was tracked.
fn model(experiment: &Experiment, spec: &Path) -> Result<Model, CommandError> {
    let PlantSpec::Simulated(plant) = &experiment.plant else {
        let (file, kind) = (spec.display(), experiment.plant.kind());
        refuse!("{file}: plant: found `{kind}`, expected a simulated robot");
    };
    let mut model = plant.model.clone();
    if let Some(mode) =
        experiment.runs.track.as_ref().and_then(|run| experiment.modes.get(&run.mode))
    {
        model.effects.extend_from_slice(&mode.effects);
    }
    Ok(model)
}

/// The motion under one policy.
fn scene(
    policy: &str,
    steps: &[&TrackRow],
    model: &Model,
    spec: &Path,
) -> Result<Scene, CommandError> {
    let mut commands = Recording::new(Actuation::Lengths, model.robot.tendons.angles_deg.len());
    let mut time_s = 0.0;
    for (row, step) in steps.iter().map(Some).chain([None]).enumerate() {
        // A command is in force from the end of the step before; the last row shows its effect.
        let step = step.unwrap_or(&steps[row.saturating_sub(1)]);
        let pulls_m: Result<Vec<f64>, _> = step.sample.pulls_m.split(' ').map(str::parse).collect();
        let pulls_m = pulls_m.unwrap_or_default();
        if pulls_m.len() != commands.commands.width() {
            let found = &step.sample.pulls_m;
            refuse!("{}: pulls_m: found `{found}`, expected one number per tendon", spec.display());
        }
        commands.trial.push(0);
        commands.time_s.push(time_s);
        commands.commands.push(&pulls_m);
        time_s = step.sample.time_s;
    }
    let mut scene = scene_of_recording(policy_label(policy), spec, &commands, model, false)
        .map_err(CommandError::bad_input)?;
    // The target of a frame is that of the step after it.
    let targets = steps.iter().chain(steps.last());
    for (frame, step) in scene.frames.iter_mut().zip(targets) {
        let sample = &step.sample;
        frame.target_m = Some([sample.target_x_m, sample.target_y_m, sample.target_z_m]);
    }
    Ok(scene)
}
