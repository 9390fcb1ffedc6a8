//! Policy B (section IV-E): the inverse mapping retrained on simulated data that the error model has moved into the
//! real workspace, p_exp = p_sim − e_gp (eq. 24). The moving happens before training; here it is the network alone.

use super::alone::Alone;
use super::direct::Direct;
use super::{Part, PolicyEntry, need};

pub(super) const ENTRY: PolicyEntry = PolicyEntry {
    name: "b",
    needs: &[Part::GeneratedInverse],
    closed_loop_only: false,
    make: |parts, options| {
        let model = need("b", Part::GeneratedInverse, parts.generated)?;
        Ok(Box::new(Alone::new(Direct::new(model, options), "b", options)))
    },
};
