//! Cases that another simulator or a bench recorded: recordings whose truth is known.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::injection::disturbances::Disturbance;
use super::injection::injected_effects::InjectedEffect;
use super::options::{CaseBatch, CaseGroup};
use super::truth::Truth;
use crate::base::BadOption;
use crate::data::tables::read_csv;
use crate::data::{DataError, Recording};
use crate::effects::{EffectSpec, Seek, card};

/// Recordings of one robot with a table of what is hidden in each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordedCases {
    /// The table: `file`, `effects` (names joined by ` + ` or `+`), `parameters` (JSON, as
    /// `effects:` of a model) and `rms_shift_m`. Paths of recordings are relative to its folder;
    /// its own path is relative to the working directory, as for a replay.
    pub truth: PathBuf,
    /// Recording of the robot as built, relative to the folder of the table. It is not a case.
    #[serde(default)]
    pub baseline: Option<PathBuf>,
    /// Standard deviation of the tracking noise by axis, metres.
    #[serde(default = "noise_m")]
    pub noise_m: f64,
}

fn noise_m() -> f64 {
    5e-4
}

/// A recording with its truth.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedCase {
    /// The recording.
    pub recording: PathBuf,
    /// The recording of the robot as built.
    pub baseline: Option<PathBuf>,
    /// What is hidden.
    pub truth: Truth,
    /// Its group and size.
    pub batch: CaseBatch,
}

/// A row of the table.
#[derive(Deserialize)]
struct TruthLine {
    file: String,
    effects: String,
    parameters: String,
    rms_shift_m: f64,
}

impl RecordedCases {
    /// Refuses noise that is no number above zero, and files that cannot be read.
    ///
    /// # Errors
    /// [`BadOption`] names the first one.
    pub fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("noise_m", self.noise_m)?;
        let expected = "a table of recordings that can be read, with `file`, `effects`, \
                        `parameters` and `rms_shift_m`";
        self.cases().map(drop).map_err(|error| BadOption {
            key: "truth",
            found: error.to_string(),
            expected,
        })
    }

    /// The cases of the table, in its order.
    ///
    /// # Errors
    /// [`DataError`] for a table or a recording that cannot be read.
    pub fn cases(&self) -> Result<Vec<RecordedCase>, DataError> {
        let folder = self.truth.parent().unwrap_or(Path::new(""));
        let baseline = self.baseline.as_ref().map(|name| folder.join(name));
        let lines: Vec<TruthLine> = read_csv(&self.truth)?;
        let others =
            lines.iter().enumerate().filter(|(_, line)| Some(folder.join(&line.file)) != baseline);
        let case = |(row, line): (usize, &TruthLine)| {
            let truth = truth(line).ok_or_else(|| self.unreadable(row, line))?;
            self.case(truth, folder.join(&line.file), baseline.clone())
        };
        others.map(case).collect()
    }

    fn case(
        &self,
        truth: Truth,
        recording: PathBuf,
        baseline: Option<PathBuf>,
    ) -> Result<RecordedCase, DataError> {
        let measured = Recording::read(&recording)?;
        let batch = CaseBatch {
            group: group(&truth),
            cases: 1,
            trials: measured.trials().len(),
            samples: measured.len(),
            shifts_m: vec![truth.shift_m],
            noise_m: self.noise_m,
            correlations: vec![0.0],
        };
        Ok(RecordedCase { recording, baseline, truth, batch })
    }

    /// The error for parameters that the effects of the catalogue do not have.
    fn unreadable(&self, row: usize, line: &TruthLine) -> DataError {
        DataError::Cell {
            file: self.truth.clone(),
            place: format!("line {}", row + 2),
            column: "parameters".to_owned(),
            found: line.parameters.clone(),
            expected:
                "a JSON list of these effects, each with its parameters as in `effects:` of a model"
                    .to_owned(),
        }
    }
}

/// The truth of a line: effects of the catalogue if all names are in it, else something outside it.
/// None where effects of the catalogue have parameters that cannot be read.
fn truth(line: &TruthLine) -> Option<Truth> {
    let names: Vec<&str> =
        line.effects.split('+').map(str::trim).filter(|name| *name != "nothing").collect();
    let in_catalogue = names.iter().all(|name| card(name).is_some());
    let hidden = if in_catalogue { parameters(&line.parameters)? } else { Vec::new() };
    let names_match = |(hidden, name): (&InjectedEffect, &&str)| hidden.name == *name;
    if in_catalogue && (hidden.len() != names.len() || !hidden.iter().zip(&names).all(names_match))
    {
        return None;
    }
    Some(Truth {
        hidden,
        unknown: (!in_catalogue).then(|| Disturbance::named(&line.effects)),
        uncertain: Vec::new(),
        shift_m: line.rms_shift_m,
        left: 0.0,
        imitations: Vec::new(),
        left_out: Vec::new(),
    })
}

/// The effects of a JSON list; none if one cannot be read.
fn parameters(text: &str) -> Option<Vec<InjectedEffect>> {
    serde_json::from_str::<Vec<EffectSpec>>(text).ok()?.iter().map(injected).collect()
}

/// The effect with its values in the order of its card; none if it lacks one.
fn injected(effect: &EffectSpec) -> Option<InjectedEffect> {
    let card = effect.card();
    let fields = serde_json::to_value(effect).ok()?;
    let fields = fields.get(card.name)?;
    let value = |name: &str| {
        let field = match name.split_once('[') {
            None => fields.get(name)?,
            Some((vector, index)) => {
                fields.get(vector)?.get(index.trim_end_matches(']').parse::<usize>().ok()?)?
            }
        };
        field.as_f64().or_else(|| field.as_bool().map(f64::from))
    };
    let values = card
        .parameters
        .iter()
        .map(|parameter| {
            // A convention that is not written is the usual one, a segment the whole robot.
            let may_be_left_out = matches!(parameter.seek, Seek::Convention | Seek::Segment);
            value(parameter.name).or(may_be_left_out.then_some(parameter.null))
        })
        .collect::<Option<Vec<f64>>>()?;
    Some(InjectedEffect { name: card.name.to_owned(), values, other_law: false })
}

/// What moves the tip by nothing is nothing, whatever its name; an effect that the catalogue does
/// not have is outside it.
fn group(truth: &Truth) -> CaseGroup {
    match (truth.hidden.len(), &truth.unknown) {
        _ if truth.shift_m == 0.0 => CaseGroup::Nothing,
        (1, None) => CaseGroup::Single,
        (2.., None) => CaseGroup::Pair,
        _ => CaseGroup::Outside,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(effects: &str, parameters: &str, rms_shift_m: f64) -> Option<Truth> {
        let (effects, parameters) = (effects.to_owned(), parameters.to_owned());
        truth(&TruthLine { file: String::new(), effects, parameters, rms_shift_m })
    }

    #[test]
    fn a_line_is_one_effect_two_nothing_or_something_outside_the_catalogue() {
        let force =
            told("tip_force", r#"[{"tip_force": {"force_n": [0.0, 0.05, 0.0]}}]"#, 0.003).unwrap();
        assert_eq!(
            (group(&force), force.hidden[0].values.as_slice()),
            (CaseGroup::Single, &[0.0, 0.05, 0.0][..])
        );
        let both = r#"[{"tip_load": {"mass_kg": 0.005}}, {"backlash": {"width_m": 0.003}}]"#;
        let pair = told("tip_load + backlash", both, 0.006).unwrap();
        assert_eq!((group(&pair), pair.name().as_str()), (CaseGroup::Pair, "backlash + tip_load"));
        assert_eq!(group(&told("nothing", "[]", 0.0).unwrap()), CaseGroup::Nothing);
        let noise =
            told("coloured_noise", r#"[{"coloured_noise": {"correlation": 0.6}}]"#, 0.0).unwrap();
        assert_eq!(group(&noise), CaseGroup::Nothing);
        let wall = told("wall", r#"[{"wall": {"y_m": -0.045}}]"#, 0.007).unwrap();
        assert_eq!((group(&wall), wall.name().as_str()), (CaseGroup::Outside, "wall"));
    }

    #[test]
    fn effects_of_the_catalogue_need_parameters_that_can_be_read() {
        assert_eq!(told("tip_load", r#"[{"tip_load": {"mass": 0.005}}]"#, 0.004), None);
        assert_eq!(
            told("tip_load + backlash", r#"[{"tip_load": {"mass_kg": 0.005}}]"#, 0.004),
            None
        );
        assert_eq!(told("tip_load", r#"[{"backlash": {"width_m": 0.003}}]"#, 0.004), None);
    }

    #[test]
    fn the_other_simulators_recordings_are_cases_and_its_baseline_is_none() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/twin");
        let baseline = Some(PathBuf::from("baseline.csv"));
        let cases = RecordedCases { truth: folder.join("truth.csv"), baseline, noise_m: noise_m() }
            .cases()
            .unwrap();
        let count =
            |group: CaseGroup| cases.iter().filter(|case| case.batch.group == group).count();
        assert_eq!(cases.len(), 39);
        assert_eq!([CaseGroup::Single, CaseGroup::Pair, CaseGroup::Nothing].map(count), [22, 5, 6]);
        assert!(cases.iter().all(|case| case.batch.samples == 400 && case.batch.trials == 8));
    }
}
