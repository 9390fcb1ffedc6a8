//! What the paper claims, as relations between measured quantities: a small closed vocabulary, no expressions.
//!
//! Each relation turns into one number per seed and a range in which the claim holds; see `runner::claims`.

use serde::{Deserialize, Serialize};

/// One claim.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaperClaim {
    /// Short name.
    pub claim: String,
    /// The paper's words, or its table's cell.
    pub statement: String,
    /// What the paper reports for the compared number, in the claim's unit, where it reports one.
    #[serde(default)]
    pub paper: Option<f64>,
    /// What must hold.
    pub relation: Relation,
}

/// What must hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Relation {
    /// left < times · right, paired by seed; the number is left − times · right.
    Less {
        /// The smaller one.
        left: ClaimMetric,
        /// The larger one.
        right: ClaimMetric,
        /// Factor of the larger one, 1 unless said.
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
    /// The metric is the paper's figure up to a tolerance; the number is the metric.
    Near {
        /// What is measured.
        metric: ClaimMetric,
        /// The paper's figure, in the metric's unit.
        figure: f64,
        /// Largest difference, in the metric's unit.
        tolerance: f64,
    },
    /// The metric falls with the data; the number is its slope in units per tenfold data, by least squares.
    Falls {
        /// Goal-reaching metric; its own sizes are left out.
        metric: ClaimMetric,
        /// What grows.
        over: Size,
        /// Its values, at least two.
        values: Vec<u64>,
    },
    /// More data does not help by more than a margin; the number is the mean at the larger sizes minus the value at
    /// `from`, and the claim holds above −margin.
    NoGain {
        /// Goal-reaching metric; its own sizes are left out.
        metric: ClaimMetric,
        /// What grows.
        over: Size,
        /// Where it is said to be enough.
        from: u64,
        /// Larger sizes.
        beyond: Vec<u64>,
        /// What would count as help, in the metric's unit.
        margin: f64,
    },
    /// The largest is less than `times` the smallest; the number is largest − times · smallest.
    Alike {
        /// What is compared, at least two.
        metrics: Vec<ClaimMetric>,
        /// How much apart counts as alike.
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
        /// Points behind it, where there are several such networks.
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
    /// Time until the path is done, seconds.
    TrackTime {
        /// Policy.
        policy: String,
    },
    /// Oscillation while tracking, as `report::track_summary` defines it, metres.
    TrackOscillation {
        /// Policy.
        policy: String,
    },
    /// Error when the first path point is left, metres.
    TrackStart {
        /// Policy.
        policy: String,
    },
    /// Root mean square difference between simulated and real tips along an axis, metres.
    GapRms {
        /// FrameAxis.
        axis: FrameAxis,
    },
}

/// Which trials of goal reaching.
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

impl ClaimMetric {
    /// `m` or `s`.
    pub fn unit(&self) -> &'static str {
        if matches!(self, ClaimMetric::TrackTime { .. }) { "s" } else { "m" }
    }

    /// True when the value depends on how the networks were trained.
    pub fn depends_on_training(&self) -> bool {
        !matches!(self, ClaimMetric::GpError { .. } | ClaimMetric::GapRms { .. })
    }

    /// The same metric at another data size; `None` where it has no such size.
    pub fn at(&self, over: Size, points: u64) -> Option<ClaimMetric> {
        let mut metric = self.clone();
        let (ClaimMetric::ReachMean(cell) | ClaimMetric::ReachSd(cell)) = &mut metric else { return None };
        match over {
            Size::GpPoints => cell.gp_points = Some(points),
            Size::RealPoints => cell.real_points = Some(points),
        }
        Some(metric)
    }
}

impl Relation {
    /// The metrics that it compares, sizes filled in.
    pub fn metrics(&self) -> Vec<ClaimMetric> {
        let swept = |metric: &ClaimMetric, over: &Size, values: &mut dyn Iterator<Item = u64>| {
            values.filter_map(|points| metric.at(*over, points)).collect()
        };
        match self {
            Relation::Less { left, right, .. } => vec![left.clone(), right.clone()],
            Relation::Between { metric, .. } | Relation::Near { metric, .. } => vec![metric.clone()],
            Relation::Falls { metric, over, values } => swept(metric, over, &mut values.iter().copied()),
            Relation::NoGain { metric, over, from, beyond, .. } => {
                swept(metric, over, &mut std::iter::once(*from).chain(beyond.iter().copied()))
            }
            Relation::Alike { metrics, .. } => metrics.clone(),
        }
    }
}
