//! Settings of a Gaussian process.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

use super::expression::KernelExpression;
use super::kernels;
use super::mean::MeanFunction;
use super::noise_prior::NoisePrior;
use crate::base::is_default;
use crate::learn::LearnError;
use crate::learn::selection::Selection;

impl Serialize for KernelExpression {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for KernelExpression {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        KernelExpression::parse(&String::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

impl schemars::JsonSchema for KernelExpression {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Kernel".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let names: Vec<&str> = kernels::names().collect();
        let description = format!(
            "A kernel or an expression of kernels with +, * and parentheses, such as `se_ard + \
             linear[tendons]`: {}; `_ard` may be left out.",
            names.join(", ")
        );
        let short = names.iter().filter_map(|name| name.strip_suffix("_ard"));
        let all: Vec<&str> = names.iter().copied().chain(short).collect();
        let factor = format!("[\\s(]*(?:{})(?:\\s*\\[[^\\]]*\\])?[\\s)]*", all.join("|"));
        let pattern = format!("^{factor}(?:[+*]{factor})*$");
        schemars::json_schema!({ "description": description, "type": "string", "pattern": pattern })
    }
}

/// Interpretation of the matrix λ of the paper's eq. 18.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Lambda {
    /// λ = diag(l₁⁻², …): `l` is the distance over which the function varies, as in the textbooks.
    #[default]
    InverseSquares,
    /// λ = diag(l₁², …), as printed: `l` is then the inverse of that distance. With `l` free this
    /// names the same functions by other numbers; only
    /// [`Gp::length_scales`](super::Gp::length_scales) tells the two apart.
    AsPrinted,
}

/// Exact process, or an approximation for more points.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Approximation {
    /// No approximation: costs grow with the cube of the number of points.
    #[default]
    Exact,
    /// Inducing points by a lower bound of the likelihood (Titsias 2009): the process that is
    /// nearest to the exact one.
    Sgpr,
    /// Inducing points with the variances of the exact process (Snelson & Ghahramani 2006).
    Fitc,
}

impl Approximation {
    /// Whether there is none.
    pub fn is_exact(&self) -> bool {
        *self == Approximation::Exact
    }
}

/// Fit of a Gaussian process. Unknown keys are refused; missing ones take the values of
/// [`Default`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GpConfig {
    /// Covariance function: a kernel, or an expression of kernels.
    pub kernel: KernelExpression,
    /// Mean function.
    #[serde(skip_serializing_if = "MeanFunction::is_zero")]
    pub mean: MeanFunction,
    /// Exact, or an approximation.
    #[serde(skip_serializing_if = "Approximation::is_exact")]
    pub approximation: Approximation,
    /// Maximum number of inducing points of an approximation; an exact process has none.
    #[serde(skip_serializing_if = "is_default_inducing")]
    pub inducing_points: usize,
    /// How an experiment chooses the rows that it fits from the predefined points.
    /// [`Gp::fit`](super::Gp::fit) takes all that it is given.
    #[serde(skip_serializing_if = "is_default")]
    pub selection: Selection,
    /// Reading of the paper's λ.
    pub lambda: Lambda,
    /// Starting points of the search for hyper-parameters, per output; the first is the
    /// conventional one (signal variance 1, length-scales 1, noise variance 0.1), the others fill
    /// the plausible range evenly.
    pub starts: usize,
    /// Maximum number of rows on which starts are compared; the best start is then fitted to all
    /// rows.
    pub start_rows: usize,
    /// Smallest noise standard deviation, as a share of the output's standard deviation.
    pub noise_floor: f64,
    /// Prior of the noise. Without it only the likelihood counts, which can estimate nearly no
    /// noise from few points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_prior: Option<NoisePrior>,
    /// Expected improvement of the log marginal likelihood (nats) below which the search ends.
    pub tolerance: f64,
    /// Folds of the cross-validated error.
    pub folds: usize,
    /// Assignment of rows to folds.
    pub fold_order: FoldOrder,
}

/// Assignment of rows to the folds of a cross-validation.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum FoldOrder {
    /// Contiguous blocks, so that a row's neighbours in time are held out with it; suitable for a
    /// random walk.
    #[default]
    Blocks,
    /// Every k-th row.
    Interleaved,
}

/// Inducing points unless said otherwise.
const INDUCING_POINTS: usize = 200;
/// Most points of an exact process.
const MAX_EXACT: usize = 5000;
/// Most points of a sparse process.
const MAX_SPARSE: usize = 100_000;

fn is_default_inducing(count: &usize) -> bool {
    *count == INDUCING_POINTS
}

impl Default for GpConfig {
    fn default() -> Self {
        GpConfig {
            kernel: KernelExpression::of(&kernels::SeArd),
            mean: MeanFunction::Zero,
            approximation: Approximation::Exact,
            inducing_points: INDUCING_POINTS,
            selection: Selection::default(),
            lambda: Lambda::InverseSquares,
            starts: 8,
            start_rows: 100,
            noise_floor: 1e-3,
            noise_prior: None,
            tolerance: 1e-4,
            folds: 10,
            fold_order: FoldOrder::Blocks,
        }
    }
}

impl GpConfig {
    /// Checks the ranges.
    pub fn check(&self) -> Result<(), LearnError> {
        let GpConfig { starts, start_rows, noise_floor, tolerance, inducing_points, folds, .. } =
            *self;
        LearnError::unless_setting((1..=1000).contains(&starts), "starts", starts, "1 to 1000")?;
        LearnError::unless_setting(start_rows >= 10, "start_rows", start_rows, "at least 10")?;
        let floored = noise_floor > 0.0 && noise_floor < 1.0;
        LearnError::unless_setting(floored, "noise_floor", noise_floor, "above 0 and below 1")?;
        self.noise_prior.map_or(Ok(()), |prior| prior.check())?;
        LearnError::unless_setting(
            tolerance > 0.0 && tolerance.is_finite(),
            "tolerance",
            tolerance,
            "above 0",
        )?;
        let induced = (2..=2000).contains(&inducing_points);
        LearnError::unless_setting(induced, "inducing_points", inducing_points, "2 to 2000")?;
        LearnError::unless_setting(folds >= 2, "folds", folds, "at least 2")
    }

    /// Most points that a process can be fitted to.
    pub fn most_points(&self) -> usize {
        if self.approximation.is_exact() { MAX_EXACT } else { MAX_SPARSE }
    }

    /// Checks that so many points are not more than the process can take.
    pub(super) fn check_points(&self, points: usize) -> Result<(), LearnError> {
        if points <= self.most_points() {
            return Ok(());
        }
        let (found, expected) = match self.approximation {
            Approximation::Exact => ("exact", "`sgpr` or `fitc` for more than 5000 points"),
            Approximation::Sgpr => ("sgpr", "at most 100000 points"),
            Approximation::Fitc => ("fitc", "at most 100000 points"),
        };
        Err(LearnError::Setting {
            key: "approximation",
            found: format!("`{found}` with {points} points"),
            expected,
        })
    }
}
