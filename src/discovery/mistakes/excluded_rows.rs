//! Rows that are left out: jumps, repeated poses, rows after gaps, lost tracking.

use crate::data::Recording;
use crate::data::findings::{ExcludedRow, Findings};
use crate::data::recording::exclusions::Exclusions;
use crate::discovery::fit::simulate;
use crate::discovery::options::Options;
use crate::effects::Model;

/// `model` as coarse as is enough to find faults of a recording.
pub(crate) fn coarse_model(model: &Model, options: &Options) -> Model {
    simulate::coarse(&simulate::search_resolution(model, options))
}

/// Suspicious rows of `measured`, by the tip and points that `model` predicts. None where the model cannot follow the commands,
/// which [`super::super::discover`] refuses by itself.
pub(crate) fn find(model: &Model, measured: &Recording, options: &Options) -> Exclusions {
    let samples = options.samples(model, measured);
    let Some(simulated_m) = simulate::tips(&coarse_model(model, options), &[], &samples) else {
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
    let mut found = Exclusions::find(measured, &predicted_m(None));
    for (index, name) in model.tracking.names().iter().enumerate() {
        let Some(point) = measured.point(name) else { continue };
        let place = (measured, point.position_m.as_slice());
        found.extend(Exclusions::find_at(place, &format!("point {name}"), &predicted_m(Some(index))));
    }
    // The times of poses at rest mean nothing.
    if options.at_rest { Exclusions { gaps: Vec::new(), ..found } } else { found }
}

/// Adds the excluded rows of `measured` to `findings`, and sentences about them and those of the `baseline`.
pub(crate) fn tell(
    findings: &mut Findings,
    (measured, excluded): (&Recording, &Exclusions),
    baseline: Option<(&Recording, &Exclusions)>,
) {
    let reason = |row: usize| excluded.all().find(|excluded| excluded.row == row).map(|excluded| excluded.why.clone());
    let is_lost = |row: usize| !measured.is_valid(row) || !measured.is_seen(row);
    let why = |row: usize| reason(row).or_else(|| is_lost(row).then(|| "tracking was lost".to_owned()));
    let rows = (0..measured.len()).filter_map(|row| {
        Some(ExcludedRow { trial: measured.trial[row], time_s: measured.time_s[row], why: why(row)? })
    });
    findings.excluded_rows = rows.collect();
    findings.limitations.extend(excluded.sentences(measured));
    if let Some((recording, excluded)) = baseline {
        findings.limitations.extend(excluded.sentences(recording).iter().map(|told| format!("Baseline: {told}")));
    }
}
