//! Derivatives at rest, and what a controller makes of them.

use super::support::{RELATIVE, shipped};
use nalgebra::{Matrix3xX, Vector3};
use spinebench::math::rotation;
use spinebench::rod::{Direction, Drive, Rod, RodParams, SolveStatus, TipRate, TipWrench};

/// Drives and load with one of them moved; what is below tension 0 stays there.
fn shifted(
    direction: Direction,
    by: f64,
    (mut drives, mut load): ([Drive; 4], TipWrench),
) -> ([Drive; 4], TipWrench) {
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

/// A derivative at rest against the difference of rods that settle from straight, so that what
/// solves leave is the same to both sides; the second solve leaves less.
fn compare_at_rest(
    params: &RodParams,
    drives: [Drive; 4],
    load: TipWrench,
    direction: Direction,
    rate: &TipRate,
) {
    let moved = |by: f64| {
        let (drives, load) = shifted(direction, by, (drives, load));
        let mut rod = Rod::new(params.clone());
        rod.set_tip_load(load);
        assert_eq!([rod.settle(&drives), rod.settle(&drives)], [SolveStatus::Converged; 2]);
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
    let (position, turn) =
        ((plus.0 - minus.0) / over, rotation::log(&(plus.1 * minus.1.transpose())) / over);
    let close = |a: Vector3<f64>, b: Vector3<f64>, left: f64| {
        (a - b).norm() < if one_sided { 1e-2 } else { RELATIVE } * b.norm() + left / over
    };
    assert!(
        close(rate.position_m, position, 1e-9),
        "{drives:?} {direction:?}: {} {position}",
        rate.position_m
    );
    assert!(
        close(rate.rotation_rad, turn, 1e-8),
        "{drives:?} {direction:?}: {} {turn}",
        rate.rotation_rad
    );
}

/// Poses at rest with none to all tendons taut, under lengths and tensions, with loads.
#[test]
fn jacobian_at_rest() {
    use Drive::{Follow, Pull, Tension};
    let load = TipWrench {
        force_n: Vector3::new(0.1, -0.2, 0.15),
        moment_nm: Vector3::new(0.005, 0.01, -0.004),
    };
    // Four tendons at equal angles can all be taut only where they stretch.
    let mut params = RodParams { moment_laws: vec![], ..shipped("real").rod(&[]) };
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
    let directions: Vec<Direction> = each
        .chain((0..3).flat_map(|axis| [Direction::Force(axis), Direction::Moment(axis)]))
        .collect();
    for (drives, taut) in poses {
        let mut rod = Rod::new(params.clone());
        rod.set_tip_load(load);
        assert_eq!(rod.tip_jacobian(&directions), None, "nothing is at rest yet");
        assert_eq!(rod.settle(&drives), SolveStatus::Converged);
        let held = drives
            .iter()
            .zip(rod.tensions_n())
            .filter(|(d, t)| matches!(d, Pull(_)) && **t > 0.0)
            .count();
        assert_eq!(held, taut, "{drives:?}: {:?}", rod.tensions_n());
        for (direction, rate) in directions.iter().zip(rod.tip_jacobian(&directions).unwrap()) {
            compare_at_rest(&params, drives, load, *direction, &rate);
        }
        rod.advance(&drives, 0.01);
        assert_eq!(rod.tip_jacobian(&directions), None, "it has moved");
    }
}

/// Places between the ends of cells, and the tip: as the tip moves, and as differences say.
#[test]
fn jacobian_of_places_at_rest() {
    let params = RodParams { moment_laws: vec![], ..shipped("real").rod(&[]) };
    let places_m = [0.0, 0.0437, 0.1312, params.length_m()];
    let drives = [Drive::Pull(0.012), Drive::Pull(0.008), Drive::Pull(-0.012), Drive::Pull(-0.008)];
    let load = TipWrench {
        force_n: Vector3::new(0.1, -0.2, 0.15),
        moment_nm: Vector3::new(0.005, 0.01, -0.004),
    };
    let settled = |(drives, load): ([Drive; 4], TipWrench)| {
        let mut rod = Rod::new(params.clone());
        rod.set_tip_load(load);
        assert_eq!([rod.settle(&drives), rod.settle(&drives)], [SolveStatus::Converged; 2]);
        rod
    };
    let mut rod = settled((drives, load));
    for (direction, step) in
        [(Direction::Pull(0), 1e-4), (Direction::Force(1), 1e-2), (Direction::Moment(0), 1e-3)]
    {
        let rates = rod.pose_jacobian(&[direction], &places_m).unwrap().remove(0);
        assert_eq!(rates.points[0].position_m.norm(), 0.0, "the base stands");
        assert!(
            (rates.points[3].position_m - rates.tip.position_m).norm()
                < 1e-8 * rates.tip.position_m.norm()
        );
        let [plus, minus] = [step, -step].map(|by| settled(shifted(direction, by, (drives, load))));
        for (place_m, rate) in places_m.iter().zip(&rates.points).skip(1) {
            let (after, before) = (plus.pose_at(*place_m), minus.pose_at(*place_m));
            let moved = (after.0 - before.0) / (2.0 * step);
            let turned = rotation::log(&(after.1 * before.1.transpose())) / (2.0 * step);
            let close = |a: Vector3<f64>, b: Vector3<f64>, left: f64| {
                (a - b).norm() < RELATIVE * b.norm() + left / step
            };
            assert!(
                close(rate.position_m, moved, 1e-9),
                "{direction:?} {place_m}: {} {moved}",
                rate.position_m
            );
            assert!(
                close(rate.rotation_rad, turned, 1e-8),
                "{direction:?} {place_m}: {} {turned}",
                rate.rotation_rad
            );
        }
    }
}

/// Gauss–Newton on the pulls of a controller: the distance to a reachable target falls with its
/// square.
#[test]
fn newton_on_pulls_converges_quadratically() {
    let mut rod = Rod::new(shipped("nominal").rod(&[]));
    let settle = |rod: &mut Rod, pulls: &[f64]| {
        let drives: Vec<Drive> = pulls.iter().map(|&pull| Drive::Pull(pull)).collect();
        assert_eq!(rod.settle(&drives), SolveStatus::Converged);
        rod.tip_m()
    };
    let target = settle(&mut rod, &[0.006, 0.004, 0.005, -0.02]);
    let mut pulls = [0.005, 0.003, 0.0045, -0.02];
    let mut tip = settle(&mut rod, &pulls);
    let mut distances = vec![(target - tip).norm()];
    for _ in 0..4 {
        let rates = rod
            .tip_jacobian(&[Direction::Pull(0), Direction::Pull(1), Direction::Pull(2)])
            .unwrap();
        let jacobian =
            Matrix3xX::from_columns(&rates.iter().map(|rate| rate.position_m).collect::<Vec<_>>());
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
