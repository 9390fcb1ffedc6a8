//! The parts of an experiment that many of its stages read.

use crate::policies::PolicyOptions;
use crate::runner::graph::failure::Failure;
use crate::runner::jobs::parts::identified::Identified;
use crate::runner::jobs::parts::outside_part::OutsidePart;
use crate::runner::jobs::parts::shared_part::SharedPart;
use crate::specs::{Experiment, PlantSpec};
use std::collections::BTreeMap;

/// The shared parts of one experiment.
pub(crate) struct SharedParts {
    pub(super) model: Identified,
    pub(super) plant: Identified,
    /// The robot measured without noise.
    pub(super) quiet: Identified,
    /// Options of the program's own policies.
    pub(super) policies: SharedPart<PolicyOptions>,
    /// Policies from outside by name.
    pub(super) outside: BTreeMap<String, OutsidePart>,
}

impl SharedParts {
    /// The parts of `spec`; robots that equal those of the experiment `previous` are shared with
    /// it.
    ///
    /// # Errors
    /// [`Failure`] for a part that cannot be written into a key.
    pub(crate) fn new(
        spec: &Experiment,
        previous: Option<&SharedParts>,
    ) -> Result<SharedParts, Failure> {
        let robot = |spec: PlantSpec, previous: Option<&Identified>| match previous
            .filter(|previous| previous.is(&spec))
        {
            Some(shared) => Ok(shared.clone()),
            None => Identified::new(spec),
        };
        Ok(SharedParts {
            model: robot(spec.model.clone(), previous.map(|previous| &previous.model))?,
            plant: robot(spec.plant.clone(), previous.map(|previous| &previous.plant))?,
            quiet: robot(spec.plant.without_noise(), previous.map(|previous| &previous.quiet))?,
            policies: SharedPart::new(PolicyOptions {
                outside: BTreeMap::new(),
                ..spec.policies.clone()
            })?,
            outside: OutsidePart::all(&spec.policies.outside)?,
        })
    }
}
