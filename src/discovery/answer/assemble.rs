//! From the search to everything that is told: the answer, its proof, the map, what to record next.

use super::final_fit::About;
use super::verdict::{Answer, set_name};
use super::{alternatives, residual_map, summary_text};
use crate::data::Recording;
use crate::data::findings::{self, Candidate, Findings, Gap, PlaceRow, ResidualRow, Verdict};
use crate::discovery::Discovery;
use crate::discovery::fit::ar1_noise::{LEAST_SIGMA_M, Noise};
use crate::discovery::fit::candidate::effects;
use crate::discovery::fit::gauss_newton::{Fitted, Study};
use crate::discovery::fit::nuisance::Explained;
use crate::discovery::fit::{jackknife, simulate};
use crate::discovery::goodness_of_fit::Sign;
use crate::discovery::noise_floor::Floor;
use crate::discovery::problem;
use crate::discovery::problem::Question;
use crate::discovery::recording::covariates::circumstances;
use crate::discovery::recording::samples::rms_m;
use crate::discovery::recording::validate;
use crate::discovery::search::{Found, Scored};
use crate::effects::{EffectSpec, Model};

/// Chance below which what a model leaves is taken to be more than the noise that everything else tells of.
const MORE_THAN_NOISE: f64 = 1e-3;

/// An answer with its proof.
struct Proved {
    answer: Answer,
    /// What it adds to the model.
    added: Vec<EffectSpec>,
    gap: Gap,
    /// Where the model with it has the tip in the held-out trials.
    played: Vec<f64>,
    /// What they leave beside it.
    unseen: Unseen,
}

/// What held-out trials leave that bear an answer out.
#[derive(Default)]
struct Unseen {
    /// But for what is uncertain or in common with a baseline.
    left: Option<Explained>,
    /// That they scatter more than the trials of the fit, and its numbers are known too little for that to refute them.
    excused: Option<Sign>,
}

impl Question<'_> {
    /// Everything that is told of what the search found.
    pub(crate) fn discovery(&self, given: &Model, measured: &Recording, about: &About, found: &Found) -> Discovery {
        let best = &found.best.fitted;
        let study = &Study { nuisances: &about.fine.nuisances, samples: &about.fine.samples, ..self.study() };
        let before = self.foretold(&found.null.fitted.explained, &self.played);
        let after = &about.missing;
        let proved =
            self.proved(study, best, study.answer(&self.study(), found, about.left.sign, self.options.rival_score));
        let answer = &proved.answer;
        let named = !answer.members.is_empty();
        let (told, played, missing) = if named {
            (&best.explained, &best.played, after)
        } else {
            (&found.null.fitted.explained, &self.played, &before)
        };
        let unexplained = answer.verdict == Verdict::Unexplained;
        let (from, noise) = self.floor(&about.left.floor, (!unexplained).then_some(told), &best.explained);
        let mut residuals = self.residual_rows(played, &proved.played);
        let places = self.map(&residuals, &noise);
        let next = self.next(&answer.rivals, &noise);
        let mut model = self.model.clone();
        model.robot.resolution = given.robot.resolution;
        model.effects.extend(proved.added.iter().cloned());
        let tolerated = about.left.tolerated_m.filter(|_| named).map(summary_text::tolerated);
        let excused = proved.unseen.excused.as_ref().map(summary_text::excused);
        let remarks = self.remarks(answer.verdict).into_iter().chain(tolerated).chain(excused);
        let remarks = remarks.chain(self.unplayable(&model));
        let mut findings = Findings {
            verdict: answer.verdict,
            effects: answer.effects.clone(),
            noise_floor_m: noise.rms_m(),
            gap: proved.gap.clone(),
            disagreement: residual_map::disagreements(&places),
            candidates: self.candidates(study, found, answer),
            next_measurement: String::new(),
            summary: String::new(),
            noise: findings::Noise { sigma_m: noise.sigma_m, correlation: noise.correlation, from },
            missing_before: before.test.clone(),
            missing_after: missing.test.clone(),
            pattern: if unexplained { summary_text::pattern(&before.foretold, &places) } else { String::new() },
            limitations: validate::limitations(measured, &self.all).into_iter().chain(remarks).collect(),
            proposals: next.iter().map(|next| next.proposal.clone()).collect(),
        };
        let sets: Vec<String> = answer.rivals.iter().map(|set| set_name(&self.hypotheses, set)).collect();
        let refused = (!best.members.is_empty()).then(|| set_name(&self.hypotheses, &best.members));
        let beside = summary_text::Beside {
            sets: &sets,
            refused,
            against: &answer.against,
            shared: self.shared(&proved, &noise),
        };
        findings.summary = summary_text::summary(&findings, &beside);
        findings.next_measurement = summary_text::next(&findings);
        let remedies =
            alternatives::remedies(&self.study(), &self.responses, &found.null.fitted, &self.proof, &self.played_proof);
        residuals.sort_by_key(|row| row.trial);
        Discovery { findings, model, residuals, places, remedies, next, calibrated: self.is_calibrated() }
    }

    /// What to know of `model`, which is played at its own resolution from now on, if it cannot be.
    fn unplayable(&self, model: &Model) -> Option<String> {
        problem::played(model, &self.all).err().map(|_| {
            "`model.yaml` cannot be played through these commands at its own resolution, which is not that of the fit: \
             `simulate` needs a coarser `robot.resolution`."
                .to_owned()
        })
    }

    /// The answer on held-out trials, that nothing is missing among others; refuted where it makes the model worse there, or
    /// they scatter about it more than the trials that it was fitted to.
    fn proved(&self, study: &Study, best: &Fitted, answer: Answer) -> Proved {
        let added = effects(&self.hypotheses, &answer.members).unwrap_or_default();
        let mut gap = Gap {
            metric: "rms tip error on held-out trials".to_owned(),
            held_out_trials: self.proof.trials.iter().map(|trial| trial.number).collect(),
            before_m: rms_m(&self.proof.residual(&self.played_proof)),
            after_m: f64::NAN,
        };
        // At the edge of what a robot can bear (a section that is all but a hinge) steps in time and cells decide what can be
        // played.
        let tips = |model: &Model| simulate::tips(model, &added, &self.proof);
        let played = tips(&self.model).or_else(|| tips(&self.coarse));
        let unplayable = || "the model with it cannot be played through the held-out trials".to_owned();
        let borne_out = played.ok_or_else(unplayable).and_then(|played| {
            gap.after_m = rms_m(&self.proof.residual(&played));
            self.borne_out(study, best, &answer, (&played, &gap)).map(|unseen| (played, unseen))
        });
        match borne_out {
            Ok((played, unseen)) => Proved { answer, added, gap, played, unseen },
            Err(against) => {
                gap.after_m = gap.before_m;
                let answer = Answer::refuted(against);
                Proved { answer, added: Vec::new(), gap, played: self.played_proof.clone(), unseen: Unseen::default() }
            }
        }
    }

    /// What held-out trials, where the model with the answer has the tip at `played`, leave where they bear it out; if they do
    /// not, what they say against it.
    fn borne_out(
        &self,
        study: &Study,
        best: &Fitted,
        answer: &Answer,
        (played, gap): (&[f64], &Gap),
    ) -> Result<Unseen, String> {
        let no_worse = gap.after_m <= gap.before_m;
        if !no_worse {
            return Err(summary_text::worse(gap));
        }
        if answer.verdict == Verdict::Unexplained {
            return Ok(Unseen::default());
        }
        let left = self.held_out(study, best, played);
        let sign = |left: &Explained| self.held_out_sign(best, left);
        let Some(refuted) = left.as_ref().and_then(sign) else { return Ok(Unseen { left, excused: None }) };
        // A recording in which a tendon is always slack does not tell how slack, and another one may.
        if study.as_good(best).iter().any(|other| self.bear_out(study, other)) {
            return Ok(Unseen { left, excused: Some(refuted) });
        }
        Err(summary_text::against(&refuted))
    }

    /// What the held-out trials leave in common with the baseline, and what but for that, where it is worth a word.
    fn shared(&self, proved: &Proved, noise: &Noise) -> Option<summary_text::Shared> {
        let apart_m = rms_m(&proved.unseen.left.as_ref().filter(|_| self.has_baseline())?.left_m);
        let shared_m = (proved.gap.after_m.powi(2) - apart_m.powi(2)).max(0.0).sqrt();
        (shared_m > self.least_left_m(noise.rms_m())).then_some(summary_text::Shared { shared_m, apart_m })
    }

    /// The noise, from what `tells` of it beside the best set and, where all is `explained`, from what is left; in words
    /// where from. `best`: what the best set explains.
    fn floor(&self, tells: &Floor, explained: Option<&Explained>, best: &Explained) -> (String, Noise) {
        let left = Floor::left_by(explained.unwrap_or(best), &self.fit);
        let tells = tells.clone();
        let floor = match explained {
            Some(_) if tells.chance_of(&left) < MORE_THAN_NOISE => tells,
            Some(_) => tells.and(left),
            None if tells.freedom >= 1.0 && tells.rms_m() > 0.0 => tells,
            None => left,
        };
        let sigma_m = floor.variance_m2.map(|variance_m2| variance_m2.sqrt().max(LEAST_SIGMA_M));
        (floor.from.join(", "), Noise { sigma_m, correlation: best.noise.correlation })
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
        residual_map::map(&around, &before, &after, noise)
    }

    fn candidates(&self, study: &Study, found: &Found, answer: &Answer) -> Vec<Candidate> {
        let plain = self.study();
        let unseen = |scored: &Scored| {
            let own = scored.fitted.members == found.best.fitted.members;
            let each = jackknife::unseen_m(if own { study } else { &plain }, &scored.fitted);
            crate::math::summary::root_mean_square(&each)
        };
        study.candidates(found, answer, self.options.rival_score, &unseen)
    }
}
