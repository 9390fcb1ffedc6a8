//! Many robots at once, over all cores.

use std::sync::{Arc, Mutex, PoisonError};

use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use spinebench::base::PlantError;

use crate::arrays::{array, led, positive, shaped};
use crate::calls::{Stop, long_on};
use crate::errors::Fault;
use crate::model::{GivenModel, plot};
use crate::rod::{Driven, UNSOLVED, counted, in_metres, shape_m};

/// Robots side by side; all have the same number of tendons.
#[pyclass(frozen, name = "Rods", module = "spinebench")]
pub(crate) struct PyRods {
    rods: Arc<Mutex<Vec<Driven>>>,
    count: usize,
    tendons: usize,
    /// Length of the longest one, metres.
    length_m: f64,
}

/// Outcome of a call for all robots: tips (n, 3), metres, not a number where the solver failed.
fn tips_m(rods: &[Driven]) -> Vec<f64> {
    let tip = |rod: &Driven| if rod.status == "converged" { rod.tip_m() } else { [f64::NAN; 3] };
    rods.iter().flat_map(tip).collect()
}

/// A failure of the solver is a status of its robot; anything else is an error of the call.
fn only_solver(outcome: Result<(), PlantError>) -> Result<(), Fault> {
    match outcome {
        Ok(()) | Err(PlantError::Solver(_)) => Ok(()),
        Err(other) => Err(other.into()),
    }
}

impl PyRods {
    /// Runs `work` for each robot.
    fn each<T: Send + 'static>(
        &self,
        py: Python<'_>,
        work: impl Fn(usize, &mut Driven, &Stop) -> Result<(), Fault> + Send + Sync + 'static,
        read: impl FnOnce(&[Driven]) -> T + Send + 'static,
    ) -> PyResult<T> {
        long_on(py, Arc::clone(&self.rods), move |rods, stop| {
            rods.par_iter_mut().enumerate().try_for_each(|(index, rod)| work(index, rod, stop))?;
            Ok(read(rods))
        })
    }

    /// Reads a number of each robot. Waits for a call that Ctrl-C has left.
    fn read<T: Send>(&self, py: Python<'_>, read: impl FnOnce(&[Driven]) -> T + Send) -> T {
        py.detach(|| read(&self.rods.lock().unwrap_or_else(PoisonError::into_inner)))
    }
}

#[pymethods]
impl PyRods {
    #[new]
    fn new(models: Vec<GivenModel>) -> PyResult<PyRods> {
        let Some(first) = models.first() else {
            return Err(Fault::argument("models", "none", "at least one model").into());
        };
        let of = |given: &GivenModel| given.0.model.robot.tendons.angles_deg.len();
        let tendons = of(first);
        if let Some(other) = models.iter().find(|model| of(model) != tendons) {
            let found = format!("robots of {tendons} and of {} tendons", of(other));
            return Err(Fault::argument("models", found, "robots of one number of tendons").into());
        }
        let rods: Vec<Driven> = models.iter().map(|given| Driven::new(&given.0.model)).collect();
        let length_m = rods.iter().map(Driven::length_m).fold(0.0, f64::max);
        Ok(PyRods { length_m, count: rods.len(), rods: Arc::new(Mutex::new(rods)), tendons })
    }

    fn __len__(&self) -> usize {
        self.count
    }

    #[getter]
    fn tendons(&self) -> usize {
        self.tendons
    }

    fn restart(&self, py: Python<'_>) -> PyResult<()> {
        let restart = |_: usize, rod: &mut Driven, _: &Stop| {
            rod.rod.restart();
            (rod.time_s, rod.status) = (0.0, UNSOLVED.to_owned());
            Ok(())
        };
        self.each(py, restart, |_| ())
    }

    fn settle<'py>(
        &self,
        py: Python<'py>,
        pulls_m: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let tendons = self.tendons;
        let pulls_m = shaped(pulls_m, "pulls_m", &[self.count, tendons], "robots, tendons")?;
        let pulls_m = in_metres(pulls_m, self.length_m)?;
        let work = move |index: usize, rod: &mut Driven, stop: &Stop| {
            if stop.raised() {
                return Ok(());
            }
            only_solver(rod.settle(&pulls_m[index * tendons..][..tendons]))
        };
        array(py, self.each(py, work, tips_m)?, &[self.count, 3])
    }

    #[pyo3(signature = (pulls_m, dt_s=0.2))]
    fn step<'py>(
        &self,
        py: Python<'py>,
        pulls_m: &Bound<'py, PyAny>,
        dt_s: f64,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (tendons, dt_s) = (self.tendons, positive("dt_s", dt_s)?);
        let pulls_m = shaped(pulls_m, "pulls_m", &[self.count, tendons], "robots, tendons")?;
        let pulls_m = in_metres(pulls_m, self.length_m)?;
        let work = move |index: usize, rod: &mut Driven, stop: &Stop| {
            if stop.raised() {
                return Ok(());
            }
            move_one(rod, &pulls_m[index * tendons..][..tendons], dt_s)
        };
        array(py, self.each(py, work, tips_m)?, &[self.count, 3])
    }

    #[pyo3(signature = (pulls_m, dt_s=0.2))]
    fn play<'py>(
        &self,
        py: Python<'py>,
        pulls_m: &Bound<'py, PyAny>,
        dt_s: f64,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (tendons, dt_s, count) = (self.tendons, positive("dt_s", dt_s)?, self.count);
        let what =
            format!("shape (n, steps, tendons) with n = {count} robots and {tendons} tendons");
        let read = led(pulls_m, "pulls_m", 2, tendons, &what)?;
        if read.shape[0] != count {
            let found = format!("commands of {} robots", read.shape[0]);
            return Err(Fault::argument("pulls_m", found, what).into());
        }
        let (steps, pulls_m) = (read.shape[1], in_metres(read.values, self.length_m)?);
        let tips = Arc::new(Mutex::new(vec![f64::NAN; count * steps * 3]));
        let seen = Arc::clone(&tips);
        let work = move |index: usize, rod: &mut Driven, stop: &Stop| {
            let mut own = vec![f64::NAN; 3 * steps];
            for step in 0..steps {
                let first = (index * steps + step) * tendons;
                if stop.raised() {
                    return Ok(());
                }
                move_one(rod, &pulls_m[first..][..tendons], dt_s)?;
                if rod.status != "converged" {
                    break;
                }
                own[3 * step..][..3].copy_from_slice(&rod.tip_m());
            }
            let mut all = seen.lock().unwrap_or_else(PoisonError::into_inner);
            all[3 * index * steps..][..3 * steps].copy_from_slice(&own);
            Ok(())
        };
        self.each(py, work, |_| ())?;
        let tips = std::mem::take(&mut *tips.lock().unwrap_or_else(PoisonError::into_inner));
        array(py, tips, &[count, steps, 3])
    }

    #[getter]
    fn tips<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        array(py, self.read(py, tips_m), &[self.count, 3])
    }

    #[getter]
    fn tensions_n<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let read = |rods: &[Driven]| {
            rods.iter().flat_map(|rod| rod.rod.rod().tensions_n().to_vec()).collect()
        };
        array(py, self.read(py, read), &[self.count, self.tendons])
    }

    #[getter]
    fn status(&self, py: Python<'_>) -> Vec<String> {
        self.read(py, |rods| rods.iter().map(|rod| rod.status.clone()).collect())
    }

    #[pyo3(signature = (n=50))]
    fn shapes<'py>(&self, py: Python<'py>, n: usize) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        counted(n)?;
        let read =
            |rods: &[Driven]| rods.iter().flat_map(|rod| shape_m(rod.rod.rod(), n)).collect();
        array(py, self.read(py, read), &[self.count, n, 3])
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
        format!("Rods({} robots, {} tendons)", self.count, self.tendons)
    }
}

/// A step of one robot; the first one starts from rest at home. One that has failed stays failed
/// until a restart.
fn move_one(rod: &mut Driven, pulls_m: &[f64], dt_s: f64) -> Result<(), Fault> {
    if rod.status == UNSOLVED {
        let home = rod.rod.home();
        only_solver(rod.noted(home))?;
    }
    if rod.status != "converged" {
        return Ok(());
    }
    only_solver(rod.step(pulls_m, dt_s))
}
