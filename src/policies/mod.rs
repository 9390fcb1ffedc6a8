//! Controllers: from what is seen and a target to tendon displacements. They see observations only.
//!
//! A policy is one file and one line of [`REGISTRY`]. What it is built from is named by [`Part`], so that whoever
//! builds it knows which networks to train first.

mod a;
mod alone;
mod b;
mod c;
mod direct;
mod learned;
mod limits;
mod network;
mod options;
mod pi_real;
mod sight;

pub use a::AOptions;
pub use c::{AfterBoth, COptions, Check, Start};
pub use direct::DirectOptions;
pub use learned::{ElmanForward, ElmanInverse, GpError};
pub use limits::LimitOptions;
pub use network::{Memory, NetworkOptions};
pub use options::PolicyOptions;

use std::sync::Arc;

use crate::base::{BadOption, Displacements, Point3, Policy, PolicyError};

/// A learned inverse mapping (x_i, x_target) → u_i, eq. (22): a recurrent network with a memory.
///
/// Within one control tick `pulls` may be asked several times (an optimisation does); the memory stays as it was at
/// the tick's start until [`InverseModel::tick`] says that time has passed.
///
/// ```
/// use spinebench::base::{Displacements, Point3, PolicyError};
/// use spinebench::policies::InverseModel;
///
/// struct Proportional;
/// impl InverseModel for Proportional {
///     fn reset(&mut self) {}
///     fn pulls(&mut self, _from_m: &Point3, to_m: &Point3) -> Result<Displacements, PolicyError> {
///         Ok(vec![0.2 * to_m[0], 0.2 * to_m[1], -0.2 * to_m[0], -0.2 * to_m[1]])
///     }
/// }
/// ```
pub trait InverseModel: Send {
    /// Forgets everything (the robot is at rest at home).
    fn reset(&mut self);
    /// Displacements in metres that take the tip from `from_m` to `to_m` in one step.
    ///
    /// # Errors
    /// [`PolicyError`] when an input or an output is not finite.
    fn pulls(&mut self, from_m: &Point3, to_m: &Point3) -> Result<Displacements, PolicyError>;
    /// A control tick has passed: what the last `pulls` saw becomes memory. Models without memory do nothing.
    fn tick(&mut self) {}
}

/// A learned forward model (u_i, x_i) → x_{i+1}, eq. (17): it moves on by itself, from its own last prediction.
pub trait ForwardModel: Send {
    /// The robot is at rest at home, where the tip is `home_m`.
    fn reset(&mut self, home_m: &Point3);
    /// The predicted tip after a step under `pulls_m`, metres.
    ///
    /// # Errors
    /// [`PolicyError`] when an input or an output is not finite.
    fn next_m(&mut self, pulls_m: &[f64]) -> Result<Point3, PolicyError>;
}

/// A learned model of the gap, eq. (20): e = p_sim − p_exp.
pub trait ErrorModel: Send + Sync {
    /// Predicted `p_sim − p_exp` in metres for displacements (metres) and a simulated tip (metres).
    fn error_m(&self, pulls_m: &[f64], p_sim_m: &Point3) -> Point3;
}

/// What a policy may be built from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Part {
    /// Inverse mapping trained on simulated data (eq. 21).
    SimulatedInverse,
    /// Inverse mapping trained on simulated data moved by the error model (eq. 24).
    GeneratedInverse,
    /// Inverse mapping trained on real data.
    RealInverse,
    /// Error model (eq. 20).
    Error,
}

/// The parts at hand; each policy takes what it needs.
#[derive(Default)]
pub struct PolicyParts {
    /// See [`Part::SimulatedInverse`].
    pub simulated: Option<Box<dyn InverseModel>>,
    /// See [`Part::GeneratedInverse`].
    pub generated: Option<Box<dyn InverseModel>>,
    /// See [`Part::RealInverse`].
    pub real: Option<Box<dyn InverseModel>>,
    /// See [`Part::Error`].
    pub error: Option<Arc<dyn ErrorModel>>,
}

/// Why a policy could not be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BuildError {
    /// A part that the policy needs was not given.
    #[error("policy {policy} needs {part:?}, which was not given")]
    Missing {
        /// Name of the policy.
        policy: &'static str,
        /// What is missing.
        part: Part,
    },
    /// A setting is out of range.
    #[error(transparent)]
    Option(#[from] BadOption),
}

/// Takes its parts and makes the policy.
type Make = fn(PolicyParts, &PolicyOptions) -> Result<Box<dyn Policy>, BuildError>;

/// One line of the registry.
pub struct PolicyEntry {
    /// Name in specs and result rows.
    pub name: &'static str,
    /// What it is built from.
    pub needs: &'static [Part],
    /// True when it decides by the measured error, so that open loop means nothing to it.
    pub closed_loop_only: bool,
    /// Call [`build`] instead, which checks the options first.
    make: Make,
}

/// Every policy, in the order of the paper's Table I.
pub static REGISTRY: &[PolicyEntry] = &[a::ENTRY, b::ENTRY, c::ENTRY, pi_real::ENTRY];

/// The policy called `name`.
pub fn find(name: &str) -> Option<&'static PolicyEntry> {
    REGISTRY.iter().find(|entry| entry.name == name)
}

/// Builds a policy from its parts.
///
/// # Errors
/// [`BuildError`] for a missing part or an option out of range.
pub fn build(entry: &PolicyEntry, parts: PolicyParts, options: &PolicyOptions) -> Result<Box<dyn Policy>, BuildError> {
    options.check()?;
    (entry.make)(parts, options)
}

/// The part, or the error that names it.
fn need<T>(policy: &'static str, part: Part, given: Option<T>) -> Result<T, BuildError> {
    given.ok_or(BuildError::Missing { policy, part })
}
