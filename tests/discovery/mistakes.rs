//! Faults of recordings are told as such, and what is hidden beside them is found.

use spinebench::base::Rows;
use spinebench::data::Recording;
use spinebench::data::findings::Verdict;
use spinebench::discovery::{Discovery, Options, discover};
use spinebench::tasks::{SimulationOptions, simulate_recording};

use super::hidden::{explored_in, found, names, nominal, recorded, trials, twin};

const LOAD: &str = "- tip_load: {mass_kg: 0.01}";

#[test]
fn jumps_and_repeated_poses_are_left_out_and_the_load_is_found() {
    let mut measured = recorded(LOAD, 4, 0, 0.0);
    let tips_m = measured.tip_m.as_mut().unwrap();
    tips_m[70][0] += 0.03;
    tips_m[120][2] -= 0.02;
    (20..28).for_each(|row| tips_m[row] = tips_m[19]);
    let found = found(&measured, &Options::default());
    assert_eq!(found.findings.verdict, Verdict::Named, "{}", found.findings.summary);
    assert_eq!(names(&found), ["tip_load"]);
    let rows: Vec<(u64, f64)> =
        found.findings.excluded_rows.iter().map(|row| (row.trial, row.time_s)).collect();
    let expected: Vec<(u64, f64)> =
        (20..28).chain([70, 120]).map(|row| (measured.trial[row], measured.time_s[row])).collect();
    assert_eq!(rows, expected);
    let limitations = found.findings.limitations.join(" ");
    assert!(
        limitations.contains("In 2 of 200 rows the tracked position jumps")
            && limitations.contains("In 8 of 200 rows the pose")
    );
    assert!(found.findings.noise_floor_m < 1.2e-3, "{}", found.findings.noise_floor_m);
}

#[test]
#[ignore = "make campaign"]
fn a_clock_that_is_ahead_is_told_and_the_load_beside_it_is_found() {
    let offset_s = 0.12;
    let mut measured = recorded(LOAD, 4, 0, 0.0);
    let mut truth = nominal();
    truth.effects = crate::support::rods::effects(LOAD);
    // The noise of the recording on the tips of a later time.
    let exact = |commands: &Recording| {
        simulate_recording(&truth, commands, &SimulationOptions::default()).tip_m.unwrap()
    };
    let later = measured.with_tips_later(offset_s);
    let seen: Vec<[f64; 3]> = exact(&later)
        .into_iter()
        .enumerate()
        .filter(|(row, _)| later.is_valid(*row))
        .map(|(_, tip)| tip)
        .collect();
    let now = exact(&trials(&twin("nothing"), 0, 4));
    for (tip, (seen, now)) in measured.tip_m.as_mut().unwrap().iter_mut().zip(seen.iter().zip(&now))
    {
        *tip = std::array::from_fn(|axis| tip[axis] + seen[axis] - now[axis]);
    }
    let found = found(&measured, &Options::default());
    assert_eq!(found.findings.verdict, Verdict::Named, "{}", found.findings.summary);
    assert_eq!(names(&found), ["tip_load"]);
    assert!(
        found.findings.summary.starts_with("The tracker's clock is about"),
        "{}",
        found.findings.summary
    );
    let ([low, high], told) =
        (found.findings.clock_offset_interval_95.unwrap(), found.findings.clock_offset_s.unwrap());
    assert!(
        low < offset_s && offset_s < high && low < told && told < high,
        "{told}: {low} to {high}"
    );
}

#[test]
fn a_mirrored_axis_is_told_before_any_effect_is_sought() {
    let mut measured = recorded(LOAD, 4, 0, 0.0);
    measured.tip_m.as_mut().unwrap().iter_mut().for_each(|tip| tip[1] = -tip[1]);
    let found = found(&measured, &Options::default());
    assert_eq!(found.findings.verdict, Verdict::Unexplained);
    assert!(
        found.findings.summary.contains("the tip's y has the opposite sign"),
        "{}",
        found.findings.summary
    );
    assert!(found.findings.next_measurement.contains("the tip's y has the opposite sign"));
    assert!(found.findings.effects.is_empty() && found.model == nominal());
    assert_eq!(found.findings.gap.before_m, found.findings.gap.after_m);
}

/// A load of 30 g is hidden beside a mistake of set-up that both recordings share.
fn with_mistake_in_both(change: &dyn Fn(&mut Recording)) -> Discovery {
    let [measured, baseline] =
        [("- tip_load: {mass_kg: 0.03}", 1), ("[]", 2)].map(|(effects, seed)| {
            let mut recording = recorded(effects, 4, seed, 0.0);
            change(&mut recording);
            recording
        });
    discover(&nominal(), &measured, Some(&baseline), &Options::default()).unwrap()
}

#[test]
fn turned_axes_in_both_recordings_are_told() {
    let found = with_mistake_in_both(&|recording| {
        let tips_m = recording.tip_m.as_mut().unwrap();
        tips_m.iter_mut().for_each(|[x, y, _]| (*x, *y) = (-*x, -*y));
    });
    let summary = &found.findings.summary;
    assert_eq!(found.findings.verdict, Verdict::Unexplained);
    assert!(
        summary.starts_with("The baseline indicates a mistake")
            && summary.contains("x = -x, y = -y, z = +z"),
        "{summary}"
    );
}

/// Zeros of the drives are no mistake that is sought. What both recordings share is not called
/// consistent all the same.
#[test]
fn forgotten_zeros_in_both_recordings_are_told_first() {
    let found = with_mistake_in_both(&|recording| {
        let mut commands = Rows::new(4);
        let pulled = |row: &[f64]| [row[0] + 0.001, row[1], row[2] + 0.016, row[3] + 0.008];
        recording.commands.iter().for_each(|row| commands.push(&pulled(row)));
        recording.commands = commands;
    });
    let (summary, next) = (&found.findings.summary, &found.findings.next_measurement);
    assert_ne!(found.findings.verdict, Verdict::Consistent, "{summary}");
    assert!(summary.starts_with("After calibration the error on the baseline"), "{summary}");
    assert!(next.contains("error of") && next.contains("on the baseline"), "{next}");
}

/// A force pushes a curved robot to the other side, where a mirrored axis would show it: 4 of 13 mm
/// are left. The baseline, from the same set-up, fits to the noise, so that effects are sought as
/// well.
#[test]
fn a_mirrored_axis_that_the_baseline_does_not_have_is_no_mistake() {
    let curved = "- precurvature: {kappa_x_rad_m: 0.5, kappa_y_rad_m: 0}";
    let baseline = explored_in(curved, 5, 20, 1);
    let measured =
        explored_in(&format!("{curved}\n- tip_force: {{force_n: [0, 0.15, 0]}}"), 5, 20, 2);
    let mut model = nominal();
    model.effects = crate::support::rods::effects(curved);
    let [alone, beside] = [None, Some(&baseline)]
        .map(|baseline| discover(&model, &measured, baseline, &Options::default()).unwrap());
    assert!(
        alone.findings.summary.contains("the tip's y has the opposite sign"),
        "{}",
        alone.findings.summary
    );
    assert_eq!(beside.findings.verdict, Verdict::Named, "{}", beside.findings.summary);
    assert_eq!(names(&beside), ["tip_force"]);
}
