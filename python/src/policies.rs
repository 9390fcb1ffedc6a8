//! Policies of Python in runs: `spinebench/_policies.py` makes and asks them, this gives them to
//! the runner.

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use spinebench::base::PolicyError;
use spinebench::policies::{
    OutsideDecider, OutsideDecision, OutsideView, PythonHost, PythonOptions, provide_python,
};

/// An instance of a class of Python.
struct PythonDecider(Py<PyAny>);

/// An exception in one line, with the line of the user's file where it was raised.
fn told(py: Python<'_>, error: &PyErr) -> String {
    let place = || -> PyResult<String> {
        let Some(mut traceback) = error.traceback(py) else { return Ok(String::new()) };
        // The innermost frame is where it was raised.
        while let Ok(next) = traceback.getattr("tb_next")?.cast_into() {
            traceback = next;
        }
        let file: String =
            traceback.getattr("tb_frame")?.getattr("f_code")?.getattr("co_filename")?.extract()?;
        let line: usize = traceback.getattr("tb_lineno")?.extract()?;
        let name = file.rsplit(['/', '\\']).next().unwrap_or_default();
        Ok(format!(" ({name}, line {line})"))
    };
    let words = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    // The package's own sentence says what is wrong; its line there helps nobody.
    if let Some(sentence) = words.strip_prefix("InputError: ") {
        return sentence.to_owned();
    }
    format!("{words}{}", place().unwrap_or_default())
}

/// The result of a function of `_policies.py` that takes a file and the name of a class in it.
fn of_class<R>(
    function: &str,
    options: &PythonOptions,
    convert: impl FnOnce(Bound<'_, PyAny>) -> PyResult<R>,
) -> Result<R, String> {
    Python::attach(|py| {
        let arguments = (options.file.as_os_str(), &options.class_name);
        py.import("spinebench._policies")
            .and_then(|module| module.call_method1(function, arguments))
            .and_then(convert)
            .map_err(|error| told(py, &error))
    })
}

fn make(options: &PythonOptions) -> Result<Box<dyn OutsideDecider>, String> {
    of_class("_make", options, |policy| Ok(Box::new(PythonDecider(policy.unbind())) as Box<_>))
}

fn closed_loop_only(options: &PythonOptions) -> Result<bool, (String, String)> {
    let answer = of_class("_closed_loop_only", options, |answer| {
        match answer.extract::<(String, String)>() {
            Ok(fault) => Ok(Err(fault)),
            Err(_) => answer.extract().map(Ok),
        }
    });
    answer.unwrap_or_else(|words| Err((words, "a class that can be loaded".to_owned())))
}

impl OutsideDecider for PythonDecider {
    fn reset(&mut self) -> Result<(), PolicyError> {
        Python::attach(|py| {
            let policy = self.0.bind(py);
            let reset = policy
                .getattr_opt("reset")
                .and_then(|reset| reset.map(|reset| reset.call0()).transpose());
            reset.map(drop).map_err(|error| PolicyError::Outside(told(py, &error)))
        })
    }

    fn decide(&mut self, view: &OutsideView) -> Result<OutsideDecision, PolicyError> {
        Python::attach(|py| {
            let asked = || -> PyResult<(Vec<f64>, Option<bool>)> {
                let array = |values: &[f64]| PyArray1::from_slice(py, values);
                let arguments = (
                    &self.0,
                    array(&view.tip_m),
                    array(&view.target_m),
                    array(view.pulls_m),
                    view.time_s,
                );
                let decided =
                    py.import("spinebench._policies")?.call_method1("_decide", arguments)?;
                let (pulls, settled): (Bound<'_, PyArray1<f64>>, Option<bool>) =
                    decided.extract()?;
                Ok((pulls.readonly().as_array().to_vec(), settled))
            };
            let (pulls_m, settled) =
                asked().map_err(|error| PolicyError::Outside(told(py, &error)))?;
            Ok(OutsideDecision { pulls_m, settled })
        })
    }
}

/// Tells the library how policies of Python are made.
pub(crate) fn provide() {
    provide_python(PythonHost { make, closed_loop_only });
}
