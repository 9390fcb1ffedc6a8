//! One robot: the rod of a model, at rest or in motion.

use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use spinebench::base::{PlantError, TendonCommand};
use spinebench::effects::{DrivenModel, Model, Variable};
use spinebench::rod::{Direction, Rod};

use crate::arrays::{array, positive, shaped};
use crate::calls::{detached, guarded};
use crate::errors::Fault;
use crate::model::{GivenModel, PyModel, named, plot};

/// A driven model with its clock and the outcome of its last solve.
pub(crate) struct Driven {
    pub(crate) rod: DrivenModel,
    pub(crate) time_s: f64,
    pub(crate) status: String,
}

impl Driven {
    pub(crate) fn new(model: &Model) -> Driven {
        Driven { rod: DrivenModel::new(model, &[]), time_s: 0.0, status: UNSOLVED.to_owned() }
    }

    /// Length of the backbone, metres.
    pub(crate) fn length_m(&self) -> f64 {
        self.rod.rod().params().length_m()
    }

    /// The measured tip, metres.
    pub(crate) fn tip_m(&self) -> [f64; 3] {
        self.rod.observation(&[], self.time_s).tip_m
    }

    /// Takes note of the outcome of a solve.
    pub(crate) fn noted(&mut self, outcome: Result<(), PlantError>) -> Result<(), PlantError> {
        self.status = match &outcome {
            Ok(()) => "converged".to_owned(),
            Err(PlantError::Solver(status)) => status.clone(),
            Err(_) => "bad_command".to_owned(),
        };
        outcome
    }

    /// Rest under displacements in metres.
    pub(crate) fn settle(&mut self, pulls_m: &[f64]) -> Result<(), PlantError> {
        let outcome = self.rod.settle(&commands(pulls_m));
        self.noted(outcome)
    }

    /// A motion to displacements in metres.
    pub(crate) fn step(&mut self, pulls_m: &[f64], dt_s: f64) -> Result<(), PlantError> {
        let outcome = self.rod.advance(&commands(pulls_m), dt_s);
        self.time_s += dt_s;
        self.noted(outcome)
    }
}

/// Status before anything has been solved.
pub(crate) const UNSOLVED: &str = "not_solved";

pub(crate) fn commands(pulls_m: &[f64]) -> Vec<TendonCommand> {
    pulls_m.iter().map(|&pull_m| TendonCommand::Pull(pull_m)).collect()
}

/// Refuses displacements beyond twice the length of the robot: usually millimetres instead of
/// metres.
pub(crate) fn in_metres(pulls_m: Vec<f64>, length_m: f64) -> Result<Vec<f64>, Fault> {
    match pulls_m.iter().find(|pull_m| pull_m.abs() > 2.0 * length_m) {
        None => Ok(pulls_m),
        Some(pull) => {
            let expected = format!(
                "metres, a possible displacement for a robot of {length_m} m (are these \
                 millimetres?)"
            );
            Err(Fault::argument("pulls_m", pull.to_string(), &expected))
        }
    }
}

/// Positions (n, 3) of `n` cross-sections evenly spaced from base to tip, metres.
pub(crate) fn shape_m(rod: &Rod, n: usize) -> Vec<f64> {
    places(rod, n).flat_map(|s_m| rod.pose_at(s_m).0.iter().copied().collect::<Vec<_>>()).collect()
}

fn places(rod: &Rod, n: usize) -> impl Iterator<Item = f64> {
    let length_m = rod.params().length_m();
    (0..n)
        .map(move |index| if n == 1 { length_m } else { length_m * index as f64 / (n - 1) as f64 })
}

/// At least one cross-section.
pub(crate) fn counted(n: usize) -> Result<usize, Fault> {
    if n > 0 { Ok(n) } else { Err(Fault::argument("n", "0", "a whole number of at least 1")) }
}

/// The rod of a model.
#[pyclass(name = "Rod", module = "spinebench")]
pub(crate) struct PyRod {
    driven: Driven,
    model: PyModel,
    parameters: Vec<String>,
}

impl PyRod {
    fn tendons(&self) -> usize {
        self.driven.rod.rod().params().tendons.len()
    }

    fn tip<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        array(py, self.driven.tip_m().to_vec(), &[3])
    }
}

#[pymethods]
impl PyRod {
    #[new]
    #[pyo3(signature = (model, parameters=None))]
    fn new(model: GivenModel, parameters: Option<Vec<String>>) -> PyResult<PyRod> {
        let (GivenModel(given), parameters) = (model, parameters.unwrap_or_default());
        let model = &*given.model;
        let mut driven = guarded(|| Ok(Driven::new(model)))?;
        if !parameters.is_empty() {
            let variable = |path: &String| named(model, path).map(Variable::Parameter);
            let variables: Vec<Variable> =
                parameters.iter().map(variable).collect::<Result<_, Fault>>()?;
            driven.rod =
                guarded(|| DrivenModel::varied(model, &[], &variables).map_err(Fault::words))?;
        }
        Ok(PyRod { driven, model: given, parameters })
    }

    fn restart(&mut self) {
        self.driven.rod.restart();
        (self.driven.time_s, self.driven.status) = (0.0, UNSOLVED.to_owned());
    }

    #[pyo3(signature = (pulls_m=None, *, tensions_n=None))]
    fn settle<'py>(
        &mut self,
        py: Python<'py>,
        pulls_m: Option<&Bound<'py, PyAny>>,
        tensions_n: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let tendons = self.tendons();
        let driven = &mut self.driven;
        match (pulls_m, tensions_n) {
            (Some(_), Some(_)) => {
                return Err(
                    Fault::argument("tensions_n", "both", "either pulls_m or tensions_n").into()
                );
            }
            (None, Some(tensions_n)) => {
                let tensions_n =
                    shaped(tensions_n, "tensions_n", &[tendons], "one number per tendon")?;
                detached(py, || {
                    let outcome = driven.rod.settle_under(&tensions_n);
                    driven.noted(outcome).map_err(Fault::from)
                })?;
            }
            (pulls_m, None) => {
                let pulls_m = match pulls_m {
                    Some(pulls_m) => in_metres(
                        shaped(pulls_m, "pulls_m", &[tendons], "one number per tendon")?,
                        driven.length_m(),
                    )?,
                    None => vec![0.0; tendons],
                };
                detached(py, || driven.settle(&pulls_m).map_err(Fault::from))?;
            }
        }
        self.tip(py)
    }

    #[pyo3(signature = (pulls_m, dt_s=0.2))]
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        pulls_m: &Bound<'py, PyAny>,
        dt_s: f64,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let pulls_m = shaped(pulls_m, "pulls_m", &[self.tendons()], "one number per tendon")?;
        let pulls_m = in_metres(pulls_m, self.driven.length_m())?;
        let dt_s = positive("dt_s", dt_s)?;
        let driven = &mut self.driven;
        detached(py, || {
            if driven.status == UNSOLVED {
                driven.rod.home()?;
            }
            driven.step(&pulls_m, dt_s).map_err(Fault::from)
        })?;
        self.tip(py)
    }

    #[getter(tip)]
    fn get_tip<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.tip(py)
    }

    #[getter]
    fn tip_rotation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let rotation = self.driven.rod.rod().tip_rotation();
        array(py, rotation.transpose().iter().copied().collect(), &[3, 3])
    }

    #[pyo3(signature = (n=50))]
    fn shape<'py>(&self, py: Python<'py>, n: usize) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        array(py, shape_m(self.driven.rod.rod(), counted(n)?), &[n, 3])
    }

    #[pyo3(signature = (n=50))]
    fn rotations<'py>(&self, py: Python<'py>, n: usize) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let rod = self.driven.rod.rod();
        let each = places(rod, counted(n)?).flat_map(|s_m| {
            let rotation = rod.pose_at(s_m).1.transpose();
            rotation.iter().copied().collect::<Vec<f64>>()
        });
        array(py, each.collect(), &[n, 3, 3])
    }

    #[getter]
    fn tensions_n<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        array(py, self.driven.rod.rod().tensions_n().to_vec(), &[self.tendons()])
    }

    #[getter]
    fn status(&self) -> &str {
        &self.driven.status
    }

    #[getter]
    fn time_s(&self) -> f64 {
        self.driven.time_s
    }

    #[getter]
    fn residual_m(&self) -> f64 {
        self.driven.rod.rod().residual_m()
    }

    #[getter]
    fn model(&self) -> PyModel {
        self.model.clone()
    }

    #[getter]
    fn parameters(&self) -> Vec<String> {
        self.parameters.clone()
    }

    #[pyo3(signature = (with_respect_to="pulls"))]
    fn jacobian<'py>(
        &self,
        py: Python<'py>,
        with_respect_to: &str,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let tendons = self.tendons();
        let directions: Vec<Direction> = match with_respect_to {
            "pulls" => (0..tendons).map(Direction::Pull).collect(),
            "tensions" => (0..tendons).map(Direction::Tension).collect(),
            "force" => (0..3).map(Direction::Force).collect(),
            "moment" => (0..3).map(Direction::Moment).collect(),
            other => {
                let expected = "\"pulls\", \"tensions\", \"force\" or \"moment\"";
                return Err(
                    Fault::argument("with_respect_to", format!("{other:?}"), expected).into()
                );
            }
        };
        let mut rod = self.driven.rod.rod().clone();
        let rates = detached(py, || {
            let none = || {
                let message = "found a rod that is not at rest, expected a previous call of \
                               settle()"
                    .to_owned();
                Fault::Solver { status: "not_at_rest".into(), message }
            };
            rod.tip_jacobian(&directions).ok_or_else(none)
        })?;
        let columns = rates.len();
        let rows =
            (0..3).flat_map(|axis| rates.iter().map(move |rate| rate.position_m[axis])).collect();
        array(py, rows, &[3, columns])
    }

    fn parameter_jacobian<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let rates = guarded(|| Ok(self.driven.rod.tip_rates()))?;
        let rows =
            (0..3).flat_map(|axis| rates.iter().map(move |rate| rate.position_m[axis])).collect();
        array(py, rows, &[3, rates.len()])
    }

    /// Draws the shape with matplotlib.
    #[pyo3(signature = (**options))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        plot(slf, options)
    }

    fn __repr__(&self) -> String {
        let (tendons, status) = (self.tendons(), &self.driven.status);
        format!("Rod({tendons} tendons, time_s={}, status={status:?})", self.driven.time_s)
    }
}
