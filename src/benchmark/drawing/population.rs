//! Robots that differ: a random number of effects of the catalogue, each of random strength.

use rand::RngExt;
use rand::seq::SliceRandom;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use crate::base::{BadOption, Seed};
use crate::benchmark::injection::injected_effects::{UnscaledEffect, drawn_catalogue};
use crate::effects::{CATALOGUE, Card, EffectSpec, Model, card, check_effects};

/// A distribution of robots around a model. Each has `least_effects` to `most_effects` different
/// effects, all numbers equally likely. The strength of an effect is the magnitude of a normal
/// variable times `strength`, in usual sizes: the size of an effect's parameters that its file in
/// the catalogue gives. Signs, directions, places, tendons and shapes are random.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Population {
    /// Smallest number of effects of a robot.
    pub least_effects: usize,
    /// Largest number of effects of a robot.
    pub most_effects: usize,
    /// Standard deviation of the signed strength, in usual sizes, above 0 and up to 5.
    pub strength: f64,
    /// Names of the effects that may occur; empty: all of the catalogue.
    pub effects: Vec<String>,
}

impl Default for Population {
    fn default() -> Population {
        Population { least_effects: 1, most_effects: 5, strength: 1.0, effects: Vec::new() }
    }
}

/// An effect of one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnEffect {
    /// Its card in the catalogue.
    pub card: &'static Card,
    /// Parameter values in the order of the card.
    pub values: Vec<f64>,
    /// Strength in usual sizes.
    pub strength: f64,
    /// The effect.
    pub spec: EffectSpec,
}

/// Halvings of a strength until an effect may have it: a radius cannot become negative.
const MAX_HALVINGS: usize = 20;

impl Population {
    /// Refuses counts and names without a meaning.
    ///
    /// # Errors
    /// [`BadOption`] names the first one.
    pub fn check(&self) -> Result<(), BadOption> {
        let bad = |key, found: String, expected| Err(BadOption { key, found, expected });
        if let Some(unknown) = self.effects.iter().find(|name| card(name).is_none()) {
            return bad("effects", format!("`{unknown}`"), "names of effects of the catalogue");
        }
        if self.most_effects == 0 || self.most_effects > self.cards().count() {
            return bad(
                "most_effects",
                self.most_effects.to_string(),
                "at least 1, and no more than may occur",
            );
        }
        if self.least_effects > self.most_effects {
            return bad("least_effects", self.least_effects.to_string(), "at most `most_effects`");
        }
        if !(self.strength > 0.0 && self.strength <= 5.0) {
            return bad("strength", self.strength.to_string(), "a number above 0 and up to 5");
        }
        Ok(())
    }

    /// The effects that may occur, each once.
    fn cards(&self) -> impl Iterator<Item = &'static Card> {
        let named = |card: &&'static Card| {
            self.effects.is_empty() || self.effects.iter().any(|name| name == card.name)
        };
        drawn_catalogue().into_iter().filter(named)
    }

    /// The effects of the robot that `seed` draws around `model`, in the order of the catalogue.
    pub fn draw(&self, model: &Model, seed: Seed) -> Vec<DrawnEffect> {
        let mut random = seed.rng();
        let mut cards: Vec<&'static Card> = self.cards().collect();
        cards.shuffle(&mut random);
        let count = random.random_range(self.least_effects..=self.most_effects);
        let mut drawn: Vec<DrawnEffect> = Vec::with_capacity(count);
        for (index, card) in cards.into_iter().enumerate() {
            if drawn.len() == count {
                break;
            }
            if let Some(effect) = self.effect(card, model, seed.child("effect").index(index as u64))
            {
                let combined: Vec<EffectSpec> =
                    drawn.iter().chain([&effect]).map(|effect| effect.spec.clone()).collect();
                // Two laws of the same moment exclude each other.
                if check_effects(&combined, &model.robot.tendon_layout()).is_ok() {
                    drawn.push(effect);
                }
            }
        }
        drawn.sort_by_key(|effect| CATALOGUE.iter().position(|card| card.name == effect.card.name));
        drawn
    }

    /// An effect of random strength, which is halved until its parameters are in range.
    fn effect(&self, card: &'static Card, model: &Model, seed: Seed) -> Option<DrawnEffect> {
        let mut random = seed.rng();
        let unscaled = UnscaledEffect::draw(card, model, false, &mut random);
        let normal: f64 = StandardNormal.sample(&mut random);
        (0..MAX_HALVINGS).find_map(|halving| {
            let strength = self.strength * normal.abs() * 0.5_f64.powi(halving as i32);
            let values = unscaled.scaled(strength).values;
            let spec = EffectSpec::from_card(card, &values)?;
            Some(DrawnEffect { card, values, strength, spec })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::TendonLayout;
    use std::collections::BTreeMap;

    fn model() -> Model {
        Model::default()
    }

    #[test]
    fn robots_repeat_and_cover_the_catalogue_with_the_strengths_that_are_asked_for() {
        let (population, model) = (Population::default(), model());
        let robots: Vec<Vec<DrawnEffect>> =
            (0..400).map(|seed| population.draw(&model, Seed(seed))).collect();
        assert_eq!(robots[7], population.draw(&model, Seed(7)));
        let mut counts = BTreeMap::new();
        robots.iter().for_each(|robot| *counts.entry(robot.len()).or_insert(0) += 1);
        assert_eq!(counts.keys().copied().collect::<Vec<_>>(), [1, 2, 3, 4, 5]);
        assert!(counts.values().all(|count| (50..110).contains(count)), "{counts:?}");
        let effects: Vec<&DrawnEffect> = robots.iter().flatten().collect();
        for card in drawn_catalogue() {
            let times = effects.iter().filter(|effect| effect.card.name == card.name).count();
            assert!((25..90).contains(&times), "{} {times}", card.name);
        }
        // Of the magnitude of a standard normal variable half lies below 0.674.
        let weak = effects.iter().filter(|effect| effect.strength < 0.674).count() as f64
            / effects.len() as f64;
        assert!((weak - 0.5).abs() < 0.06, "{weak}");
        for robot in &robots {
            let specs: Vec<EffectSpec> = robot.iter().map(|effect| effect.spec.clone()).collect();
            check_effects(&specs, &TendonLayout::ring(4)).unwrap();
        }
    }

    #[test]
    fn what_makes_no_population_is_refused() {
        let told = |change: fn(&mut Population)| {
            let mut population = Population::default();
            change(&mut population);
            population.check().map_err(|bad| (bad.key, bad.found))
        };
        assert_eq!(told(|_| {}), Ok(()));
        assert_eq!(told(|p| p.most_effects = 99), Err(("most_effects", "99".into())));
        assert_eq!(told(|p| p.most_effects = 0), Err(("most_effects", "0".into())));
        assert_eq!(told(|p| p.least_effects = 6), Err(("least_effects", "6".into())));
        assert_eq!(told(|p| p.strength = f64::NAN), Err(("strength", "NaN".into())));
        assert_eq!(
            told(|p| p.effects = vec!["frction".into()]),
            Err(("effects", "`frction`".into()))
        );
        assert_eq!(told(|p| p.effects = vec!["creep".into()]), Err(("most_effects", "5".into())));
        assert_eq!(
            told(|p| p.effects = vec!["creep".into(); 5]),
            Err(("most_effects", "5".into())),
            "one effect"
        );
    }
}
