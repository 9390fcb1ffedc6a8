//! Discovery: where a model and a measurement disagree, which effect of the catalogue is missing, how much of it, and
//! whether that is all (docs/discovery.md).
//!
//! The physics is fitted anew for every candidate; numbers that a lab would recalibrate are free in all of them alike;
//! candidates pay for their parameters; trials that take no part in any of it are the proof.

mod answer;
mod base;
mod baseline;
mod check;
mod compare;
mod error;
mod features;
mod floor;
mod hypothesis;
mod menu;
mod missing;
mod next;
mod noise;
mod nuisance;
mod options;
mod places;
mod play;
mod proof;
mod refit;
mod responses;
mod samples;
mod screen;
mod search;
mod unseen;
mod words;

use crate::data::Recording;
use crate::data::findings::{Findings, Gap, PlaceRow, ResidualRow, Verdict};
use crate::effects::Model;

use answer::Answer;
use features::circumstances;
use hypothesis::{Hypothesis, effects, hypotheses};
use missing::{Missing, missing};
use noise::Noise;
use nuisance::{Explained, Nuisances};
use refit::Study;
use samples::{Samples, rms_m};
use search::{Found, Limits, Scored};

pub use compare::Remedies;
pub use error::DiscoveryError;
pub use next::Next;
pub use options::{Options, Uncertainty};

/// An answer with all that stands behind it.
#[derive(Clone, Debug)]
pub struct Discovery {
    /// The answer.
    pub findings: Findings,
    /// The given model (calibrated, where there was a baseline) with the effects that were named.
    pub model: Model,
    /// Every tracked sample with its residual before and after.
    pub residuals: Vec<ResidualRow>,
    /// The map of disagreement.
    pub places: Vec<PlaceRow>,
    /// What a lab would try instead.
    pub remedies: Remedies,
    /// What to record next where these data cannot tell, the best first.
    pub next: Vec<Next>,
}

/// What an answer is sought for, and what has been found out on the way.
struct Question<'a> {
    options: &'a Options,
    /// The model, calibrated on the baseline where there is one, played with the precision of the options.
    model: Model,
    hypotheses: Vec<Hypothesis>,
    /// All samples, those of the fit, and the proof.
    all: Samples,
    fit: Samples,
    proof: Samples,
    played: Vec<f64>,
    played_proof: Vec<f64>,
    responses: Vec<responses::Response>,
    nuisances: Nuisances,
    /// Whether markers on the base show it standing straight.
    base_is_straight: bool,
}

/// Finds what `model` lacks to explain `measured`. With a `baseline`, a recording of the robot as built, the model is
/// first calibrated on it, and what the two have in common is no discovery.
///
/// # Errors
/// [`DiscoveryError`] for data that allow no answer.
pub fn discover(
    model: &Model,
    measured: &Recording,
    baseline: Option<&Recording>,
    options: &Options,
) -> Result<Discovery, DiscoveryError> {
    options.check()?;
    let all = Samples::new(measured);
    check::check(measured, &all)?;
    let mut question = Question::new(model, all, baseline, options)?;
    question.base_is_straight = base::stands_straight(measured);
    let study = question.study();
    let unplayable = || DiscoveryError::Unplayable(question.fit.trials[0].number);
    let search = |thorough: bool| study.search(&question.responses, &Limits { thorough, ..options.limits() });
    let mut found = search(false).ok_or_else(unplayable)?;
    // Before anything is called unexplained, nothing has been left out because of what it promised.
    if question.left(&found) {
        found = search(true).ok_or_else(unplayable)?;
    }
    let sharp = question.sharpened(&study, found);
    Ok(question.discovery(model, measured, &study, &sharp))
}

impl<'a> Question<'a> {
    fn new(
        model: &Model,
        all: Samples,
        baseline: Option<&Recording>,
        options: &'a Options,
    ) -> Result<Question<'a>, DiscoveryError> {
        let mut model = model.clone();
        let resolution = &mut model.robot.resolution;
        resolution.motion_tolerance_m = options.motion_tolerance_m;
        resolution.cell_m = resolution.cell_m.max(options.cell_m);
        let hypotheses = hypotheses(&model);
        let (kept, held_out) = proof::split(&all, options.held_out_share);
        let (fit, proof) = (all.of_trials(&kept), all.of_trials(&held_out));
        let base = match baseline {
            Some(recording) => Some(
                Base::new(&mut model, &hypotheses, recording, options)
                    .map_err(|error| DiscoveryError::Baseline(Box::new(error)))?,
            ),
            None => None,
        };
        let played = played(&model, &fit)?;
        let played_proof = self::played(&model, &proof)?;
        let responses = responses::responses(&model, &hypotheses, &|_| true, &fit, &played);
        let columns = baseline::uncertain(&options.uncertain, &hypotheses, &responses, 1.0);
        let nuisances = match &base {
            None => Nuisances::independent(played.len(), &columns),
            Some(base) => baseline::in_common((&base.samples, &base.played, &base.columns), (&fit, &played, &columns)),
        };
        Ok(Question {
            options,
            model,
            hypotheses,
            all,
            fit,
            proof,
            played,
            played_proof,
            responses,
            nuisances,
            base_is_straight: false,
        })
    }

    fn study(&self) -> Study<'_> {
        let open = |hypothesis: &Hypothesis| {
            let name = hypothesis.card.name;
            let contradicted = self.base_is_straight && name == "base_tilt";
            !contradicted && !self.options.left_out.iter().any(|left_out| left_out == name)
        };
        Study {
            model: &self.model,
            hypotheses: &self.hypotheses,
            open: self.hypotheses.iter().map(open).collect(),
            samples: &self.fit,
            nuisances: &self.nuisances,
        }
    }

    /// The best set with derivatives taken where it ended: its intervals depend on them.
    fn sharpened(&self, study: &Study, found: Found) -> Found {
        let sharpen = |scored: Scored| {
            let fitted = study.sharpened(scored.fitted.clone()).unwrap_or(scored.fitted);
            Scored { fitted, score: scored.score }
        };
        let near = found.best.score - self.options.rival_score;
        let tried: Vec<Scored> =
            found.tried.into_iter().map(|scored| if scored.score > near { sharpen(scored) } else { scored }).collect();
        Found { best: sharpen(found.best), tried, ..found }
    }

    /// Whether the samples of the fit hold more than nuisances and noise.
    fn missing(&self, explained: &Explained, played: &[f64]) -> (Missing, bool) {
        let around = circumstances(&self.fit, played);
        let found = missing(&self.fit, &around, &explained.left_m, self.options.seed());
        let floor_m = explained.noise.rms_m();
        let foretold = found.test.p_value < self.options.false_alarm
            && found.test.foretold_m > self.options.least_foretold * floor_m;
        // More scatter than where the same thing was measured again.
        let floor = floor::Floor::of_repeats(&self.fit);
        let freedom = 3.0 * explained.noise.independent(self.fit.len());
        let scatters = floor.p_value(floor_m * floor_m, freedom) < self.options.false_alarm;
        (found, foretold || scatters)
    }

    /// Whether something is still missing with the best set.
    fn left(&self, found: &Found) -> bool {
        let best = &found.best.fitted;
        self.missing(&best.explained, &best.played).1
    }

    fn discovery(&self, given: &Model, measured: &Recording, study: &Study, found: &Found) -> Discovery {
        let best = &found.best.fitted;
        let (before, _) = self.missing(&found.null.fitted.explained, &self.played);
        let (after, left) = self.missing(&best.explained, &best.played);
        let answer = study.answer(found, left, self.options.rival_score);
        let added = effects(&self.hypotheses, &answer.members).unwrap_or_default();
        let mut gap = Gap {
            metric: "rms tip error on held-out trials".to_owned(),
            held_out_trials: self.proof.trials.iter().map(|trial| trial.number).collect(),
            before_m: rms_m(&self.proof.residual(&self.played_proof)),
            after_m: f64::NAN,
        };
        let played_proof = play::tips(&self.model, &added, &self.proof);
        let after_m = played_proof.as_ref().map_or(f64::INFINITY, |there| rms_m(&self.proof.residual(there)));
        // A model is never made worse.
        let kept = after_m <= gap.before_m;
        let answer = if kept { answer } else { Answer::refuted(answer) };
        let added = if kept { added } else { Vec::new() };
        gap.after_m = if kept { after_m } else { gap.before_m };
        let played_proof = played_proof.filter(|_| kept).unwrap_or_else(|| self.played_proof.clone());
        let mut model = self.model.clone();
        model.robot.resolution = given.robot.resolution;
        model.effects.extend(added);
        let named = !answer.members.is_empty();
        let final_explained = if named { &best.explained } else { &found.null.fitted.explained };
        let final_missing = if named { &after } else { &before };
        let final_played = if named { &best.played } else { &self.played };
        let floor = self
            .floor(if answer.verdict == Verdict::Unexplained { None } else { Some(final_explained) }, &best.explained);
        let residuals = self.residual_rows(final_played, &played_proof);
        let places = self.map(&residuals, &floor.1);
        let mut findings = Findings {
            verdict: answer.verdict,
            effects: answer.effects.clone(),
            noise_floor_m: floor.1.rms_m(),
            gap,
            disagreement: places::disagreements(&places),
            candidates: self.candidates(study, found, &answer),
            next_measurement: String::new(),
            summary: String::new(),
            noise: crate::data::findings::Noise {
                sigma_m: floor.1.sigma_m,
                correlation: floor.1.correlation,
                from: floor.0,
            },
            missing_before: before.test.clone(),
            missing_after: final_missing.test.clone(),
            pattern: if answer.verdict == Verdict::Unexplained {
                words::pattern(after.pattern, &places)
            } else {
                String::new()
            },
            limitations: check::limitations(measured, &self.all),
            proposals: Vec::new(),
        };
        let next = self.next(&answer.rivals, &floor.1);
        findings.proposals = next.iter().map(|next| next.proposal.clone()).collect();
        findings.summary = words::summary(&findings);
        findings.next_measurement = words::next(&findings);
        Discovery {
            findings,
            model,
            residuals,
            places,
            remedies: compare::remedies(study, &self.played, &self.proof, &self.played_proof),
            next,
        }
    }

    /// The noise, from repeats and, where all is explained, from what is left; in words where from.
    fn floor(&self, explained: Option<&Explained>, best: &Explained) -> (String, Noise) {
        let repeats = floor::Floor::of_repeats(&self.fit);
        let correlation = best.noise.correlation;
        let pooled = match explained {
            // What the model leaves is more than noise where it is more than repeats show.
            Some(explained) => {
                let variance_m2 = explained.noise.sigma_m.map(|sigma| sigma * sigma);
                let freedom = explained.noise.independent(self.fit.len());
                if repeats.p_value(variance_m2.iter().sum(), 3.0 * freedom) < MORE_THAN_REPEATS {
                    repeats
                } else {
                    repeats.pooled(variance_m2, freedom)
                }
            }
            None if repeats.freedom >= 3.0 => repeats,
            None => repeats.pooled(best.noise.sigma_m.map(|sigma| sigma * sigma), 1.0),
        };
        let sigma_m = pooled.variance_m2.map(f64::sqrt);
        (pooled.from, Noise { sigma_m, correlation })
    }

    fn residual_rows(&self, after: &[f64], after_proof: &[f64]) -> Vec<ResidualRow> {
        let mut rows = Vec::new();
        let parts = [(&self.fit, &self.played, after, false), (&self.proof, &self.played_proof, after_proof, true)];
        for (samples, before, after, held_out) in parts {
            let (before, after) = (samples.residual(before), samples.residual(after));
            rows.extend(samples.rows.iter().enumerate().map(|(k, row)| ResidualRow {
                trial: samples.trials[row.trial].number,
                time_s: row.time_s,
                held_out,
                tip_x_m: row.tip_m[0],
                tip_y_m: row.tip_m[1],
                tip_z_m: row.tip_m[2],
                before_x_m: before[3 * k],
                before_y_m: before[3 * k + 1],
                before_z_m: before[3 * k + 2],
                after_x_m: after[3 * k],
                after_y_m: after[3 * k + 1],
                after_z_m: after[3 * k + 2],
            }));
        }
        rows
    }

    fn map(&self, rows: &[ResidualRow], noise: &Noise) -> Vec<PlaceRow> {
        let mut played = self.played.clone();
        played.extend_from_slice(&self.played_proof);
        let order: Vec<u64> = self.fit.trials.iter().chain(&self.proof.trials).map(|trial| trial.number).collect();
        let place = |number: &u64| self.all.trials.iter().position(|trial| trial.number == *number);
        let all = self.all.of_trials(&order.iter().filter_map(place).collect::<Vec<usize>>());
        let around = circumstances(&all, &played);
        let before: Vec<f64> = rows.iter().flat_map(|row| [row.before_x_m, row.before_y_m, row.before_z_m]).collect();
        let after: Vec<f64> = rows.iter().flat_map(|row| [row.after_x_m, row.after_y_m, row.after_z_m]).collect();
        places::map(&around, &before, &after, noise)
    }

    fn candidates(&self, study: &Study, found: &Found, answer: &Answer) -> Vec<crate::data::findings::Candidate> {
        let unseen = |scored: &Scored| {
            let each = unseen::unseen_m(study, &scored.fitted);
            crate::math::summary::root_mean_square(&each)
        };
        study.candidates(found, answer, self.options.rival_score, &unseen)
    }
}

/// Chance below which what a model leaves is taken to be more than the noise of repeats.
const MORE_THAN_REPEATS: f64 = 0.05;

/// A baseline, once the model is calibrated on it.
struct Base {
    samples: Samples,
    played: Vec<f64>,
    /// What is uncertain, far wider than after a calibration.
    columns: Vec<(Vec<f64>, f64)>,
}

/// Before a calibration a number is known this many times worse than after it.
const BEFORE_CALIBRATION: f64 = 10.0;

impl Base {
    fn new(
        model: &mut Model,
        hypotheses: &[Hypothesis],
        recording: &Recording,
        options: &Options,
    ) -> Result<Base, DiscoveryError> {
        let samples = Samples::new(recording);
        check::check(recording, &samples)?;
        let look = |model: &Model| -> Result<(Vec<f64>, Vec<(Vec<f64>, f64)>), DiscoveryError> {
            let played = played(model, &samples)?;
            let responses =
                responses::responses(model, hypotheses, &|name| options.is_uncertain(name), &samples, &played);
            let columns = baseline::uncertain(&options.uncertain, hypotheses, &responses, BEFORE_CALIBRATION);
            Ok((played, columns))
        };
        let (first, columns) = look(model)?;
        let nuisances = Nuisances::independent(first.len(), &columns);
        if let Some(better) = baseline::calibrated(model, hypotheses, &samples, &nuisances) {
            *model = better;
        }
        let (played, columns) = look(model)?;
        Ok(Base { samples, played, columns })
    }
}

fn played(model: &Model, samples: &Samples) -> Result<Vec<f64>, DiscoveryError> {
    play::tips(model, &[], samples).ok_or_else(|| {
        let alone = |k: usize| play::tips(model, &[], &samples.of_trials(&[k])).is_none();
        let first = (0..samples.trials.len()).find(|&k| alone(k)).unwrap_or(0);
        DiscoveryError::Unplayable(samples.trials[first].number)
    })
}
