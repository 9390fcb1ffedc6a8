//! Rods in motion: steps of other lengths, the time of the drives, single commands, forces, and
//! rods that follow.

use super::support::{
    ABSOLUTE, Commands, RELATIVE, SIZE_M, adaptive, minus, rms, rows, shipped, yaml,
};
use spinebench::base::{Point3, Rows};
use spinebench::effects::{EffectSpec, Model, ModelParameter, Trial, Variable, replay};
use spinebench::math::rotation;
use spinebench::rod::{Drive, PerturbedRods, Rod, RodParams, SolveStatus};

/// Steps that follow from their error: differences of whole runs jump with them, derivatives along
/// the motion do not. They agree with those of small steps of one length as well as the motions
/// themselves do.
#[test]
fn steps_as_long_as_their_error_allows() {
    let (mut model, mut fine) = (adaptive("nominal"), shipped("nominal"));
    model.robot.resolution.motion_tolerance_m = 1e-6;
    fine.robot.resolution.time_step_s = 0.0025;
    let commands = Commands::loops(&model, SIZE_M, false);
    let rates = |model: &Model| -> Vec<Vec<Point3>> {
        let parameters = ModelParameter::all(model);
        let variables: Vec<Variable> = parameters.into_iter().map(Variable::Parameter).collect();
        replay(model, &[], &commands.trial(), &variables).unwrap().rates
    };
    let (own, exact) = (rates(&model), rates(&fine));
    for (index, parameter) in ModelParameter::all(&model).iter().enumerate() {
        let column =
            |rates: &[Vec<Point3>]| rates.iter().map(|row| row[index]).collect::<Vec<Point3>>();
        let (own, exact) = (column(&own), column(&exact));
        let scale = parameter.scale(&model).unwrap();
        let (off, size) = (rms(&minus(&own, &exact)) * scale, rms(&exact) * scale);
        println!("{parameter}: {size:.2e} m, off by {off:.1e} m");
        assert!(off < 0.1 * size + 1e-4, "{parameter}: {off} of {size}");
    }
}

/// The time of the drives: whole runs divide what comes after it in other ways, so that only small
/// steps compare.
#[test]
fn time_of_the_drives() {
    let mut model = shipped("nominal");
    model.robot.resolution.time_step_s = 0.005;
    let rows = rows(&[[0.01, 0.005, -0.01, -0.005]]);
    let commands = Commands { rows, durations_s: vec![0.2], tensions: false, at_rest: false };
    let parameter = ModelParameter::named(&model, "robot.drive_time_s").unwrap();
    let replayed =
        replay(&model, &[], &commands.trial(), &[Variable::Parameter(parameter.clone())]).unwrap();
    let rates: Vec<Point3> = replayed.rates.iter().map(|row| row[0]).collect();
    let differences = parameter.differences(&model, 0.01, &|m| commands.tips(m)).unwrap();
    let off = rms(&minus(&rates, &differences)) / rms(&differences);
    assert!(rms(&differences) > 5e-3 && off < 0.05, "{off}");
}

/// The difference between derivatives and differences, and the size of the latter, for a change by
/// `scale`; for the step that comes closest.
fn closest(rates: &[Point3], scale: f64, run: &dyn Fn(f64) -> Vec<Point3>) -> (f64, f64) {
    let error = |share: f64| {
        let step = share * scale;
        let twice = minus(&run(step), &run(-step));
        let differences: Vec<Point3> =
            twice.iter().map(|change| change.map(|x| x / (2.0 * step))).collect();
        (rms(&minus(rates, &differences)) * scale, rms(&differences) * scale)
    };
    [1e-2, 1e-3, 1e-4, 1e-5].map(error).into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
}

/// Each command of a tendon, some of them together, and a steady force.
#[test]
fn commands_and_forces_in_motion() {
    let model = shipped("real");
    let commands = Commands::loops(&model, SIZE_M, false);
    let ranges = [(0, 0..1), (2, 3..4), (1, 2..9), (3, 11..12)];
    let mut variables: Vec<Variable> = ranges
        .iter()
        .map(|(tendon, commands)| Variable::Command { tendon: *tendon, commands: commands.clone() })
        .collect();
    variables.extend((0..3).map(Variable::Force));
    let replayed = replay(&model, &[], &commands.trial(), &variables).unwrap();
    for (index, variable) in variables.iter().enumerate() {
        let run = |by: f64| {
            let mut moved = Rows::new(4);
            for (k, row) in commands.rows.iter().enumerate() {
                let mut row = row.to_vec();
                match variable {
                    Variable::Command { tendon, commands } if commands.contains(&k) => {
                        row[*tendon] += by
                    }
                    _ => {}
                }
                moved.push(&row);
            }
            let mut force = [0.0; 3];
            if let Variable::Force(axis) = variable {
                force[*axis] = by;
            }
            let pushed: Vec<EffectSpec> = yaml(&format!("[{{tip_force: {{force_n: {force:?}}}}}]"));
            replay(&model, &pushed, &Trial { commands: &moved, ..commands.trial() }, &[])
                .unwrap()
                .tips_m
        };
        let rates: Vec<Point3> = replayed.rates.iter().map(|row| row[index]).collect();
        let scale = if matches!(variable, Variable::Force(_)) { 0.1 } else { 0.01 };
        let (off, size) = closest(&rates, scale, &run);
        println!("{variable:?}: {size:.2e} m, off by {off:.1e} m");
        assert!(
            off < RELATIVE * size + ABSOLUTE * model.robot.backbone.length_m,
            "{variable:?}: {off} of {size}"
        );
    }
}

/// Moments and tensions, where the rods turn as well.
#[test]
fn positions_and_turns_of_rods_that_follow() {
    let params = shipped("nominal").rod(&[]);
    let pushed = |moment: f64, force: f64| {
        let mut changed = params.clone();
        changed.tip_load.moment_nm.y = moment;
        changed.tip_load.force_n.x = force;
        changed
    };
    let drives = |tension: f64| {
        [Drive::Tension(4.0 + tension), Drive::Tension(2.0), Drive::Follow, Drive::Tension(0.5)]
    };
    let run = |params: RodParams, tension: f64| {
        let mut rod = Rod::new(params);
        assert_eq!(rod.settle(&[Drive::Tension(1.0); 4]), SolveStatus::Converged);
        assert_eq!(rod.advance(&drives(tension), 0.3), SolveStatus::Converged);
        (rod.tip_m(), rod.tip_rotation())
    };
    let small = 1e-7;
    let mut rods = PerturbedRods::new(
        params.clone(),
        vec![pushed(0.01 * small, 0.0), pushed(0.0, 0.1 * small), params.clone()],
    )
    .unwrap();
    assert_eq!(rods.settle(&|_| vec![Drive::Tension(1.0); 4]), SolveStatus::Converged);
    let tension = |number: usize| drives(if number == 3 { small } else { 0.0 }).to_vec();
    assert_eq!(rods.advance_with(&|number, _| tension(number), &|_| 0.3), SolveStatus::Converged);
    let (tip, turn) = run(params.clone(), 0.0);
    assert_eq!((tip, turn), (rods.leader().tip_m(), rods.leader().tip_rotation()));
    let step = 1e-4;
    let ends = |by: f64| {
        [run(pushed(0.01 * by, 0.0), 0.0), run(pushed(0.0, 0.1 * by), 0.0), run(params.clone(), by)]
    };
    for ((rod, plus), minus) in rods.others().iter().zip(ends(step)).zip(ends(-step)) {
        let moved = (rod.tip_m() - tip) / small - (plus.0 - minus.0) / (2.0 * step);
        let turned = rotation::log(&(rod.tip_rotation() * turn.transpose())) / small
            - rotation::log(&(plus.1 * minus.1.transpose())) / (2.0 * step);
        assert!(moved.norm() < 1e-5 * (plus.0 - minus.0).norm() / (2.0 * step), "{moved}");
        assert!(
            turned.norm()
                < 1e-5 * rotation::log(&(plus.1 * minus.1.transpose())).norm() / (2.0 * step),
            "{turned}"
        );
    }
}
