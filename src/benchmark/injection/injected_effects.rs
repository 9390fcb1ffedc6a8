//! Injected effects of the catalogue, with random directions, signs, shapes, positions and tendons.

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use crate::base::Generator;
use crate::effects::{CATALOGUE, Card, EffectSpec, Model, ModelParameter, Parameter, Seek, card};

/// An effect of the catalogue with its values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InjectedEffect {
    /// Its name.
    pub name: String,
    /// Parameter values in the order of its card.
    pub values: Vec<f64>,
    /// Whether it follows another law of the same effect.
    pub other_law: bool,
}

/// Effects with another law.
const OTHER_LAWS: [&str; 3] = ["friction", "hysteresis", "creep"];

impl InjectedEffect {
    /// Its card in the catalogue.
    pub fn card(&self) -> Option<&'static Card> {
        card(&self.name)
    }

    /// Its name, with its tendon if it acts on one.
    pub(crate) fn label(&self) -> String {
        let tendon = self.card().and_then(tendon_parameter).map(|index| self.values[index]);
        effect_label(&self.name, tendon)
    }

    /// The effect, or the effects that form its other law; none if a value is outside its valid
    /// range.
    pub fn effects(&self) -> Option<Vec<EffectSpec>> {
        let spec = EffectSpec::from_card(self.card()?, &self.values)?;
        if !self.other_law {
            return Some(vec![spec]);
        }
        let pair = |first: EffectSpec, second: EffectSpec| Some(vec![first, second]);
        match spec {
            // Half of it slips early, half late.
            EffectSpec::Friction(friction) => {
                let (mut early, mut late) = (friction, friction);
                (early.moment_nm, early.yield_rad_m) =
                    (0.5 * friction.moment_nm, 0.5 * friction.yield_rad_m);
                (late.moment_nm, late.yield_rad_m) =
                    (0.5 * friction.moment_nm, 1.5 * friction.yield_rad_m);
                pair(EffectSpec::Friction(early), EffectSpec::Friction(late))
            }
            // Two relaxation times, two octaves apart.
            EffectSpec::Creep(creep) => {
                let (mut fast, mut slow) = (creep, creep);
                (fast.share, fast.time_s) = (0.5 * creep.share, 0.5 * creep.time_s);
                (slow.share, slow.time_s) = (0.5 * creep.share, 2.0 * creep.time_s);
                pair(EffectSpec::Creep(fast), EffectSpec::Creep(slow))
            }
            // Yield points denser at small curvatures.
            EffectSpec::Hysteresis(hysteresis) => {
                let (mut early, mut late) = (hysteresis, hysteresis);
                (early.share, early.range_rad_m) =
                    (0.5 * hysteresis.share, 0.5 * hysteresis.range_rad_m);
                (late.share, late.range_rad_m) =
                    (0.5 * hysteresis.share, 1.5 * hysteresis.range_rad_m);
                pair(EffectSpec::Hysteresis(early), EffectSpec::Hysteresis(late))
            }
            spec => Some(vec![spec]),
        }
    }
}

/// Index of the parameter that says which tendon an effect acts on, if it acts on one.
pub(crate) fn tendon_parameter(card: &Card) -> Option<usize> {
    card.parameters.iter().position(|parameter| parameter.seek == Seek::Tendon)
}

/// Name of an effect, with its tendon if it acts on one.
pub(crate) fn effect_label(name: &str, tendon: Option<f64>) -> String {
    tendon.map_or_else(|| name.to_owned(), |tendon| format!("{name} (tendon {tendon})"))
}

/// The effects that cases are drawn of: those with a strength, of a robot with one segment.
/// Something fixed in the world has a place instead.
pub fn drawn_catalogue() -> Vec<&'static Card> {
    let is_drawn = |card: &&Card| {
        !card.parameters.iter().any(|parameter| match parameter.seek {
            Seek::Distance(_) => true,
            Seek::Segment => parameter.null > 0.0,
            _ => false,
        })
    };
    CATALOGUE.iter().copied().filter(is_drawn).collect()
}

/// Value of a parameter without influence on `model`.
pub(crate) fn null_value(parameter: &Parameter, model: &Model) -> f64 {
    match parameter.seek {
        Seek::Replaces(path, _) => {
            let number = ModelParameter::named(model, path).and_then(|number| number.value(model));
            number.unwrap_or(parameter.null)
        }
        _ => parameter.null,
    }
}

/// Usual size of a parameter; none if it is no size.
pub(crate) fn size(parameter: &Parameter) -> Option<f64> {
    match parameter.seek {
        Seek::Size(size)
        | Seek::Scanned(size, _)
        | Seek::Replaces(_, size)
        | Seek::Distance(size) => Some(size),
        _ => None,
    }
}

/// An effect without its size.
#[derive(Clone, Debug)]
pub(crate) struct UnscaledEffect {
    pub(crate) card: &'static Card,
    /// Values without any size.
    null: Vec<f64>,
    /// Change of the values by one usual size.
    per_strength: Vec<f64>,
    other_law: bool,
}

impl UnscaledEffect {
    /// Draws all open values except the size.
    pub(crate) fn draw(
        card: &'static Card,
        model: &Model,
        other_law: bool,
        random: &mut Generator,
    ) -> UnscaledEffect {
        let null: Vec<f64> = card
            .parameters
            .iter()
            .map(|parameter| draw_null_value(parameter, model, random))
            .collect();
        let mut per_strength: Vec<f64> =
            card.parameters.iter().map(|parameter| size(parameter).unwrap_or(0.0)).collect();
        let sizes = per_strength.iter().filter(|size| **size != 0.0).count();
        if sizes > 1 {
            let direction: Vec<f64> =
                (0..per_strength.len()).map(|_| StandardNormal.sample(random)).collect();
            let length = direction.iter().map(|x: &f64| x * x).sum::<f64>().sqrt().max(1e-9);
            per_strength.iter_mut().zip(direction).for_each(|(size, x)| *size *= x / length);
        } else if random.random_range(0..2) == 1 {
            let opposite: Vec<f64> =
                null.iter().zip(&per_strength).map(|(null, size)| null - size).collect();
            // A weaker section is damage; a stiffer one is not.
            if EffectSpec::from_card(card, &opposite).is_some() && card.name != "soft_section" {
                per_strength.iter_mut().for_each(|size| *size = -*size);
            }
        }
        UnscaledEffect {
            card,
            null,
            per_strength,
            other_law: other_law && OTHER_LAWS.contains(&card.name),
        }
    }

    /// The effect at `amount` usual sizes.
    pub(crate) fn scaled(&self, amount: f64) -> InjectedEffect {
        let values = self
            .null
            .iter()
            .zip(&self.per_strength)
            .map(|(null, size)| null + amount * size)
            .collect();
        InjectedEffect { name: self.card.name.to_owned(), values, other_law: self.other_law }
    }
}

/// Draws values without influence: shapes in the range of tried values, any position, any tendon,
/// any flag.
fn draw_null_value(parameter: &Parameter, model: &Model, random: &mut Generator) -> f64 {
    match parameter.seek {
        Seek::Size(_)
        | Seek::Scanned(..)
        | Seek::Replaces(..)
        | Seek::Distance(_)
        | Seek::Located(_)
        | Seek::Segment
        | Seek::Convention => null_value(parameter, model),
        Seek::Shape(tries) => {
            let (low, high) =
                tries.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| {
                    (low.min(x), high.max(x))
                });
            let share = random.random_range(0.0..1.0);
            if low > 0.0 { low * (high / low).powf(share) } else { low + share * (high - low) }
        }
        Seek::Place => random.random_range(0.05..0.95) * model.robot.backbone.length_m,
        Seek::Tendon => random.random_range(1..=model.robot.tendons.angles_deg.len()) as f64,
        Seek::Flag => f64::from(random.random_range(0..2_u8)),
    }
}
