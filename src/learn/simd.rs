//! Number traits and functions written for vector instructions.
//!
//! Every function works per lane with fused multiply-adds: results do not depend on the vector
//! width.

/// A floating-point number that networks are made of.
pub(crate) trait Real:
    Copy
    + Default
    + PartialOrd
    + std::ops::Add<Output = Self>
    + std::ops::Sub<Output = Self>
    + std::ops::Mul<Output = Self>
    + std::ops::Div<Output = Self>
    + std::ops::Neg<Output = Self>
    + std::ops::AddAssign
{
    /// `self * a + b`, rounded once.
    fn fma(self, a: Self, b: Self) -> Self;
    /// Hyperbolic tangent, within a few units of the last place of 1.
    fn tanh_fast(self) -> Self;
    /// Square root.
    fn root(self) -> Self;
    /// Nearest number of this width.
    fn of(value: f64) -> Self;
}

macro_rules! real {
    ($float:ty, $largest:literal, $exp:ident) => {
        impl Real for $float {
            #[inline(always)]
            fn fma(self, a: Self, b: Self) -> Self {
                self.mul_add(a, b)
            }
            #[inline(always)]
            fn tanh_fast(self) -> Self {
                // Beyond, tanh is 1 to rounding.
                let x = self.clamp(-$largest, $largest);
                1.0 - 2.0 / ($exp(2.0 * x) + 1.0)
            }
            #[inline(always)]
            fn root(self) -> Self {
                self.sqrt()
            }
            #[inline(always)]
            fn of(value: f64) -> Self {
                value as Self
            }
        }
    };
}
real!(f32, 9.0, exp_f32);
real!(f64, 19.0, exp_f64);

/// `e^x` for −700 ≤ x ≤ 700 (clamped), relative error below 3e-16: x = n ln 2 + r with |r| ≤ ln 2 /
/// 2, Taylor's polynomial of degree 13 for `e^r`, and n added to the exponent bits.
#[inline(always)]
pub(crate) fn exp_f64(x: f64) -> f64 {
    // 1.5 · 2^52: adding it leaves round(x) in the low bits.
    const SHIFT: f64 = 6_755_399_441_055_744.0;
    // ln 2 in two parts, so that n ln 2 is subtracted without rounding (Cody & Waite).
    const LN_2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    let x = x.clamp(-700.0, 700.0);
    let shifted = x.mul_add(std::f64::consts::LOG2_E, SHIFT);
    let n = shifted - SHIFT;
    let r = n.mul_add(-LN_2_LOW, n.mul_add(-LN_2_HIGH, x));
    const INVERSE_FACTORIALS: [f64; 13] = [
        1.0 / 479_001_600.0,
        1.0 / 39_916_800.0,
        1.0 / 3_628_800.0,
        1.0 / 362_880.0,
        1.0 / 40_320.0,
        1.0 / 5_040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
        1.0,
        1.0,
    ];
    let mut p = 1.0 / 6_227_020_800.0;
    for c in INVERSE_FACTORIALS {
        p = r.mul_add(p, c);
    }
    // The low bits of `shifted` hold n; shifted by 52 they add to the exponent.
    f64::from_bits(p.to_bits().wrapping_add(shifted.to_bits() << 52))
}

/// `e^x` for −87 ≤ x ≤ 88 (clamped), relative error below 2e-7; as [`exp_f64`] with degree 7.
#[inline(always)]
pub(crate) fn exp_f32(x: f32) -> f32 {
    const SHIFT: f32 = 12_582_912.0; // 1.5 · 2^23
    const LN_2_HIGH: f32 = 0.693_359_4;
    const LN_2_LOW: f32 = -2.121_944_4e-4;
    let x = x.clamp(-87.0, 88.0);
    let shifted = x.mul_add(std::f32::consts::LOG2_E, SHIFT);
    let n = shifted - SHIFT;
    let r = n.mul_add(-LN_2_LOW, n.mul_add(-LN_2_HIGH, x));
    let mut p = 1.0 / 5040.0_f32;
    for c in [1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0] {
        p = r.mul_add(p, c);
    }
    f32::from_bits(p.to_bits().wrapping_add(shifted.to_bits() << 23))
}

/// Sum of `a[i] · b[i]` in sixteen lanes and a fixed order.
#[inline(always)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    // More lanes than any register: the additions do not wait for each other.
    let mut lanes = [0.0_f64; 16];
    let (a_chunks, a_tail) = a.as_chunks::<16>();
    let (b_chunks, b_tail) = b.as_chunks::<16>();
    for (a, b) in a_chunks.iter().zip(b_chunks) {
        for lane in 0..16 {
            lanes[lane] = a[lane].mul_add(b[lane], lanes[lane]);
        }
    }
    for (lane, (a, b)) in a_tail.iter().zip(b_tail).enumerate() {
        lanes[lane] = a.mul_add(*b, lanes[lane]);
    }
    fold(lanes)
}

/// Pairwise sum of sixteen lanes.
#[inline(always)]
pub(crate) fn fold(mut lanes: [f64; 16]) -> f64 {
    for half in [8, 4, 2, 1] {
        for lane in 0..half {
            lanes[lane] += lanes[lane + half];
        }
    }
    lanes[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponentials_match_the_library() {
        for i in -6900..=6900 {
            let x = f64::from(i) * 0.1003;
            assert!((exp_f64(x) / x.exp() - 1.0).abs() < 1e-15, "{x}");
            let y = (f64::from(i) * 0.0125) as f32;
            assert!((f64::from(exp_f32(y)) / f64::from(y).exp() - 1.0).abs() < 3e-7, "{y}");
        }
        assert!(exp_f64(-1e300) > 0.0 && exp_f64(-1e300) < 1e-300);
    }

    #[test]
    fn tangents_match_the_library() {
        for i in -3000..=3000 {
            let x = f64::from(i) * 0.01;
            assert!((x.tanh_fast() - x.tanh()).abs() < 5e-16, "{x}");
            assert!(((x as f32).tanh_fast() - (x as f32).tanh()).abs() < 3e-7, "{x}");
        }
    }

    #[test]
    fn dot_sums_every_element() {
        let a: Vec<f64> = (0..53).map(f64::from).collect();
        assert_eq!(dot(&a, &a), a.iter().map(|v| v * v).sum::<f64>());
    }
}
