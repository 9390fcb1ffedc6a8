//! Models: what is believed about a robot.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyType;
use spinebench::effects::{EffectSpec, Model, ModelParameter};
use spinebench::specs::{model_text, read_model};

use crate::errors::{Fault, InputFault};

/// A robot and the effects added to it. It does not change: `with_value` and `with_effects` return
/// another one.
#[pyclass(frozen, from_py_object, name = "Model", module = "spinebench")]
#[derive(Clone)]
pub(crate) struct PyModel(pub(crate) Arc<Model>);

/// Checks a model that was changed here.
pub(crate) fn checked(model: Model) -> Result<PyModel, Fault> {
    model.check().map_err(|(path, error)| {
        Fault::argument(&format!("{path}.{}", error.key), error.found.clone(), error.expected)
    })?;
    Ok(PyModel(Arc::new(model)))
}

/// Effects from JSON: a list such as `[{"tip_load": {"mass_kg": 0.02}}]`.
pub(crate) fn effects_of(json: &str) -> Result<Vec<EffectSpec>, Fault> {
    let expected = "a list such as [{\"tip_load\": {\"mass_kg\": 0.02}}]";
    serde_json::from_str(json)
        .map_err(|error| Fault::argument("effects", error.to_string(), expected))
}

#[pymethods]
impl PyModel {
    #[new]
    fn new() -> PyModel {
        PyModel(Arc::new(Model::default()))
    }

    #[classmethod]
    fn load(_class: &Bound<'_, PyType>, file: PathBuf) -> PyResult<PyModel> {
        Ok(PyModel(Arc::new(read_model(&file).map_err(Fault::from)?)))
    }

    #[classmethod]
    fn from_yaml(_class: &Bound<'_, PyType>, text: &str) -> PyResult<PyModel> {
        Ok(of_text(text)?)
    }

    fn to_yaml(&self) -> PyResult<String> {
        model_text(&self.0).map_err(|error| Fault::Run(error.to_string()).into())
    }

    fn save(&self, file: PathBuf) -> PyResult<()> {
        let text = model_text(&self.0).map_err(|error| Fault::Run(error.to_string()))?;
        Ok(spinebench::data::write_atomic(&file, text.as_bytes()).map_err(Fault::from)?)
    }

    #[getter]
    fn tendons(&self) -> usize {
        self.0.robot.tendons.angles_deg.len()
    }

    #[getter]
    fn length_m(&self) -> f64 {
        self.0.robot.backbone.length_m
    }

    #[getter]
    fn effect_names(&self) -> Vec<&'static str> {
        self.0.effects.iter().map(|effect| effect.card().name).collect()
    }

    fn parameters(&self) -> PyResult<Vec<(String, f64, &'static str)>> {
        let of = |parameter: ModelParameter| {
            let value = parameter.value(&self.0).map_err(Fault::words)?;
            Ok((parameter.path().to_owned(), value, parameter.unit()))
        };
        ModelParameter::all(&self.0).into_iter().map(of).collect()
    }

    fn value(&self, path: &str) -> PyResult<f64> {
        Ok(named(&self.0, path)?.value(&self.0).map_err(Fault::words)?)
    }

    fn with_value(&self, path: &str, value: f64) -> PyResult<PyModel> {
        Ok(checked(named(&self.0, path)?.with_value(&self.0, value).map_err(Fault::words)?)?)
    }

    fn with_effects(&self, effects: &Bound<'_, PyAny>) -> PyResult<PyModel> {
        let json: String =
            effects.py().import("json")?.call_method1("dumps", (effects,))?.extract()?;
        let mut model = Model::clone(&self.0);
        model.effects.extend(effects_of(&json)?);
        Ok(checked(model)?)
    }

    fn __eq__(&self, other: &PyModel) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        let (tendons, effects) = (self.tendons(), self.effect_names().join(", "));
        format!("Model({tendons} tendons, length_m={}, effects=[{effects}])", self.length_m())
    }
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

/// Name of a model that was given as text, in errors.
const TEXT: &str = "<text>";

/// A model from the text of a file. Names of files in it (`extends`) are relative to the current
/// folder.
fn of_text(text: &str) -> Result<PyModel, Fault> {
    let made = |error: std::io::Error| Fault::Run(format!("a temporary file: {error}"));
    let folder = tempfile::tempdir().map_err(made)?;
    let file = folder.path().join("model.yaml");
    std::fs::write(&file, text).map_err(made)?;
    let read = read_model(&file).map_err(Fault::from);
    read.map(|model| PyModel(Arc::new(model))).map_err(|fault| without_file(fault, &file))
}

/// The fault with `<text>` in place of the name of a temporary file.
fn without_file(fault: Fault, file: &Path) -> Fault {
    let name = file.display().to_string();
    match fault {
        Fault::Input(input) => {
            let message = input.message.replace(&name, TEXT);
            Fault::Input(Box::new(InputFault { message, file: Some(TEXT.to_owned()), ..*input }))
        }
        other => other,
    }
}
