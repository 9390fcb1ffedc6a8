//! Makes the findings from the evidence of all stages. This is the one place where they are made.

use super::Discovery;
use super::evidence::Evidence;
use super::summary_text;
use crate::data::findings::{Findings, FoundEffect, Noise};
use crate::discovery::fit::ar1_noise::Ar1Noise;
use crate::discovery::mistakes::excluded_rows::PreparedRecording;
use crate::discovery::recording::blocks::{self, Playing};

/// What an answer says of the tracker's clock.
#[derive(Default)]
struct ClockFindings {
    offset_s: Option<f64>,
    interval_95: Option<[f64; 2]>,
    limitation: Option<String>,
    /// What stands before the summary.
    preface: String,
}

impl Evidence {
    /// The answer for the `measured` recording, whose rows follow each other as `playing` says.
    pub(crate) fn into_discovery(
        mut self,
        measured: &PreparedRecording,
        baseline: Option<&PreparedRecording>,
        playing: Playing,
    ) -> Discovery {
        let clock = self.clock_findings();
        let limitations = self.limitations(measured, baseline, playing, &clock);
        let (search, residuals) = (&self.search, &self.residuals);
        let Ar1Noise { sigma_m, correlation } = residuals.noise;
        let findings = Findings {
            verdict: self.decision.verdict,
            effects: search.effects.clone(),
            noise_floor_m: residuals.noise.rms_m(),
            explained_share: search.explained.map(|explained| explained.share),
            explained_share_interval_95: search.explained.map(|explained| explained.interval_95),
            left_m: self.left_m,
            complete: self.decision.is_complete(),
            model_form_m: self.model_form_m,
            gap: self.gap.clone(),
            disagreement: super::residual_map::disagreements(&residuals.places),
            candidates: search.candidates.clone(),
            next_measurement: summary_text::next_measurement(&self),
            summary: format!("{}{}{}", clock.preface, self.preface(), summary_text::summary(&self)),
            noise: Noise { sigma_m, correlation, from: residuals.noise_from.clone() },
            missing_before: residuals.missing_before.clone(),
            missing_after: residuals.missing_after.clone(),
            pattern: residuals.pattern.clone(),
            limitations,
            excluded_rows: measured.excluded_rows(),
            clock_offset_s: clock.offset_s,
            clock_offset_interval_95: clock.interval_95,
            proposals: search.next_experiments.iter().map(|next| next.proposal.clone()).collect(),
        };
        if let Some(offset) = self.clock {
            // The table gives the times of the recording, not the shifted ones.
            self.residuals.rows.iter_mut().for_each(|row| row.time_s -= offset.offset_s);
        }
        Discovery {
            findings,
            model: self.model,
            residuals: self.residuals.rows,
            places: self.residuals.places,
            alternatives: self.search.alternatives,
            next_experiments: self.search.next_experiments,
            calibrated: self.search.is_calibrated,
        }
    }

    /// All limitations: those of the stages, of excluded rows, of the division into blocks, and of
    /// the clock.
    fn limitations(
        &self,
        measured: &PreparedRecording,
        baseline: Option<&PreparedRecording>,
        playing: Playing,
        clock: &ClockFindings,
    ) -> Vec<String> {
        let mut sentences = self.limitations.clone();
        sentences.extend(measured.exclusions.sentences(measured.original));
        // A mistake is recognised without the baseline and before the recording is divided.
        if self.mistake.is_none() {
            let of_baseline =
                baseline.map(|baseline| baseline.exclusions.sentences(baseline.original));
            sentences.extend(
                of_baseline.into_iter().flatten().map(|sentence| format!("Baseline: {sentence}")),
            );
            sentences.extend(blocks::caveats(measured.original, playing));
        }
        sentences.extend(clock.limitation.clone());
        sentences
    }

    /// An error on the baseline and a possible mistake, which must be read first.
    fn preface(&self) -> String {
        let error = self.leading_baseline_error().map(|error| error.sentence());
        let mistake = self.possible_mistake.as_ref().map(|one| self.possible_sentence(one));
        error.into_iter().chain(mistake).map(|sentence| format!("{sentence} ")).collect()
    }

    /// The offset of the clock, or the same from a named `delay`, which the data cannot tell from
    /// it.
    fn clock_findings(&self) -> ClockFindings {
        if let Some(clock) = &self.clock {
            // An estimated offset is the first thing to read. One of exactly one step needs no
            // estimate.
            let is_estimated = clock.deviation_s().is_some();
            return ClockFindings {
                offset_s: Some(clock.offset_s),
                interval_95: Some(clock.interval_95),
                preface: if is_estimated {
                    format!("{} ", clock.sentence())
                } else {
                    String::new()
                },
                limitation: Some(clock.sentence()),
            };
        }
        let delay =
            self.search.effects.iter().find(|effect| effect.name == "delay").and_then(delay_s);
        delay.map_or_else(ClockFindings::default, |(time_s, [low_s, high_s])| ClockFindings {
            // A robot that is late equals a tracker's clock that is behind.
            offset_s: Some(-time_s),
            interval_95: Some([-high_s, -low_s]),
            preface: String::new(),
            limitation: Some(summary_text::delay_caveat(time_s)),
        })
    }
}

/// The time of a delay and its interval, seconds.
fn delay_s(effect: &FoundEffect) -> Option<(f64, [f64; 2])> {
    let time_s = effect.parameters.get("time_s")?.as_f64()?;
    let ends = effect.interval_95.get("time_s").and_then(serde_json::Value::as_array);
    let ends = ends.and_then(|ends| Some([ends.first()?.as_f64()?, ends.get(1)?.as_f64()?]));
    Some((time_s, ends.unwrap_or([time_s, time_s])))
}
