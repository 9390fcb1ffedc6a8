//! Where a model errs: by point, pattern and place.

use std::collections::BTreeMap;

use crate::calibration::compare::blocks::Blocks;
use crate::calibration::compare::comparison::Comparison;
use crate::calibration::fit::optimum::Optimum;
use crate::data::calibration::{ResidualGroup, SightingRow};

/// Root mean square and mean error of groups of sightings.
pub(crate) fn groups(
    comparison: &Comparison,
    blocks: &Blocks,
    best: &Optimum,
) -> Vec<ResidualGroup> {
    let mut all = Vec::new();
    let mut by = |kind: &str, name: &dyn Fn(usize) -> String| {
        let mut groups: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for index in
            (0..comparison.sightings.len()).filter(|&index| best.positions[index].is_some())
        {
            groups.entry(name(index)).or_default().push(index);
        }
        let mut of_kind: Vec<ResidualGroup> =
            groups.into_iter().map(|(name, members)| group(kind, name, &members, best)).collect();
        // The worst first: that is where to look.
        of_kind.sort_by(|a, b| b.rms_m.total_cmp(&a.rms_m));
        all.extend(of_kind);
    };
    by("point", &|index| comparison.markers[comparison.sightings[index].marker].clone());
    if comparison.recordings.each.len() > 1 {
        by("recording", &|index| {
            let place = comparison.recordings.of_row(comparison.sightings[index].row);
            comparison.recordings.each[place].0.clone()
        });
    }
    by(blocks.kind, &|index| blocks.names[blocks.of[index]].clone());
    let extents = extents(comparison);
    by("place", &|index| place(comparison, &extents, index));
    all
}

fn group(kind: &str, name: String, members: &[usize], best: &Optimum) -> ResidualGroup {
    let count = members.len() as f64;
    let residual = |index: usize, axis: usize| best.residual_m[3 * index + axis];
    let mean =
        |axis: usize| members.iter().map(|&index| residual(index, axis)).sum::<f64>() / count;
    let squares =
        members.iter().map(|&index| best.residual_m.rows(3 * index, 3).norm_squared()).sum::<f64>();
    ResidualGroup {
        kind: kind.to_owned(),
        name,
        positions: members.len(),
        rms_m: (squares / count).sqrt(),
        mean_x_m: mean(0),
        mean_y_m: mean(1),
        mean_z_m: mean(2),
    }
}

/// Middle of the sightings of each point across the robot, and how far out they reach, metres.
fn extents(comparison: &Comparison) -> Vec<([f64; 2], f64)> {
    let of = |marker: usize| {
        let same: Vec<_> =
            comparison.sightings.iter().filter(|sighting| sighting.marker == marker).collect();
        let mean = |axis: usize| {
            same.iter().map(|sighting| sighting.at_m[axis]).sum::<f64>() / same.len() as f64
        };
        let middle = [mean(0), mean(1)];
        let out = |at: &[f64; 3]| (at[0] - middle[0]).hypot(at[1] - middle[1]);
        (middle, same.iter().map(|sighting| out(&sighting.at_m)).fold(0.0, f64::max))
    };
    (0..comparison.markers.len()).map(of).collect()
}

/// Where a sighting lies: towards one of the four sides, and how far out among those of its point.
fn place(comparison: &Comparison, extents: &[([f64; 2], f64)], index: usize) -> String {
    let sighting = comparison.sightings[index];
    let (middle, farthest) = extents[sighting.marker];
    let (x, y) = (sighting.at_m[0] - middle[0], sighting.at_m[1] - middle[1]);
    let side = match (x.abs() > y.abs(), x > 0.0, y > 0.0) {
        (true, true, _) => "+x",
        (true, false, _) => "−x",
        (false, _, true) => "+y",
        (false, _, false) => "−y",
    };
    let how = if x.hypot(y) > 0.5 * farthest { "far out" } else { "near the middle" };
    format!("{} towards {side}, {how}", comparison.markers[sighting.marker])
}

/// Every sighting with its error.
pub(crate) fn rows(comparison: &Comparison, blocks: &Blocks, best: &Optimum) -> Vec<SightingRow> {
    let row = |index: usize| {
        let sighting = comparison.sightings[index];
        let solved = best.positions[index].is_some();
        let residual =
            |axis: usize| if solved { best.residual_m[3 * index + axis] } else { f64::NAN };
        SightingRow {
            trial: comparison.recordings.joined.trial[sighting.row],
            time_s: comparison.recordings.joined.time_s[sighting.row],
            block: blocks.names[blocks.of[index]].clone(),
            point: comparison.markers[sighting.marker].clone(),
            x_m: sighting.at_m[0],
            y_m: sighting.at_m[1],
            z_m: sighting.at_m[2],
            error_x_m: residual(0),
            error_y_m: residual(1),
            error_z_m: residual(2),
            weight: best.weights[index],
        }
    };
    (0..comparison.sightings.len()).map(row).collect()
}
