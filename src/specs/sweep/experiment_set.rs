//! A spec with its sweep: one checked experiment for each point of the product.

use super::series::{SweepValue, expand};
use crate::base::Seed;
use crate::specs::check::experiment::check;
use crate::specs::document::error::SpecError;
use crate::specs::document::merged::{Document, Origin, SweptEntry};
use crate::specs::document::path::{KeyPath, Step};
use crate::specs::document::tree::{get, put, remove};
use crate::specs::experiment::scale::{far_bends, scale};
use crate::specs::experiment::spec::Experiment;
use crate::specs::read::model_paths;
use crate::specs::write::to_yaml;
use serde_yaml::{Mapping, Value};
use std::path::Path;
use std::sync::Arc;

/// Most points of one sweep; more indicate a mistyped count and would not fit in memory.
const MAX_POINTS: usize = 100_000;

/// Fields that cannot be swept, as they change no trial.
const NOT_SWEPT: [&str; 8] =
    ["name", "extends", "sweep", "seeds", "first_seed", "figures", "claims", "slurm"];

/// An experiment, or one for each point of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct ExperimentSet {
    /// The experiment; of a sweep, its first point, which alone has the claims.
    pub experiment: Experiment,
    /// The swept fields; the last one varies fastest. Empty without a sweep.
    pub sweep: Vec<SweptField>,
    /// All points in a fixed order. Empty without a sweep.
    pub points: Vec<SweepPoint>,
    /// What the user should know of the spec: keys under former names, inherited kinds of training,
    /// numbers that were scaled to the robot, commands that bend it far; of a sweep, at its first and
    /// last point.
    pub notes: Vec<String>,
    /// The entries of `sweep:` as written, with the content of files in place of their names.
    written: Mapping,
}

/// A swept field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SweptField {
    /// Name of its column: its path; for a key of the root, `spec.` and the key.
    pub name: String,
    /// Its values as in tables, in order.
    pub values: Vec<String>,
}

/// One point of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPoint {
    /// Index of the value of each field.
    pub values: Vec<usize>,
    /// The experiment there.
    pub experiment: Arc<Experiment>,
}

impl From<Experiment> for ExperimentSet {
    fn from(experiment: Experiment) -> ExperimentSet {
        ExperimentSet {
            experiment,
            sweep: Vec::new(),
            points: Vec::new(),
            notes: Vec::new(),
            written: Mapping::new(),
        }
    }
}

impl ExperimentSet {
    /// Reads and checks a spec with overrides `path.to.key=value` and sweeps `path.to.key=values`.
    /// Paths may be written with the aliases of `docs/evidence/sweeps.md`.
    ///
    /// # Errors
    /// [`SpecError`] for the first invalid key or value, at any point.
    pub fn read(
        file: &Path,
        sets: &[String],
        sweeps: &[String],
    ) -> Result<ExperimentSet, SpecError> {
        let includes: Vec<KeyPath> = ["model", "plant"]
            .iter()
            .flat_map(|key| model_paths(&KeyPath::default().key(key)))
            .collect();
        let mut document = Document::read_swept(file, sets, sweeps, &includes)?;
        let written = document.take_sweep()?;
        if written.is_empty() {
            let (experiment, notes) = checked(&document)?;
            document.notes.extend(notes);
            return Ok(ExperimentSet { notes: document.notes, ..ExperimentSet::from(experiment) });
        }
        let seed = get(&document.merged, &KeyPath::default().key("seed"))
            .and_then(Value::as_u64)
            .unwrap_or_default();
        let fields = written
            .into_iter()
            .map(|written| ResolvedField::read(&document, written, &includes, Seed(seed)));
        let fields = fields.collect::<Result<Vec<ResolvedField>, SpecError>>()?;
        let count = count(&document, &fields)?;
        let (experiment, notes) = at_point(&mut document, &fields, 0, count)?;
        let mut set = ExperimentSet {
            experiment,
            sweep: fields.iter().map(ResolvedField::swept).collect(),
            points: Vec::with_capacity(count),
            notes: [std::mem::take(&mut document.notes), notes].concat(),
            written: fields.iter().map(|field| field.resolved(seed)).collect(),
        };
        remove(&mut document.merged, &KeyPath::default().key("claims"));
        for number in 0..count {
            let (experiment, notes) = at_point(&mut document, &fields, number, count)?;
            // The ends of a sweep speak for what lies between.
            if number + 1 == count {
                let new = notes.into_iter().filter(|note| !set.notes.contains(note));
                set.notes.extend(new.collect::<Vec<_>>());
            }
            let experiment = Arc::new(experiment);
            set.points.push(SweepPoint { values: digits(&fields, number), experiment });
        }
        Ok(set)
    }

    /// The experiment, and the experiments at all points (the first of which it repeats).
    pub fn experiments(&self) -> impl Iterator<Item = &Experiment> {
        std::iter::once(&self.experiment)
            .chain(self.points.iter().map(|point| point.experiment.as_ref()))
    }

    /// The spec with all defaults filled in and no references to other files.
    ///
    /// # Errors
    /// The serialiser's message.
    pub fn to_yaml(&self) -> Result<String, String> {
        let body = to_yaml(&self.experiment)?;
        if self.sweep.is_empty() {
            return Ok(body);
        }
        let sweep =
            Mapping::from_iter([(Value::from("sweep"), Value::Mapping(self.written.clone()))]);
        Ok(body + &to_yaml(&sweep)?)
    }
}

impl Experiment {
    /// Reads and checks a spec without a sweep, with overrides `path.to.key=value`.
    ///
    /// # Errors
    /// [`SpecError`] for the first invalid key or value, or for a sweep.
    pub fn read(file: &Path, sets: &[String]) -> Result<Experiment, SpecError> {
        let experiment_set = ExperimentSet::read(file, sets, &[])?;
        let swept = experiment_set.sweep.first().map(|field| SpecError::File {
            file: file.display().to_string(),
            found: format!("a sweep of `{}`", field.name),
            expected: "a spec without a sweep",
        });
        swept.map_or(Ok(experiment_set.experiment), Err)
    }
}

impl SweepPoint {
    /// Its values as text, `field=value` for each field.
    pub fn label(&self, sweep: &[SweptField]) -> String {
        label(
            sweep
                .iter()
                .zip(&self.values)
                .map(|(field, &value)| (field.name.as_str(), field.values[value].as_str())),
        )
    }
}

fn label<'a>(values: impl Iterator<Item = (&'a str, &'a str)>) -> String {
    values.map(|(field, value)| format!("{field}={value}")).collect::<Vec<_>>().join(" ")
}

/// A swept field with its values.
struct ResolvedField {
    written: Arc<SweptEntry>,
    values: Vec<(SweepValue, IncludedFiles)>,
}

/// The files that a value names: path of the name below the field, the file, its text.
type IncludedFiles = Arc<Vec<(KeyPath, String, String)>>;

impl ResolvedField {
    fn read(
        document: &Document,
        written: SweptEntry,
        includes: &[KeyPath],
        seed: Seed,
    ) -> Result<ResolvedField, SpecError> {
        let field = &written.field;
        let refuse = |found: &str, expected: &str| {
            document.refuse_swept(&written, &[], found.to_owned(), expected)
        };
        if let Some(Step::Key(first)) = field.0.first()
            && NOT_SWEPT.contains(&first.as_str())
        {
            return Err(refuse(&format!("`{first}`"), "a field that the trials depend on"));
        }
        if let Some(place) = document.set_by(field) {
            let expected =
                "a field that is either set or swept (`--set sweep=null` removes the sweeps of the \
                 file)"
                    .to_owned();
            return Err(SpecError::Key {
                place,
                key: field.clone(),
                found: "a field that is swept".into(),
                expected,
            });
        }
        let values = expand(&written.value, field, seed).map_err(|(below, found, expected)| {
            document.refuse_swept(&written, &below.0, found, &expected)
        })?;
        let with_files = |mut sweep_value: SweepValue| {
            let files = read_files(document, &written, &mut sweep_value, includes)?;
            Ok((sweep_value, files))
        };
        let values = values.into_iter().map(with_files).collect::<Result<Vec<_>, SpecError>>()?;
        Ok(ResolvedField { written: Arc::new(written), values })
    }

    fn swept(&self) -> SweptField {
        SweptField {
            name: self.name(),
            values: self.values.iter().map(|(sweep_value, _)| sweep_value.name.clone()).collect(),
        }
    }

    fn name(&self) -> String {
        let path = self.written.field.to_string();
        if self.written.field.0.len() == 1 { format!("spec.{path}") } else { path }
    }

    /// The field's entry without references to files, and with its seed.
    fn resolved(&self, seed: u64) -> (Value, Value) {
        let mut value = self.written.value.clone();
        if let Some(Value::Mapping(random)) = value.get_mut("random") {
            random.entry(Value::from("seed")).or_insert(Value::from(seed));
        }
        if self.values.iter().any(|(_, files)| !files.is_empty()) {
            let named = self.values.iter().map(|(sweep_value, _)| {
                (Value::from(sweep_value.name.as_str()), sweep_value.value.clone())
            });
            let named = Value::Mapping(named.collect());
            value = Value::Mapping(Mapping::from_iter([(Value::from("named"), named)]));
        }
        (Value::from(self.written.field.to_string()), value)
    }
}

/// Replaces names of files in a value by the content of the files.
fn read_files(
    document: &Document,
    written: &SweptEntry,
    sweep_value: &mut SweepValue,
    includes: &[KeyPath],
) -> Result<IncludedFiles, SpecError> {
    let mut files = Vec::new();
    for include in includes {
        let Some(below) = include.0.strip_prefix(written.field.0.as_slice()) else { continue };
        let below = KeyPath(below.to_vec());
        let Some(Value::String(name)) = get(&sweep_value.value, &below).cloned() else { continue };
        let steps: Vec<Step> = sweep_value.below.iter().chain(&below.0).cloned().collect();
        let (content, file, text) = document.read_swept_file(written, &steps, &name)?;
        put(&mut sweep_value.value, &below.0, content).unwrap_or_default(); // the name stood there
        files.push((below, file, text));
    }
    Ok(Arc::new(files))
}

/// The size of the product.
fn count(document: &Document, fields: &[ResolvedField]) -> Result<usize, SpecError> {
    let sizes: Vec<usize> = fields.iter().map(|field| field.values.len()).collect();
    let count = sizes.iter().try_fold(1_usize, |product, &size| product.checked_mul(size));
    match (count.filter(|&count| count <= MAX_POINTS), fields.last()) {
        (Some(count), _) => Ok(count),
        (None, Some(last)) => {
            let sizes: Vec<String> = sizes.iter().map(usize::to_string).collect();
            let found = format!("{} points", sizes.join(" × "));
            Err(document.refuse_swept(
                &last.written,
                &[],
                found,
                &format!("at most {MAX_POINTS} in one sweep"),
            ))
        }
        (None, None) => Ok(0),
    }
}

/// Index of the value of each field at point `number`; the last field varies fastest.
fn digits(fields: &[ResolvedField], number: usize) -> Vec<usize> {
    let mut remaining = number;
    let mut digits = vec![0; fields.len()];
    for (digit, field) in digits.iter_mut().zip(fields).rev() {
        (*digit, remaining) = (remaining % field.values.len(), remaining / field.values.len());
    }
    digits
}

/// Sets the values of point `number` in the document and reads the experiment.
fn at_point(
    document: &mut Document,
    fields: &[ResolvedField],
    number: usize,
    count: usize,
) -> Result<(Experiment, Vec<String>), SpecError> {
    let digits = digits(fields, number);
    let mut chosen: Vec<(&ResolvedField, &SweepValue, &IncludedFiles)> = fields
        .iter()
        .zip(&digits)
        .map(|(field, &digit)| (field, &field.values[digit].0, &field.values[digit].1))
        .collect();
    // A field inside another swept field (a number of a swept model) is set after it.
    chosen.sort_by_key(|(field, _, _)| field.written.field.0.len());
    let origin =
        |&(field, sweep_value, files): &(&ResolvedField, &SweepValue, &IncludedFiles)| Origin {
            written: field.written.clone(),
            below: sweep_value.below.clone(),
            files: files.clone(),
        };
    document.origins = chosen.iter().map(origin).collect();
    for (field, sweep_value, _) in &chosen {
        put(&mut document.merged, &field.written.field.0, sweep_value.value.clone()).map_err(
            |found| {
                document.refuse_swept(
                    &field.written,
                    &[],
                    format!("{found} within this path"),
                    "a field of this spec",
                )
            },
        )?;
    }
    let values = || {
        let named = fields.iter().zip(&digits);
        let named: Vec<(String, &str)> = named
            .map(|(field, &digit)| (field.name(), field.values[digit].0.name.as_str()))
            .collect();
        label(named.iter().map(|(name, value)| (name.as_str(), *value)))
    };
    checked(document).map_err(|error| match error {
        SpecError::Key { place, key, found, expected } => {
            let expected = format!("{expected} (point {} of {count}: {})", number + 1, values());
            SpecError::Key { place, key, found, expected }
        }
        other => other,
    })
}

/// The document as a checked experiment in proportion to its robot, and what the user should know
/// of it.
fn checked(document: &Document) -> Result<(Experiment, Vec<String>), SpecError> {
    let mut experiment: Experiment = document.parse()?;
    let (policies, tendons) = (&mut experiment.policies, experiment.plant.tendons());
    let process = &policies.process;
    policies.outside.values_mut().for_each(|policy| policy.read_attributes(tendons, process));
    let mut notes = scale(&mut experiment, document);
    check(&experiment, document)?;
    notes.extend(far_bends(&experiment));
    Ok((experiment, notes))
}
