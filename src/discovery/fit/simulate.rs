//! Simulation of models with the commands of samples.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::obstacle_hint::BodyRow;
use crate::base::{Point3, counted};
use crate::discovery::options::Options;
use crate::discovery::recording::samples::{Sample, Samples, TrialCommands};
use crate::effects::replay;
use crate::effects::{BodyPoint, EffectSpec, Model, Trial};
use crate::math::rotation;

/// Coarse resolution for screening and rough fits: factors on time tolerance and cell length, and
/// numbers of modes.
const COARSE_TOLERANCE_FACTOR: f64 = 10.0;
const COARSE_CELL_FACTOR: f64 = 1.5;
const BENDING_MODES: usize = 4;
const OTHER_MODES: usize = 3;
/// Fine resolution of the final fit: factor on the time tolerance. At the resolution of the search
/// the error corresponds to the information in some hundred samples.
const FINE_TOLERANCE_FACTOR: f64 = 30.0;
/// Static tolerance over the time-stepping tolerance.
const STATIC_SHARE: f64 = 0.3;

/// `model` at the resolution of the search: of the time steps and cells of `options`, with rest
/// states on the same grid.
pub(crate) fn search_resolution(model: &Model, options: &Options) -> Model {
    let mut model = model.clone();
    let resolution = &mut model.robot.resolution;
    resolution.motion_tolerance_m = options.motion_tolerance_m;
    resolution.static_tolerance_m = f64::INFINITY;
    resolution.cell_m = resolution.cell_m.max(options.cell_m);
    // Cells across material jumps take 0.4 of the time and put the tip 0.004 mm off.
    resolution.blended = true;
    model
}

/// `model` at the coarse resolution; two to three times faster.
pub(crate) fn coarse(model: &Model) -> Model {
    let mut coarse = model.clone();
    let resolution = &mut coarse.robot.resolution;
    resolution.motion_tolerance_m *= COARSE_TOLERANCE_FACTOR;
    resolution.cell_m *= COARSE_CELL_FACTOR;
    resolution.bending_modes = resolution.bending_modes.min(BENDING_MODES);
    for modes in
        [&mut resolution.torsion_modes, &mut resolution.shear_modes, &mut resolution.axial_modes]
    {
        *modes = (*modes).min(OTHER_MODES);
    }
    coarse
}

/// `model` at the fine resolution, with cells that end at material jumps; ten times slower.
fn fine(model: &Model) -> Model {
    let mut fine = model.clone();
    let resolution = &mut fine.robot.resolution;
    resolution.motion_tolerance_m /= FINE_TOLERANCE_FACTOR;
    resolution.static_tolerance_m = STATIC_SHARE * resolution.motion_tolerance_m;
    resolution.blended = false;
    fine
}

/// [`tips`] at the fine resolution; none if the simulation fails.
pub(crate) fn fine_tips(
    model: &Model,
    extra: &[EffectSpec],
    samples: &Samples,
) -> Option<Vec<f64>> {
    let fine = fine(model);
    // Rest states that do not converge to the fine tolerance use the grid of the motion.
    let mut coarse_rest = fine.clone();
    coarse_rest.robot.resolution.static_tolerance_m = f64::INFINITY;
    tips(&fine, extra, samples).or_else(|| tips(&coarse_rest, extra, samples))
}

/// `samples` minus the difference of the fine solution `fine` and the coarse solution
/// `simulated_m`: a fit to them equals a fit at the fine resolution (defect correction; Stetter,
/// Numerische Mathematik 29, 1978).
pub(crate) fn corrected(samples: &Samples, fine: &[f64], simulated_m: &[f64]) -> Samples {
    let mut corrected = samples.clone();
    for (row, (fine, simulated_m)) in
        corrected.rows.iter_mut().zip(fine.chunks_exact(3).zip(simulated_m.chunks_exact(3)))
    {
        row.position_m =
            std::array::from_fn(|axis| row.position_m[axis] - (fine[axis] - simulated_m[axis]));
    }
    corrected
}

/// Simulated tip or point of `model` with `extra` effects in every sample, three values a sample,
/// metres; none if the simulation fails. Trials run in parallel.
pub(crate) fn tips(model: &Model, extra: &[EffectSpec], samples: &Samples) -> Option<Vec<f64>> {
    let simulated: Vec<SimulatedPlaces> = samples
        .trials
        .par_iter()
        .map(counted(|trial| SimulatedPlaces::new(model, extra, trial)))
        .collect::<Option<_>>()?;
    Some(samples.rows.iter().flat_map(|row| simulated[row.trial].position_m(row)).collect())
}

/// Places along the body at which obstacles are asked for.
const BODY_PLACES: usize = 12;

/// The body of `model` in the samples of the tip, in the frame of its base, with their residuals
/// (three values a sample, metres); none if the simulation fails.
pub(crate) fn body_rows(
    model: &Model,
    samples: &Samples,
    residual_m: &[f64],
) -> Option<Vec<BodyRow>> {
    let mut model = model.clone();
    let place = |k: usize| {
        let s_m = model.robot.backbone.length_m * (k + 1) as f64 / BODY_PLACES as f64;
        (format!("{k:03}"), BodyPoint { s_m, offset_m: [0.0; 3] })
    };
    model.tracking.points = (0..BODY_PLACES).map(place).collect();
    let simulated: Vec<SimulatedPlaces> = samples
        .trials
        .par_iter()
        .map(counted(|trial| SimulatedPlaces::new(&model, &[], trial)))
        .collect::<Option<_>>()?;
    let base_m = Vector3::from(model.robot.base_m);
    let from_world = rotation::exp(&Vector3::from(model.robot.base_rotation_rad)).transpose();
    let row = |(sample, residual): (&Sample, &[f64])| BodyRow {
        places_m: simulated[sample.trial].points_m[sample.row]
            .iter()
            .map(|place_m| from_world * (Vector3::from(*place_m) - base_m))
            .collect(),
        residual_m: from_world * Vector3::from_column_slice(residual),
    };
    let tips = samples
        .rows
        .iter()
        .zip(residual_m.chunks_exact(3))
        .filter(|(sample, _)| sample.point.is_none());
    Some(tips.map(row).collect())
}

/// Positions before the first command and at the end of each, or at rest under each, metres.
struct SimulatedPlaces {
    tips_m: Vec<Point3>,
    /// Those of the tracked points, in the model's order.
    points_m: Vec<Vec<Point3>>,
}

impl SimulatedPlaces {
    fn new(model: &Model, extra: &[EffectSpec], trial: &TrialCommands) -> Option<SimulatedPlaces> {
        let commands = Trial {
            commands: &trial.commands,
            durations_s: &trial.durations_s,
            tensions: trial.tensions,
            at_rest: trial.at_rest,
            starts: trial.starts.unwrap_or(model.tracking.starts),
            tip_loads: trial.tip_loads.as_deref(),
        };
        let load = (trial.known_load_kg > 0.0).then(|| EffectSpec::tip_load(trial.known_load_kg));
        let extra: Vec<EffectSpec> = extra.iter().cloned().chain(load).collect();
        let gravity = trial.gravity_m_s2.map(|gravity_m_s2| {
            let mut turned = model.clone();
            turned.robot.gravity_m_s2 = gravity_m_s2;
            turned
        });
        // A trial on a turned base differs in gravity alone.
        let model = gravity.as_ref().unwrap_or(model);
        let played = replay(model, &extra, &commands, &[]).ok()?;
        let mut simulated = SimulatedPlaces { tips_m: played.tips_m, points_m: played.points_m };
        if trial.at_rest {
            // The state before the first command belongs to no row.
            simulated.tips_m.remove(0);
            simulated.points_m.remove(0);
        }
        let mut all = simulated.tips_m.iter().chain(simulated.points_m.iter().flatten()).flatten();
        // A diverged simulation would poison every sum of squares.
        all.all(|x| x.is_finite()).then_some(simulated)
    }

    fn position_m(&self, sample: &Sample) -> Point3 {
        sample.point.map_or(self.tips_m[sample.row], |point| self.points_m[sample.row][point])
    }
}

/// Three noise-free trials of `model` with `extra` effects on circling commands.
#[cfg(test)]
pub(crate) fn circling(model: &Model, extra: &[EffectSpec]) -> Samples {
    use crate::data::{Actuation, Recording};

    let mut recording = Recording::new(Actuation::Lengths, 4);
    let mut tips_m = Vec::new();
    for trial in 0..3_u64 {
        for row in 0..20 {
            let angle = 0.4 * f64::from(row) + trial as f64;
            let (x, y) = (6e-3 * angle.sin(), 6e-3 * (0.6 * angle).sin());
            recording.trial.push(trial);
            recording.time_s.push(0.2 * f64::from(row));
            recording.commands.push(&[x.max(0.0), y.max(0.0), (-x).max(0.0), (-y).max(0.0)]);
            tips_m.push([0.0; 3]);
        }
    }
    recording.tip_m = Some(tips_m);
    let mut samples = Samples::new(&recording);
    let simulated_m = tips(model, extra, &samples).unwrap();
    for (row, tip) in samples.rows.iter_mut().zip(simulated_m.chunks_exact(3)) {
        row.position_m = [tip[0], tip[1], tip[2]];
    }
    samples
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::data::Recording;
    use crate::discovery::recording::samples::rms_m;

    #[test]
    fn corrected_samples_are_those_of_finer_steps() {
        let mut model = Model::default();
        let resolution = &mut model.robot.resolution;
        (resolution.motion_tolerance_m, resolution.static_tolerance_m) = (3e-5, f64::INFINITY);
        (resolution.cell_m, resolution.blended) = (0.03, true);
        let mut exact = Model::default();
        exact.robot.resolution.motion_tolerance_m = 3e-7;
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/twin/nothing.csv");
        let mut samples = Samples::new(&Recording::read(&file).unwrap()).of_trials(&[0, 1]);
        let tips_m = tips(&exact, &[], &samples).unwrap();
        for (row, tip) in samples.rows.iter_mut().zip(tips_m.chunks_exact(3)) {
            row.position_m = [tip[0], tip[1], tip[2]];
        }
        let simulated_m = tips(&model, &[], &samples).unwrap();
        let fine = fine_tips(&model, &[], &samples).unwrap();
        let [before_m, after_m] = [&samples, &corrected(&samples, &fine, &simulated_m)]
            .map(|samples| rms_m(&samples.residual(&simulated_m)));
        assert!(before_m > 1e-5 && after_m < 0.4 * before_m, "{before_m} to {after_m}");
    }
}
