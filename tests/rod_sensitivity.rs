//! Derivatives of the tip against finite differences of whole runs: commands, loads, every number of a robot and of every
//! effect, at rest and in motion.

use nalgebra::{Matrix3xX, Vector3};
use spinebench::base::{PlantError, Point3, Rows};
use spinebench::effects::{
    CATALOGUE, Card, Driven, EffectSpec, Model, ModelParameter, ReplayError, Trial, Variable, VariationError, replay,
};
use spinebench::math::rotation;
use spinebench::rod::{Direction, Drive, Nearby, Rod, RodParams, Status, TipLoad, TipRate};

fn yaml<T: serde::de::DeserializeOwned>(text: &str) -> T {
    serde_yaml::with::singleton_map_recursive::deserialize(serde_yaml::Deserializer::from_str(text))
        .unwrap_or_else(|error| panic!("{error} in\n{text}"))
}

/// A shipped model with steps of one length: where they follow from an error estimate, whole runs jump when it changes
/// its mind, and their differences with them.
fn shipped(name: &str) -> Model {
    let mut model = adaptive(name);
    model.robot.resolution.motion_tolerance_m = f64::INFINITY;
    // One and two steps for the way and the wait of the drives: their number stays when the time of the way changes.
    model.robot.resolution.time_step_s = 0.1;
    model
}

/// A shipped model as it is.
fn adaptive(name: &str) -> Model {
    let path = format!("{}/models/{name}.yaml", env!("CARGO_MANIFEST_DIR"));
    yaml(&std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}")))
}

/// The nominal robot with one effect of the catalogue.
fn with_effect(card: &Card, value: &dyn Fn(&str, f64) -> f64) -> Model {
    let values: Vec<f64> = card.parameters.iter().map(|parameter| value(parameter.name, parameter.null)).collect();
    let effect = EffectSpec::from_card(card, &values).unwrap_or_else(|| panic!("{}: {values:?}", card.name));
    Model { effects: vec![effect], ..shipped("nominal") }
}

/// A value at which an effect is clearly there, away from the kinks of backlash and delay.
fn strong(name: &str, null: f64) -> f64 {
    match name {
        "mass_kg" => 0.02,
        "coupled" => 0.0,
        "tendon" => 2.0,
        "offset_m" | "width_m" => 0.002,
        "moment_nm" => 0.01,
        "compliance_m_per_n" => 2e-4,
        "position_m" => 0.06,
        "share" => 0.2,
        "ratio" => 0.15,
        "time_s" if null == 0.0 => 0.117,
        "range_rad_m" | "yield_rad_m" | "time_s" => null,
        _ if name.starts_with("force_n") => 0.1,
        _ if name.starts_with("shift_m") => 0.003,
        _ if name.starts_with("kappa") => 0.5,
        _ if name.ends_with("_rad") => 0.03,
        "scale" => 1.2,
        other => panic!("{other}: give this parameter a strong value"),
    }
}

/// Commands of one trial.
struct Commands {
    rows: Rows,
    durations_s: Vec<f64>,
    tensions: bool,
    at_rest: bool,
}

impl Commands {
    /// Loops with reversals: opposite tendons pull and give way, so that tendons go slack and taut.
    fn loops(model: &Model, size_m: f64, at_rest: bool) -> Commands {
        let tendons = model.robot.tendons.angles_deg.len();
        let mut rows = Rows::new(tendons);
        for k in 0..12 {
            let (x, y) = (size_m * (0.6 * f64::from(k) + 0.3).sin(), 0.75 * size_m * (0.45 * f64::from(k)).cos());
            let angle = |degrees: &f64| degrees.to_radians();
            let pull = |degrees: &f64| x * angle(degrees).cos() + y * angle(degrees).sin();
            rows.push(&model.robot.tendons.angles_deg.iter().map(pull).collect::<Vec<f64>>());
        }
        Commands { durations_s: vec![0.2; rows.len()], rows, tensions: false, at_rest }
    }

    fn trial(&self) -> Trial<'_> {
        let Commands { rows, durations_s, tensions, at_rest } = self;
        Trial { commands: rows, durations_s, tensions: *tensions, at_rest: *at_rest, tip_loads: None }
    }

    fn tips(&self, model: &Model) -> Result<Vec<Point3>, ReplayError> {
        replay(model, &[], &self.trial(), &[]).map(|replayed| replayed.tips_m)
    }
}

fn rows<const N: usize>(commands: &[[f64; N]]) -> Rows {
    let mut rows = Rows::new(N);
    commands.iter().for_each(|command| rows.push(command));
    rows
}

fn rms(points: &[Point3]) -> f64 {
    (points.iter().flatten().map(|x| x * x).sum::<f64>() / points.len() as f64).sqrt()
}

fn minus(a: &[Point3], b: &[Point3]) -> Vec<Point3> {
    a.iter().zip(b).map(|(p, q)| std::array::from_fn(|axis| p[axis] - q[axis])).collect()
}

/// Size of the loops on the nominal robot: one at which no Gauss point of the friction tests comes to rest on the edge
/// between stick and slip, where the derivatives to both sides differ (docs/sensitivities.md).
const SIZE_M: f64 = 0.0121;

/// What derivatives may be off by: this share of themselves, …
const RELATIVE: f64 = 1e-4;
/// … this where whole runs are no smoother (dry friction, a long whip), …
const ROUGH: f64 = 5e-4;
/// … and this much for a change of the number by its scale, in lengths of
/// the robot.
const ABSOLUTE: f64 = 2.5e-8;
/// The same for robots whose tendons alone say where they are: a stiffness changes all forces and hardly the shape.
const ABSOLUTE_FIXED: f64 = 5e-7;

/// Compares derivatives along a trial with differences of whole trials, for the step that comes closest: smaller ones
/// show what the solves leave, larger ones the curvature.
fn compare(model: &Model, commands: &Commands, parameters: &[ModelParameter], (relative, absolute): (f64, f64)) {
    let variables: Vec<Variable> = parameters.iter().cloned().map(Variable::Parameter).collect();
    let replayed = replay(model, &[], &commands.trial(), &variables).unwrap();
    assert_eq!(replayed.tips_m, commands.tips(model).unwrap(), "those who follow disturb nothing");
    for (index, parameter) in parameters.iter().enumerate() {
        let scale = parameter.scale(model).unwrap();
        let rates: Vec<Point3> = replayed.rates.iter().map(|row| row[index]).collect();
        let error = |step: f64| {
            let differences = parameter.differences(model, step, &|m| commands.tips(m)).unwrap();
            (rms(&minus(&rates, &differences)) * scale, rms(&differences) * scale)
        };
        let errors = [1e-2, 1e-3, 1e-4, 1e-5].map(error);
        let (off, size) = errors.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        println!("{parameter}: {size:.2e} m, off by {off:.1e} m, {:.0e}", off / size);
        assert!(off < relative * size + absolute * model.robot.backbone.length_m, "{parameter}: {errors:?}");
    }
}

/// All numbers but those whose smallest change makes another discretisation; in time, that is what the time of the drives
/// does to whole runs.
fn nearby(model: &Model) -> Vec<ModelParameter> {
    let mut all = ModelParameter::all(model);
    all.retain(|parameter| parameter.path() != "robot.drive_time_s");
    let variables: Vec<Variable> = all.iter().cloned().map(Variable::Parameter).collect();
    let (_, left_out) = Driven::varied_where_possible(model, &[], &variables).unwrap();
    left_out.iter().rev().for_each(|&index| drop(all.remove(index)));
    all
}

/// Steps that follow from their error: differences of whole runs jump with them, derivatives along the motion do not. They
/// agree with those of small steps of one length as well as the motions themselves do.
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
        let column = |rates: &[Vec<Point3>]| rates.iter().map(|row| row[index]).collect::<Vec<Point3>>();
        let (own, exact) = (column(&own), column(&exact));
        let scale = parameter.scale(&model).unwrap();
        let (off, size) = (rms(&minus(&own, &exact)) * scale, rms(&exact) * scale);
        println!("{parameter}: {size:.2e} m, off by {off:.1e} m");
        assert!(off < 0.1 * size + 1e-4, "{parameter}: {off} of {size}");
    }
}

/// The time of the drives: whole runs divide what comes after it in other ways, so that only small steps compare.
#[test]
fn time_of_the_drives() {
    let mut model = shipped("nominal");
    model.robot.resolution.time_step_s = 0.005;
    let rows = rows(&[[0.01, 0.005, -0.01, -0.005]]);
    let commands = Commands { rows, durations_s: vec![0.2], tensions: false, at_rest: false };
    let parameter = ModelParameter::named(&model, "robot.drive_time_s").unwrap();
    let replayed = replay(&model, &[], &commands.trial(), &[Variable::Parameter(parameter.clone())]).unwrap();
    let rates: Vec<Point3> = replayed.rates.iter().map(|row| row[0]).collect();
    let differences = parameter.differences(&model, 0.01, &|m| commands.tips(m)).unwrap();
    let off = rms(&minus(&rates, &differences)) / rms(&differences);
    assert!(rms(&differences) > 5e-3 && off < 0.05, "{off}");
}

fn of_effects(model: &Model) -> Vec<ModelParameter> {
    ModelParameter::all(model).into_iter().filter(|parameter| parameter.path().starts_with("effects")).collect()
}

#[test]
fn numbers_of_the_robot_at_rest() {
    let model = shipped("nominal");
    compare(&model, &Commands::loops(&model, SIZE_M, true), &nearby(&model), (RELATIVE, ABSOLUTE));
}

#[test]
fn numbers_of_the_robot_in_motion() {
    let model = shipped("nominal");
    compare(&model, &Commands::loops(&model, SIZE_M, false), &nearby(&model), (RELATIVE, ABSOLUTE));
}

#[test]
fn numbers_of_effects_at_rest() {
    for card in CATALOGUE {
        let model = with_effect(card, &strong);
        compare(&model, &Commands::loops(&model, SIZE_M, true), &of_effects(&model), (RELATIVE, ABSOLUTE));
    }
}

#[test]
fn numbers_of_effects_in_motion() {
    for card in CATALOGUE {
        let model = with_effect(card, &strong);
        let relative = if ["friction", "hysteresis"].contains(&card.name) { ROUGH } else { RELATIVE };
        compare(&model, &Commands::loops(&model, SIZE_M, false), &of_effects(&model), (relative, ABSOLUTE));
    }
}

/// Where an effect is null, its derivative is that to the side on which it can be. A delay is left out: from zero to a
/// little, the parts in which commands are carried out change, and with them whole runs.
#[test]
fn numbers_of_effects_at_their_null_value() {
    for card in CATALOGUE.iter().filter(|card| card.name != "delay") {
        let model = with_effect(card, &|_, null| null);
        let relative = if card.name == "friction" { ROUGH } else { RELATIVE };
        compare(&model, &Commands::loops(&model, SIZE_M, false), &of_effects(&model), (relative, ABSOLUTE));
    }
}

#[test]
fn numbers_of_other_robots() {
    // A stiff robot with elastic tendons; two segments; drag, which the derivative of the equations leaves out.
    let till = shipped("till");
    compare(&till, &Commands::loops(&till, 0.01, false), &nearby(&till), (RELATIVE, ABSOLUTE_FIXED));
    let segments = shipped("tdcr_two_segments");
    let tensions =
        rows(&[[0.5, 1.0, 0.2, 2.0, 0.3, 0.4], [1.5, 0.2, 0.2, 0.5, 1.0, 2.4], [0.1, 0.4, 2.0, 0.5, 0.6, 0.7]]);
    let commands = Commands { rows: tensions, durations_s: vec![], tensions: true, at_rest: true };
    compare(&segments, &commands, &nearby(&segments), (RELATIVE, ABSOLUTE_FIXED));
    let mut dynamic = shipped("till_dynamic");
    dynamic.robot.resolution.time_step_s = 0.02;
    let tensions = rows(&[[5.0], [12.0], [2.0]]);
    let commands = Commands { rows: tensions, durations_s: vec![0.3; 3], tensions: true, at_rest: false };
    compare(&dynamic, &commands, &nearby(&dynamic), (ROUGH, ABSOLUTE_FIXED));
}

/// The difference between derivatives and differences, and the size of the latter, for a change by `scale`; for the step
/// that comes closest.
fn closest(rates: &[Point3], scale: f64, run: &dyn Fn(f64) -> Vec<Point3>) -> (f64, f64) {
    let error = |share: f64| {
        let step = share * scale;
        let twice = minus(&run(step), &run(-step));
        let differences: Vec<Point3> = twice.iter().map(|change| change.map(|x| x / (2.0 * step))).collect();
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
                    Variable::Command { tendon, commands } if commands.contains(&k) => row[*tendon] += by,
                    _ => {}
                }
                moved.push(&row);
            }
            let mut force = [0.0; 3];
            if let Variable::Force(axis) = variable {
                force[*axis] = by;
            }
            let pushed: Vec<EffectSpec> = yaml(&format!("[{{tip_force: {{force_n: {force:?}}}}}]"));
            replay(&model, &pushed, &Trial { commands: &moved, ..commands.trial() }, &[]).unwrap().tips_m
        };
        let rates: Vec<Point3> = replayed.rates.iter().map(|row| row[index]).collect();
        let scale = if matches!(variable, Variable::Force(_)) { 0.1 } else { 0.01 };
        let (off, size) = closest(&rates, scale, &run);
        println!("{variable:?}: {size:.2e} m, off by {off:.1e} m");
        assert!(off < RELATIVE * size + ABSOLUTE * model.robot.backbone.length_m, "{variable:?}: {off} of {size}");
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
    let drives =
        |tension: f64| [Drive::Tension(4.0 + tension), Drive::Tension(2.0), Drive::Follow, Drive::Tension(0.5)];
    let run = |params: RodParams, tension: f64| {
        let mut rod = Rod::new(params);
        assert_eq!(rod.settle(&[Drive::Tension(1.0); 4]), Status::Converged);
        assert_eq!(rod.advance(&drives(tension), 0.3), Status::Converged);
        (rod.tip_m(), rod.tip_rotation())
    };
    let small = 1e-7;
    let mut rods =
        Nearby::new(params.clone(), vec![pushed(0.01 * small, 0.0), pushed(0.0, 0.1 * small), params.clone()]).unwrap();
    assert_eq!(rods.settle(&|_| vec![Drive::Tension(1.0); 4]), Status::Converged);
    let tension = |number: usize| drives(if number == 3 { small } else { 0.0 }).to_vec();
    assert_eq!(rods.advance_with(&|number, _| tension(number), &|_| 0.3), Status::Converged);
    let (tip, turn) = run(params.clone(), 0.0);
    assert_eq!((tip, turn), (rods.leader().tip_m(), rods.leader().tip_rotation()));
    let step = 1e-4;
    let ends = |by: f64| [run(pushed(0.01 * by, 0.0), 0.0), run(pushed(0.0, 0.1 * by), 0.0), run(params.clone(), by)];
    for ((rod, plus), minus) in rods.others().iter().zip(ends(step)).zip(ends(-step)) {
        let moved = (rod.tip_m() - tip) / small - (plus.0 - minus.0) / (2.0 * step);
        let turned = rotation::log(&(rod.tip_rotation() * turn.transpose())) / small
            - rotation::log(&(plus.1 * minus.1.transpose())) / (2.0 * step);
        assert!(moved.norm() < 1e-5 * (plus.0 - minus.0).norm() / (2.0 * step), "{moved}");
        assert!(
            turned.norm() < 1e-5 * rotation::log(&(plus.1 * minus.1.transpose())).norm() / (2.0 * step),
            "{turned}"
        );
    }
}

/// Drives and load with one of them moved; what is below tension 0 stays there.
fn shifted(direction: Direction, by: f64, (mut drives, mut load): ([Drive; 4], TipLoad)) -> ([Drive; 4], TipLoad) {
    match (direction, drives) {
        (Direction::Pull(i), now) if matches!(now[i], Drive::Pull(_)) => {
            let Drive::Pull(pull) = now[i] else { unreachable!() };
            drives[i] = Drive::Pull(pull + by);
        }
        (Direction::Tension(i), now) => match now[i] {
            Drive::Tension(tension) => drives[i] = Drive::Tension((tension + by).max(0.0)),
            Drive::Follow => drives[i] = Drive::Tension(by.max(0.0)),
            Drive::Pull(_) => {}
        },
        (Direction::Force(axis), _) => load.force_n[axis] += by,
        (Direction::Moment(axis), _) => load.moment_nm[axis] += by,
        (Direction::Pull(_), _) => {}
    }
    (drives, load)
}

/// A derivative at rest against the difference of rods that settle from straight, so that what solves leave is the same
/// to both sides; the second solve leaves less.
fn compare_at_rest(params: &RodParams, drives: [Drive; 4], load: TipLoad, direction: Direction, rate: &TipRate) {
    let moved = |by: f64| {
        let (drives, load) = shifted(direction, by, (drives, load));
        let mut rod = Rod::new(params.clone());
        rod.set_tip_load(load);
        assert_eq!([rod.settle(&drives), rod.settle(&drives)], [Status::Converged; 2]);
        (rod.tip_m(), rod.tip_rotation())
    };
    let step = match direction {
        Direction::Pull(_) => 1e-4,
        Direction::Tension(_) => 3e-2,
        Direction::Force(_) => 1e-2,
        Direction::Moment(_) => 1e-3,
    };
    let loose = [Drive::Tension(0.0), Drive::Follow];
    let one_sided = matches!(direction, Direction::Tension(i) if loose.contains(&drives[i]));
    let (plus, minus) = (moved(step), moved(if one_sided { 0.0 } else { -step }));
    let over = if one_sided { step } else { 2.0 * step };
    let (position, turn) = ((plus.0 - minus.0) / over, rotation::log(&(plus.1 * minus.1.transpose())) / over);
    let close = |a: Vector3<f64>, b: Vector3<f64>, left: f64| {
        (a - b).norm() < if one_sided { 1e-2 } else { RELATIVE } * b.norm() + left / over
    };
    assert!(close(rate.position_m, position, 1e-9), "{drives:?} {direction:?}: {} {position}", rate.position_m);
    assert!(close(rate.rotation_rad, turn, 1e-8), "{drives:?} {direction:?}: {} {turn}", rate.rotation_rad);
}

/// Poses at rest with none to all tendons taut, under lengths and tensions, with loads.
#[test]
fn jacobian_at_rest() {
    use Drive::{Follow, Pull, Tension};
    let load = TipLoad { force_n: Vector3::new(0.1, -0.2, 0.15), moment_nm: Vector3::new(0.005, 0.01, -0.004) };
    // Four tendons at equal angles can all be taut only where they stretch.
    let mut params = RodParams { memory: vec![], ..shipped("real").rod(&[]) };
    params.tendons.iter_mut().for_each(|tendon| tendon.compliance_m_per_n = 2e-4);
    let poses: [([Drive; 4], usize); 7] = [
        ([Pull(-0.01); 4], 0),
        ([Pull(0.012), Pull(-0.02), Pull(-0.02), Pull(-0.02)], 1),
        ([Pull(0.012), Pull(0.008), Pull(-0.012), Pull(-0.008)], 2),
        ([Pull(0.006), Pull(0.004), Pull(0.005), Pull(-0.02)], 3),
        ([Pull(0.006); 4], 4),
        ([Tension(5.0), Pull(0.01), Follow, Pull(-0.02)], 1),
        ([Tension(5.0), Tension(3.0), Tension(0.0), Tension(1.0)], 0),
    ];
    let each = (0..4).flat_map(|i| [Direction::Pull(i), Direction::Tension(i)]);
    let directions: Vec<Direction> =
        each.chain((0..3).flat_map(|axis| [Direction::Force(axis), Direction::Moment(axis)])).collect();
    for (drives, taut) in poses {
        let mut rod = Rod::new(params.clone());
        rod.set_tip_load(load);
        assert_eq!(rod.tip_jacobian(&directions), None, "nothing is at rest yet");
        assert_eq!(rod.settle(&drives), Status::Converged);
        let held = drives.iter().zip(rod.tensions_n()).filter(|(d, t)| matches!(d, Pull(_)) && **t > 0.0).count();
        assert_eq!(held, taut, "{drives:?}: {:?}", rod.tensions_n());
        for (direction, rate) in directions.iter().zip(rod.tip_jacobian(&directions).unwrap()) {
            compare_at_rest(&params, drives, load, *direction, &rate);
        }
        rod.advance(&drives, 0.01);
        assert_eq!(rod.tip_jacobian(&directions), None, "it has moved");
    }
}

/// Gauss–Newton on the pulls of a controller: the distance to a reachable target falls with its square.
#[test]
fn newton_on_pulls_converges_quadratically() {
    let mut rod = Rod::new(shipped("nominal").rod(&[]));
    let settle = |rod: &mut Rod, pulls: &[f64]| {
        let drives: Vec<Drive> = pulls.iter().map(|&pull| Drive::Pull(pull)).collect();
        assert_eq!(rod.settle(&drives), Status::Converged);
        rod.tip_m()
    };
    let target = settle(&mut rod, &[0.006, 0.004, 0.005, -0.02]);
    let mut pulls = [0.005, 0.003, 0.0045, -0.02];
    let mut tip = settle(&mut rod, &pulls);
    let mut distances = vec![(target - tip).norm()];
    for _ in 0..4 {
        let rates = rod.tip_jacobian(&[Direction::Pull(0), Direction::Pull(1), Direction::Pull(2)]).unwrap();
        let jacobian = Matrix3xX::from_columns(&rates.iter().map(|rate| rate.position_m).collect::<Vec<_>>());
        let step = jacobian.svd(true, true).solve(&(target - tip), 1e-9).unwrap();
        pulls.iter_mut().zip(step.iter()).for_each(|(pull, change)| *pull += change);
        tip = settle(&mut rod, &pulls);
        distances.push((target - tip).norm());
    }
    println!("{distances:?}");
    assert!(distances[0] > 1e-3 && distances[4] < 1e-9, "{distances:?}");
    for pair in distances.windows(2).filter(|pair| pair[1] > 1e-8) {
        assert!(pair[1] < 100.0 * pair[0] * pair[0], "{distances:?}");
    }
}

/// A tendon that ends where a section does cannot be shortened a little on the same grid: told from whole trials.
#[test]
fn numbers_that_change_the_discretisation() {
    let mut model = shipped("nominal");
    let (disk_m, section_m) = (0.11 / 12.0, 0.01);
    let border_m = disk_m + 6.0 * (disk_m + section_m);
    model.robot.tendons.ends_m = Some(vec![0.22, 0.22, border_m, 0.22]);
    let named = |path: &str| Variable::Parameter(ModelParameter::named(&model, path).unwrap());
    let variables = ["robot.disks.mass_kg", "robot.tendons.ends_m[2]", "robot.backbone.youngs_modulus_pa"];
    let variables = variables.map(named);
    let (_, left_out) = Driven::varied_where_possible(&model, &[], &variables).unwrap();
    assert_eq!(left_out, [1]);
    let commands = Commands::loops(&model, SIZE_M, true);
    let replayed = replay(&model, &[], &commands.trial(), &variables).unwrap();
    for (index, variable) in variables.iter().enumerate() {
        let Variable::Parameter(parameter) = variable else { unreachable!() };
        let rates: Vec<Point3> = replayed.rates.iter().map(|row| row[index]).collect();
        let differences = parameter.differences(&model, 3e-4, &|m| commands.tips(m)).unwrap();
        let off = rms(&minus(&rates, &differences)) / rms(&differences);
        assert!(rms(&rates) * parameter.scale(&model).unwrap() > 1e-3 && off < 1e-3, "{parameter}: {off}");
    }
}

#[test]
fn numbers_by_name() {
    let mut model = shipped("nominal");
    model.effects = yaml(
        "[{tip_load: {mass_kg: 0.02}}, {tip_force: {force_n: [0.1, 0.2, 0.3]}}, {actuator_gain: {tendon: 2, scale: 1.1}}]",
    );
    let paths: Vec<String> = ModelParameter::all(&model).iter().map(|p| p.path().to_owned()).collect();
    for path in
        ["robot.backbone.youngs_modulus_pa", "robot.gravity_m_s2[2]", "effects[0].mass_kg", "effects[1].force_n[1]"]
    {
        assert!(paths.iter().any(|p| p == path), "{path} is missing from {paths:?}");
    }
    let none = |what: &str| paths.iter().all(|path| !path.contains(what));
    assert!(none("count") && none("tendon]") && none("effects[2].tendon") && none("resolution"), "{paths:?}");
    for parameter in ModelParameter::all(&model) {
        let value = parameter.value(&model).unwrap();
        let other = parameter.with_value(&model, value + 0.1).unwrap();
        assert_eq!(parameter.value(&other).unwrap(), value + 0.1, "{parameter}");
        assert_ne!(other, model);
        assert_eq!(parameter.with_value(&other, value).unwrap(), model, "{parameter}");
        assert!(parameter.with_value(&model, f64::NAN).is_err());
    }
    assert_eq!(ModelParameter::named(&model, "effects[1].force_n[1]").unwrap().value(&model).unwrap(), 0.2);
    assert_eq!(ModelParameter::named(&model, "robot.backbone.youngs_modulus_pa").unwrap().unit(), "Pa");
    let unknown = ModelParameter::named(&model, "robot.backbone.colour").unwrap_err();
    assert_eq!(unknown.to_string(), "the model has no number at `robot.backbone.colour`");
    let gone = ModelParameter::named(&model, "effects[0].mass_kg").unwrap().value(&shipped("nominal"));
    assert!(gone.is_err());
}

#[test]
fn what_cannot_be_played_is_named() {
    let model = shipped("nominal");
    let commands = Commands::loops(&model, SIZE_M, false);
    let short = Trial { durations_s: &[0.2], ..commands.trial() };
    let error = replay(&model, &[], &short, &[]).unwrap_err();
    assert_eq!(error.to_string(), "durations: found 1, expected one a command, 12");
    let fifth = [Variable::Force(0), Variable::Command { tendon: 4, commands: 0..1 }];
    let error = replay(&model, &[], &commands.trial(), &fifth).unwrap_err();
    assert_eq!(error, ReplayError::Variation(VariationError::Missing(1)));
    let narrow = rows(&[[0.0; 3]]);
    let trial = Trial { commands: &narrow, durations_s: &[0.2], ..commands.trial() };
    let error = replay(&model, &[], &trial, &[]).unwrap_err();
    assert!(matches!(error, ReplayError::Plant(PlantError::Refused(_))), "{error}");
}
