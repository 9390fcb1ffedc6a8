//! Models: what is believed about a robot.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple, PyType};
use spinebench::effects::{CATALOGUE, EffectSpec, Model, ModelParameter};
use spinebench::specs::{model_text, read_model};

use crate::errors::{Fault, InputFault};

/// A robot and the effects added to it. Immutable: `with_value` and `with_effects` return a new
/// model.
#[pyclass(frozen, name = "Model", module = "spinebench")]
#[derive(Clone)]
pub(crate) struct PyModel {
    pub(crate) model: Arc<Model>,
    /// The file that it was read from.
    pub(crate) file: Option<Arc<ModelFile>>,
}

/// A model file as it was read.
pub(crate) struct ModelFile {
    pub(crate) name: PathBuf,
    pub(crate) text: String,
}

impl From<Model> for PyModel {
    fn from(model: Model) -> PyModel {
        PyModel { model: Arc::new(model), file: None }
    }
}

impl PyModel {
    fn read(file: PathBuf) -> Result<PyModel, Fault> {
        let model = Arc::new(read_model(&file)?);
        let text = spinebench::data::read_text(&file)
            .map_err(|error| Fault::words(format!("{}: {error}", file.display())))?;
        Ok(PyModel { model, file: Some(Arc::new(ModelFile { name: file, text })) })
    }

    /// Its text as YAML with every key filled in.
    pub(crate) fn yaml(&self) -> Result<String, Fault> {
        model_text(&self.model).map_err(|error| Fault::Run(error.to_string()))
    }
}

/// A model as an argument: a `Model` or the name of a model file.
pub(crate) struct GivenModel(pub(crate) PyModel);

impl FromPyObject<'_, '_> for GivenModel {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, '_, PyAny>) -> PyResult<GivenModel> {
        if let Ok(model) = given.cast::<PyModel>() {
            return Ok(GivenModel(model.get().clone()));
        }
        let Ok(file) = given.extract::<PathBuf>() else {
            let kind = given.get_type().name()?;
            let expected = "a Model, or the name of a model file";
            return Err(Fault::argument("model", format!("a {kind}"), expected).into());
        };
        Ok(GivenModel(PyModel::read(file)?))
    }
}

/// Checks a model that was changed here, its units too.
pub(crate) fn checked(model: Model) -> Result<PyModel, Fault> {
    model.check_units().and_then(|()| model.check()).map_err(|(path, error)| {
        Fault::argument(&format!("{path}.{}", error.key), error.found.clone(), error.expected)
    })?;
    Ok(PyModel::from(model))
}

/// Name, unit and value without effect of each parameter.
type EffectParameters = Vec<(&'static str, &'static str, f64)>;

/// The effects of the catalogue with their parameters.
#[pyfunction]
pub(crate) fn _effects() -> Vec<(&'static str, EffectParameters)> {
    let parameters = CATALOGUE.iter().map(|card| {
        let each = card.parameters.iter();
        (card.name, each.map(|each| (each.name, each.unit, each.null)).collect())
    });
    parameters.collect()
}

/// Effects from JSON: a list such as `[{"tip_load": {"mass_kg": 0.02}}]`; `name` is the argument.
pub(crate) fn effects_of(name: &str, json: &str) -> Result<Vec<EffectSpec>, Fault> {
    let expected = "a list such as [{\"tip_load\": {\"mass_kg\": 0.02}}]";
    serde_json::from_str(json).map_err(|error| Fault::argument(name, error.to_string(), expected))
}

#[pymethods]
impl PyModel {
    #[new]
    #[pyo3(signature = (file=None))]
    fn new(file: Option<GivenModel>) -> PyModel {
        file.map_or_else(|| PyModel::from(Model::default()), |given| given.0)
    }

    #[classmethod]
    fn load(_class: &Bound<'_, PyType>, file: PathBuf) -> PyResult<PyModel> {
        Ok(PyModel::read(file)?)
    }

    #[classmethod]
    fn from_yaml(_class: &Bound<'_, PyType>, text: &str) -> PyResult<PyModel> {
        Ok(of_text(text)?)
    }

    fn to_yaml(&self) -> PyResult<String> {
        Ok(self.yaml()?)
    }

    fn save(&self, file: PathBuf) -> PyResult<()> {
        Ok(spinebench::data::write_atomic(&file, self.yaml()?.as_bytes()).map_err(Fault::from)?)
    }

    #[getter]
    fn tendons(&self) -> usize {
        self.model.robot.tendons.angles_deg.len()
    }

    #[getter]
    fn length_m(&self) -> f64 {
        self.model.robot.backbone.length_m
    }

    #[getter]
    fn effect_names(&self) -> Vec<&'static str> {
        self.model.effects.iter().map(|effect| effect.card().name).collect()
    }

    fn parameters(&self) -> PyResult<Vec<(String, f64, &'static str)>> {
        let of = |parameter: ModelParameter| {
            let value = parameter.value(&self.model).map_err(Fault::words)?;
            Ok((parameter.path().to_owned(), value, parameter.unit()))
        };
        ModelParameter::all(&self.model).into_iter().map(of).collect()
    }

    fn value(&self, path: &str) -> PyResult<f64> {
        Ok(named(&self.model, path)?.value(&self.model).map_err(Fault::words)?)
    }

    fn with_value(&self, path: &str, value: f64) -> PyResult<PyModel> {
        Ok(checked(
            named(&self.model, path)?.with_value(&self.model, value).map_err(Fault::words)?,
        )?)
    }

    fn with_effects(&self, effects: &Bound<'_, PyAny>) -> PyResult<PyModel> {
        let json: String =
            effects.py().import("json")?.call_method1("dumps", (effects,))?.extract()?;
        let mut model = Model::clone(&self.model);
        model.effects.extend(effects_of("effects", &json)?);
        Ok(checked(model)?)
    }

    fn __eq__(&self, other: &PyModel) -> bool {
        self.model == other.model
    }

    fn __hash__(&self) -> PyResult<u64> {
        let mut hasher = DefaultHasher::new();
        self.effect_names().hash(&mut hasher);
        for (path, value, _) in self.parameters()? {
            // 0 and −0 are equal.
            (path, (value + 0.0).to_bits()).hash(&mut hasher);
        }
        Ok(hasher.finish())
    }

    fn __copy__(&self) -> PyModel {
        self.clone()
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> PyModel {
        self.clone()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Stored)> {
        let file = self.file.as_ref().map(|file| (file.name.clone(), file.text.clone()));
        let restore = py.get_type::<PyModel>().getattr("_restore")?;
        Ok((restore, (self.yaml()?, file)))
    }

    /// From what `__reduce__` keeps. A fitted number may lie where no written one may.
    #[classmethod]
    fn _restore(
        _class: &Bound<'_, PyType>,
        yaml: &str,
        file: Option<(PathBuf, String)>,
    ) -> PyResult<PyModel> {
        let read = serde_yaml::with::singleton_map_recursive::deserialize(
            serde_yaml::Deserializer::from_str(yaml),
        );
        let model: Model = read.map_err(Fault::words)?;
        let file = file.map(|(name, text)| Arc::new(ModelFile { name, text }));
        Ok(PyModel { model: Arc::new(model), file })
    }

    fn __repr__(&self) -> String {
        let (tendons, effects) = (self.tendons(), self.effect_names().join(", "));
        format!("Model({tendons} tendons, length_m={}, effects=[{effects}])", self.length_m())
    }

    fn _repr_html_(slf: &Bound<'_, PyModel>) -> PyResult<String> {
        slf.py().import("spinebench._notebook")?.call_method1("model", (slf,))?.extract()
    }
}

/// What a pickled model keeps: YAML, and name and text of its file.
type Stored = (String, Option<(PathBuf, String)>);

/// A picture of `shown` by matplotlib: what its method `plot` does.
pub(crate) fn plot<'py>(
    shown: &Bound<'py, PyAny>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let arguments = PyTuple::new(shown.py(), [shown])?;
    shown.py().import("spinebench._plots")?.getattr("plot")?.call(arguments, options)
}

/// The number of `model` at `path`.
pub(crate) fn named(model: &Model, path: &str) -> Result<ModelParameter, Fault> {
    ModelParameter::named(model, path).map_err(|_| {
        Fault::argument(
            "path",
            format!("`{path}`"),
            "the path of a number, as `Model.parameters` lists them",
        )
    })
}

/// A model from the text of a file. Names of files in it (`extends`) are relative to the current
/// folder.
fn of_text(text: &str) -> Result<PyModel, Fault> {
    read_text("<text>", text, |file| Ok(PyModel::from(read_model(file)?)))
}

/// Reads a text that stands in no file; `name` stands for the file in errors.
pub(crate) fn read_text<T>(
    name: &str,
    text: &str,
    read: impl FnOnce(&Path) -> Result<T, Fault>,
) -> Result<T, Fault> {
    let made = |error: std::io::Error| Fault::Run(format!("a temporary file: {error}"));
    let folder = tempfile::tempdir().map_err(made)?;
    let file = folder.path().join("text.yaml");
    std::fs::write(&file, text).map_err(made)?;
    read(&file).map_err(|fault| match fault {
        Fault::Input(input) => {
            let message = input.message.replace(&file.display().to_string(), name);
            Fault::Input(Box::new(InputFault { message, file: Some(name.to_owned()), ..*input }))
        }
        other => other,
    })
}
