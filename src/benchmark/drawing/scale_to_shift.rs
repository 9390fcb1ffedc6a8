//! Scaling of an effect to a requested tip displacement.

/// A strength and its displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaledStrength {
    /// Strength, in usual sizes.
    pub amount: f64,
    /// Rms tip displacement, metres.
    pub shift_m: f64,
}

/// Relative tolerance of the displacement.
const SHIFT_TOLERANCE: f64 = 0.02;
/// Maximum number of evaluations.
const MAX_EVALUATIONS: usize = 20;

/// The strength up to `max_amount` at which the displacement `shift_m` (none if the simulation
/// fails) equals `target_m`, or the strongest possible one. None if nothing can be simulated.
pub fn scale_to_shift(
    target_m: f64,
    max_amount: f64,
    shift_m: &mut dyn FnMut(f64) -> Option<f64>,
) -> Option<ScaledStrength> {
    let mut below = ScaledStrength { amount: 0.0, shift_m: 0.0 };
    let mut above: Option<f64> = None;
    let mut amount = max_amount.min(1.0);
    for evaluation in 0..MAX_EVALUATIONS {
        match shift_m(amount) {
            Some(shift_m) if (shift_m / target_m - 1.0).abs() <= SHIFT_TOLERANCE => {
                return Some(ScaledStrength { amount, shift_m });
            }
            Some(shift_m) if shift_m < target_m => {
                below = ScaledStrength { amount, shift_m };
                if amount >= max_amount {
                    break;
                }
                amount =
                    next_amount(amount * (target_m / shift_m).min(4.0), amount, above, evaluation)
                        .min(max_amount);
            }
            too_far => {
                above = Some(amount);
                let proportional = too_far.map_or(0.0, |shift_m| amount * target_m / shift_m);
                amount = next_amount(proportional, below.amount, above, evaluation);
            }
        }
    }
    (below.amount > 0.0).then_some(below)
}

/// Bisection with proportional guesses: `guess` if it is well inside the bracket, else the
/// midpoint; every other time the midpoint, because proportional guesses can converge from one side
/// at a kink.
fn next_amount(guess: f64, low: f64, high: Option<f64>, evaluation: usize) -> f64 {
    match high {
        None => guess,
        Some(high) => {
            let margin = 0.05 * (high - low);
            let proportionate =
                evaluation.is_multiple_of(2) && guess > low + margin && guess < high - margin;
            if proportionate { guess } else { 0.5 * (low + high) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifts_that_can_be_reached_are_and_others_come_as_near_as_they_can() {
        let linear = |amount: f64| Some(0.003 * amount);
        let kinked = |amount: f64| Some(0.002 * (amount - 0.7).max(0.0));
        let saturating = |amount: f64| Some(0.01 * (1.0 - (-amount).exp()));
        let fragile = |amount: f64| (amount < 2.5).then_some(0.001 * amount);
        for wanted_m in [0.002, 0.004, 0.008] {
            for (number, shift) in
                [&linear as &dyn Fn(f64) -> Option<f64>, &kinked, &saturating].iter().enumerate()
            {
                let scaled = scale_to_shift(wanted_m, 8.0, &mut |amount| shift(amount)).unwrap();
                assert!(
                    (scaled.shift_m / wanted_m - 1.0).abs() <= SHIFT_TOLERANCE,
                    "{number} {wanted_m} {scaled:?}"
                );
                assert_eq!(shift(scaled.amount), Some(scaled.shift_m));
            }
        }
        let scaled = scale_to_shift(0.004, 8.0, &mut |amount| fragile(amount)).unwrap();
        assert!(scaled.amount > 2.3 && scaled.amount < 2.5, "{scaled:?}");
        let scaled = scale_to_shift(0.1, 8.0, &mut |amount| linear(amount)).unwrap();
        assert_eq!(scaled.amount, 8.0);
        assert_eq!(scale_to_shift(0.004, 8.0, &mut |_| None), None);
    }
}
