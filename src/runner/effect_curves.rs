//! What each effect of the catalogue does to a robot: shapes at rest, responses and loops of the
//! robot without it and with it under the same commands.

use crate::base::{PlantError, TendonCommand};
use crate::effects::{CATALOGUE, Card, DrivenModel, EffectSpec, Model};
use crate::report::{EffectCurve, EffectPicture, EffectView};

/// Largest pull of a picture, metres, and the share of it by which the second tendon is pulled in a
/// shape.
const PULL_M: f64 = 0.022;
const SECOND_SHARE: f64 = 0.5;
/// Points along the body, and steps of a response and of a quarter of a loop.
const BODY_POINTS: usize = 40;
const RESPONSE_STEPS: usize = 80;
const LOOP_STEPS: usize = 12;

/// Parameters other than their null values, large enough to be seen.
const SIZES: [(&str, &[(&str, f64)]); 25] = [
    ("tip_load", &[("mass_kg", 0.05)]),
    ("distributed_mass", &[("scale", 2.0)]),
    ("tip_force", &[("force_n[0]", -0.4)]),
    ("base_tilt", &[("tilt_y_rad", -0.1)]),
    ("frame_shift", &[("shift_m[0]", 0.012)]),
    ("bending_stiffness", &[("scale", 0.4)]),
    ("anisotropic_stiffness", &[("ratio", 0.4), ("angle_rad", 0.8)]),
    ("precurvature", &[("kappa_y_rad_m", 1.5)]),
    ("soft_section", &[("position_m", 0.05), ("scale", 0.08)]),
    ("spine_compressibility", &[("scale", 6.0)]),
    ("friction", &[("moment_nm", 0.03)]),
    ("hysteresis", &[("share", 1.5)]),
    ("creep", &[("share", 0.4), ("time_s", 2.0)]),
    ("damping", &[("time_s", 0.3)]),
    ("delay", &[("time_s", 0.2)]),
    ("backlash", &[("width_m", 0.004)]),
    ("actuator_gain", &[("scale", 1.4)]),
    ("actuator_offset", &[("offset_m", 0.005)]),
    ("tendon_stretch", &[("compliance_m_per_n", 1e-3)]),
    ("tendon_angle", &[("angle_rad", 0.35)]),
    ("tendon_radius", &[("scale", 1.5)]),
    ("tendon_friction", &[("coefficient", 1.5)]),
    ("servo_lag", &[("time_s", 0.25)]),
    ("contact", &[("distance_m", 0.03), ("position_m", 0.15)]),
    ("pretension", &[("change_m", 0.006)]),
];

/// Effects that are seen while the robot moves, and how; all others are seen at rest.
const MOVING: [(&str, EffectView); 8] = [
    ("friction", EffectView::Loop),
    ("hysteresis", EffectView::Loop),
    ("backlash", EffectView::Loop),
    ("tendon_friction", EffectView::Loop),
    ("creep", EffectView::Response),
    ("damping", EffectView::Response),
    ("delay", EffectView::Response),
    ("servo_lag", EffectView::Response),
];

/// The picture of every effect on this robot, in the order of the catalogue.
///
/// # Errors
/// The first effect with a pose that cannot be simulated, in words.
pub fn effect_pictures(model: &Model) -> Result<Vec<EffectPicture>, String> {
    let picture = |card: &&'static Card| {
        picture(model, card).map_err(|error| format!("{}: {error}", card.name))
    };
    CATALOGUE.iter().map(picture).collect()
}

fn picture(model: &Model, card: &'static Card) -> Result<EffectPicture, String> {
    let sizes =
        SIZES.iter().find(|(name, _)| *name == card.name).map_or(&[][..], |(_, sizes)| sizes);
    let size = |name: &str| sizes.iter().find(|(parameter, _)| *parameter == name);
    let values: Vec<f64> = card
        .parameters
        .iter()
        .map(|parameter| size(parameter.name).map_or(parameter.null, |(_, value)| *value))
        .collect();
    let effect = EffectSpec::from_card(card, &values).ok_or("found no size for a picture")?;
    let view = MOVING.iter().find(|(name, _)| *name == card.name).map(|(_, view)| *view);
    let robots = [Vec::new(), vec![effect]].map(|extra| DrivenModel::new(model, &extra));
    let failed = |error: PlantError| error.to_string();
    let (view, [nominal, with_effect]) = match view {
        None => shapes(robots).map_err(failed)?,
        Some(EffectView::Loop) => {
            let [nominal, with_effect] = robots.map(|mut robot| pulled(&mut robot));
            (EffectView::Loop, [nominal.map_err(failed)?, with_effect.map_err(failed)?])
        }
        Some(view) => {
            // A response lasts as long as the effect takes.
            let longest_s = sizes.iter().filter(|(name, _)| *name == "time_s").map(|(_, s)| *s);
            let duration_s = longest_s.fold(0.3, f64::max) * 4.0 + 0.4;
            let [nominal, with_effect] = robots.map(|mut robot| stepped(&mut robot, duration_s));
            (view, [nominal.map_err(failed)?, with_effect.map_err(failed)?])
        }
    };
    let words = |parameter: &(&str, f64)| {
        let unit = card.parameters.iter().find(|known| known.name == parameter.0);
        let unit = unit.map_or("", |known| if known.unit == "1" { "" } else { known.unit });
        let value = parameter.1.to_string().replace('-', "−");
        format!("{} = {value} {unit}", parameter.0).trim().to_owned()
    };
    let parameters = sizes.iter().map(words).collect::<Vec<_>>().join(", ");
    let parameters = format!("{} ({parameters})", card.name);
    Ok(EffectPicture { name: card.name, parameters, view, nominal, with_effect })
}

/// Commands that pull the first tendon and slacken the one opposite, and a share of it on the next.
fn commands(robot: &DrivenModel, pull_m: f64, share: f64) -> Vec<TendonCommand> {
    let tendons = robot.rod().params().tendons.len();
    let pull = |index: usize| match (index, 2 * index == tendons) {
        (0, _) => pull_m,
        (_, true) => -pull_m,
        (1, _) => share * pull_m,
        _ if 2 * (index - 1) == tendons => -share * pull_m,
        _ => 0.0,
    };
    (0..tendons).map(|index| TendonCommand::Pull(pull(index))).collect()
}

/// Both bodies at rest, in the plane in which their tips are farther apart.
fn shapes(robots: [DrivenModel; 2]) -> Result<(EffectView, [EffectCurve; 2]), PlantError> {
    let mut bodies = Vec::new();
    for mut robot in robots {
        let commands = commands(&robot, PULL_M, SECOND_SHARE);
        robot.home()?;
        robot.settle(&commands)?;
        let length_m = robot.rod().params().length_m();
        let place = |index: usize| length_m * index as f64 / BODY_POINTS as f64;
        let body: Vec<[f64; 3]> =
            (0..=BODY_POINTS).map(|index| robot.rod().pose_at(place(index)).0.into()).collect();
        bodies.push((body, robot.observation(&commands, 0.0).tip_m));
    }
    let apart = |axis: usize| (bodies[0].1[axis] - bodies[1].1[axis]).abs();
    let axis = usize::from(apart(1) > apart(0));
    let curve = |(body, tip): &(Vec<[f64; 3]>, [f64; 3])| EffectCurve {
        points: body.iter().map(|point| [point[2], point[axis]]).collect(),
        tip: Some([tip[2], tip[axis]]),
    };
    Ok((EffectView::Shape(axis), [curve(&bodies[0]), curve(&bodies[1])]))
}

/// The tip while the first tendon is pulled, let go, slackened and pulled again.
fn pulled(robot: &mut DrivenModel) -> Result<EffectCurve, PlantError> {
    robot.home()?;
    let quarter = |from: f64, to: f64| {
        (1..=LOOP_STEPS).map(move |step| from + (to - from) * step as f64 / LOOP_STEPS as f64)
    };
    let shares = quarter(0.0, 1.0)
        .chain(quarter(1.0, 0.0))
        .chain(quarter(0.0, -1.0))
        .chain(quarter(-1.0, 0.0))
        .chain(quarter(0.0, 1.0));
    let mut points = Vec::new();
    for share in shares {
        let commands = commands(robot, share * PULL_M, 0.0);
        robot.advance(&commands, 0.4)?;
        points.push([share * PULL_M, robot.observation(&commands, 0.0).tip_m[0]]);
    }
    // The first pull comes from a robot without history.
    points.drain(..LOOP_STEPS - 1);
    Ok(EffectCurve { points, tip: None })
}

/// The tip over time while the first tendon is pulled within a tenth of a second and held.
fn stepped(robot: &mut DrivenModel, duration_s: f64) -> Result<EffectCurve, PlantError> {
    const RAMP_S: f64 = 0.1;
    robot.home()?;
    let step_s = duration_s / RESPONSE_STEPS as f64;
    let rest = commands(robot, 0.0, 0.0);
    let mut points = vec![[0.0, robot.observation(&rest, 0.0).tip_m[0]]];
    for step in 1..=RESPONSE_STEPS {
        let time_s = step_s * step as f64;
        let share = (time_s / RAMP_S).min(1.0);
        let commands = commands(robot, share * PULL_M, 0.0);
        robot.advance(&commands, step_s)?;
        points.push([time_s, robot.observation(&commands, time_s).tip_m[0]]);
    }
    Ok(EffectCurve { points, tip: None })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::specs::read_model;
    use std::path::Path;

    /// Largest distance between two curves, in the units of their second coordinate.
    fn apart(one: &EffectCurve, other: &EffectCurve) -> f64 {
        let ends = |curve: &EffectCurve| curve.points.iter().chain(&curve.tip).copied().collect();
        let (one, other): (Vec<[f64; 2]>, Vec<[f64; 2]>) = (ends(one), ends(other));
        one.iter().zip(&other).map(|(p, q)| (p[1] - q[1]).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn every_effect_is_seen_in_its_picture() {
        let model = read_model(Path::new("models/nominal.yaml")).unwrap();
        let pictures = effect_pictures(&model).unwrap();
        assert_eq!(pictures.len(), CATALOGUE.len());
        for picture in pictures {
            let apart_m = apart(&picture.nominal, &picture.with_effect);
            assert!(apart_m > 0.002, "{}: {apart_m} m", picture.name);
        }
    }
}
