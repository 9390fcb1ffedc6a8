//! The paper's claims as relations between measured quantities: a closed set of relations, no
//! expressions.
//!
//! Each relation yields one number per seed and a range in which the claim holds; see
//! `runner::claims`.

use crate::policies;
use crate::rows::cell::CellLabel;
use serde::{Deserialize, Serialize};

/// A claim of the paper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaperClaim {
    /// Short name.
    pub claim: String,
    /// The paper's statement, or the cell of its table.
    pub statement: String,
    /// Value that the paper reports for the compared number, in the claim's unit, if any.
    #[serde(default)]
    pub paper: Option<f64>,
    /// The relation that must hold.
    pub relation: Relation,
}

/// A relation between metrics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Relation {
    /// left < times · right, paired by seed; the number is left − times · right.
    Less {
        /// The smaller one.
        left: ClaimMetric,
        /// The larger one.
        right: ClaimMetric,
        /// Factor of the larger one, by default 1.
        #[serde(default = "one")]
        times: f64,
    },
    /// The metric lies in a range; the number is the metric.
    Between {
        /// What is measured.
        metric: ClaimMetric,
        /// Lower end, in the metric's unit.
        low: f64,
        /// Upper end, in the metric's unit.
        high: f64,
    },
    /// The metric equals the paper's figure within a tolerance; the number is the metric.
    Near {
        /// What is measured.
        metric: ClaimMetric,
        /// The paper's figure, in the metric's unit.
        figure: f64,
        /// Largest difference, in the metric's unit.
        tolerance: f64,
    },
    /// The metric falls with the amount of data; the number is its slope in units per decade of
    /// data, by least squares.
    Falls {
        /// Goal-reaching metric, without sizes.
        metric: ClaimMetric,
        /// The size that grows.
        over: Size,
        /// Its values, at least two.
        values: Vec<u64>,
    },
    /// More data improves the metric by less than a margin; the number is the mean at the larger
    /// sizes minus the value at `from`, and the claim holds above −margin.
    NoGain {
        /// Goal-reaching metric, without sizes.
        metric: ClaimMetric,
        /// The size that grows.
        over: Size,
        /// The size that the paper calls sufficient.
        from: u64,
        /// Larger sizes.
        beyond: Vec<u64>,
        /// Smallest improvement that counts, in the metric's unit.
        margin: f64,
    },
    /// The largest is less than `times` the smallest; the number is largest − times · smallest.
    Alike {
        /// The compared metrics, at least two.
        metrics: Vec<ClaimMetric>,
        /// Largest ratio that counts as alike.
        times: f64,
    },
}

fn one() -> f64 {
    1.0
}

/// A data size that is swept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Size {
    /// Real points of the Gaussian process.
    GpPoints,
    /// Real points of π_real's network.
    RealPoints,
}

/// A quantity with one value per seed (and kind of training, where networks take part).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ClaimMetric {
    /// Mean goal-reaching error over the targets, metres.
    ReachMean(ReachCell),
    /// Standard deviation of the goal-reaching error over the targets, metres.
    ReachSd(ReachCell),
    /// Validation mean absolute error of a network, metres.
    NetworkMae {
        /// `forward`, `inverse`, `inverse_b` or `pi_real`.
        network: String,
        /// Its data points, where there are several such networks.
        #[serde(default)]
        points: Option<u64>,
    },
    /// Cross-validated mean absolute error of the Gaussian process, metres.
    GpError {
        /// Training points.
        points: u64,
    },
    /// Mean distance to the path point over all steps of tracking, metres.
    TrackMean {
        /// Policy.
        policy: String,
    },
    /// Time until the path is completed, seconds.
    TrackTime {
        /// Policy.
        policy: String,
    },
    /// Oscillation while tracking, as `report::track_summary` defines it, metres.
    TrackOscillation {
        /// Policy.
        policy: String,
    },
    /// Error at the end of the first path point, metres.
    TrackStart {
        /// Policy.
        policy: String,
    },
    /// Root mean square difference between simulated and real tips along an axis, metres.
    GapRms {
        /// Axis of the base frame.
        axis: FrameAxis,
    },
}

/// The goal-reaching trials of one cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReachCell {
    /// Policy.
    pub policy: String,
    /// `open`, `closed` or `closed_load`.
    pub mode: String,
    /// Points of the Gaussian process, where there are several.
    #[serde(default)]
    pub gp_points: Option<u64>,
    /// Points of π_real's network, where there are several.
    #[serde(default)]
    pub real_points: Option<u64>,
}

/// An axis of the base frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FrameAxis {
    /// Up, against gravity.
    X,
    /// To the side.
    Y,
    /// Along the straight robot.
    Z,
}

impl Size {
    fn words(self) -> &'static str {
        match self {
            Size::GpPoints => "points of the Gaussian process",
            Size::RealPoints => "points of π_real’s network",
        }
    }
}

impl ReachCell {
    /// Whether trials of this cell count.
    pub fn includes(&self, cell: &CellLabel) -> bool {
        cell.policy == self.policy
            && cell.mode == self.mode
            && self.gp_points.is_none_or(|points| points == cell.gp_points)
            && self.real_points.is_none_or(|points| points == cell.real_points)
    }

    /// Policy, mode and sizes.
    fn words(&self) -> String {
        let mode = match self.mode.as_str() {
            "open" => "open loop",
            "closed" => "closed loop",
            "closed_load" => "closed loop with load",
            other => other,
        };
        let size = |points: Option<u64>, over: Size| {
            points.map_or_else(String::new, |points| format!(", {points} {}", over.words()))
        };
        let sizes =
            size(self.gp_points, Size::GpPoints) + &size(self.real_points, Size::RealPoints);
        format!("{}, {mode}{sizes}", policy_name(&self.policy))
    }
}

/// The name of a policy in text.
fn policy_name(policy: &str) -> &str {
    policies::find(policy).map_or(policy, |entry| entry.label.plain)
}

impl ClaimMetric {
    /// What is measured, in words.
    fn words(&self) -> String {
        match self {
            ClaimMetric::ReachMean(cell) => format!("mean error ({})", cell.words()),
            ClaimMetric::ReachSd(cell) => format!("SD of the error ({})", cell.words()),
            ClaimMetric::NetworkMae { network, points } => {
                let points = points.map_or_else(String::new, |points| format!(", {points} points"));
                format!("validation error of the network `{network}`{points}")
            }
            ClaimMetric::GpError { points } => {
                format!("cross-validation error of the Gaussian process, {points} points")
            }
            ClaimMetric::TrackMean { policy } => {
                format!("mean error on the path ({})", policy_name(policy))
            }
            ClaimMetric::TrackTime { policy } => {
                format!("time for the path ({})", policy_name(policy))
            }
            ClaimMetric::TrackOscillation { policy } => {
                format!("oscillation on the path ({})", policy_name(policy))
            }
            ClaimMetric::TrackStart { policy } => {
                format!("error at the first path point ({})", policy_name(policy))
            }
            ClaimMetric::GapRms { axis } => {
                let axis = match axis {
                    FrameAxis::X => "x",
                    FrameAxis::Y => "y",
                    FrameAxis::Z => "z",
                };
                format!("rms simulation error along {axis}")
            }
        }
    }

    /// `m` or `s`.
    pub fn unit(&self) -> &'static str {
        if matches!(self, ClaimMetric::TrackTime { .. }) { "s" } else { "m" }
    }

    /// True when the value depends on how the networks were trained.
    pub fn depends_on_training(&self) -> bool {
        !matches!(self, ClaimMetric::GpError { .. } | ClaimMetric::GapRms { .. })
    }

    /// The metric at another data size; `None` for a metric without that size.
    pub fn at(&self, over: Size, points: u64) -> Option<ClaimMetric> {
        let mut metric = self.clone();
        let (ClaimMetric::ReachMean(cell) | ClaimMetric::ReachSd(cell)) = &mut metric else {
            return None;
        };
        match over {
            Size::GpPoints => cell.gp_points = Some(points),
            Size::RealPoints => cell.real_points = Some(points),
        }
        Some(metric)
    }
}

impl Relation {
    /// The number that decides, in words.
    pub fn quantity(&self) -> String {
        let range = |values: &[u64]| match values {
            [first, .., last] => format!("{first} to {last}"),
            _ => values.iter().map(u64::to_string).collect(),
        };
        match self {
            Relation::Less { left, right, times } => {
                let factor = if *times == 1.0 { String::new() } else { format!("{times} × ") };
                format!("{} − {factor}{}", left.words(), right.words())
            }
            Relation::Between { metric, .. } | Relation::Near { metric, .. } => metric.words(),
            Relation::Falls { metric, over, values } => {
                format!(
                    "slope of the {} per tenfold {}, {}",
                    metric.words(),
                    over.words(),
                    range(values)
                )
            }
            Relation::NoGain { metric, over, from, beyond, .. } => {
                let (metric, over, beyond) = (metric.words(), over.words(), range(beyond));
                format!("{metric}, average with {beyond} {over} − that with {from}")
            }
            Relation::Alike { metrics, times } => {
                let words: Vec<String> = metrics.iter().map(ClaimMetric::words).collect();
                format!("largest − {times} × smallest of: {}", words.join("; "))
            }
        }
    }

    /// The metrics that it compares, with their sizes.
    pub fn metrics(&self) -> Vec<ClaimMetric> {
        let swept = |metric: &ClaimMetric, over: &Size, values: &mut dyn Iterator<Item = u64>| {
            values.filter_map(|points| metric.at(*over, points)).collect()
        };
        match self {
            Relation::Less { left, right, .. } => vec![left.clone(), right.clone()],
            Relation::Between { metric, .. } | Relation::Near { metric, .. } => {
                vec![metric.clone()]
            }
            Relation::Falls { metric, over, values } => {
                swept(metric, over, &mut values.iter().copied())
            }
            Relation::NoGain { metric, over, from, beyond, .. } => {
                swept(metric, over, &mut std::iter::once(*from).chain(beyond.iter().copied()))
            }
            Relation::Alike { metrics, .. } => metrics.clone(),
        }
    }
}
