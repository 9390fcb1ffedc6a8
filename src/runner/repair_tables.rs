//! The rows of repairs, from the results of their stages.

use super::graph::{Failure, Handle};
use super::jobs::diagnosis::Diagnosis;
use super::metrics::Tables;
use super::outcomes::Outcomes;
use super::stages::{RepairCampaign, RepairStages, RepairVariant};
use crate::data::repairs::{IdentificationRow, MonitorRow, RepairRow, RepairTrialRow};
use crate::data::rows::TrialRow;
use crate::effects::EffectSpec;
use crate::specs::TrialCell;

/// Adds the rows of one repetition and training; `targets` rows where a failure has made trials impossible.
pub(super) fn add(
    tables: &mut Tables,
    (seed, training): (u64, &str),
    repair: &RepairCampaign,
    targets: usize,
    outcomes: &Outcomes,
) {
    // The same for every kind of training.
    if tables.published.identifications.iter().all(|row| row.seed != seed) {
        tables.published.identifications.push(identification_row(seed, repair, outcomes));
    }
    tables.published.monitors.push(monitor_row(seed, training, repair, outcomes));
    for change in &repair.changes {
        tables.published.repairs.push(repair_row(seed, training, change, outcomes));
        for (variant, cell, stage) in &change.trials {
            let label = |target: u64| labelled((seed, training, &change.change), *variant, cell, target);
            let rows: Vec<RepairTrialRow> = match outcomes.get(*stage) {
                Ok(rows) => rows.iter().map(|row| measured(label(row.target), row)).collect(),
                Err(failure) => (0..targets as u64)
                    .map(|target| RepairTrialRow { status: failure.to_string(), ..label(target) })
                    .collect(),
            };
            tables.published.repair_trials.extend(rows);
        }
    }
}

fn monitor_row(seed: u64, training: &str, repair: &RepairCampaign, outcomes: &Outcomes) -> MonitorRow {
    let training = training.to_owned();
    match outcomes.get(repair.monitor) {
        Ok(tried) => MonitorRow {
            seed,
            training,
            threshold: tried.monitor.threshold(),
            watched_s: tried.watched_s,
            false_alarms: tried.false_alarms,
            status: "ok".to_owned(),
        },
        Err(failure) => {
            let status = failure.to_string();
            MonitorRow { seed, training, threshold: f64::NAN, watched_s: 0.0, false_alarms: 0, status }
        }
    }
}

fn identification_row(seed: u64, repair: &RepairCampaign, outcomes: &Outcomes) -> IdentificationRow {
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

/// The diagnosis, and `ok` or why there is none.
fn diagnosis(stage: Handle<Diagnosis>, outcomes: &Outcomes) -> (Diagnosis, String) {
    let nothing = |failure: Failure| (Diagnosis::nothing("failed".to_owned(), 0), failure.to_string());
    outcomes.get(stage).map_or_else(nothing, |diagnosis| (diagnosis.clone(), "ok".to_owned()))
}

fn labelled(
    (seed, training, change): (u64, &str, &str),
    variant: RepairVariant,
    cell: &TrialCell,
    target: u64,
) -> RepairTrialRow {
    RepairTrialRow {
        seed,
        training: training.to_owned(),
        change: change.to_owned(),
        variant: variant.name().to_owned(),
        policy: cell.policy.clone(),
        mode: cell.mode.clone(),
        gp_points: cell.gp_points as u64,
        real_points: cell.real_points as u64,
        target,
        error_m: f64::NAN,
        steps: 0,
        settled: false,
        status: String::new(),
    }
}

fn measured(label: RepairTrialRow, row: &TrialRow) -> RepairTrialRow {
    RepairTrialRow { error_m: row.error_m, steps: row.steps, settled: row.settled, status: row.status.clone(), ..label }
}

/// Effects as they stand in a model file, on one line: `tip_load: {mass_kg: 0.02}`.
fn effects_text(effects: &[EffectSpec]) -> String {
    let one = |effect: &EffectSpec| {
        let text = serde_json::to_string(effect).unwrap_or_default();
        let inner = text.strip_prefix('{').and_then(|text| text.strip_suffix('}')).unwrap_or(&text);
        inner.replace('"', "").replace(':', ": ").replace(',', ", ")
    };
    effects.iter().map(one).collect::<Vec<_>>().join("; ")
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
        assert_eq!(effects_text(&effects), "tip_load: {mass_kg: 0.02}; actuator_offset: {tendon: 1, offset_m: 0.002}");
    }
}
