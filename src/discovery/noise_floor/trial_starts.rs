//! Trial starts that may not be settled at home as the model assumes: trials cut from a longer log,
//! or a tracker that was not ready.

use super::NoiseFloor;
use crate::discovery::recording::samples::{Sample, Samples};
use crate::effects::Model;

/// First tip positions that scatter by more than this share of the backbone's length are doubtful
/// (docs/reference/discovery.md, "What to record").
const MAX_SCATTER_SHARE: f64 = 0.01;
/// Time after which the start of a trial has no influence, seconds.
const EXCLUDED_START_S: f64 = 1.0;

/// Scatter of first tip positions, if it is doubtful.
pub(crate) fn scattered_starts(samples: &Samples, model: &Model) -> Option<NoiseFloor> {
    let starts = NoiseFloor::from_starts(samples);
    (starts.rms_m() > MAX_SCATTER_SHARE * model.robot.backbone.length_m).then_some(starts)
}

/// Samples without the starts of trials.
pub(crate) fn without_starts(samples: &Samples) -> Samples {
    let rows: Vec<Sample> =
        samples.rows.iter().filter(|row| row.time_s > EXCLUDED_START_S).copied().collect();
    let later = Samples { trials: samples.trials.clone(), rows, ..*samples };
    // A trial shorter than a second has no sample left.
    let seen = later.ranges().into_iter().enumerate().filter(|(_, rows)| !rows.is_empty());
    later.of_trials(&seen.map(|(trial, _)| trial).collect::<Vec<usize>>())
}

/// Limitation if trial starts were excluded; `starts`: their scatter.
pub(crate) fn starts_caveat(starts: &NoiseFloor) -> String {
    format!(
        "The first tip positions of the trials scatter by {:.1} mm, far more than the residual of \
         later samples: not every trial starts settled at home, as the model does, or the tracker \
         was not ready. The first second of each trial was excluded, and the starts were not used \
         to estimate the noise.",
        1e3 * starts.rms_m()
    )
}

/// The same for the baseline.
pub(crate) fn baseline_starts_caveat(starts: &NoiseFloor) -> String {
    format!(
        "The first tip positions of the baseline's trials scatter by {:.1} mm; the first second of \
         each trial was excluded.",
        1e3 * starts.rms_m()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_first_second_is_left_out_and_trials_of_no_more_with_it() {
        let mut samples = Samples::alike(3, 10);
        samples.rows.retain(|sample| sample.trial != 1 || sample.row < 5);
        assert!(scattered_starts(&samples, &Model::default()).is_none());
        samples.rows[0].position_m[0] = 0.02;
        let starts = scattered_starts(&samples, &Model::default()).unwrap();
        assert!((starts.rms_m() - 0.02 / 3.0_f64.sqrt()).abs() < 1e-12);
        let later = without_starts(&samples);
        assert_eq!(later.trials.iter().map(|trial| trial.number).collect::<Vec<u64>>(), [0, 2]);
        let rows: Vec<(usize, usize)> =
            later.rows.iter().map(|sample| (sample.trial, sample.row)).collect();
        assert_eq!(
            rows,
            (0..2).flat_map(|trial| (6..10).map(move |row| (trial, row))).collect::<Vec<_>>()
        );
    }
}
