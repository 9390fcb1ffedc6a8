//! Which values of a swept field make a difference: each against the field's first value,
//! repetition by repetition.

use std::collections::{BTreeMap, HashMap};

use super::rows::SweepCell;
use crate::math::distribution::{holm, student_beyond};
use crate::math::summary::{interval_95, mean, standard_deviation};
use crate::rows::experiment::ComparisonRow;

/// One point of a sweep: which value each field has, and what came out there.
pub struct SweptPoint {
    /// Index of the value of each field.
    pub values: Vec<usize>,
    /// The summary at this point, with the errors of each repetition.
    pub cells: Vec<SweepCell>,
}

/// The comparisons of every point with the point that differs from it in one field alone, which has
/// its first value there: Student's t-test of the differences, paired by seed, and Holm's
/// correction over all comparisons of one field and task but those without any difference: a policy
/// that does not use a field is no test of it. With each goes the index of its point. `fields` are
/// names and values. Fewer than two common repetitions give none.
pub fn comparisons(
    fields: &[(String, Vec<String>)],
    points: &[SweptPoint],
) -> Vec<(usize, ComparisonRow)> {
    let at: HashMap<&[usize], &SweptPoint> =
        points.iter().map(|point| (point.values.as_slice(), point)).collect();
    let mut rows = Vec::new();
    for (index, point) in points.iter().enumerate() {
        for (field, (name, values)) in
            fields.iter().enumerate().filter(|(field, _)| point.values[*field] > 0)
        {
            let mut first = point.values.clone();
            first[field] = 0;
            let (Some(reference), Some(label)) = (at.get(first.as_slice()), values.first()) else {
                continue;
            };
            let row = |(cell, reference)| Some((index, compared(cell, reference, name, label)?));
            rows.extend(pairs(point, reference).filter_map(row));
        }
    }
    correct(&mut rows);
    rows
}

/// The cells of a point, each with the one of the reference that has the same task, training,
/// policy and mode. Sizes may be what is swept: cells that differ in them alone are paired by their
/// order.
fn pairs<'a>(
    point: &'a SweptPoint,
    reference: &'a SweptPoint,
) -> impl Iterator<Item = (&'a SweepCell, &'a SweepCell)> {
    let key = |cell: &SweepCell| {
        let row = &cell.row;
        (row.task.clone(), row.training.clone(), row.cell.policy.clone(), row.cell.mode.clone())
    };
    let mut reference_cells: HashMap<_, Vec<&SweepCell>> = HashMap::new();
    for cell in reference.cells.iter().rev() {
        reference_cells.entry(key(cell)).or_default().push(cell);
    }
    point
        .cells
        .iter()
        .filter_map(move |cell| Some((cell, reference_cells.get_mut(&key(cell))?.pop()?)))
}

fn compared(
    cell: &SweepCell,
    reference: &SweepCell,
    field: &str,
    label: &str,
) -> Option<ComparisonRow> {
    let paired = cell
        .seed_means_m
        .iter()
        .filter_map(|(seed, ours)| Some(ours - reference.seed_means_m.get(seed)?));
    let differences_m: Vec<f64> = paired.collect();
    let freedom = differences_m.len().checked_sub(1).filter(|&freedom| freedom > 0)? as f64;
    let [low_95_m, high_95_m] = interval_95(&differences_m)?;
    let difference_m = mean(&differences_m);
    let standard_error_m = standard_deviation(&differences_m) / (differences_m.len() as f64).sqrt();
    // A field without influence gives the same bits.
    let p = if difference_m == 0.0 {
        1.0
    } else {
        student_beyond(difference_m / standard_error_m, freedom)
    };
    let row = &cell.row;
    Some(ComparisonRow {
        field: field.to_owned(),
        reference: label.to_owned(),
        task: row.task.clone(),
        training: row.training.clone(),
        cell: row.cell.clone(),
        difference_m,
        low_95_m,
        high_95_m,
        seeds: differences_m.len() as u64,
        p,
        p_holm: f64::NAN,
    })
}

/// Fills in the corrected p-values, field by field and task by task. Equal bits stay out of the
/// family.
fn correct(rows: &mut [(usize, ComparisonRow)]) {
    let mut families: BTreeMap<(String, String), Vec<usize>> = BTreeMap::new();
    for (place, (_, row)) in rows.iter_mut().enumerate() {
        if row.low_95_m == 0.0 && row.high_95_m == 0.0 {
            row.p_holm = 1.0;
            continue;
        }
        families.entry((row.field.clone(), row.task.clone())).or_default().push(place);
    }
    for places in families.into_values() {
        let p_values: Vec<f64> = places.iter().map(|&place| rows[place].1.p).collect();
        for (place, corrected) in places.into_iter().zip(holm(&p_values)) {
            rows[place].1.p_holm = corrected;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::cell::CellLabel;
    use crate::rows::experiment::SweepRow;

    fn cell(policy: &str, gp_points: u64, seed_means_m: &[f64]) -> SweepCell {
        let row = SweepRow {
            task: "reach".into(),
            training: "paper".into(),
            cell: CellLabel {
                policy: policy.into(),
                mode: "open".into(),
                gp_points,
                real_points: 0,
            },
            mean_m: mean(seed_means_m),
            sd_over_seeds_m: f64::NAN,
            low_95_m: f64::NAN,
            high_95_m: f64::NAN,
            seeds: seed_means_m.len() as u64,
            count: 1,
            failed: 0,
        };
        SweepCell { row, seed_means_m: (0..).zip(seed_means_m.iter().copied()).collect() }
    }

    fn swept(name: &str, values: &[&str]) -> (String, Vec<String>) {
        (name.into(), values.iter().map(|&value| value.into()).collect())
    }

    /// Numbers of the t-test by hand: differences 1, 2, 3 have mean 2, standard error 1/√3, t = 2√3
    /// with 2 degrees of freedom.
    #[test]
    fn differences_are_paired_by_repetition_and_corrected() {
        let fields = [swept("kernel", &["one", "two", "three"])];
        let point = |value: usize, means: &[f64]| SweptPoint {
            values: vec![value],
            cells: vec![cell("a", 100, means)],
        };
        let points = [
            point(0, &[1.0, 5.0, 9.0]),
            point(1, &[2.0, 7.0, 12.0]),
            point(2, &[2.0, 4.0, 9.0]),
            point(3, &[1.0, 5.0, 9.0]),
        ];
        let rows = comparisons(&fields, &points);
        assert_eq!(rows.iter().map(|(point, _)| *point).collect::<Vec<_>>(), [1, 2, 3]);
        let row = &rows[0].1;
        assert!((row.difference_m - 2.0).abs() < 1e-12 && row.reference == "one", "{row:?}");
        assert!(
            (row.p - 0.074_179_9).abs() < 1e-6 && (row.p_holm - 2.0 * row.p).abs() < 1e-12,
            "{row:?}"
        );
        assert_eq!((rows[1].1.p, rows[1].1.p_holm), (1.0, 1.0));
        assert_eq!((rows[2].1.p, rows[2].1.p_holm), (1.0, 1.0), "the same bits are no test");
    }

    #[test]
    fn a_point_is_compared_in_each_field_by_itself_and_sizes_may_be_swept() {
        let fields = [swept("kernel", &["one", "two"]), swept("points", &["10", "20"])];
        let point = |values: [usize; 2], size: u64, means: &[f64]| SweptPoint {
            values: values.to_vec(),
            cells: vec![cell("a", size, means), cell("b", size, &[1.0])],
        };
        let points = [
            point([0, 0], 10, &[3.0, 4.0]),
            point([0, 1], 20, &[2.0, 2.5]),
            point([1, 0], 10, &[5.0, 7.0]),
            point([1, 1], 20, &[1.0, 1.5]),
        ];
        let rows = comparisons(&fields, &points);
        let told: Vec<(usize, &str, f64)> = rows
            .iter()
            .map(|(point, row)| (*point, row.field.as_str(), row.difference_m))
            .collect();
        // One repetition of policy b says nothing.
        assert_eq!(
            told,
            [(1, "points", -1.25), (2, "kernel", 2.5), (3, "kernel", -1.0), (3, "points", -4.75)]
        );
    }
}
