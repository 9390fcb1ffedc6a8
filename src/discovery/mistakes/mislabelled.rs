//! Mistakes of recording or set-up that imitate a strange robot: axes turned, mirrored or
//! exchanged, tendons in another order or with another sign, other units.
//!
//! Each hypothesis is a change of the recording without any number to fit. It is believed when it
//! closes most of a gap that is as large as the motion itself, which no effect of the catalogue is
//! at a usual size. A load or a tilted base beside the mistake mainly shifts all tips. So a single
//! change is also believed when it closes most of the gap about the mean error.

use super::excluded_rows::{PreparedRecording, coarse_model};
use crate::base::{Point3, Rows};
use crate::data::{Actuation, Recording};
use crate::discovery::fit::simulate;
use crate::discovery::options::Options;
use crate::discovery::recording::samples::{Samples, rms_m};
use crate::effects::Model;

/// The gap must be at least this share of the motion of the tip …
pub(crate) const LARGE_SHARE: f64 = 0.3;
/// … and a hypothesis must leave at most this share of its squares. Chosen so that a half of every
/// usual effect beside the mistake is tolerated.
const MAX_REMAINING_SHARE: f64 = 0.25;
/// Maximum number of mistakes that are named as equally likely.
const MAX_NAMED: usize = 4;
/// Hypotheses that leave up to this many times the squares of the best are named beside it.
const AS_GOOD: f64 = 1.3;
/// Rows that are enough to recognise a mistake.
const USED_ROWS: usize = 100;
/// Most orders of tendons that are simulated.
const MAX_ORDERS: usize = 40;

/// A mistake that closes most of the gap.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mistake {
    /// What is wrong, as a clause: `the tip's y axis has the other sign`; several that fit equally
    /// well joined by `, or`.
    pub(crate) what: String,
    /// Rms gap with it and without, metres.
    pub(crate) before_m: f64,
    pub(crate) after_m: f64,
    /// Whether it is a mistake of the baseline, whose gap this then is.
    pub(crate) of_baseline: bool,
}

/// A recording that fits worse, with the mistake, than the baseline does by this factor may have
/// another cause.
const WORSE_THAN_BASELINE: f64 = 3.0;

impl Mistake {
    /// Whether the gap with the mistake is far larger than that of the `baseline` without one.
    pub(crate) fn is_doubtful(&self, model: &Model, baseline: &Samples, options: &Options) -> bool {
        let predicted_m = simulate::tips(&coarse_model(model, options), &[], baseline);
        predicted_m.is_some_and(|predicted_m| {
            self.after_m > WORSE_THAN_BASELINE * rms_m(&baseline.residual(&predicted_m))
        })
    }
}

/// A change of a recording that undoes a mistake.
struct RecordingFix<F: ?Sized> {
    /// The mistake; empty for no change.
    mistake: String,
    apply: Box<F>,
}

/// A change of one row of commands, or of the tip.
type RowFix = dyn Fn(&[f64]) -> Vec<f64>;
type CommandFix = RecordingFix<RowFix>;
type TipFix = RecordingFix<dyn Fn(&Point3) -> Point3>;

/// A changed recording that fits the model.
struct Hypothesis {
    /// Number of mistakes in it.
    mistakes: usize,
    /// Rms gap, metres.
    after_m: f64,
    what: String,
}

/// Rms gap between a recording and a prediction, metres.
#[derive(Clone, Copy)]
struct GapSize {
    whole_m: f64,
    /// Without the mean error.
    centred_m: f64,
}

impl GapSize {
    fn new(residual_m: &[f64]) -> GapSize {
        GapSize { whole_m: rms_m(residual_m), centred_m: prediction_motion_m(residual_m) }
    }
}

/// Whether a change of the recording that leaves the gap `after` is believed. `motion_m`: of the
/// tip; `after_motion_m`: of the tip predicted for the changed recording, so that a unit does not
/// shrink the error.
fn is_believed(
    [before, after]: [GapSize; 2],
    [motion_m, after_motion_m]: [f64; 2],
    is_single: bool,
) -> bool {
    let closes = |before_m: f64, after_m: f64| {
        before_m >= LARGE_SHARE * motion_m
            && after_m < LARGE_SHARE * after_motion_m
            && after_m * after_m < MAX_REMAINING_SHARE * before_m * before_m
    };
    // Two changes together reverse gravity, which a force or rest curvature imitates.
    let beside_a_shift = is_single && after.whole_m < before.whole_m;
    closes(before.whole_m, after.whole_m)
        || beside_a_shift && closes(before.centred_m, after.centred_m)
}

/// Looks for a mistake in the `baseline`, then in `measured`. What the baseline shows needs no
/// missing effect to explain it.
pub(crate) fn find_first(
    model: &Model,
    measured: &PreparedRecording,
    baseline: Option<&PreparedRecording>,
    options: &Options,
) -> Option<Mistake> {
    let in_baseline = baseline.and_then(|baseline| find(model, baseline, options));
    in_baseline
        .map(|mistake| Mistake { of_baseline: true, ..mistake })
        .or_else(|| find(model, measured, options))
}

/// Looks for a mistake in `measured`.
pub(crate) fn find(
    model: &Model,
    measured: &PreparedRecording,
    options: &Options,
) -> Option<Mistake> {
    find_where(model, measured, options, &is_believed)
}

/// Looks for a single change of `measured` that closes most of the gap, however much remains. It is
/// a possible cause, to be checked where effects explain less.
pub(crate) fn find_possible(
    model: &Model,
    measured: &PreparedRecording,
    options: &Options,
) -> Option<Mistake> {
    let is_possible = |[before, after]: [GapSize; 2], _: [f64; 2], is_single: bool| {
        is_single && after.whole_m.powi(2) < MAX_REMAINING_SHARE * before.whole_m.powi(2)
    };
    find_where(model, measured, options, &is_possible)
}

/// Whether a change of a recording is kept: from the gap before and after, the motion of the tip
/// and that of the tip predicted for the changed recording, and whether it is a single change.
type KeptIf = dyn Fn([GapSize; 2], [f64; 2], bool) -> bool;

/// The best of the changes of `measured` that are kept.
fn find_where(
    model: &Model,
    measured: &PreparedRecording,
    options: &Options,
    is_kept: &KeptIf,
) -> Option<Mistake> {
    let coarse = coarse_model(model, options);
    let samples = first_trials(&measured.samples);
    if samples.len() == 0 {
        return None;
    }
    // 1. Only a gap as large as the motion itself can be a mistake.
    let predicted_m = simulate::tips(&coarse, &[], &samples)?;
    let before = GapSize::new(&samples.residual(&predicted_m));
    let motion_m = measured_motion_m(&samples).max(prediction_motion_m(&predicted_m));
    if before.whole_m < LARGE_SHARE * motion_m {
        return None;
    }
    // 2. Every change of commands beside every change of the tip.
    let tips = tip_changes(model.rod(&[]).base_m.into());
    let mut hypotheses: Vec<Hypothesis> = Vec::new();
    for command in command_changes(&measured.kept) {
        let changed = with_commands(&samples, &command);
        // A wrong unit may ask for commands that no rod can follow.
        let Some(simulated_m) = simulate::tips(&coarse, &[], &changed) else { continue };
        let motions_m = [motion_m, prediction_motion_m(&simulated_m)];
        for tip in &tips {
            let both = [&*tip.mistake, &*command.mistake]
                .into_iter()
                .filter(|mistake| !mistake.is_empty());
            let both: Vec<&str> = both.collect();
            let changed_m = samples.rows.iter().flat_map(|row| (tip.apply)(&row.position_m));
            let residual_m: Vec<f64> =
                changed_m.zip(&simulated_m).map(|(tip, simulated)| tip - simulated).collect();
            let after = GapSize::new(&residual_m);
            if !both.is_empty() && is_kept([before, after], motions_m, both.len() == 1) {
                hypotheses.push(Hypothesis {
                    mistakes: both.len(),
                    after_m: after.whole_m,
                    what: both.join(" and "),
                });
            }
        }
    }
    // 3. One mistake is likelier than two; those that fit as well are named beside the best.
    let fewest = hypotheses.iter().map(|hypothesis| hypothesis.mistakes).min()?;
    hypotheses.retain(|hypothesis| hypothesis.mistakes == fewest);
    hypotheses.sort_by(|a, b| a.after_m.total_cmp(&b.after_m));
    let after_m = hypotheses[0].after_m;
    let alike = hypotheses
        .iter()
        .take_while(|other| other.after_m * other.after_m < AS_GOOD * after_m * after_m);
    let what =
        alike.take(MAX_NAMED).map(|other| other.what.as_str()).collect::<Vec<&str>>().join(", or ");
    Some(Mistake { what, before_m: before.whole_m, after_m, of_baseline: false })
}

/// The first trials with [`USED_ROWS`] rows together.
fn first_trials(samples: &Samples) -> Samples {
    let ends = samples.ranges().into_iter().map(|rows| rows.end);
    let count = 1 + ends.take_while(|end| *end < USED_ROWS).count();
    samples.of_trials(&(0..count.min(samples.trials.len())).collect::<Vec<usize>>())
}

/// Rms motion of the measured tip, metres.
pub(crate) fn measured_motion_m(samples: &Samples) -> f64 {
    motion_m(samples.rows.iter().map(|row| row.position_m))
}

/// Rms distance from the mean of a predicted tip or of a residual, three values a sample, metres.
fn prediction_motion_m(values_m: &[f64]) -> f64 {
    motion_m(values_m.as_chunks::<3>().0.iter().copied())
}

/// Rms distance of points from their mean, metres.
fn motion_m(points: impl Iterator<Item = Point3> + Clone) -> f64 {
    let count = points.clone().count().max(1) as f64;
    let mean: Point3 =
        std::array::from_fn(|axis| points.clone().map(|point| point[axis]).sum::<f64>() / count);
    let away: Vec<f64> = points
        .flat_map(|point| -> Point3 { std::array::from_fn(|axis| point[axis] - mean[axis]) })
        .collect();
    rms_m(&away)
}

fn with_commands(samples: &Samples, change: &CommandFix) -> Samples {
    let mut changed = samples.clone();
    for trial in &mut changed.trials {
        let mut commands = Rows::new(trial.commands.width());
        trial.commands.iter().for_each(|row| commands.push(&(change.apply)(row)));
        trial.commands = commands;
    }
    changed
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// No change, every turn and mirror that exchanges axes, and other units.
fn tip_changes(base_m: Point3) -> Vec<TipFix> {
    let mut changes = vec![TipFix { mistake: String::new(), apply: Box::new(|tip| *tip) }];
    for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        for signs in 0..8_u8 {
            let sign: [f64; 3] =
                std::array::from_fn(|axis| if signs >> axis & 1 == 1 { -1.0 } else { 1.0 });
            if (order, signs) == ([0, 1, 2], 0) {
                continue;
            }
            let change = move |tip: &Point3| -> Point3 {
                // Axes turn about the base, where the model and the frame agree.
                std::array::from_fn(|axis| {
                    base_m[axis] + sign[axis] * (tip[order[axis]] - base_m[order[axis]])
                })
            };
            changes.push(TipFix { mistake: axes_text(order, sign), apply: Box::new(change) });
        }
    }
    for (unit, factor) in [
        ("millimetres", 1e-3),
        ("centimetres", 1e-2),
        ("thousands of metres", 1e3),
        ("hundreds of metres", 1e2),
    ] {
        let mistake = format!("the tip is in {unit} instead of metres");
        changes.push(TipFix { mistake, apply: Box::new(move |tip| tip.map(|x| factor * x)) });
    }
    changes
}

/// The turn or mirror that takes the recorded tip to the model's axes.
fn axes_text(order: [usize; 3], sign: [f64; 3]) -> String {
    let flipped: Vec<&str> =
        (0..3).filter(|&axis| sign[axis] < 0.0).map(|axis| AXES[axis]).collect();
    if order == [0, 1, 2] && flipped.len() == 1 {
        return format!("the tip's {} has the opposite sign", flipped[0]);
    }
    let moved: Vec<usize> = (0..3).filter(|&axis| order[axis] != axis).collect();
    if let ([one, other], true) = (&moved[..], flipped.is_empty()) {
        return format!("the tip's {} and {} are exchanged", AXES[*one], AXES[*other]);
    }
    let each: Vec<String> = (0..3)
        .map(|axis| {
            format!(
                "{} = {}{}",
                AXES[axis],
                if sign[axis] < 0.0 { "-" } else { "+" },
                AXES[order[axis]]
            )
        })
        .collect();
    // Even permutations with an even number of flips are turns, all others are mirrors.
    let parity =
        [[0, 1, 2], [1, 2, 0], [2, 0, 1]].contains(&order) == (flipped.len().is_multiple_of(2));
    let kind = if parity { "turned" } else { "mirrored" };
    format!("the tip's axes are {kind} ({} in the recorded axes)", each.join(", "))
}

/// No change, other orders and signs of the tendons, and other units.
fn command_changes(measured: &Recording) -> Vec<CommandFix> {
    let width = measured.tendons();
    let mut changes = vec![CommandFix { mistake: String::new(), apply: Box::new(<[f64]>::to_vec) }];
    let mut push = |mistake: String, apply: Box<RowFix>| {
        changes.push(CommandFix { mistake, apply });
    };
    for order in orders(width) {
        push(
            order_text(&order),
            Box::new(move |row| order.iter().map(|&tendon| row[tendon]).collect()),
        );
    }
    if measured.actuation == Actuation::Lengths {
        let scaled = |factor: f64| {
            Box::new(move |row: &[f64]| row.iter().map(|pull| factor * pull).collect())
        };
        push("all tendons have the opposite sign (positive pulls)".to_owned(), scaled(-1.0));
        for flipped in 0..width {
            let flip = move |row: &[f64]| {
                let mut row = row.to_vec();
                row[flipped] = -row[flipped];
                row
            };
            push(
                format!("tendon {} has the opposite sign (positive pulls)", flipped + 1),
                Box::new(flip),
            );
        }
        for (unit, factor) in [
            ("in millimetres instead of metres", 1e-3),
            ("in centimetres instead of metres", 1e-2),
            ("degrees instead of radians of the drive", std::f64::consts::PI / 180.0),
            ("radians instead of degrees of the drive", 180.0 / std::f64::consts::PI),
        ] {
            push(format!("the commands are {unit}"), scaled(factor));
        }
    }
    changes
}

/// Orders of tendons: exchanges of two, shifts by some, and the reverse; for each place the
/// recorded tendon.
fn orders(width: usize) -> Vec<Vec<usize>> {
    let recorded: Vec<usize> = (0..width).collect();
    let shifts =
        (1..width).map(|shift| (0..width).map(|tendon| (tendon + shift) % width).collect());
    let reversed =
        |shift: usize| (0..width).map(|tendon| (2 * width - 1 - tendon + shift) % width).collect();
    let mut orders: Vec<Vec<usize>> = shifts.chain((0..width).map(reversed)).collect();
    for (one, other) in (0..width).flat_map(|one| (one + 1..width).map(move |other| (one, other))) {
        let mut order = recorded.clone();
        order.swap(one, other);
        orders.push(order);
    }
    let mut listed = std::collections::HashSet::from([recorded]);
    orders.retain(|order| listed.insert(order.clone()));
    orders.truncate(MAX_ORDERS);
    orders
}

fn order_text(order: &[usize]) -> String {
    let moved: Vec<usize> = (0..order.len()).filter(|&tendon| order[tendon] != tendon).collect();
    if let [one, other] = moved[..] {
        return format!("tendons {} and {} are exchanged", one + 1, other + 1);
    }
    let numbers: Vec<String> = order.iter().map(|tendon| (tendon + 1).to_string()).collect();
    format!(
        "the tendons are numbered differently (the model's 1, 2, … are the recorded {})",
        numbers.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::super::tests::robot;
    use super::*;
    use crate::effects::EffectSpec;

    /// What is said of a robot with a payload whose recording is changed.
    fn said(change: &dyn Fn(&mut Recording)) -> String {
        said_beside(0.006, change)
    }

    fn said_beside(load_kg: f64, change: &dyn Fn(&mut Recording)) -> String {
        let (model, mut measured) = robot(&[EffectSpec::tip_load(load_kg)], 0.0).unwrap();
        change(&mut measured);
        let measured = PreparedRecording::new(&model, &measured, &Options::default());
        find(&model, &measured, &Options::default())
            .map_or_else(String::new, |mistake| mistake.what)
    }

    fn with_tips(change: &dyn Fn(Point3) -> Point3) -> String {
        said(&|measured| {
            measured.tip_m.as_mut().unwrap().iter_mut().for_each(|tip| *tip = change(*tip))
        })
    }

    fn with_pulls(change: &dyn Fn(&[f64]) -> Vec<f64>) -> String {
        said(&|measured| {
            let mut commands = Rows::new(measured.tendons());
            measured.commands.iter().for_each(|row| commands.push(&change(row)));
            measured.commands = commands;
        })
    }

    #[test]
    fn axes_that_are_turned_mirrored_or_exchanged_are_recognised() {
        assert_eq!(with_tips(&|tip| tip), "");
        let turned = with_tips(&|[x, y, z]| [-z, y, x]);
        assert_eq!(
            turned,
            "the tip's axes are turned (x = +z, y = +y, z = -x in the recorded axes)"
        );
        assert!(with_tips(&|[x, y, z]| [x, -y, z]).contains("the tip's y has the opposite sign"));
        assert!(with_tips(&|[x, y, z]| [y, x, z]).contains("the tip's x and y are exchanged"));
    }

    /// A load of 30 g moves the tip as far as its commands do.
    #[test]
    fn a_large_load_does_not_hide_a_mistake() {
        let beside_load = |change: &dyn Fn(&mut Recording)| said_beside(0.03, change);
        assert_eq!(beside_load(&|_| ()), "");
        let turned = beside_load(&|measured| {
            let tips_m = measured.tip_m.as_mut().unwrap();
            tips_m.iter_mut().for_each(|[x, y, _]| (*x, *y) = (-*x, -*y));
        });
        assert_eq!(
            turned,
            "the tip's axes are turned (x = -x, y = -y, z = +z in the recorded axes)"
        );
        let exchanged = beside_load(&|measured| {
            let mut commands = Rows::new(measured.tendons());
            measured
                .commands
                .iter()
                .for_each(|row| commands.push(&[row[0], row[2], row[1], row[3]]));
            measured.commands = commands;
        });
        assert_eq!(exchanged, "tendons 2 and 3 are exchanged");
    }

    #[test]
    fn tendons_and_units_that_are_wrong_are_recognised() {
        assert!(
            with_pulls(&|row| vec![row[1], row[0], row[2], row[3]])
                .contains("tendons 1 and 2 are exchanged")
        );
        assert!(
            with_pulls(&|row| row.iter().map(|pull| -pull).collect())
                .contains("all tendons have the opposite sign")
        );
        assert!(with_tips(&|tip| tip.map(|x| 100.0 * x)).contains("the tip is in centimetres"));
        assert!(
            with_pulls(&|row| row.iter().map(|pull| pull.to_radians()).collect())
                .contains("radians instead of degrees")
        );
    }
}
