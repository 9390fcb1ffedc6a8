//! The trained models at hand; each policy takes what it needs.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::base::{TendonLayout, TipModel};
use crate::learn::LearnError;
use crate::learn::networks::Network;
use crate::policies::{
    BuildError, ErrorModel, ForwardModel, InverseModel, NetworkDescription, NetworkForward,
    NetworkInverse, SampleColumns,
};

/// The parts that a policy is built from, networks by their names.
#[derive(Default)]
pub struct PolicyParts {
    inverse: BTreeMap<&'static str, Box<dyn InverseModel>>,
    forward: BTreeMap<&'static str, Box<dyn ForwardModel>>,
    error: Option<Arc<dyn ErrorModel>>,
    layout: Option<TendonLayout>,
    tip_model: Option<Box<dyn TipModel>>,
}

impl PolicyParts {
    /// Adds a trained network as the model that its columns make it: an inverse mapping, or a
    /// forward model.
    ///
    /// # Errors
    /// [`LearnError::Shape`] for a network that does not fit its columns.
    pub fn with_network(
        self,
        network: &NetworkDescription,
        trained: Arc<Network>,
    ) -> Result<Self, LearnError> {
        if network.outputs == [SampleColumns::TipAfter] {
            let tendons = trained.inputs().saturating_sub(3);
            let model = NetworkForward::new(trained, tendons)?;
            return Ok(self.with_forward(network, Box::new(model)));
        }
        Ok(self.with_inverse(network, Box::new(NetworkInverse::new(trained)?)))
    }

    /// Adds an inverse mapping.
    #[must_use]
    pub fn with_inverse(
        mut self,
        network: &NetworkDescription,
        model: Box<dyn InverseModel>,
    ) -> Self {
        self.inverse.insert(network.name, model);
        self
    }

    /// Adds a forward model.
    #[must_use]
    pub fn with_forward(
        mut self,
        network: &NetworkDescription,
        model: Box<dyn ForwardModel>,
    ) -> Self {
        self.forward.insert(network.name, model);
        self
    }

    /// Adds the error model.
    #[must_use]
    pub fn with_error(mut self, error: Arc<dyn ErrorModel>) -> Self {
        self.error = Some(error);
        self
    }

    /// Says where the tendons lie.
    #[must_use]
    pub fn with_layout(mut self, layout: TendonLayout) -> Self {
        self.layout = Some(layout);
        self
    }

    /// Adds the nominal model.
    #[must_use]
    pub fn with_tip_model(mut self, model: Box<dyn TipModel>) -> Self {
        self.tip_model = Some(model);
        self
    }

    /// Where the tendons lie, for the policy called `policy`.
    ///
    /// # Errors
    /// [`BuildError::Missing`] where nobody said so.
    pub fn layout(&self, policy: &'static str) -> Result<TendonLayout, BuildError> {
        self.layout.clone().ok_or(BuildError::Missing { policy, model: "tendon layout" })
    }

    /// Takes the nominal model for the policy called `policy`.
    ///
    /// # Errors
    /// [`BuildError::Missing`] where there is none.
    pub fn tip_model(&mut self, policy: &'static str) -> Result<Box<dyn TipModel>, BuildError> {
        self.tip_model.take().ok_or(BuildError::Missing { policy, model: "nominal model" })
    }

    /// Takes an inverse mapping for the policy called `policy`.
    ///
    /// # Errors
    /// [`BuildError::Missing`] where there is none.
    pub fn inverse(
        &mut self,
        policy: &'static str,
        network: &NetworkDescription,
    ) -> Result<Box<dyn InverseModel>, BuildError> {
        self.inverse.remove(network.name).ok_or(BuildError::Missing { policy, model: network.name })
    }

    /// Takes a forward model for the policy called `policy`.
    ///
    /// # Errors
    /// [`BuildError::Missing`] where there is none.
    pub fn forward(
        &mut self,
        policy: &'static str,
        network: &NetworkDescription,
    ) -> Result<Box<dyn ForwardModel>, BuildError> {
        self.forward.remove(network.name).ok_or(BuildError::Missing { policy, model: network.name })
    }

    /// The error model for the policy called `policy`.
    ///
    /// # Errors
    /// [`BuildError::Missing`] where there is none.
    pub fn error(&self, policy: &'static str) -> Result<Arc<dyn ErrorModel>, BuildError> {
        self.error.clone().ok_or(BuildError::Missing { policy, model: "error model" })
    }
}
