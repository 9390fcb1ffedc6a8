//! Plants side by side: the robots of environments, stepped over all cores.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyType;
use rayon::prelude::*;
use spinebench::base::{Observation, Plant, PlantError, Seed};
use spinebench::plants::{PlantOptions, Simulated, SimulatedOptions, SimulatedSpec};
use spinebench::specs::{PlantSpec, read_plant, suited_travel_m};

use crate::arrays::{array, positive, shaped};
use crate::calls::{detached, guarded, long_on, pool};
use crate::errors::Fault;
use crate::model::{PyModel, effects_of};
use crate::rod::{counted, shape_m};

/// A plant; a simulated one shows its shape.
enum Robot {
    Simulated(Box<Simulated>),
    Other(Box<dyn Plant>),
}

impl Robot {
    fn new(spec: &PlantSpec, step_s: f64) -> Result<Robot, Fault> {
        match spec {
            PlantSpec::Simulated(spec) => {
                let options =
                    SimulatedOptions { step_s, noise_m: spec.noise_m, travel_m: spec.travel_m };
                Ok(Robot::Simulated(Box::new(Simulated::new(&spec.model, &[], options))))
            }
            other => Ok(Robot::Other(other.build(step_s).map_err(Fault::words)?)),
        }
    }

    fn plant(&mut self) -> &mut dyn Plant {
        match self {
            Robot::Simulated(plant) => plant.as_mut(),
            Robot::Other(plant) => plant.as_mut(),
        }
    }
}

/// One robot of several: the plant, what was last seen of it, and its status.
struct Slot {
    robot: Robot,
    seen: Option<Observation>,
    status: String,
}

impl Slot {
    /// Takes note of an observation or of the reason why there is none.
    fn note(&mut self, outcome: Result<Observation, PlantError>) {
        match outcome {
            Ok(seen) => {
                "ok".clone_into(&mut self.status);
                self.seen = Some(seen);
            }
            Err(PlantError::Solver(status)) => self.status = status,
            Err(other) => self.status = other.to_string(),
        }
    }
}

/// Robots of one plant file, each with effects of its own.
#[pyclass(frozen, name = "_Plants", module = "spinebench")]
pub(crate) struct PyPlants {
    spec: PlantSpec,
    step_s: f64,
    slots: Arc<Mutex<Vec<Slot>>>,
    count: usize,
    tendons: usize,
}

/// Tips (n, 3), displacements (n, tendons), whether each tip was seen, and each status.
type Seen<'py> = (Bound<'py, PyArrayDyn<f64>>, Bound<'py, PyArrayDyn<f64>>, Vec<bool>, Vec<String>);

impl PyPlants {
    fn of(spec: PlantSpec, count: usize, step_s: f64) -> Result<PyPlants, Fault> {
        positive("step_s", step_s)?;
        counted(count)?;
        let slot = |_| {
            let robot = Robot::new(&spec, step_s)?;
            Ok(Slot { robot, seen: None, status: "closed".to_owned() })
        };
        let slots: Vec<Slot> = guarded(|| (0..count).map(slot).collect())?;
        let tendons = spec.tendons();
        Ok(PyPlants { spec, step_s, slots: Arc::new(Mutex::new(slots)), count, tendons })
    }

    fn seen<'py>(&self, py: Python<'py>) -> PyResult<Seen<'py>> {
        let (tips, pulls, valid, status) = py.detach(|| {
            let slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
            let none = vec![0.0; self.tendons];
            let tip = |slot: &Slot| slot.seen.as_ref().map_or([f64::NAN; 3], |seen| seen.tip_m);
            let pulls =
                |slot: &Slot| slot.seen.as_ref().map_or(none.clone(), |seen| seen.pulls_m.clone());
            let tips: Vec<f64> = slots.iter().flat_map(tip).collect();
            let pulls: Vec<f64> = slots.iter().flat_map(pulls).collect();
            let valid: Vec<bool> = slots
                .iter()
                .map(|slot| slot.seen.as_ref().is_some_and(|seen| seen.valid))
                .collect();
            let status: Vec<String> = slots.iter().map(|slot| slot.status.clone()).collect();
            (tips, pulls, valid, status)
        });
        Ok((
            array(py, tips, &[self.count, 3])?,
            array(py, pulls, &[self.count, self.tendons])?,
            valid,
            status,
        ))
    }
}

#[pymethods]
impl PyPlants {
    #[classmethod]
    fn of_model(
        _class: &Bound<'_, PyType>,
        model: &PyModel,
        count: usize,
        step_s: f64,
        noise_m: f64,
        travel_m: Option<f64>,
    ) -> PyResult<PyPlants> {
        let model = spinebench::effects::Model::clone(&model.0);
        let mut robot = SimulatedSpec { model, noise_m, travel_m: 0.0 };
        robot.travel_m = travel_m.unwrap_or_else(|| suited_travel_m(robot.size()));
        let spec = PlantSpec::Simulated(Box::new(robot));
        spec.check().map_err(|(path, bad)| {
            Fault::argument(&format!("{path}.{}", bad.key), bad.found, bad.expected)
        })?;
        Ok(PyPlants::of(spec, count, step_s)?)
    }

    #[classmethod]
    fn of_file(
        _class: &Bound<'_, PyType>,
        file: PathBuf,
        count: usize,
        step_s: f64,
    ) -> PyResult<PyPlants> {
        let spec = read_plant(&file).map_err(Fault::from)?;
        if spec.drives_hardware() && count > 1 {
            return Err(Fault::argument(
                "count",
                count.to_string(),
                "1: a real robot stands alone",
            )
            .into());
        }
        Ok(PyPlants::of(spec, count, step_s)?)
    }

    #[getter]
    fn tendons(&self) -> usize {
        self.tendons
    }

    #[getter]
    fn travel_m(&self) -> Option<f64> {
        self.spec.travel_m()
    }

    /// The travel that suits the levers of its tendons, metres.
    #[getter]
    fn suited_travel_m(&self) -> f64 {
        suited_travel_m(self.spec.size())
    }

    /// For each segment its tendons (from 0) with their angles in degrees.
    #[getter]
    fn layout(&self) -> Vec<Vec<(usize, f64)>> {
        let of = |segment: Vec<spinebench::base::PlacedTendon>| {
            segment.into_iter().map(|placed| (placed.tendon, placed.angle_deg)).collect()
        };
        self.spec.tendon_layout().segments.into_iter().map(of).collect()
    }

    /// Brings the robots `which` home, each with its seed and further effects (JSON; empty for
    /// none).
    fn reset<'py>(
        &self,
        py: Python<'py>,
        which: Vec<usize>,
        seeds: Vec<u64>,
        effects: Vec<String>,
    ) -> PyResult<Seen<'py>> {
        if let Some(index) = which.iter().find(|index| **index >= self.count) {
            return Err(Fault::argument(
                "which",
                index.to_string(),
                format!("below {}", self.count),
            )
            .into());
        }
        if seeds.len() != which.len() || effects.len() != which.len() {
            return Err(Fault::argument(
                "seeds",
                seeds.len().to_string(),
                "one seed and effects a robot",
            )
            .into());
        }
        let takes = self.spec.takes_effects();
        let (spec, step_s) = (self.spec.clone(), self.step_s);
        long_on(py, Arc::clone(&self.slots), move |slots, _| {
            let mut order: Vec<Option<usize>> = vec![None; slots.len()];
            which.iter().enumerate().for_each(|(place, &index)| order[index] = Some(place));
            slots.par_iter_mut().zip(order).try_for_each(|(slot, place)| {
                let Some(place) = place else { return Ok(()) };
                if !effects[place].is_empty() {
                    if !takes {
                        return Err(Fault::argument(
                            "effects",
                            "some",
                            "none: this plant takes no effects",
                        ));
                    }
                    let own = spec.with_effects(&effects_of(&effects[place])?);
                    own.check().map_err(|(path, bad)| {
                        Fault::argument(&format!("{path}.{}", bad.key), bad.found, bad.expected)
                    })?;
                    slot.robot = Robot::new(&own, step_s)?;
                }
                let outcome = slot.robot.plant().reset(Seed(seeds[place]));
                slot.seen = None;
                slot.note(outcome);
                Ok(())
            })
        })?;
        self.seen(py)
    }

    /// One step of every robot whose status is `ok`; the others stay as they are.
    fn step<'py>(&self, py: Python<'py>, pulls_m: &Bound<'py, PyAny>) -> PyResult<Seen<'py>> {
        let tendons = self.tendons;
        let pulls_m = shaped(pulls_m, "pulls_m", &[self.count, tendons], "robots, tendons")?;
        let slots = &self.slots;
        let move_slot = |(index, slot): (usize, &mut Slot)| {
            if slot.status == "ok" {
                let outcome = slot.robot.plant().step(&pulls_m[index * tendons..][..tendons]);
                slot.note(outcome);
            }
        };
        detached(py, || {
            let mut slots = slots.lock().unwrap_or_else(PoisonError::into_inner);
            if slots.len() == 1 {
                slots.iter_mut().enumerate().for_each(move_slot);
            } else {
                let slots: &mut [Slot] = &mut slots;
                pool()?.install(|| slots.par_iter_mut().enumerate().for_each(move_slot));
            }
            Ok(())
        })?;
        self.seen(py)
    }

    /// Positions (n, 3) along a simulated robot, metres; None for another plant.
    fn shape<'py>(
        &self,
        py: Python<'py>,
        index: usize,
        n: usize,
    ) -> PyResult<Option<Bound<'py, PyArrayDyn<f64>>>> {
        counted(n)?;
        let shape = py.detach(|| {
            let slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
            match slots.get(index).map(|slot| &slot.robot) {
                Some(Robot::Simulated(plant)) => Some(shape_m(plant.rod(), n)),
                _ => None,
            }
        });
        shape.map(|shape| array(py, shape, &[n, 3])).transpose()
    }
}
