//! Rows that are excluded: jumps, repeated poses, rows after gaps, lost tracking.

use super::clock_offset;
use crate::data::Recording;
use crate::data::findings::ExcludedRow;
use crate::data::recording::exclusions::Exclusions;
use crate::discovery::fit::simulate;
use crate::discovery::options::Options;
use crate::discovery::recording::samples::Samples;
use crate::effects::Model;

/// `model` as coarse as is enough to find faults of a recording.
pub(crate) fn coarse_model(model: &Model, options: &Options) -> Model {
    simulate::coarse(&simulate::search_resolution(model, options))
}

/// A recording without its faulty rows, and its samples.
pub(crate) struct PreparedRecording<'a> {
    /// The recording as given.
    pub(crate) original: &'a Recording,
    pub(crate) exclusions: Exclusions,
    /// The recording with the excluded rows marked as not tracked.
    pub(crate) kept: Recording,
    /// Samples of `kept`.
    pub(crate) samples: Samples,
}

impl<'a> PreparedRecording<'a> {
    pub(crate) fn new(
        model: &Model,
        original: &'a Recording,
        options: &Options,
    ) -> PreparedRecording<'a> {
        let samples = options.samples(model, original);
        let exclusions = exclusions(model, original, &samples, options);
        if exclusions.is_empty() {
            return PreparedRecording { original, exclusions, kept: original.clone(), samples };
        }
        // Excluded rows stay as commands: the robot obeyed them, though nothing was seen.
        let kept = exclusions.without(original);
        let samples = options.samples(model, &kept);
        PreparedRecording { original, exclusions, kept, samples }
    }

    /// The recording with its tips one step later, if each row holds the tip of the end of its
    /// command.
    pub(crate) fn in_step(self, model: &Model, options: &Options) -> PreparedRecording<'a> {
        let offset =
            (!options.at_rest).then(|| clock_offset::find(model, &self.kept, options)).flatten();
        let Some(offset) = offset.filter(|offset| offset.is_one_step) else { return self };
        let kept = self.kept.with_tips_later(offset.offset_s);
        let samples = options.samples(model, &kept);
        PreparedRecording { kept, samples, ..self }
    }

    /// Rows of the given recording that are not used, and why.
    pub(crate) fn excluded_rows(&self) -> Vec<ExcludedRow> {
        let PreparedRecording { original, exclusions, .. } = self;
        let reason = |row: usize| {
            exclusions.all().find(|excluded| excluded.row == row).map(|excluded| &*excluded.why)
        };
        let is_lost = |row: usize| !original.is_valid(row) || !original.is_seen(row);
        let why = |row: usize| reason(row).or_else(|| is_lost(row).then_some("tracking was lost"));
        let rows = (0..original.len()).filter_map(|row| {
            let why = why(row)?.to_owned();
            Some(ExcludedRow { trial: original.trial[row], time_s: original.time_s[row], why })
        });
        rows.collect()
    }
}

/// Suspicious rows of `measured`, by the tip and points that `model` predicts. None where the model
/// cannot follow the commands, which [`super::super::discover`] refuses by itself.
fn exclusions(
    model: &Model,
    measured: &Recording,
    samples: &Samples,
    options: &Options,
) -> Exclusions {
    let Some(simulated_m) = simulate::tips(&coarse_model(model, options), &[], samples) else {
        return Exclusions::default();
    };
    let predicted_m = |point: Option<usize>| {
        let mut predicted_m = vec![[f64::NAN; 3]; measured.len()];
        let each = samples.rows.iter().zip(simulated_m.as_chunks::<3>().0);
        for (sample, position_m) in each.filter(|(sample, _)| sample.point == point) {
            predicted_m[samples.trials[sample.trial].first_row + sample.row] = *position_m;
        }
        predicted_m
    };
    let mut exclusions = Exclusions::find(measured, &predicted_m(None));
    for (index, name) in model.tracking.names().iter().enumerate() {
        let Some(point) = measured.point(name) else { continue };
        let what = format!("point {name}");
        exclusions.extend(Exclusions::find_at(
            measured,
            &point.position_m,
            &what,
            &predicted_m(Some(index)),
        ));
    }
    // Times of poses at rest are arbitrary, so steps between them are no gaps.
    if options.at_rest { Exclusions { gaps: Vec::new(), ..exclusions } } else { exclusions }
}
