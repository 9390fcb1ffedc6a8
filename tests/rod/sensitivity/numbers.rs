//! Derivatives to every number of a robot and of every effect, along whole trials.

use super::support::{
    ABSOLUTE, ABSOLUTE_FIXED, Commands, RELATIVE, ROUGH, SIZE_M, minus, rms, rows, shipped, yaml,
};
use spinebench::base::Point3;
use spinebench::effects::{
    CATALOGUE, Card, DrivenModel, EffectSpec, Model, ModelParameter, Variable, replay,
};

/// The nominal robot with one effect of the catalogue.
fn with_effect(card: &Card, value: &dyn Fn(&str, f64) -> f64) -> Model {
    let values: Vec<f64> =
        card.parameters.iter().map(|parameter| value(parameter.name, parameter.null)).collect();
    let effect =
        EffectSpec::from_card(card, &values).unwrap_or_else(|| panic!("{}: {values:?}", card.name));
    Model { effects: vec![effect], ..shipped("nominal") }
}

/// A value at which an effect is clearly there, away from the kinks of backlash and delay.
fn strong(name: &str, null: f64) -> f64 {
    match name {
        "mass_kg" | "distance_m" => 0.02,
        "coupled" | "relaxed" => 0.0,
        "tendon" => 2.0,
        "offset_m" | "width_m" | "change_m" => 0.002,
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
        "coefficient" => 0.2,
        "presliding_m" | "curvature_1_m" | "segment" => null,
        other => panic!("{other}: give this parameter a strong value"),
    }
}

/// Compares derivatives along a trial with differences of whole trials, for the step that comes
/// closest: smaller ones show what the solves leave, larger ones the curvature.
fn compare(
    model: &Model,
    commands: &Commands,
    parameters: &[ModelParameter],
    (relative, absolute): (f64, f64),
) {
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
        assert!(
            off < relative * size + absolute * model.robot.backbone.length_m,
            "{parameter}: {errors:?}"
        );
    }
}

/// All numbers but those whose smallest change makes another discretisation; in time, that is what
/// the time of the drives does to whole runs.
fn nearby(model: &Model) -> Vec<ModelParameter> {
    let mut all = ModelParameter::all(model);
    all.retain(|parameter| parameter.path() != "robot.drive_time_s");
    let variables: Vec<Variable> = all.iter().cloned().map(Variable::Parameter).collect();
    let (_, left_out) = DrivenModel::varied_where_possible(model, &[], &variables).unwrap();
    left_out.iter().rev().for_each(|&index| drop(all.remove(index)));
    all
}

fn of_effects(model: &Model) -> Vec<ModelParameter> {
    ModelParameter::all(model)
        .into_iter()
        .filter(|parameter| parameter.path().starts_with("effects"))
        .collect()
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
        compare(
            &model,
            &Commands::loops(&model, SIZE_M, true),
            &of_effects(&model),
            (RELATIVE, ABSOLUTE),
        );
    }
}

#[test]
fn numbers_of_effects_in_motion() {
    for card in CATALOGUE {
        let model = with_effect(card, &strong);
        let relative =
            if ["friction", "hysteresis"].contains(&card.name) { ROUGH } else { RELATIVE };
        compare(
            &model,
            &Commands::loops(&model, SIZE_M, false),
            &of_effects(&model),
            (relative, ABSOLUTE),
        );
    }
}

/// Where an effect is null, its derivative is that to the side on which it can be. A delay and a
/// lag are left out: from zero to a little, the parts in which commands are carried out change, and
/// with them whole runs.
#[test]
fn numbers_of_effects_at_their_null_value() {
    for card in CATALOGUE.iter().filter(|card| !["delay", "servo_lag"].contains(&card.name)) {
        let model = with_effect(card, &|_, null| null);
        let relative = if card.name == "friction" { ROUGH } else { RELATIVE };
        compare(
            &model,
            &Commands::loops(&model, SIZE_M, false),
            &of_effects(&model),
            (relative, ABSOLUTE),
        );
    }
}

#[test]
fn numbers_of_other_robots() {
    // A stiff robot with elastic tendons; two segments; drag, which the derivative of the equations
    // leaves out.
    let till = shipped("till");
    compare(
        &till,
        &Commands::loops(&till, 0.01, false),
        &nearby(&till),
        (RELATIVE, ABSOLUTE_FIXED),
    );
    let segments = shipped("tdcr_two_segments");
    let tensions = rows(&[
        [0.5, 1.0, 0.2, 2.0, 0.3, 0.4],
        [1.5, 0.2, 0.2, 0.5, 1.0, 2.4],
        [0.1, 0.4, 2.0, 0.5, 0.6, 0.7],
    ]);
    let commands = Commands { rows: tensions, durations_s: vec![], tensions: true, at_rest: true };
    compare(&segments, &commands, &nearby(&segments), (RELATIVE, ABSOLUTE_FIXED));
    let mut dynamic = shipped("till_dynamic");
    dynamic.robot.resolution.time_step_s = 0.02;
    let tensions = rows(&[[5.0], [12.0], [2.0]]);
    let commands =
        Commands { rows: tensions, durations_s: vec![0.3; 3], tensions: true, at_rest: false };
    compare(&dynamic, &commands, &nearby(&dynamic), (ROUGH, ABSOLUTE_FIXED));
}

/// A tendon that ends where a section does cannot be shortened a little on the same grid: told from
/// whole trials.
#[test]
fn numbers_that_change_the_discretisation() {
    let mut model = shipped("nominal");
    let (disk_m, section_m) = (0.11 / 12.0, 0.01);
    let border_m = disk_m + 6.0 * (disk_m + section_m);
    model.robot.tendons.ends_m = Some(vec![0.22, 0.22, border_m, 0.22]);
    let named = |path: &str| Variable::Parameter(ModelParameter::named(&model, path).unwrap());
    let variables =
        ["robot.disks.mass_kg", "robot.tendons.ends_m[2]", "robot.backbone.youngs_modulus_pa"];
    let variables = variables.map(named);
    let (_, left_out) = DrivenModel::varied_where_possible(&model, &[], &variables).unwrap();
    assert_eq!(left_out, [1]);
    let commands = Commands::loops(&model, SIZE_M, true);
    let replayed = replay(&model, &[], &commands.trial(), &variables).unwrap();
    for (index, variable) in variables.iter().enumerate() {
        let Variable::Parameter(parameter) = variable else { unreachable!() };
        let rates: Vec<Point3> = replayed.rates.iter().map(|row| row[index]).collect();
        let differences = parameter.differences(&model, 3e-4, &|m| commands.tips(m)).unwrap();
        let off = rms(&minus(&rates, &differences)) / rms(&differences);
        assert!(
            rms(&rates) * parameter.scale(&model).unwrap() > 1e-3 && off < 1e-3,
            "{parameter}: {off}"
        );
    }
}

#[test]
fn numbers_by_name() {
    let mut model = shipped("nominal");
    model.effects = yaml(
        "[{tip_load: {mass_kg: 0.02}}, {tip_force: {force_n: [0.1, 0.2, 0.3]}}, {actuator_gain: \
         {tendon: 2, scale: 1.1}}]",
    );
    let paths: Vec<String> =
        ModelParameter::all(&model).iter().map(|p| p.path().to_owned()).collect();
    for path in [
        "robot.backbone.youngs_modulus_pa",
        "robot.gravity_m_s2[2]",
        "effects[0].mass_kg",
        "effects[1].force_n[1]",
    ] {
        assert!(paths.iter().any(|p| p == path), "{path} is missing from {paths:?}");
    }
    let none = |what: &str| paths.iter().all(|path| !path.contains(what));
    assert!(
        none("count") && none("tendon]") && none("effects[2].tendon") && none("resolution"),
        "{paths:?}"
    );
    for parameter in ModelParameter::all(&model) {
        let value = parameter.value(&model).unwrap();
        let other = parameter.with_value(&model, value + 0.1).unwrap();
        assert_eq!(parameter.value(&other).unwrap(), value + 0.1, "{parameter}");
        assert_ne!(other, model);
        assert_eq!(parameter.with_value(&other, value).unwrap(), model, "{parameter}");
        assert!(parameter.with_value(&model, f64::NAN).is_err());
    }
    assert_eq!(
        ModelParameter::named(&model, "effects[1].force_n[1]").unwrap().value(&model).unwrap(),
        0.2
    );
    assert_eq!(
        ModelParameter::named(&model, "robot.backbone.youngs_modulus_pa").unwrap().unit(),
        "Pa"
    );
    let unknown = ModelParameter::named(&model, "robot.backbone.colour").unwrap_err();
    assert_eq!(unknown.to_string(), "the model has no number at `robot.backbone.colour`");
    let gone =
        ModelParameter::named(&model, "effects[0].mass_kg").unwrap().value(&shipped("nominal"));
    assert!(gone.is_err());
}
