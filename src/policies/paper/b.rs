//! Policy B (section IV-E): the inverse mapping retrained on simulated data that the error model
//! has moved into the real workspace, p_exp = p_sim − e_gp (eq. 24). The moving happens before
//! training; here it is the network alone.

use crate::policies::parts::inverse_network::InverseNetworkController;
use crate::policies::parts::single_controller::SingleController;
use crate::policies::{INVERSE_B, ModelNeed, PolicyEntry, SeriesLabel};

pub(crate) const ENTRY: PolicyEntry = PolicyEntry {
    name: "b",
    label: SeriesLabel::text("B"),
    needs: &[ModelNeed::Network(&INVERSE_B)],
    make: |mut parts, options| {
        let model = parts.inverse("b", &INVERSE_B)?;
        Ok(Box::new(SingleController::new(
            InverseNetworkController::new(model, options),
            "b",
            options,
        )))
    },
    ..PolicyEntry::PLAIN
};
