//! π_real (section V-C): the same inverse mapping, trained on real data alone (eq. 21).

use crate::policies::parts::inverse_network::InverseNetworkController;
use crate::policies::parts::single_controller::SingleController;
use crate::policies::{ModelNeed, PI_REAL, PolicyEntry, SeriesLabel};

pub(crate) const ENTRY: PolicyEntry = PolicyEntry {
    name: "pi_real",
    label: SeriesLabel {
        plain: "πᵣₑₐₗ", markdown: "π<sub>real</sub>", latex: "$\\pi_{real}$"
    },
    footnote: "trained directly from real data.",
    needs: &[ModelNeed::Network(&PI_REAL)],
    make: |mut parts, options| {
        let model = parts.inverse("pi_real", &PI_REAL)?;
        Ok(Box::new(SingleController::new(
            InverseNetworkController::new(model, options),
            "",
            options,
        )))
    },
    ..PolicyEntry::PLAIN
};
