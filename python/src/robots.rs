//! Robots of environments: one call steps them over all cores and tells everything of the step.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use numpy::{PyArray1, PyArrayDyn};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyString, PyType};
use rayon::prelude::*;
use spinebench::plants::{PlantOptions, SimulatedSpec};
use spinebench::specs::{PlantSpec, read_plant, suited_travel_m};

use crate::arrays::{array, positive, shaped};
use crate::calls::{detached, guarded, long_on, pool};
use crate::episodes::{Drive, Episode, Step, Task, observation_size};
use crate::errors::Fault;
use crate::model::GivenModel;
use crate::plants::{OK, Robot, extended};
use crate::rod::counted;

/// Robots of one plant file, each with effects of its own and in an episode of its own.
#[pyclass(frozen, name = "_Robots", module = "spinebench._spinebench")]
pub(crate) struct PyRobots {
    spec: PlantSpec,
    step_s: f64,
    drive: Drive,
    task: OnceLock<Task>,
    episodes: Arc<Mutex<Vec<Episode>>>,
    count: usize,
    tendons: usize,
}

/// Settings of robots.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct RobotArguments {
    count: usize,
    step_s: f64,
    noise_m: f64,
    /// None: what suits the robot.
    travel_m: Option<f64>,
    /// None: a fifth of the travel.
    max_step_m: Option<f64>,
    action: String,
}

/// Episodes that begin: which robots, their seeds, their further effects (JSON; empty for none) and
/// their targets, metres.
#[derive(FromPyObject)]
pub(crate) struct Beginnings(Vec<usize>, Vec<u64>, Vec<String>, Vec<[f64; 3]>);

type Floats<'py> = Bound<'py, PyArrayDyn<f64>>;
type Row<'py> = Bound<'py, PyArray1<f64>>;
type Flags<'py> = Bound<'py, PyArray1<bool>>;
/// Observation, reward, terminated, truncated and info of one robot.
type Alone<'py> = (Bound<'py, PyArray1<f32>>, f64, bool, bool, Bound<'py, PyDict>);
/// The same of all robots: observations (n, size), rewards, terminated, truncated and info.
type Together<'py> =
    (Bound<'py, PyArrayDyn<f32>>, Row<'py>, Flags<'py>, Flags<'py>, Bound<'py, PyDict>);

/// What there is to tell of one robot.
struct Seen {
    tip_m: [f64; 3],
    target_m: [f64; 3],
    pulls_m: Vec<f64>,
    step: Step,
    /// None where it is `ok`.
    failure: Option<String>,
    observation: Vec<f32>,
}

impl Seen {
    fn new(episode: &Episode, drive: &Drive, task: &Task) -> Seen {
        let robot = &episode.robot;
        let mut pulls_m = robot.pulls_m().to_vec();
        // A robot that was not seen.
        pulls_m.resize(drive.tendons(), 0.0);
        Seen {
            tip_m: robot.tip_m(),
            target_m: episode.target_m,
            pulls_m,
            step: episode.step,
            failure: (robot.status != OK).then(|| robot.status.clone()),
            observation: episode.observe(drive, task).collect(),
        }
    }

    fn status<'py>(&self, py: Python<'py>) -> Bound<'py, PyString> {
        match &self.failure {
            None => intern!(py, "ok").clone(),
            Some(failure) => PyString::new(py, failure),
        }
    }

    fn alone(self, py: Python<'_>) -> PyResult<Alone<'_>> {
        let info = PyDict::new(py);
        info.set_item(intern!(py, "tip_m"), PyArray1::from_slice(py, &self.tip_m))?;
        info.set_item(intern!(py, "target_m"), PyArray1::from_slice(py, &self.target_m))?;
        info.set_item(intern!(py, "pulls_m"), PyArray1::from_slice(py, &self.pulls_m))?;
        info.set_item(intern!(py, "distance_m"), self.step.distance_m)?;
        info.set_item(intern!(py, "status"), self.status(py))?;
        let Step { reward, is_terminated, is_truncated, .. } = self.step;
        let observation = PyArray1::from_slice(py, &self.observation);
        Ok((observation, reward, is_terminated, is_truncated, info))
    }
}

impl PyRobots {
    fn of(spec: PlantSpec, arguments: &RobotArguments) -> Result<PyRobots, Fault> {
        let &RobotArguments { count, step_s, travel_m, max_step_m, ref action, .. } = arguments;
        positive("step_s", step_s)?;
        counted(count)?;
        let tendons = spec.tendons();
        let travel_m = travel_m.unwrap_or_else(|| suited_travel_m(spec.size()));
        let max_step_m = max_step_m.unwrap_or(0.2 * travel_m);
        if !(max_step_m > 0.0 && max_step_m <= travel_m) {
            let expected = "a number above 0 and up to travel_m";
            return Err(Fault::argument("max_step_m", max_step_m.to_string(), expected));
        }
        let travel_m = spec.travel_m().map_or(travel_m, |limit_m| travel_m.min(limit_m));
        let drive = Drive::new(action, spec.tendon_layout(), tendons, travel_m, max_step_m)?;
        let episode = |_| Ok(Episode::new(Robot::new(&spec, step_s)?, &drive));
        let episodes: Vec<Episode> = guarded(|| (0..count).map(episode).collect())?;
        let (task, episodes) = (OnceLock::new(), Arc::new(Mutex::new(episodes)));
        Ok(PyRobots { spec, step_s, drive, task, episodes, count, tendons })
    }

    fn locked(&self) -> MutexGuard<'_, Vec<Episode>> {
        self.episodes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn task(&self) -> Result<&Task, Fault> {
        self.task.get().ok_or_else(|| Fault::Run("robots without a task".into()))
    }

    /// Does `work` on each robot, over all cores where there are several.
    fn each(&self, work: impl Fn(usize, &mut Episode) + Sync) -> Result<(), Fault> {
        let mut episodes = self.locked();
        if let [one] = episodes.as_mut_slice() {
            work(0, one);
            return Ok(());
        }
        let episodes: &mut [Episode] = &mut episodes;
        pool()?.install(|| {
            episodes.par_iter_mut().enumerate().for_each(|(index, each)| work(index, each));
        });
        Ok(())
    }

    /// Numbers of each robot.
    fn numbers<'py, const N: usize>(
        &self,
        py: Python<'py>,
        of: impl Fn(&Episode) -> [f64; N] + Sync,
    ) -> PyResult<Floats<'py>> {
        let numbers = py.detach(|| self.locked().iter().flat_map(&of).collect());
        array(py, numbers, &[self.count, N])
    }

    /// What there is to tell of all robots.
    fn told<'py>(&self, py: Python<'py>) -> PyResult<Together<'py>> {
        let task = self.task()?;
        let seen: Vec<Seen> = py.detach(|| {
            self.locked().iter().map(|episode| Seen::new(episode, &self.drive, task)).collect()
        });
        let all = |of: fn(&Seen) -> &[f64], width: usize| {
            array(py, seen.iter().flat_map(of).copied().collect(), &[self.count, width])
        };
        let floats = |of: fn(&Seen) -> f64| PyArray1::from_iter(py, seen.iter().map(of));
        let flags = |of: fn(&Seen) -> bool| PyArray1::from_iter(py, seen.iter().map(of));
        let statuses = seen.iter().map(|seen| seen.status(py));
        let info = PyDict::new(py);
        info.set_item("tip_m", all(|seen| &seen.tip_m, 3)?)?;
        info.set_item("target_m", all(|seen| &seen.target_m, 3)?)?;
        info.set_item("pulls_m", all(|seen| &seen.pulls_m, self.tendons)?)?;
        info.set_item("distance_m", floats(|seen| seen.step.distance_m))?;
        info.set_item("status", PyList::new(py, statuses)?)?;
        let observations = seen.iter().flat_map(|seen| &seen.observation).copied().collect();
        Ok((
            array(py, observations, &[self.count, observation_size(&self.drive)])?,
            floats(|seen| seen.step.reward),
            flags(|seen| seen.step.is_terminated),
            flags(|seen| seen.step.is_truncated),
            info,
        ))
    }

    /// Brings robots home and begins their episodes.
    fn begin_each(&self, py: Python<'_>, beginnings: Beginnings) -> PyResult<()> {
        let Beginnings(which, seeds, effects, targets_m) = beginnings;
        let counts = [seeds.len(), effects.len(), targets_m.len()];
        if counts.iter().any(|&count| count != which.len()) {
            return Err(Fault::words("seeds, effects, targets: expected one per robot").into());
        }
        let mut order: Vec<Option<usize>> = vec![None; self.count];
        for (place, &index) in which.iter().enumerate() {
            let expected = format!("below {}", self.count);
            *order
                .get_mut(index)
                .ok_or_else(|| Fault::argument("which", index.to_string(), expected))? =
                Some(place);
        }
        let (spec, step_s) = (self.spec.clone(), self.step_s);
        long_on(py, Arc::clone(&self.episodes), move |episodes, _| {
            episodes.par_iter_mut().zip(order).try_for_each(|(episode, place)| {
                let Some(place) = place else { return Ok(()) };
                episode.robot.reset(&spec, step_s, seeds[place], &effects[place])?;
                episode.begin(targets_m[place]);
                Ok(())
            })
        })
    }
}

#[pymethods]
impl PyRobots {
    #[classmethod]
    fn of_model(
        _class: &Bound<'_, PyType>,
        model: GivenModel,
        arguments: RobotArguments,
    ) -> PyResult<PyRobots> {
        let model = spinebench::effects::Model::clone(&model.0.model);
        let mut robot = SimulatedSpec { model, noise_m: arguments.noise_m, travel_m: 0.0 };
        robot.travel_m = arguments.travel_m.unwrap_or_else(|| suited_travel_m(robot.size()));
        let spec = PlantSpec::Simulated(Box::new(robot));
        spec.check().map_err(|(path, bad)| {
            Fault::argument(&format!("{path}.{}", bad.key), bad.found, bad.expected)
        })?;
        Ok(PyRobots::of(spec, &arguments)?)
    }

    #[classmethod]
    fn of_file(
        _class: &Bound<'_, PyType>,
        file: PathBuf,
        arguments: RobotArguments,
    ) -> PyResult<PyRobots> {
        let spec = read_plant(&file).map_err(Fault::from)?;
        let count = arguments.count;
        if spec.drives_hardware() && count > 1 {
            let expected = "1, because a real robot cannot be copied";
            return Err(Fault::argument("count", count.to_string(), expected).into());
        }
        Ok(PyRobots::of(spec, &arguments)?)
    }

    #[getter]
    fn actions(&self) -> usize {
        self.drive.actions()
    }

    #[getter]
    fn travel_m(&self) -> f64 {
        self.drive.travel_m
    }

    #[getter]
    fn max_step_m(&self) -> f64 {
        self.drive.max_step_m
    }

    /// Says what is asked of the robots, once.
    fn set_task(&self, task: Task) {
        // A second task would be one of another environment.
        let _ = self.task.set(task);
    }

    /// Refuses effects (JSON) that this robot cannot have.
    fn check_effects(&self, effects: &str) -> PyResult<()> {
        Ok(guarded(|| extended(&self.spec, effects).map(drop))?)
    }

    /// Brings robots home and begins their episodes.
    fn begin(&self, py: Python<'_>, beginnings: Beginnings) -> PyResult<()> {
        self.begin_each(py, beginnings)
    }

    /// Moves all robots by the actions (n, actions), outside any task.
    fn drive(&self, py: Python<'_>, actions: &Bound<'_, PyAny>) -> PyResult<()> {
        let size = self.drive.actions();
        let actions = shaped(actions, "action", &[self.count, size], "robots, actions")?;
        detached(py, || {
            self.each(|index, episode| {
                episode.drive(&actions[index * size..][..size], &self.drive);
            })
        })
    }

    /// One step of one robot.
    fn step_alone<'py>(&self, py: Python<'py>, action: &Bound<'py, PyAny>) -> PyResult<Alone<'py>> {
        let size = self.drive.actions();
        let action = shaped(action, "action", &[size], "one number per action")?;
        let task = self.task()?;
        let seen = detached(py, || {
            let mut episodes = self.locked();
            let episode = &mut episodes[0];
            if episode.has_ended {
                return Err(Fault::argument(
                    "environment",
                    "no active episode",
                    "a call of reset() before step()",
                ));
            }
            episode.step(&action, &self.drive, task);
            Ok(Seen::new(episode, &self.drive, task))
        })?;
        seen.alone(py)
    }

    /// What there is to tell of one robot.
    fn tell_alone<'py>(&self, py: Python<'py>) -> PyResult<Alone<'py>> {
        let task = self.task()?;
        py.detach(|| Seen::new(&self.locked()[0], &self.drive, task)).alone(py)
    }

    /// One step of all robots by the actions (n, actions); where `beginnings` says so, an episode
    /// begins instead.
    #[pyo3(signature = (actions, beginnings=None))]
    fn step<'py>(
        &self,
        py: Python<'py>,
        actions: &Bound<'py, PyAny>,
        beginnings: Option<Beginnings>,
    ) -> PyResult<Together<'py>> {
        let size = self.drive.actions();
        let actions = shaped(actions, "action", &[self.count, size], "robots, actions")?;
        let task = self.task()?;
        // An episode that has ended begins anew instead of a step.
        detached(py, || {
            self.each(|index, episode| {
                if !episode.has_ended {
                    episode.step(&actions[index * size..][..size], &self.drive, task);
                }
            })
        })?;
        if let Some(beginnings) = beginnings {
            self.begin_each(py, beginnings)?;
        }
        self.told(py)
    }

    /// What there is to tell of all robots.
    fn tell<'py>(&self, py: Python<'py>) -> PyResult<Together<'py>> {
        self.told(py)
    }

    /// Tips (n, 3), metres.
    #[getter]
    fn tips_m<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.numbers(py, |episode| episode.robot.tip_m())
    }

    /// Targets of the last step (n, 3), metres.
    #[getter]
    fn last_targets_m<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.numbers(py, |episode| episode.step.target_m)
    }

    /// Wanted bends or displacements (n, actions), metres.
    #[getter]
    fn wanted_m<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let wanted_m =
            py.detach(|| self.locked().iter().flat_map(|each| each.wanted_m.clone()).collect());
        array(py, wanted_m, &[self.count, self.drive.actions()])
    }

    #[getter]
    fn status(&self, py: Python<'_>) -> Vec<String> {
        py.detach(|| self.locked().iter().map(|each| each.robot.status.clone()).collect())
    }

    /// Positions (n, 3) along a simulated robot, metres; None for another plant.
    fn shape<'py>(&self, py: Python<'py>, index: usize, n: usize) -> PyResult<Option<Floats<'py>>> {
        counted(n)?;
        let shape = py.detach(|| self.locked().get(index).and_then(|each| each.robot.shape_m(n)));
        shape.map(|shape| array(py, shape, &[n, 3])).transpose()
    }
}
