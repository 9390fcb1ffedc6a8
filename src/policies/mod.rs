//! Controllers: from what is seen and a target to tendon displacements. They see observations only.
//!
//! A policy is one file of `paper/` or `further/` and one line of `policies!`: its module and,
//! where it has options, the section of a spec's `policies` that holds them and their type.
//! Everything else that others need to know of it is its [`PolicyEntry`].

mod outside;
mod parts;

pub use further::a_integral::AIntegralOptions;
pub use further::a_online::AOnlineOptions;
pub use further::c_hysteresis::CHysteresisOptions;
pub use further::dagger::DaggerOptions;
pub use further::integral::IntegralOptions;
pub use further::model_integral::ModelIntegralOptions;
pub use further::mpc::MpcOptions;
pub use further::online_jacobian::OnlineJacobianOptions;
pub use outside::{
    OUTSIDE_KINDS, OnnxInput, OnnxInputs, OnnxOptions, OnnxOutput, OnnxWindow, OutsideDecider,
    OutsideDecision, OutsidePolicies, OutsidePolicy, OutsideView, ProcessOptions, ProgramOptions,
    PythonHost, PythonOptions, answer_requests, provide_python,
};
pub use paper::a::AOptions;
pub use paper::c::{AfterBoth, COptions, StartBranch, SwitchCheck};
pub use parts::actuator_limits::LimitOptions;
pub use parts::disturbance::DisturbanceOptions;
pub use parts::inverse_network::DirectOptions;
pub use parts::learned::{GpError, NetworkForward, NetworkInverse};
pub use parts::model_traits::{ErrorModel, ForwardModel, InverseModel, LearningErrorModel};
pub use parts::models::{
    DAGGER, EarlyStopping, FORWARD, INVERSE, INVERSE_B, ModelNeed, NetworkDescription, PI_REAL,
    SampleColumns, TrainingData,
};
pub use parts::network::{MemoryUpdate, NetworkOptions};
pub use parts::policy_parts::PolicyParts;
pub use parts::rest_model::nearest_at_rest_m;

use serde::{Deserialize, Serialize};

use crate::base::series::{Look, SeriesLabel};
use crate::base::{BadOption, Policy, is_default};

macro_rules! policies {
    (
        paper: [$(paper::$module:ident::ENTRY $({ $section:ident: $options:ty })?),* $(,)?]
        further: [$(further::$further:ident::ENTRY $({ $further_section:ident: $further_options:ty })?),* $(,)?]
    ) => {
        mod paper {
            $(pub(super) mod $module;)*
        }
        mod further {
            $(pub(super) mod $further;)*
        }

        /// Options of all policies; each default and its alternatives are argued in
        /// `docs/method/decisions.md`.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        pub struct PolicyOptions {
            /// Limits of the drive; the same for every policy.
            pub limits: LimitOptions,
            /// Evaluation of the networks; the same for every policy.
            pub network: NetworkOptions,
            /// Processes of user-defined policies.
            #[serde(skip_serializing_if = "is_default")]
            pub process: ProcessOptions,
            /// User-defined policies by name. A spec may also write `NAME: {onnx: …}`, `NAME: {python:
            /// …}` and `NAME: {program: …}` next to the other keys of `policies`.
            #[serde(skip_serializing_if = "OutsidePolicies::is_empty")]
            pub outside: OutsidePolicies,
            $($(#[doc = concat!("Options of `", stringify!($module), "`.")] pub $section: $options,)?)*
            $($(
                #[doc = concat!("Options of `", stringify!($further), "`.")]
                #[serde(skip_serializing_if = "is_default")]
                pub $further_section: $further_options,
            )?)*
        }

        impl PolicyOptions {
            /// Checks every range.
            ///
            /// # Errors
            /// [`BadOption`] names the first field out of range.
            pub fn check(&self) -> Result<(), BadOption> {
                self.limits.check()?;
                self.network.check()?;
                self.process.check()?;
                self.outside.values().try_for_each(OutsidePolicy::check)?;
                $($(self.$section.check()?;)?)*
                $($(self.$further_section.check()?;)?)*
                Ok(())
            }
        }

        /// Every policy: the paper's in the order of its Table I, then the others.
        pub static REGISTRY: &[PolicyEntry] = &[$(paper::$module::ENTRY,)* $(further::$further::ENTRY,)*];
    };
}

policies! {
    // Published specs hold their options even where they are the defaults.
    paper: [
        paper::a::ENTRY { a: paper::a::AOptions },
        // Shared with `pi_real`, which is the same controller with another network.
        paper::b::ENTRY { direct: parts::inverse_network::DirectOptions },
        paper::c::ENTRY { c: paper::c::COptions },
        paper::pi_real::ENTRY,
    ]
    // A spec holds their options where they differ from the defaults.
    further: [
        further::integral::ENTRY { integral: further::integral::IntegralOptions },
        further::online_jacobian::ENTRY { online_jacobian: further::online_jacobian::OnlineJacobianOptions },
        further::model_integral::ENTRY { model_integral: further::model_integral::ModelIntegralOptions },
        further::mpc::ENTRY { mpc: further::mpc::MpcOptions },
        further::a_integral::ENTRY { a_integral: further::a_integral::AIntegralOptions },
        further::c_hysteresis::ENTRY { c_hysteresis: further::c_hysteresis::CHysteresisOptions },
        further::a_online::ENTRY { a_online: further::a_online::AOnlineOptions },
        further::dagger::ENTRY { dagger: further::dagger::DaggerOptions },
    ]
}

/// Why a policy could not be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BuildError {
    /// A network or model that the policy needs was not given.
    #[error("policy `{policy}` needs `{model}`, which was not given")]
    Missing {
        /// Name of the policy.
        policy: &'static str,
        /// What is missing.
        model: &'static str,
    },
    /// A setting is out of range.
    #[error(transparent)]
    Option(#[from] BadOption),
}

/// Takes its parts and makes the policy.
type Make = fn(PolicyParts, &PolicyOptions) -> Result<Box<dyn Policy>, BuildError>;

/// What a policy is told of the nominal model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelAccess {
    /// Nothing beside the data of the model that its networks are trained on.
    None,
    /// Where its tendons lie.
    Tendons,
    /// Where its tip comes to rest under a bend, with the derivatives ([`crate::base::TipModel`]).
    AtRest,
}

/// What a policy states about itself.
pub struct PolicyEntry {
    /// Name in specs and result rows.
    pub name: &'static str,
    /// Name in tables and figures.
    pub label: SeriesLabel,
    /// How it is drawn; `None`: as its position in the registry says.
    pub look: Option<Look>,
    /// What a table says of it below its rows, in LaTeX; empty for nothing.
    pub footnote: &'static str,
    /// What it is trained from.
    pub needs: &'static [ModelNeed],
    /// What it is told of the nominal model while it controls.
    pub model: ModelAccess,
    /// True when it decides by the measured error, so that open loop means nothing to it.
    pub closed_loop_only: bool,
    /// Call [`build`] instead, which checks the options first.
    make: Make,
}

impl PolicyEntry {
    /// The entry of a policy from outside; what the others leave out is as here.
    const PLAIN: PolicyEntry = PolicyEntry {
        name: "outside",
        label: SeriesLabel::text("outside"),
        look: None,
        footnote: "",
        needs: &[],
        model: ModelAccess::None,
        closed_loop_only: false,
        make: |_, _| Err(BuildError::Missing { policy: "outside", model: "its file" }),
    };

    /// The networks that it needs.
    pub fn networks(&self) -> impl Iterator<Item = &'static NetworkDescription> {
        self.needs.iter().filter_map(|need| match need {
            ModelNeed::Network(network) => Some(*network),
            ModelNeed::ErrorModel => None,
        })
    }

    /// Whether it needs the error model, be it for the data that one of its networks is trained on.
    pub fn uses_error_model(&self) -> bool {
        self.needs.contains(&ModelNeed::ErrorModel)
            || self.networks().any(|network| network.data == TrainingData::Generated)
    }

    /// Whether one of its networks is trained on robots that differ from the model.
    pub fn uses_randomised_robots(&self) -> bool {
        self.networks().any(|network| network.data == TrainingData::Randomised)
    }

    /// Whether one of its networks is trained on real data.
    pub fn uses_real_data(&self) -> bool {
        self.networks().any(|network| network.data == TrainingData::Real)
    }
}

/// Every network: the forward model, then those of the policies in the order of the registry.
pub fn networks() -> Vec<&'static NetworkDescription> {
    let mut networks = vec![&FORWARD];
    for network in REGISTRY.iter().flat_map(PolicyEntry::networks) {
        if networks.iter().all(|other| other.name != network.name) {
            networks.push(network);
        }
    }
    networks
}

/// The policy called `name`.
pub fn find(name: &str) -> Option<&'static PolicyEntry> {
    REGISTRY.iter().find(|entry| entry.name == name)
}

/// The policy called `name`, which may be one from outside.
pub fn find_with(name: &str, outside: &OutsidePolicies) -> Option<&'static PolicyEntry> {
    find(name).or_else(|| outside.get(name).map(OutsidePolicy::entry))
}

/// Builds a policy from its parts.
///
/// # Errors
/// [`BuildError`] for a missing part or an option out of range.
pub fn build(
    entry: &PolicyEntry,
    parts: PolicyParts,
    options: &PolicyOptions,
) -> Result<Box<dyn Policy>, BuildError> {
    options.check()?;
    (entry.make)(parts, options)
}
