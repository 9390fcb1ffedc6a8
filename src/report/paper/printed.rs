//! Values printed in the paper, for comparison with the results of this project. Wang & Rojas, "A
//! Data-Efficient Model-Based Learning Framework for the Closed-Loop Control of Continuum Robots".

/// A mean and a standard deviation, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperValue {
    /// Mean goal-reaching error.
    pub mean_m: f64,
    /// Standard deviation over the 50 targets.
    pub sd_m: f64,
}

/// Table I, "Performance Comparison for Goal reaching for different policies": policy, mode, mean,
/// standard deviation. The Gaussian process of A, B and C has 100 real points, π_real 10,000; the
/// load is 20 g.
pub const TABLE_1: [(&str, &str, PaperValue); 11] = [
    ("a", "open", PaperValue { mean_m: 0.026_40, sd_m: 0.012_47 }),
    ("a", "closed", PaperValue { mean_m: 0.015_10, sd_m: 0.008_59 }),
    ("a", "closed_load", PaperValue { mean_m: 0.029_62, sd_m: 0.011_85 }),
    ("b", "open", PaperValue { mean_m: 0.028_75, sd_m: 0.009_60 }),
    ("b", "closed", PaperValue { mean_m: 0.015_46, sd_m: 0.006_54 }),
    ("b", "closed_load", PaperValue { mean_m: 0.028_78, sd_m: 0.009_87 }),
    ("c", "closed", PaperValue { mean_m: 0.010_91, sd_m: 0.004_61 }),
    ("c", "closed_load", PaperValue { mean_m: 0.028_07, sd_m: 0.009_61 }),
    ("pi_real", "open", PaperValue { mean_m: 0.031_86, sd_m: 0.013_14 }),
    ("pi_real", "closed", PaperValue { mean_m: 0.014_987, sd_m: 0.008_37 }),
    ("pi_real", "closed_load", PaperValue { mean_m: 0.032_79, sd_m: 0.012_77 }),
];

/// Real points behind the Gaussian process in Table I.
pub const TABLE_1_GP_POINTS: u64 = 100;
/// Real points behind π_real in Table I.
pub const TABLE_1_REAL_POINTS: u64 = 10_000;

/// Table I's entry for a policy and a mode.
pub fn table_1(policy: &str, mode: &str) -> Option<PaperValue> {
    TABLE_1
        .iter()
        .find(|(row, column, _)| *row == policy && *column == mode)
        .map(|(_, _, printed)| *printed)
}
