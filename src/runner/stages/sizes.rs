//! How large the stages of an experiment are beside those of the paper's experiments, for which
//! [`crate::runner::graph::stage::StageKind::cost_ms`] is given.

use crate::runner::jobs::data::exploration::{EXPLORE, REPLAY};
use crate::runner::jobs::data::gp_pool::GP_POOL;
use crate::runner::jobs::data::targets::TARGET_POOL;
use crate::runner::jobs::trials::reach_track::{REACH, TRACK};
use crate::runner::jobs::trials::responses::{PACE, RESPONSE};
use crate::specs::Experiment;
use crate::tasks::{ExploreOptions, GridOptions, PathOptions, PointLayout, TargetOptions};
use std::collections::BTreeMap;

/// Points of the Gaussian process whose fit costs what its kind says; more cost the cube.
pub(super) const GP_POINTS: f64 = 100.0;
/// Epochs after which the training of a network usually ends.
const USUAL_EPOCHS: f64 = 400.0;
/// Units of the networks of the paper.
const HIDDEN: f64 = 30.0;
/// Steps of a trial that reaches its target, ticks of a response, and laps of a stage.
const USUAL_STEPS: f64 = 20.0;
const USUAL_RESPONSE_S: f64 = 10.0;
const USUAL_SPEEDS: f64 = 3.0;

/// Sizes by kind of stage; of kinds that are not named, 1. `networks` are the kinds that train on
/// the exploration.
pub(super) fn sizes(
    spec: &Experiment,
    networks: impl Iterator<Item = &'static str>,
) -> BTreeMap<&'static str, f64> {
    let share = |number: usize, usual: usize| number as f64 / usual as f64;
    let nodes = |grid: &GridOptions| (grid.rows * grid.columns) as f64;
    let explored = share(spec.explore.points, ExploreOptions::default().points);
    let drawn = share(spec.targets.drawn, TargetOptions::default().drawn);
    let pool = match spec.gp_points.layout {
        PointLayout::Grid(grid) => nodes(&grid),
        PointLayout::Walk { points, every, .. } => (points * every) as f64,
    };
    let epochs = (spec.network.max_epochs as f64 / USUAL_EPOCHS).min(1.0);
    let network = explored * epochs * (spec.network.hidden as f64 / HIDDEN);
    let steps = (spec.reach.max_steps as f64 / USUAL_STEPS).min(1.0);
    let response_s = spec.runs.response.as_ref().map_or(USUAL_RESPONSE_S, |run| run.duration_s);
    let speeds = spec.runs.pace.as_ref().map_or(USUAL_SPEEDS, |run| run.speeds.len() as f64);
    let mut sizes = BTreeMap::from([
        (EXPLORE.kind.name, explored),
        (REPLAY.kind.name, explored),
        (GP_POOL.kind.name, pool / nodes(&GridOptions::default())),
        (
            TARGET_POOL.kind.name,
            nodes(&spec.targets.sweep) / nodes(&TargetOptions::default().sweep),
        ),
        (REACH.kind.name, drawn * steps),
        (TRACK.kind.name, share(spec.path.points, PathOptions::default().points)),
        (RESPONSE.kind.name, drawn * response_s / USUAL_RESPONSE_S),
        (PACE.kind.name, speeds / USUAL_SPEEDS),
    ]);
    sizes.extend(networks.map(|kind| (kind, network)));
    sizes
}
