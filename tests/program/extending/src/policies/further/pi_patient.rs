//! π_real with a network that is always trained to convergence.

use crate::base::series::SeriesLabel;
use crate::policies::parts::inverse_network::InverseNetworkController;
use crate::policies::parts::single_controller::SingleController;
use crate::policies::{
    EarlyStopping, ModelAccess, ModelNeed, NetworkDescription, PolicyEntry, SampleColumns,
    TrainingData,
};

static NETWORK: NetworkDescription = NetworkDescription {
    name: "patient",
    stage: "train_patient",
    label: "patient network",
    inputs: &[SampleColumns::TipBefore, SampleColumns::TipAfter],
    outputs: &[SampleColumns::Pulls],
    data: TrainingData::Real,
    early_stopping: EarlyStopping::Never,
    start: None,
    paper_mae_m: f64::NAN,
};

pub(crate) const ENTRY: PolicyEntry = PolicyEntry {
    name: "pi_patient",
    label: SeriesLabel { plain: "patient", markdown: "patient", latex: "$\\pi_{patient}$" },
    look: None,
    footnote: "",
    needs: &[ModelNeed::Network(&NETWORK)],
    model: ModelAccess::None,
    closed_loop_only: false,
    make: |mut parts, options| {
        let model = parts.inverse("pi_patient", &NETWORK)?;
        Ok(Box::new(SingleController::new(
            InverseNetworkController::new(model, options),
            "",
            options,
        )))
    },
};
