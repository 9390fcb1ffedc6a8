//! What a model lacks of the robot as it was built, and what has changed since.

use super::diagnosis::Diagnosis;
use crate::data::{Actuation, Recording};
use crate::discovery::{Options, discover};
use crate::effects::{EffectSpec, Model};
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::tasks::Transitions;

/// Handles of the recording before the change, of that after the alarm, and of what the model
/// lacked before.
type DiagnoseInputs = (Handle<Transitions>, Handle<Transitions>, Handle<Diagnosis>);

/// What the model lacks of the robot as it was built.
pub(crate) const IDENTIFY: Stage<DiagnoseParams, Handle<Transitions>, Diagnosis> = Stage {
    kind: StageKind { name: "identify", module: module_path!(), cost_ms: 20_000 },
    job: |params, built| Ok(params.answer(&[], built, None)),
};

/// What has changed since.
pub(crate) const DIAGNOSE: Stage<DiagnoseParams, DiagnoseInputs, Diagnosis> = Stage {
    kind: StageKind { name: "diagnose", module: module_path!(), cost_ms: 15_000 },
    job: |params, (built, changed, identified)| {
        Ok(params.answer(&identified.effects, changed, Some(built)))
    },
};

/// Parameters of [`IDENTIFY`] and [`DIAGNOSE`].
#[derive(Clone, serde::Serialize)]
pub(crate) struct DiagnoseParams {
    pub(crate) model: Model,
    pub(crate) options: Options,
    pub(crate) step_s: f64,
}

impl DiagnoseParams {
    /// The answer for the model with the `identified` effects. Data that allow none are an answer,
    /// too: a lab then has no line to add.
    fn answer(
        &self,
        identified: &[EffectSpec],
        measured: &Transitions,
        baseline: Option<&Transitions>,
    ) -> Diagnosis {
        let mut model = self.model.clone();
        model.effects.extend(identified.iter().cloned());
        let baseline = baseline.map(|baseline| recording(baseline, self.step_s));
        let measured = recording(measured, self.step_s);
        let samples = measured.len() as u64;
        match discover(&model, &measured, baseline.as_ref(), &self.options) {
            Ok(discovery) => Diagnosis {
                verdict: discovery.findings.verdict.name().to_owned(),
                effects: discovery
                    .model
                    .effects
                    .iter()
                    .skip(model.effects.len())
                    .cloned()
                    .collect(),
                samples,
                gap_m: [discovery.findings.gap.before_m, discovery.findings.gap.after_m],
                noise_floor_m: discovery.findings.noise_floor_m,
            },
            Err(error) => Diagnosis::nothing(format!("failed: {error}"), samples),
        }
    }
}

/// Transitions as a recording: a row holds the tip at its time and the command from then on; the
/// last command is held.
fn recording(samples: &Transitions, step_s: f64) -> Recording {
    let mut recording = Recording::new(Actuation::Lengths, samples.pulls_m.width());
    let mut tips_m = Vec::with_capacity(samples.len() + samples.starts.len());
    for (number, range) in samples.trajectories().into_iter().enumerate() {
        for row in 0..=range.len() {
            recording.trial.push(number as u64);
            recording.time_s.push(row as f64 * step_s);
            recording.commands.push(samples.pulls_m.row((range.start + row).min(range.end - 1)));
            let tip_m = if row == 0 {
                samples.from_m.row(range.start)
            } else {
                samples.to_m.row(range.start + row - 1)
            };
            tips_m.push([tip_m[0], tip_m[1], tip_m[2]]);
        }
    }
    recording.tip_m = Some(tips_m);
    recording
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rows;

    fn table(rows: &[&[f64]]) -> Rows {
        let mut table = Rows::new(rows[0].len());
        rows.iter().for_each(|row| table.push(row));
        table
    }

    #[test]
    fn a_row_holds_the_tip_at_its_time_and_the_command_from_then_on() {
        let samples = Transitions {
            from_m: table(&[&[0.0, 0.0, 0.2], &[0.01, 0.0, 0.2], &[0.0, 0.0, 0.21]]),
            pulls_m: table(&[&[0.001, -0.001], &[0.002, -0.002], &[0.003, -0.003]]),
            to_m: table(&[&[0.01, 0.0, 0.2], &[0.02, 0.0, 0.2], &[0.03, 0.0, 0.2]]),
            starts: vec![0, 2],
        };
        let recording = recording(&samples, 0.2);
        assert_eq!(recording.trial, [0, 0, 0, 1, 1]);
        assert_eq!(recording.time_s, [0.0, 0.2, 0.4, 0.0, 0.2]);
        let first: Vec<f64> = (0..5).map(|row| recording.commands.row(row)[0]).collect();
        assert_eq!(first, [0.001, 0.002, 0.002, 0.003, 0.003]);
        let x: Vec<f64> = recording.tip_m.unwrap().iter().map(|tip_m| tip_m[0]).collect();
        assert_eq!(x, [0.0, 0.01, 0.02, 0.0, 0.03]);
    }
}
