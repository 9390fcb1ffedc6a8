//! The truth of a blind case and its simulation.

use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use super::commands::Commands;
use super::error::BenchmarkError;
use super::injection::disturbances::Disturbance;
use super::injection::injected_effects::{InjectedEffect, null_value};
use super::options::Prior;
use crate::base::{BadOption, Generator, Point3};
use crate::effects::{EffectSpec, Model, Seek, card};

/// What is hidden in a recording: the sealed label.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Injected effects of the catalogue.
    pub hidden: Vec<InjectedEffect>,
    /// Injected disturbance outside the catalogue.
    pub unknown: Option<Disturbance>,
    /// Drawn values of the uncertain parameters.
    pub uncertain: Vec<InjectedEffect>,
    /// Rms tip displacement by the injected effect, metres.
    pub shift_m: f64,
    /// For groups of the oracle: residual of the best imitation over the noise; else 0.
    pub left: f64,
    /// Inside the span: sets of other effects that imitate it equally well, best first.
    pub imitations: Vec<String>,
    /// Effects removed from the catalogue for this case.
    pub left_out: Vec<String>,
}

impl Truth {
    /// Names of the injected effects, joined by ` + `.
    pub fn name(&self) -> String {
        let mut names: Vec<&str> = self.hidden.iter().map(|hidden| hidden.name.as_str()).collect();
        names.extend(self.unknown.as_ref().map(|unknown| unknown.name.as_str()));
        names.sort_unstable();
        names.join(" + ")
    }
}

/// Simulated tip of `model` under `commands` with these uncertain parameters, effects and
/// disturbance, metres; none if the simulation fails.
pub(crate) fn tips_m(
    model: &Model,
    commands: &Commands,
    uncertain: &[InjectedEffect],
    hidden: &[InjectedEffect],
    unknown: Option<&Disturbance>,
) -> Option<Vec<Point3>> {
    let effects = uncertain
        .iter()
        .chain(hidden)
        .map(InjectedEffect::effects)
        .collect::<Option<Vec<Vec<EffectSpec>>>>()?;
    let extra: Vec<EffectSpec> = effects.into_iter().flatten().collect();
    let Some(unknown) = unknown else { return commands.tips_m(model, &extra) };
    let tips_m = unknown.drives(commands).tips_m(model, &extra)?;
    Some(unknown.recorded(commands, tips_m))
}

/// Refuses a prior on something that is no size of an effect.
///
/// # Errors
/// [`BenchmarkError::Option`].
pub(crate) fn check_prior(prior: &Prior) -> Result<(), BenchmarkError> {
    let is_parameter = card(&prior.effect).is_some_and(|card| {
        card.parameters.iter().any(|parameter| is_component_of(parameter.name, prior))
    });
    let found = format!("{}.{}", prior.effect, prior.parameter);
    if is_parameter {
        return Ok(());
    }
    Err(BadOption {
        key: "uncertain",
        found,
        expected: "an effect of the catalogue and one of its parameters",
    }
    .into())
}

/// Whether a parameter is that of the prior or a component of it.
pub(crate) fn is_component_of(parameter: &str, prior: &Prior) -> bool {
    parameter.split('[').next() == Some(prior.parameter.as_str())
}

/// Draws the uncertain parameters of a robot from their priors: one effect each, for each tendon if
/// it acts on one.
pub(crate) fn draw_uncertain(
    priors: &[Prior],
    model: &Model,
    deviate: &mut Generator,
) -> Vec<InjectedEffect> {
    let mut drawn = Vec::new();
    for prior in priors {
        let Some(card) = card(&prior.effect) else { continue };
        let tendon = card.parameters.iter().position(|parameter| parameter.seek == Seek::Tendon);
        let count = if tendon.is_some() { model.robot.tendons.angles_deg.len() } else { 1 };
        for number in 1..=count {
            let mut values: Vec<f64> =
                card.parameters.iter().map(|parameter| null_value(parameter, model)).collect();
            for (value, parameter) in values.iter_mut().zip(card.parameters) {
                if is_component_of(parameter.name, prior) {
                    let deviate: f64 = StandardNormal.sample(deviate);
                    *value += prior.deviation * deviate;
                }
            }
            if let Some(tendon) = tendon {
                values[tendon] = number as f64;
            }
            drawn.push(InjectedEffect { name: card.name.to_owned(), values, other_law: false });
        }
    }
    drawn
}
