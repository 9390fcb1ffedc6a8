//! π_real (section V-C): the same inverse mapping, trained on real data alone (eq. 21).

use super::inverse_network::InverseNetworkController;
use super::single_controller::SingleController;
use super::{Part, PolicyEntry, need};
use crate::base::series::SeriesLabel;

pub(super) const ENTRY: PolicyEntry = PolicyEntry {
    name: "pi_real",
    label: SeriesLabel { plain: "πᵣₑₐₗ", markdown: "π<sub>real</sub>", latex: "$\\pi_{real}$" },
    look: None,
    footnote: "trained directly from real data.",
    needs: &[Part::RealInverse],
    closed_loop_only: false,
    make: |parts, options| {
        let model = need("pi_real", Part::RealInverse, parts.real)?;
        Ok(Box::new(SingleController::new(InverseNetworkController::new(model, options), "", options)))
    },
};
