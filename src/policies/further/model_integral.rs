//! The inverse of the nominal model with integral action: the cheap baseline that needs a model and
//! no data. It is [`super::mpc`] without the Gaussian process, a single tick ahead.

use super::mpc::{MpcOptions, RecedingHorizon};
use crate::policies::parts::disturbance::DisturbanceOptions;
use crate::policies::parts::rest_model::RestModel;
use crate::policies::parts::single_controller::SingleController;
use crate::policies::{BadOption, Deserialize, ModelAccess, PolicyEntry, Serialize, SeriesLabel};

pub(crate) const ENTRY: PolicyEntry = PolicyEntry {
    name: "model_integral",
    label: SeriesLabel::text("model + integral"),
    footnote: "inverse of the nominal rod with integral action, without data.",
    model: ModelAccess::AtRest,
    make: |mut parts, options| {
        let (travel_m, slack_m) = (options.limits.travel_m, options.model_integral.slack_m);
        let layout = parts.layout("model_integral")?;
        let model =
            RestModel::new(parts.tip_model("model_integral")?, None, layout, travel_m, slack_m);
        let controller = RecedingHorizon::new(model, options.model_integral.as_horizon(), options);
        Ok(Box::new(SingleController::new(controller, "", options)))
    },
    ..PolicyEntry::PLAIN
};

/// Options of the inverse model with integral action.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ModelIntegralOptions {
    /// Additional release of a following tendon compared with the model, so that it stays slack if
    /// the robot differs.
    pub slack_m: f64,
    /// Growth of the integral: the remaining error is treated as a disturbance of the model.
    pub disturbance: DisturbanceOptions,
}

impl Default for ModelIntegralOptions {
    fn default() -> Self {
        // Without the Gaussian process the model is off by up to centimetres.
        let disturbance = DisturbanceOptions { first_sd_m: 0.01, ..DisturbanceOptions::default() };
        ModelIntegralOptions { slack_m: MpcOptions::default().slack_m, disturbance }
    }
}

impl ModelIntegralOptions {
    pub(crate) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_not_negative("slack_m", self.slack_m)?;
        self.disturbance.check()
    }

    fn as_horizon(self) -> MpcOptions {
        MpcOptions {
            horizon: 1,
            slack_m: self.slack_m,
            disturbance: self.disturbance,
            ..MpcOptions::default()
        }
    }
}
