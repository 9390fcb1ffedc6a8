//! π_real (section V-C): the same inverse mapping, trained on real data alone (eq. 21).

use super::alone::Alone;
use super::direct::Direct;
use super::{Part, PolicyEntry, need};

pub(super) const ENTRY: PolicyEntry = PolicyEntry {
    name: "pi_real",
    needs: &[Part::RealInverse],
    closed_loop_only: false,
    make: |parts, options| {
        let model = need("pi_real", Part::RealInverse, parts.real)?;
        Ok(Box::new(Alone::new(Direct::new(model, options), "", options)))
    },
};
