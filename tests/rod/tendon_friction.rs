//! Friction of tendons in their guides: the capstan equation, its memory, and its derivatives.

use spinebench::rod::{Direction, Drive, Rod, RodParams, SolveStatus, Tendon};

use crate::support::rods::round_rod;

const LENGTH_M: f64 = 0.2;
const OFFSET_M: f64 = 0.01;

/// A rod without weight and one tendon, which rubs.
fn rod(coefficient: f64) -> Rod {
    let tendon =
        Tendon { friction_coefficient: coefficient, ..Tendon::parallel([OFFSET_M, 0.0], LENGTH_M) };
    let bare = round_rod(LENGTH_M, 0.001, 6e10, 2.3e10, 0.02);
    Rod::new(RodParams { tendons: vec![tendon], damping_time_s: 0.05, ..bare })
}

fn bend_rad(rod: &Rod) -> f64 {
    let z = rod.tip_rotation().column(2).into_owned();
    z.x.atan2(z.z)
}

/// Nothing but the tendon acts on the rod, so that E I θ′ = r τ exp(−μ θ): θ(L) = ln(1 + μ r τ L /
/// E I) / μ.
#[test]
fn under_a_tension_the_bend_is_that_of_the_capstan_equation() {
    for (coefficient, tension_n) in [(0.1, 2.0), (0.3, 2.0), (0.3, 6.0), (0.6, 6.0)] {
        let mut free = rod(0.0);
        assert_eq!(free.settle(&[Drive::Tension(tension_n)]), SolveStatus::Converged);
        let without = bend_rad(&free).abs();
        let mut rubbing = rod(coefficient);
        assert_eq!(rubbing.settle(&[Drive::Tension(tension_n)]), SolveStatus::Converged);
        let (found, expected) =
            (bend_rad(&rubbing).abs(), (coefficient * without).ln_1p() / coefficient);
        assert!(
            (found - expected).abs() < 2e-5 * expected,
            "μ {coefficient}, {tension_n} N: {found}, {expected} rad"
        );
    }
}

/// After the drive has turned round and mobilised the friction the other way, the tendon is tighter
/// at the tip than at the drive, by as much as it was looser before.
#[test]
fn a_tendon_that_is_let_out_needs_less_tension_for_the_same_bend() {
    let mut rubbing = rod(0.3);
    let mut at = |pull_m: f64| {
        assert_eq!(rubbing.settle(&[Drive::Pull(pull_m)]), SolveStatus::Converged);
        (rubbing.tensions_n()[0], bend_rad(&rubbing).abs())
    };
    at(0.004);
    let (pulled_n, pulled_rad) = at(0.008);
    at(0.010);
    let (let_out_n, let_out_rad) = at(0.008);
    assert!((pulled_rad - let_out_rad).abs() < 0.02 * pulled_rad, "{pulled_rad} {let_out_rad}");
    // The mean along the rod of exp(∓μ θ) is near that of half the bend.
    let expected = (0.3 * pulled_rad).exp();
    assert!(
        (pulled_n / let_out_n / expected - 1.0).abs() < 0.02,
        "{pulled_n} {let_out_n} N, {expected}"
    );
    // A step of less than the dead band changes the friction in proportion.
    let (held_n, _) = at(0.008 + 3e-4);
    assert!(held_n > 1.05 * let_out_n && held_n < 0.95 * pulled_n, "{held_n} N");
}

/// A tendon under a prescribed tension holds the tip until the tension has fallen by what both
/// directions of friction carry.
#[test]
fn under_a_falling_tension_the_tip_waits_for_the_dead_band() {
    let mut rubbing = rod(0.3);
    rubbing.settle(&[Drive::Tension(4.0)]);
    let bent = bend_rad(&rubbing).abs();
    let band = (-2.0 * 0.3 * bent).exp();
    // Half way in the logarithm the friction is nowhere mobilised, and the tension is the same all
    // along.
    rubbing.settle(&[Drive::Tension(4.0 * band.sqrt())]);
    let mut free = rod(0.0);
    free.settle(&[Drive::Tension(4.0 * band.sqrt())]);
    let (held, plain) = (bend_rad(&rubbing).abs(), bend_rad(&free).abs());
    assert!((held - plain).abs() < 0.15 * plain, "{held} {plain}");
    assert!(held < bent);
}

#[test]
fn the_derivative_with_respect_to_a_command_is_that_of_a_difference() {
    let mut rubbing = rod(0.3);
    for drives in [[Drive::Pull(0.006)], [Drive::Tension(3.0)]] {
        let before = rubbing.clone();
        let direction = if matches!(drives[0], Drive::Pull(_)) {
            Direction::Pull(0)
        } else {
            Direction::Tension(0)
        };
        assert_eq!(rubbing.settle(&drives), SolveStatus::Converged);
        let rate = rubbing.tip_jacobian(&[direction]).expect("at rest")[0];
        let step = 1e-5;
        let tip = |sign: f64| {
            let mut moved = before.clone();
            let shifted = match drives[0] {
                Drive::Pull(pull_m) => Drive::Pull(pull_m + sign * step),
                Drive::Tension(tension_n) => Drive::Tension(tension_n + sign * step),
                Drive::Follow => Drive::Follow,
            };
            assert_eq!(moved.settle(&[shifted]), SolveStatus::Converged);
            moved.tip_m()
        };
        let difference = (tip(1.0) - tip(-1.0)) / (2.0 * step);
        let apart = (rate.position_m - difference).norm();
        assert!(
            apart < 1e-3 * difference.norm(),
            "{direction:?}: {:?}, {difference:?}",
            rate.position_m
        );
    }
}

/// Motion that goes slowly enough ends where equilibria end.
#[test]
fn a_slow_motion_ends_at_the_equilibrium() {
    let (mut settled, mut moved) = (rod(0.3), rod(0.3));
    moved.settle(&[Drive::Pull(0.0)]);
    settled.settle(&[Drive::Pull(0.0)]);
    for pull_m in [0.004, 0.008, 0.006] {
        settled.settle(&[Drive::Pull(pull_m)]);
    }
    let mut from_m = 0.0;
    for pull_m in [0.004, 0.008, 0.006] {
        let to = |t: f64| vec![Drive::Pull(from_m + (pull_m - from_m) * (t / 0.5_f64).min(1.0))];
        assert_eq!(moved.advance_with(&to, 0.5), SolveStatus::Converged);
        assert_eq!(moved.advance(&[Drive::Pull(pull_m)], 2.0), SolveStatus::Converged);
        from_m = pull_m;
    }
    assert!(
        (moved.tip_m() - settled.tip_m()).norm() < 2e-5,
        "{} {}",
        moved.tip_m(),
        settled.tip_m()
    );
}
