//! The samples with their residuals, for `residuals.csv`.

use crate::data::findings::ResidualRow;
use crate::discovery::recording::samples::{Sample, Samples};

/// A row for each sample: its residuals `before` and after, three values a sample, metres. `points`: names of the
/// model's points.
pub(super) fn residual_rows(
    samples: &Samples,
    points: &[String],
    [before, after]: [&[f64]; 2],
    is_held_out: &dyn Fn(usize) -> bool,
) -> Vec<ResidualRow> {
    let row = |((sample, before), after): ((&Sample, &[f64; 3]), &[f64; 3])| ResidualRow {
        trial: samples.trials[sample.trial].number,
        time_s: sample.time_s,
        held_out: is_held_out(sample.trial),
        point: sample.point.map(|point| points[point].clone()).unwrap_or_default(),
        tip_x_m: sample.position_m[0],
        tip_y_m: sample.position_m[1],
        tip_z_m: sample.position_m[2],
        before_x_m: before[0],
        before_y_m: before[1],
        before_z_m: before[2],
        after_x_m: after[0],
        after_y_m: after[1],
        after_z_m: after[2],
    };
    samples.rows.iter().zip(before.as_chunks::<3>().0).zip(after.as_chunks::<3>().0).map(row).collect()
}
