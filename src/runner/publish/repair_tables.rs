//! The rows of repairs, from the results of their stages.

use super::tables::TrainedRepetition;
use crate::base::Outcome;
use crate::effects::EffectSpec;
use crate::report::Published;
use crate::rows::experiment::ReachTrial;
use crate::rows::repairs::{IdentificationRow, MonitorRow, RepairRow, RepairTrialRow};
use crate::runner::execute::outcomes::Outcomes;
use crate::runner::graph::{Failure, Handle};
use crate::runner::jobs::repair::diagnosis::Diagnosis;
use crate::runner::stages::{RepairCampaign, RepairStages};

/// Adds the rows of one repetition and training; `targets` rows where a failure has made trials
/// impossible.
pub(crate) fn add(
    published: &mut Published,
    repetition: &TrainedRepetition,
    repair: &RepairCampaign,
    targets: usize,
) {
    let TrainedRepetition { seed, training, outcomes } = *repetition;
    // The same for every kind of training.
    if published.identifications.iter().all(|row| row.seed != seed) {
        published.identifications.push(identification_row(seed, repair, outcomes));
    }
    published.monitors.push(monitor_row(repetition, repair));
    for change in &repair.changes {
        published.repairs.push(repair_row(seed, training, change, outcomes));
        for (variant, cell, stage) in &change.trials {
            let unmeasured = |status: Outcome| {
                (0..targets as u64)
                    .map(|target| ReachTrial::unmeasured(target, status.clone()))
                    .collect()
            };
            let row = |trial: ReachTrial| RepairTrialRow {
                seed,
                training: training.to_owned(),
                change: change.change.clone(),
                variant: variant.name().to_owned(),
                cell: cell.clone(),
                target: trial.target,
                error_m: trial.error_m,
                steps: trial.steps,
                settled: trial.settled,
                status: trial.status,
            };
            published
                .repair_trials
                .extend(repetition.values(*stage, unmeasured).into_iter().map(row));
        }
    }
}

fn monitor_row(repetition: &TrainedRepetition, repair: &RepairCampaign) -> MonitorRow {
    let tried = repetition.outcomes.get(repair.monitor);
    MonitorRow {
        seed: repetition.seed,
        training: repetition.training.to_owned(),
        threshold: tried.as_ref().map_or(f64::NAN, |tried| tried.monitor.threshold()),
        watched_s: tried.as_ref().map_or(0.0, |tried| tried.watched_s),
        false_alarms: tried.as_ref().map_or(0, |tried| tried.false_alarms),
        status: Outcome::from(&tried),
    }
}

fn identification_row(
    seed: u64,
    repair: &RepairCampaign,
    outcomes: &Outcomes,
) -> IdentificationRow {
    let (diagnosis, status) = diagnosis(repair.identified, outcomes);
    IdentificationRow {
        seed,
        samples: diagnosis.samples,
        verdict: diagnosis.verdict,
        named: effects_text(&diagnosis.effects),
        nearest_m: outcomes.get(repair.nearest_m).copied().unwrap_or(f64::NAN),
        gap_before_m: diagnosis.gap_m[0],
        gap_after_m: diagnosis.gap_m[1],
        noise_floor_m: diagnosis.noise_floor_m,
        status,
    }
}

fn repair_row(seed: u64, training: &str, change: &RepairStages, outcomes: &Outcomes) -> RepairRow {
    let (diagnosis, status) = diagnosis(change.diagnosis, outcomes);
    let alarm_s = outcomes.get(change.alarm).ok().copied().flatten();
    RepairRow {
        seed,
        training: training.to_owned(),
        change: change.change.clone(),
        truth: effects_text(&change.truth),
        alarm_s: alarm_s.unwrap_or(f64::NAN),
        samples: diagnosis.samples,
        verdict: diagnosis.verdict,
        named: effects_text(&diagnosis.effects),
        nearest_m: outcomes.get(change.nearest_m).copied().unwrap_or(f64::NAN),
        gap_before_m: diagnosis.gap_m[0],
        gap_after_m: diagnosis.gap_m[1],
        noise_floor_m: diagnosis.noise_floor_m,
        status,
    }
}

/// The diagnosis, and what became of it.
fn diagnosis(stage: Handle<Diagnosis>, outcomes: &Outcomes) -> (Diagnosis, Outcome) {
    let result: Result<&Diagnosis, Failure> = outcomes.get(stage);
    let status = Outcome::from(&result);
    (result.map_or_else(|_| Diagnosis::nothing("failed".to_owned(), 0), Clone::clone), status)
}

/// Effects as they stand in a model file, on one line: `tip_load: {mass_kg: 0.02}`.
fn effects_text(effects: &[EffectSpec]) -> String {
    let effect_text = |effect: &EffectSpec| {
        let text = serde_json::to_string(effect).unwrap_or_default();
        let inner = text.strip_prefix('{').and_then(|text| text.strip_suffix('}')).unwrap_or(&text);
        inner.replace('"', "").replace(':', ": ").replace(',', ", ")
    };
    effects.iter().map(effect_text).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_stand_as_in_a_model_file() {
        let effects: Vec<EffectSpec> = serde_json::from_str(
            r#"[{"tip_load": {"mass_kg": 0.02}}, {"actuator_offset": {"tendon": 1, "offset_m": 0.002}}]"#,
        )
        .unwrap();
        assert_eq!(
            effects_text(&effects),
            "tip_load: {mass_kg: 0.02}; actuator_offset: {tendon: 1, offset_m: 0.002}"
        );
    }
}
