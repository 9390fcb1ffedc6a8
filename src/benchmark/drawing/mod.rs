//! Drawing of blind cases: robots with injected effects.

pub(crate) mod population;
pub(crate) mod scale_to_shift;

use rand::seq::SliceRandom;
use serde::Serialize;

use super::commands::{Commands, rms_distance_m};
use super::error::BenchmarkError;
use super::injection::disturbances::{DISTURBANCES, Disturbance};
use super::injection::injected_effects::{InjectedEffect, UnscaledEffect, drawn_catalogue};
use super::options::{CaseGroup, OracleOptions, Prior, TruthOptions};
use super::oracle::refit::difference;
use super::oracle::{CatalogueSpan, Imitated};
use super::truth::{Truth, check_prior, draw_uncertain, tips_m};
use crate::base::{Generator, Point3, Seed};
use crate::effects::{Card, Model};
use scale_to_shift::{ScaledStrength, scale_to_shift};

/// Minimum displacement by a disturbance over the requested one: a disturbance of a tendon that is
/// hardly used shows in no recording.
const MIN_SHIFT_SHARE: f64 = 0.25;

/// Draws the injected effects given the uncertain parameters; none if impossible.
type DrawEffects<'h> =
    dyn FnMut(&[InjectedEffect], &mut Generator) -> Option<Vec<InjectedEffect>> + 'h;

/// Design of a blind case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CaseDesign {
    /// The model as given.
    pub model: Model,
    /// What is injected.
    pub group: CaseGroup,
    /// Number of the case in its batch, by which kinds and sizes alternate.
    pub number: usize,
    /// Requested rms tip displacement, metres.
    pub shift_m: f64,
    /// Standard deviation of the noise by axis, metres; unit of the oracle.
    pub noise_m: f64,
    /// Priors of the uncertain parameters.
    pub priors: Vec<Prior>,
    /// Resolution of the truth.
    pub truth: TruthOptions,
    /// Thresholds of the oracle.
    pub oracle: OracleOptions,
    /// Root seed.
    pub seed: u64,
}

/// Maximum strength in usual sizes.
const MAX_STRENGTH: f64 = 8.0;
/// Minimum displacement of each effect of a pair over the requested one.
const MIN_PAIR_SHIFT_SHARE: f64 = 0.98;
/// Maximum number of robots, or of disturbances, that are drawn until one serves.
const MAX_DRAWS: usize = 20;

/// Draws the truth of a case. `span`: the oracle's span for these commands, for groups that need
/// it.
///
/// # Errors
/// [`BenchmarkError`] if no robot can be simulated or the oracle finds no candidate.
pub fn draw(
    robot: &CaseDesign,
    commands: &Commands,
    span: Option<&CatalogueSpan>,
) -> Result<Truth, BenchmarkError> {
    robot.priors.iter().try_for_each(check_prior)?;
    let drawing = CaseDrawing { robot, commands };
    match robot.group {
        CaseGroup::Nothing => drawing.draw_robot("nothing", &mut |_, _| Some(Vec::new())),
        CaseGroup::Single => {
            let card = drawing.card_in_turn();
            drawing.draw_robot(card.name, &mut |uncertain, random| {
                drawing.draw_effect(card, uncertain, random).map(|(hidden, _)| vec![hidden])
            })
        }
        CaseGroup::Pair => drawing
            .draw_robot("a pair", &mut |uncertain, random| drawing.draw_pair(uncertain, random)),
        CaseGroup::Outside | CaseGroup::Inside => {
            drawing.draw_by_oracle(span.ok_or(BenchmarkError::Unplayable)?)
        }
    }
}

struct CaseDrawing<'a> {
    robot: &'a CaseDesign,
    commands: &'a Commands,
}

impl CaseDrawing<'_> {
    /// The model with the resolution of the truth.
    fn fine(&self) -> Model {
        let mut fine = self.robot.model.clone();
        fine.robot.resolution = self.robot.truth.resolution(&fine.robot.resolution);
        fine
    }

    fn card_in_turn(&self) -> &'static Card {
        let all = drawn_catalogue();
        all[self.robot.number % all.len()]
    }

    /// Whether an effect follows another law in this case: in every other round of the catalogue.
    fn other_law(&self, card: &Card) -> bool {
        let all = drawn_catalogue();
        let index = all.iter().position(|other| other.name == card.name).unwrap_or(0);
        self.robot.truth.other_laws && (self.robot.number / all.len() + index) % 2 == 1
    }

    /// Draws robots until one with the injected effects can be simulated.
    fn draw_robot(&self, what: &str, hide: &mut DrawEffects) -> Result<Truth, BenchmarkError> {
        for tried in 0..MAX_DRAWS {
            let seed = Seed(self.robot.seed).child("robot").index(tried as u64);
            let uncertain = draw_uncertain(
                &self.robot.priors,
                &self.robot.model,
                &mut seed.child("uncertain").rng(),
            );
            let Some(hidden) = hide(&uncertain, &mut seed.child("hidden").rng()) else { continue };
            if let Some(truth) = self.measure_shift(hidden, None, uncertain) {
                return Ok(truth);
            }
        }
        Err(BenchmarkError::NoRobot { what: what.to_owned(), tried: MAX_DRAWS })
    }

    /// The truth with its measured displacement; none if the simulation fails.
    fn measure_shift(
        &self,
        hidden: Vec<InjectedEffect>,
        unknown: Option<Disturbance>,
        uncertain: Vec<InjectedEffect>,
    ) -> Option<Truth> {
        let fine = self.fine();
        let with = tips_m(&fine, self.commands, &uncertain, &hidden, unknown.as_ref())?;
        let nothing = hidden.is_empty() && unknown.is_none();
        let shift_m = if nothing {
            0.0
        } else {
            rms_distance_m(&with, &tips_m(&fine, self.commands, &uncertain, &[], None)?)
        };
        Some(Truth {
            hidden,
            unknown,
            uncertain,
            shift_m,
            left: 0.0,
            imitations: Vec::new(),
            left_out: Vec::new(),
        })
    }

    /// An effect scaled to the requested displacement, or as far as possible.
    fn draw_effect(
        &self,
        card: &'static Card,
        uncertain: &[InjectedEffect],
        random: &mut Generator,
    ) -> Option<(InjectedEffect, ScaledStrength)> {
        let model = &self.robot.model;
        let unscaled = UnscaledEffect::draw(card, model, self.other_law(card), random);
        let without = tips_m(model, self.commands, uncertain, &[], None)?;
        let shift_m = |amount: f64| {
            let with = tips_m(model, self.commands, uncertain, &[unscaled.scaled(amount)], None)?;
            Some(rms_distance_m(&with, &without))
        };
        let scaled = scale_to_shift(self.robot.shift_m, MAX_STRENGTH, &mut { shift_m })?;
        Some((unscaled.scaled(scaled.amount), scaled))
    }

    /// Two different effects with sufficient displacements.
    fn draw_pair(
        &self,
        uncertain: &[InjectedEffect],
        random: &mut Generator,
    ) -> Option<Vec<InjectedEffect>> {
        let mut cards = drawn_catalogue();
        cards.shuffle(random);
        let mut pair = Vec::new();
        for card in cards {
            let Some((hidden, scaled)) = self.draw_effect(card, uncertain, random) else {
                continue;
            };
            if scaled.shift_m >= MIN_PAIR_SHIFT_SHARE * self.robot.shift_m {
                pair.push(hidden);
            }
            if pair.len() == 2 {
                return Some(pair);
            }
        }
        None
    }

    /// The first candidate that the oracle assigns to the requested group.
    fn draw_by_oracle(&self, span: &CatalogueSpan) -> Result<Truth, BenchmarkError> {
        let outside = self.robot.group == CaseGroup::Outside;
        let candidates = self.candidates();
        for (tried, candidate) in candidates.iter().enumerate() {
            let seed = Seed(self.robot.seed).child("robot").index(tried as u64);
            let mut random = seed.child("hidden").rng();
            let Some(drawn) = self.draw_candidate(*candidate, &mut random) else { continue };
            let left_out: Vec<String> =
                drawn.hidden.iter().map(|hidden| hidden.name.clone()).collect();
            let imitated = Imitated {
                model: &self.robot.model,
                commands: self.commands,
                displacement_m: &drawn.displacement_m,
                left_out: &left_out,
                options: &self.robot.oracle,
            };
            let Some(left) = oracle_residual(span, &imitated, outside) else { continue };
            let uncertain = draw_uncertain(
                &self.robot.priors,
                &self.robot.model,
                &mut seed.child("uncertain").rng(),
            );
            if let Some(truth) = self.measure_shift(drawn.hidden, drawn.unknown, uncertain) {
                let imitations = if outside { Vec::new() } else { span.imitations(&imitated) };
                return Ok(Truth { left, imitations, left_out, ..truth });
            }
        }
        Err(BenchmarkError::NoneFound { group: self.robot.group.name(), tried: candidates.len() })
    }

    /// Candidates in order: first the one whose turn it is, then the others shuffled. Every third
    /// case outside starts with effects removed from the catalogue.
    fn candidates(&self) -> Vec<InjectionKind> {
        let number = self.robot.number;
        let mut random = Seed(self.robot.seed).child("candidates").rng();
        let mut in_turn = |mut all: Vec<InjectionKind>, turn: usize| -> Vec<InjectionKind> {
            let first = all.remove(turn % all.len());
            all.shuffle(&mut random);
            [vec![first], all].concat()
        };
        let left_out = (0..drawn_catalogue().len()).map(InjectionKind::LeftOut).collect();
        let unknown = (0..DISTURBANCES.len()).map(InjectionKind::Unknown).collect();
        match self.robot.group {
            CaseGroup::Outside if number % 3 == 2 => {
                [in_turn(left_out, number / 3 * 5), in_turn(unknown, number / 3)].concat()
            }
            CaseGroup::Outside => in_turn(unknown, number - number / 3),
            _ => in_turn(left_out, number * 5),
        }
    }

    /// A scaled candidate and its tip displacement by sample.
    fn draw_candidate(
        &self,
        candidate: InjectionKind,
        random: &mut Generator,
    ) -> Option<DrawnCandidate> {
        let model = &self.robot.model;
        let without = tips_m(model, self.commands, &[], &[], None)?;
        let displacement_m =
            |hidden: &[InjectedEffect], unknown: Option<&Disturbance>| -> Option<Vec<f64>> {
                let with = tips_m(model, self.commands, &[], hidden, unknown)?;
                Some(difference(&with, &without))
            };
        match candidate {
            InjectionKind::LeftOut(index) => {
                let (hidden, _) = self.draw_effect(drawn_catalogue()[index], &[], random)?;
                let displacement_m = displacement_m(std::slice::from_ref(&hidden), None)?;
                Some(DrawnCandidate { hidden: vec![hidden], unknown: None, displacement_m })
            }
            InjectionKind::Unknown(index) => {
                // A disturbance of an unused tendon has no influence: draw another tendon.
                let drawn = (0..MAX_DRAWS).find_map(|_| {
                    let unit =
                        DISTURBANCES[index].draw(model.robot.tendons.angles_deg.len(), random);
                    let shift_m = |amount: f64| {
                        let with =
                            tips_m(model, self.commands, &[], &[], Some(&unit.scaled(amount)))?;
                        Some(rms_distance_m(&with, &without))
                    };
                    let max_amount = DISTURBANCES[index].max_multiple;
                    let scaled = scale_to_shift(self.robot.shift_m, max_amount, &mut { shift_m })?;
                    (scaled.shift_m >= MIN_SHIFT_SHARE * self.robot.shift_m)
                        .then(|| unit.scaled(scaled.amount))
                });
                let unknown = drawn?;
                let displacement_m = displacement_m(&[], Some(&unknown))?;
                Some(DrawnCandidate { hidden: Vec::new(), unknown: Some(unknown), displacement_m })
            }
        }
    }
}

/// Residual of the best imitation over the noise, if it fits the requested group.
fn oracle_residual(span: &CatalogueSpan, imitated: &Imitated, outside: bool) -> Option<f64> {
    let options = imitated.options;
    let threshold = if outside { options.outside_above } else { options.inside_below };
    // The linear screening avoids refits of clear cases.
    let linear =
        span.linear_residual(imitated.displacement_m, imitated.left_out, options.most_effects);
    let is_excluded = if outside { linear < threshold } else { linear > 10.0 * threshold };
    if is_excluded {
        return None;
    }
    let residual = span.residual(imitated, outside);
    let fits = if outside { residual > threshold } else { residual < threshold };
    fits.then_some(residual)
}

/// A candidate: an effect removed from the catalogue, or a disturbance.
#[derive(Clone, Copy, Debug)]
enum InjectionKind {
    LeftOut(usize),
    Unknown(usize),
}

/// A scaled candidate.
struct DrawnCandidate {
    hidden: Vec<InjectedEffect>,
    unknown: Option<Disturbance>,
    /// Tip displacement, three values a sample, metres.
    displacement_m: Vec<f64>,
}

/// Simulated tip of the true robot, metres; none if the simulation fails.
pub(crate) fn true_tips_m(
    robot: &CaseDesign,
    truth: &Truth,
    commands: &Commands,
) -> Option<Vec<Point3>> {
    let drawing = CaseDrawing { robot, commands };
    tips_m(&drawing.fine(), commands, &truth.uncertain, &truth.hidden, truth.unknown.as_ref())
}
