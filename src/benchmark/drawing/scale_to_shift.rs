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
const ACCURACY: f64 = 0.02;
/// Maximum number of evaluations.
const TRIES: usize = 20;

/// The strength up to `most` at which the displacement `shift_m` (none if the simulation fails) equals `wanted_m`, or
/// the strongest possible one. None if nothing can be simulated.
pub fn scale_to_shift(wanted_m: f64, most: f64, shift_m: &mut dyn FnMut(f64) -> Option<f64>) -> Option<ScaledStrength> {
    let mut below = ScaledStrength { amount: 0.0, shift_m: 0.0 };
    let mut above: Option<f64> = None;
    let mut amount = most.min(1.0);
    for tried in 0..TRIES {
        match shift_m(amount) {
            Some(shift_m) if (shift_m / wanted_m - 1.0).abs() <= ACCURACY => {
                return Some(ScaledStrength { amount, shift_m });
            }
            Some(shift_m) if shift_m < wanted_m => {
                below = ScaledStrength { amount, shift_m };
                if amount >= most {
                    break;
                }
                amount = middle(amount * (wanted_m / shift_m).min(4.0), amount, above, tried).min(most);
            }
            too_far => {
                above = Some(amount);
                let proportional = too_far.map_or(0.0, |shift_m| amount * wanted_m / shift_m);
                amount = middle(proportional, below.amount, above, tried);
            }
        }
    }
    (below.amount > 0.0).then_some(below)
}

/// `guess` if it is well inside the bracket, else the midpoint; every other time the midpoint, because proportional
/// guesses can converge from one side at a kink.
fn middle(guess: f64, low: f64, high: Option<f64>, tried: usize) -> f64 {
    match high {
        None => guess,
        Some(high) => {
            let margin = 0.05 * (high - low);
            let proportionate = tried.is_multiple_of(2) && guess > low + margin && guess < high - margin;
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
            for (number, shift) in [&linear as &dyn Fn(f64) -> Option<f64>, &kinked, &saturating].iter().enumerate() {
                let found = scale_to_shift(wanted_m, 8.0, &mut |amount| shift(amount)).unwrap();
                assert!((found.shift_m / wanted_m - 1.0).abs() <= ACCURACY, "{number} {wanted_m} {found:?}");
                assert_eq!(shift(found.amount), Some(found.shift_m));
            }
        }
        let found = scale_to_shift(0.004, 8.0, &mut |amount| fragile(amount)).unwrap();
        assert!(found.amount > 2.3 && found.amount < 2.5, "{found:?}");
        let found = scale_to_shift(0.1, 8.0, &mut |amount| linear(amount)).unwrap();
        assert_eq!(found.amount, 8.0);
        assert_eq!(scale_to_shift(0.004, 8.0, &mut |_| None), None);
    }
}
