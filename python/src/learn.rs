//! Learners of the library for scikit-learn's conventions; `spinebench/_learn.py` makes estimators
//! of them.

use numpy::PyArrayDyn;
use pyo3::prelude::*;
use spinebench::base::{Rows, Seed};
use spinebench::learn::gp::{Gp, GpConfig};
use spinebench::learn::networks::{Network, NetworkConfig, Trained};

use crate::arrays::{array, led, numbers};
use crate::calls::{detached, guarded, long};
use crate::errors::Fault;

type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// A table (rows, columns).
fn table(found: &Bound<'_, PyAny>, name: &str) -> PyResult<Rows> {
    let read = numbers(found, name)?;
    let &[_, width] = &read.shape[..] else {
        return Err(Fault::argument(
            name,
            format!("{} axes", read.shape.len()),
            "shape (rows, columns)",
        )
        .into());
    };
    let mut rows = Rows::new(width);
    read.values.chunks(width.max(1)).for_each(|row| rows.push(row));
    Ok(rows)
}

fn out<'py>(py: Python<'py>, rows: &Rows) -> PyResult<Array<'py>> {
    array(py, rows.values().to_vec(), &[rows.len(), rows.width()])
}

/// Options in JSON. A fault names the option, not its place in the text, which nobody wrote.
fn options<T: serde::de::DeserializeOwned>(json: &str) -> Result<T, Fault> {
    serde_path_to_error::deserialize(&mut serde_json::Deserializer::from_str(json)).map_err(
        |error| {
            let words = error.inner().to_string();
            let words = words.split(" at line ").next().unwrap_or_default();
            match error.path().to_string().as_str() {
                "." => Fault::words(words),
                option => Fault::words(format!("{option}: {words}")),
            }
        },
    )
}

/// A fitted Gaussian process.
#[pyclass(name = "_Gp", module = "spinebench._spinebench", frozen)]
pub(crate) struct PyGp(Gp);

#[pymethods]
impl PyGp {
    /// Fits (rows, inputs) and (rows, outputs) with the hyper-parameters of greatest likelihood, or
    /// given ones (outputs, each).
    #[staticmethod]
    #[pyo3(signature = (inputs, outputs, config, theta=None))]
    fn fit(
        py: Python<'_>,
        inputs: &Bound<'_, PyAny>,
        outputs: &Bound<'_, PyAny>,
        config: &str,
        theta: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyGp> {
        let (inputs, outputs) = (table(inputs, "X")?, table(outputs, "y")?);
        let config: GpConfig = options(config)?;
        let theta = theta.map(|theta| table(theta, "theta")).transpose()?;
        long(py, move |stop| {
            let fitted = match theta {
                None => stop.within(|| Gp::fit(&inputs, &outputs, &config)),
                Some(theta) => {
                    config.check().map_err(Fault::words)?;
                    Gp::condition(
                        &inputs,
                        &outputs,
                        &config,
                        theta.iter().map(<[f64]>::to_vec).collect(),
                        0,
                    )
                }
            };
            fitted.map(PyGp).map_err(Fault::words)
        })
    }

    /// Means (rows, outputs) and standard deviations of the noise-free function.
    fn predict<'py>(
        &self,
        py: Python<'py>,
        inputs: &Bound<'py, PyAny>,
        std: bool,
    ) -> PyResult<(Array<'py>, Option<Array<'py>>)> {
        let inputs = table(inputs, "X")?;
        if !std {
            let mean = detached(py, || self.0.mean_rows(&inputs).map_err(Fault::words))?;
            return Ok((out(py, &mean)?, None));
        }
        let found = detached(py, || self.0.predict_rows(&inputs).map_err(Fault::words))?;
        let mut deviations = Rows::new(found.variance.width());
        for row in found.variance.iter() {
            deviations
                .push(&row.iter().map(|variance| variance.max(0.0).sqrt()).collect::<Vec<f64>>());
        }
        Ok((out(py, &found.mean)?, Some(out(py, &deviations)?)))
    }

    /// Mean, standard deviation with noise, and log density of every sample as the others foretell
    /// it: three of (rows, outputs).
    fn leave_one_out<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Array<'py>, Array<'py>, Array<'py>)> {
        let found = detached(py, || Ok::<_, Fault>(self.0.leave_one_out()))?;
        let mut deviations = Rows::new(found.variance.width());
        found
            .variance
            .iter()
            .for_each(|row| deviations.push(&row.iter().map(|v| v.sqrt()).collect::<Vec<f64>>()));
        Ok((out(py, &found.mean)?, out(py, &deviations)?, out(py, &found.log_probability)?))
    }

    /// Natural logarithms of the hyper-parameters (outputs, each), in standardised units.
    #[getter]
    fn theta<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let theta = self.0.theta();
        array(py, theta.concat(), &[theta.len(), theta.first().map_or(0, Vec::len)])
    }

    #[getter]
    fn hyperparameter_names(&self) -> Vec<String> {
        self.0.hyperparameter_names()
    }

    /// Log marginal likelihood of each output, nats, of the standardised values.
    #[getter]
    fn log_marginal_likelihood(&self) -> Vec<f64> {
        self.0.log_marginal_likelihood()
    }

    /// Noise standard deviation of each output, in its unit.
    #[getter]
    fn noise_std(&self) -> Vec<f64> {
        self.0.noise_std()
    }

    /// Hyper-parameters at an end of their range: output, name, `low` or `high`.
    #[getter]
    fn range_ends(&self) -> Vec<(usize, String, &'static str)> {
        let ends = self.0.range_ends().into_iter();
        ends.map(|end| (end.output, end.name, if end.is_upper { "high" } else { "low" })).collect()
    }

    /// Everything, as text.
    fn dump(&self) -> PyResult<String> {
        Ok(serde_json::to_string(&self.0).map_err(Fault::words)?)
    }

    /// From [`PyGp::dump`].
    #[staticmethod]
    fn load(text: &str) -> PyResult<PyGp> {
        Ok(guarded(|| options(text).map(PyGp))?)
    }
}

/// A trained network.
#[pyclass(name = "_Network", module = "spinebench._spinebench", frozen)]
pub(crate) struct PyNetwork(Trained);

#[pymethods]
impl PyNetwork {
    /// Trains on (rows, inputs) and (rows, outputs) in time order; recordings begin at the rows
    /// `sequences`.
    #[staticmethod]
    fn train(
        py: Python<'_>,
        inputs: &Bound<'_, PyAny>,
        outputs: &Bound<'_, PyAny>,
        sequences: Vec<usize>,
        config: &str,
        seed: u64,
    ) -> PyResult<PyNetwork> {
        let (inputs, outputs) = (table(inputs, "X")?, table(outputs, "y")?);
        let config: NetworkConfig = options(config)?;
        long(py, move |stop| {
            let trained =
                stop.within(|| Network::train(&inputs, &outputs, &sequences, &config, Seed(seed)));
            trained.map(PyNetwork).map_err(Fault::words)
        })
    }

    /// Outputs (rows, outputs) row by row; the state is reset at the rows `sequences`.
    fn predict<'py>(
        &self,
        py: Python<'py>,
        inputs: &Bound<'py, PyAny>,
        sequences: Vec<usize>,
    ) -> PyResult<Array<'py>> {
        let network = &self.0.network;
        let read = led(inputs, "X", 1, network.inputs(), "(rows, inputs of the training)")?;
        let mut rows = Rows::new(network.inputs());
        read.values.chunks(network.inputs()).for_each(|row| rows.push(row));
        let found = detached(py, || network.predict_rows(&rows, &sequences).map_err(Fault::words))?;
        out(py, &found)
    }

    /// Epochs, optimiser steps, best validation error, and why training ended.
    #[getter]
    fn summary(&self) -> PyResult<(usize, usize, f64, String)> {
        let Trained { epochs, updates, validation_mae, stopped, .. } = &self.0;
        let stopped = serde_json::to_value(stopped).map_err(Fault::words)?;
        Ok((*epochs, *updates, *validation_mae, stopped.as_str().unwrap_or_default().to_owned()))
    }

    /// Epoch, training loss, validation error and learning rate of every epoch.
    #[getter]
    fn history(&self) -> Vec<(usize, f64, f64, f64)> {
        let each = self.0.history.iter();
        each.map(|one| (one.epoch, one.training_loss, one.validation_mae, one.learning_rate))
            .collect()
    }

    /// Everything, as text.
    fn dump(&self) -> PyResult<String> {
        Ok(serde_json::to_string(&self.0).map_err(Fault::words)?)
    }

    /// From [`PyNetwork::dump`].
    #[staticmethod]
    fn load(text: &str) -> PyResult<PyNetwork> {
        Ok(guarded(|| options(text).map(PyNetwork))?)
    }
}
