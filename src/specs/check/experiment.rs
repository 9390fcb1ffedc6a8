//! Checks of an experiment: ranges, and names and sizes that must agree.

use super::discovery::check_entries;
use super::named_values::with_values;
use super::outside_policies::outside_policies;
use crate::base::BadOption;
use crate::effects::{EffectSpec, check_effect_units, check_effects};
use crate::learn::LearnError;
use crate::plants::PlantSpec;
use crate::policies::{self, ModelAccess, PolicyEntry};
use crate::report::figures;
use crate::specs::document::error::SpecError;
use crate::specs::document::locate::PathEnd;
use crate::specs::document::merged::Document;
use crate::specs::document::mismatch::one_near;
use crate::specs::document::path::KeyPath;
use crate::specs::experiment::cells::uses;
use crate::specs::experiment::claims::Size;
use crate::specs::experiment::spec::{DiscoveryRun, Experiment, ReachSweep, TrackRun};
use crate::tasks::{PointLayout, has_tip_model};
use std::ops::RangeInclusive;

/// Checks `experiment`, which was read from `document`.
///
/// # Errors
/// [`SpecError::Key`] with the location of the first invalid value.
pub(crate) fn check(experiment: &Experiment, document: &Document) -> Result<(), SpecError> {
    let checker = Checker { experiment, document };
    checker.header()?;
    checker.options()?;
    checker.runs()?;
    super::claims::check(experiment, document)
}

/// Most repetitions of an experiment; the plan of more would not fit in memory.
const MAX_SEEDS: u64 = 1000;
/// Inputs of an error model beside the displacements: a position.
const POSITION_INPUTS: usize = 3;
/// Tracking noise above this indicates a wrong unit, metres.
const MAX_NOISE_M: f64 = 0.05;

/// Whether a name is of letters, digits, `_` and `-`.
pub(super) fn is_name(name: &str) -> bool {
    !name.is_empty()
        && name.chars().all(|letter| letter.is_ascii_alphanumeric() || "_-".contains(letter))
}

pub(super) struct Checker<'a> {
    pub(super) experiment: &'a Experiment,
    pub(super) document: &'a Document,
}

impl Checker<'_> {
    fn wrong(&self, path: &KeyPath, expected: impl Into<String>) -> SpecError {
        self.document.wrong(path, expected)
    }

    pub(super) fn unless(
        &self,
        holds: bool,
        path: &KeyPath,
        expected: &str,
    ) -> Result<(), SpecError> {
        if holds { Ok(()) } else { Err(self.wrong(path, expected)) }
    }

    fn header(&self) -> Result<(), SpecError> {
        let (root, spec) = (KeyPath::default(), self.experiment);
        let null = self.document.is_null(&root.key("name"));
        self.unless(
            is_name(&spec.name) && !null,
            &root.key("name"),
            "a name of letters, digits, `_` and `-`",
        )?;
        let hz = spec.control_hz;
        self.unless(
            hz > 0.0 && hz <= 1000.0,
            &root.key("control_hz"),
            "a rate above 0 and up to 1000 Hz",
        )?;
        let travel = spec.travel_m.is_none_or(|travel_m| travel_m > 0.0 && travel_m.is_finite());
        self.unless(travel, &root.key("travel_m"), "a length above 0 m, or null")?;
        self.unless((1..=MAX_SEEDS).contains(&spec.seeds), &root.key("seeds"), "1 to 1000")?;
        let max_first = MAX_SEEDS - spec.seeds;
        self.unless(
            spec.first_seed <= max_first,
            &root.key("first_seed"),
            &format!("0 to {max_first}"),
        )?;
        self.unless(
            !spec.training.is_empty(),
            &root.key("training"),
            "at least one kind of training",
        )?;
        for (name, training) in &spec.training {
            let path = root.key("training").key(name);
            self.unless(is_name(name), &path, "a name of letters, digits, `_` and `-`")?;
            let stops = [
                ("forward_mae_m", training.forward_mae_m),
                ("inverse_mae_m", training.inverse_mae_m),
                ("inverse_b_mae_m", training.inverse_b_mae_m),
                ("pi_real_mae_m", training.pi_real_mae_m),
            ];
            for (key, stop_m) in stops {
                let positive = stop_m.is_none_or(|stop_m| stop_m > 0.0 && stop_m.is_finite());
                self.unless(positive, &path.key(key), "a length above 0, or null")?;
            }
        }
        for name in spec.modes.keys() {
            let path = root.key("modes").key(name);
            self.unless(is_name(name), &path, "a name of letters, digits, `_` and `-`")?;
        }
        Ok(())
    }

    /// The checks of each module's options.
    fn options(&self) -> Result<(), SpecError> {
        let spec = self.experiment;
        let option = |name: &str, result: Result<(), BadOption>| {
            self.checked(&KeyPath::default().key(name), result)
        };
        // Of each module the first fault, all of them at once.
        let checks = [
            option("explore", spec.explore.check()),
            option("gp_points", spec.gp_points.check()),
            option("policies", spec.policies.check()),
            outside_policies(self.document, spec),
            option("targets", spec.targets.check()),
            option("reach", spec.reach.check()),
            option("path", spec.path.check()),
            option("track", spec.track.check()),
            option("slurm", spec.slurm.check()),
            self.plants(),
            self.learn("gp", spec.gp.check()),
            self.learn("network", spec.network.check()),
        ];
        let faults: Vec<SpecError> = checks.into_iter().filter_map(Result::err).collect();
        if !faults.is_empty() {
            return Err(SpecError::of_all(faults));
        }
        if let Some(population) = &spec.population {
            let path = KeyPath::default().key("plant");
            let has_model = spec.plant.model().is_some();
            let expected = "a `simulated` or `external` robot, to which `population` adds effects";
            self.unless(has_model, &path, expected)?;
            option("population", population.check())?;
        }
        self.learn("gp", spec.gp.kernel.check_inputs(spec.model.tendons() + POSITION_INPUTS))?;
        let stop = KeyPath::default().key("network").key("stop_at_validation_mae_m");
        self.unless(
            spec.network.stop_at_validation_mae_m.is_none(),
            &stop,
            "null: `training` sets where networks stop",
        )
    }

    fn plants(&self) -> Result<(), SpecError> {
        let (root, spec) = (KeyPath::default(), self.experiment);
        for (name, plant) in [("model", &spec.model), ("plant", &spec.plant)] {
            plant.check().map_err(|(path, bad)| {
                self.option(&format!("{name}.{path}"), bad.key, &bad.found, bad.expected)
            })?;
            let path = root.key(name).key(plant.kind());
            plant.tendon_layout().check().map_err(|found| {
                let angles = ["model", "robot", "tendons", "angles_deg"]
                    .iter()
                    .fold(path.clone(), |path, key| path.key(key));
                let at = if self.document.has(&angles) { &angles } else { &path };
                self.document.refuse(
                    at,
                    PathEnd::Value,
                    found,
                    "tendons on every side, to bend the robot both ways",
                )
            })?;
            let is_plausible =
                plant.noise_m().is_none_or(|noise_m| (0.0..=MAX_NOISE_M).contains(&noise_m));
            self.unless(is_plausible, &path.key("noise_m"), "0 to 0.05 m of tracking noise")?;
            let is_allowed = name == "plant" || !plant.drives_hardware();
            self.unless(
                is_allowed,
                &root.key(name),
                &format!("a model, not a `{}` plant", plant.kind()),
            )?;
            plant.travel_m().map_or(Ok(()), |travel_m| self.pulls(name, travel_m))?;
        }
        let (found, expected) = (spec.plant.tendons(), spec.model.tendons());
        if found != expected {
            let expected = format!(
                "{expected}, the number of the model: its commands are replayed on the robot"
            );
            return Err(self.document.refuse(
                &root.key("plant"),
                PathEnd::Value,
                format!("{found} tendons"),
                expected,
            ));
        }
        for (name, mode) in &spec.modes {
            let path = root.key("modes").key(name).key("effects");
            let allowed = mode.effects.is_empty() || spec.plant.takes_effects();
            let expected =
                "no effects: only `simulated`, `external` and `hardware` plants take them";
            self.unless(allowed, &path, expected)?;
            self.effects(&mode.effects, &path)?;
            if let Some(change) = &mode.change {
                let path = root.key("modes").key(name).key("change");
                self.unless(spec.plant.takes_effects(), &path, expected)?;
                self.checked(&path, change.check())?;
                self.effects(&change.effects, &path.key("effects"))?;
            }
        }
        Ok(())
    }

    /// Explorations and points stay within the travel of the robot that executes them.
    fn pulls(&self, robot: &str, travel_m: f64) -> Result<(), SpecError> {
        let (root, spec) = (KeyPath::default(), self.experiment);
        let layout = root.key("gp_points").key("layout");
        let points = match spec.gp_points.layout {
            PointLayout::Grid(grid) => (layout.key("grid"), grid.max_pull_m),
            PointLayout::Walk { max_pull_m, .. } => (layout.key("walk"), max_pull_m),
        };
        let explore = (root.key("explore"), spec.explore.max_pull_m);
        for (path, pull_m) in [explore, points] {
            let expected = format!("at most {travel_m} m, the travel of `{robot}`");
            self.unless(pull_m <= travel_m, &path.key("max_pull_m"), &expected)?;
        }
        Ok(())
    }

    fn learn(&self, name: &str, result: Result<(), LearnError>) -> Result<(), SpecError> {
        result.map_err(|error| match error {
            LearnError::Setting { key, found, expected } => match key.rsplit_once('.') {
                None => self.option(name, key, &found, expected),
                Some((parent, key)) => {
                    self.option(&format!("{name}.{parent}"), key, &found, expected)
                }
            },
            other => self.document.refuse(
                &KeyPath::default().key(name),
                PathEnd::Value,
                other.to_string(),
                "a valid value",
            ),
        })
    }

    /// A check of the options below `path`.
    pub(super) fn checked(
        &self,
        path: &KeyPath,
        result: Result<(), BadOption>,
    ) -> Result<(), SpecError> {
        result.map_err(|bad| self.option(&path.to_string(), bad.key, &bad.found, bad.expected))
    }

    /// Effects and their units; `path` is that of their list.
    pub(super) fn effects(&self, effects: &[EffectSpec], path: &KeyPath) -> Result<(), SpecError> {
        let checked = check_effects(effects, &self.experiment.plant.tendon_layout());
        checked.and_then(|()| check_effect_units(effects)).map_err(|(index, effect, bad)| {
            let path = path.item(index).key(effect).key(bad.key);
            self.document.refuse(&path, PathEnd::Value, bad.found, bad.expected)
        })
    }

    /// Option checks name a key without the keys above it: it is the first one below `name` with
    /// that value.
    pub(super) fn option(&self, name: &str, key: &str, found: &str, expected: &str) -> SpecError {
        let below = KeyPath::parse(name).unwrap_or_default();
        let path = self.document.find(&below, key, found).unwrap_or_else(|| below.key(key));
        let expected = with_values(expected, self.experiment, &path);
        self.document.refuse(&path, PathEnd::Value, found.to_owned(), expected)
    }

    fn runs(&self) -> Result<(), SpecError> {
        let (runs, path) = (&self.experiment.runs, KeyPath::default().key("runs"));
        let points = self.experiment.explore.points;
        let rows =
            self.experiment.network.check_rows(points, &self.experiment.explore.starts(points));
        self.enough(rows, &KeyPath::default().key("explore").key("points"))?;
        let any = runs.gap.is_some()
            || runs.forward
            || !runs.gp_points.is_empty()
            || !runs.reach.is_empty();
        self.unless(
            any || runs.track.is_some()
                || runs.response.is_some()
                || runs.pace.is_some()
                || runs.repair.is_some()
                || runs.discovery.is_some(),
            &path,
            "at least one of `gap`, `forward`, `gp_points`, `reach`, `track`, `response`, `pace`, \
             `repair`, `discovery`",
        )?;
        if let Some(gap) = runs.gap {
            let max_rows = self.experiment.explore.points;
            self.fits(&[gap.rows], &path.key("gap").key("rows"), 1..=max_rows, "collected points")?;
        }
        self.gp_sizes(&runs.gp_points, &path.key("gp_points"))?;
        for (key, shares) in
            [("gp_coverage", &runs.gp_coverage), ("gp_leave_one_out", &runs.gp_leave_one_out)]
        {
            for (index, share) in shares.iter().enumerate() {
                let inside = *share > 0.0 && *share < 1.0;
                self.unless(inside, &path.key(key).item(index), "a share above 0 and below 1")?;
            }
        }
        let figures: Vec<&str> = figures().map(|figure| figure.name).collect();
        for (index, name) in self.experiment.figures.iter().enumerate() {
            let path = KeyPath::default().key("figures").item(index);
            self.unless(
                !self.experiment.figures[..index].contains(name),
                &path,
                "each figure once",
            )?;
            self.unless(figures.contains(&name.as_str()), &path, &one_near(&figures, name))?;
        }
        self.cells(&runs.reach, &path.key("reach"))?;
        self.fixed_duration(&path)?;
        runs.track.as_ref().map_or(Ok(()), |track| self.track(track, &path.key("track")))?;
        runs.repair.as_ref().map_or(Ok(()), |repair| self.repair(repair, &path.key("repair")))?;
        runs.discovery
            .as_ref()
            .map_or(Ok(()), |discovery| self.discovery(discovery, &path.key("discovery")))
    }

    /// Products of policies, modes and sizes.
    pub(super) fn cells(&self, sweeps: &[ReachSweep], path: &KeyPath) -> Result<(), SpecError> {
        for (index, sweep) in sweeps.iter().enumerate() {
            let path = path.item(index);
            self.policies(&sweep.policies, &path.key("policies"))?;
            self.not_empty(&sweep.modes, &path.key("modes"))?;
            for (number, mode) in sweep.modes.iter().enumerate() {
                self.mode(mode, &path.key("modes").item(number))?;
            }
            for (key, part) in [("gp_points", Size::GpPoints), ("real_points", Size::RealPoints)] {
                let sizes =
                    if part == Size::GpPoints { &sweep.gp_points } else { &sweep.real_points };
                self.sizes(&sweep.policies, part, sizes.as_deref(), &path.key(key))?;
            }
        }
        Ok(())
    }

    /// Trials of fixed duration.
    fn fixed_duration(&self, path: &KeyPath) -> Result<(), SpecError> {
        let runs = &self.experiment.runs;
        let seconds = |value: f64, path: &KeyPath| {
            self.unless((1.0..=600.0).contains(&value), path, "1 to 600 s")
        };
        if let Some(run) = &runs.response {
            let path = path.key("response");
            seconds(run.duration_s, &path.key("duration_s"))?;
            self.unless(
                !run.cells.is_empty(),
                &path.key("cells"),
                "at least one product of policies and modes",
            )?;
            self.cells(&run.cells, &path.key("cells"))?;
        }
        let Some(run) = &runs.pace else { return Ok(()) };
        let path = path.key("pace");
        seconds(run.lead_in_s, &path.key("lead_in_s"))?;
        self.unless((1.0..=3600.0).contains(&run.lap_s), &path.key("lap_s"), "1 to 3600 s")?;
        self.not_empty(&run.speeds, &path.key("speeds"))?;
        for (index, &speed) in run.speeds.iter().enumerate() {
            self.unless(
                (0.1..=100.0).contains(&speed),
                &path.key("speeds").item(index),
                "0.1 to 100 times",
            )?;
        }
        self.unless(
            !run.cells.is_empty(),
            &path.key("cells"),
            "at least one product of policies and modes",
        )?;
        self.cells(&run.cells, &path.key("cells"))
    }

    fn discovery(&self, discovery: &DiscoveryRun, path: &KeyPath) -> Result<(), SpecError> {
        let rod = matches!(self.experiment.model, PlantSpec::Simulated(_));
        self.unless(
            rod,
            &KeyPath::default().key("model"),
            "a simulated rod, which `runs.discovery` requires",
        )?;
        check_entries(self.document, &discovery.options, &path.key("options"))?;
        self.checked(&path.key("options"), discovery.options.check())?;
        self.checked(&path.key("truth"), discovery.truth.check())?;
        self.checked(&path.key("oracle"), discovery.oracle.check())?;
        let batches = path.key("batches");
        let has_cases = !discovery.batches.is_empty() || !discovery.recordings.is_empty();
        self.unless(has_cases, &batches, "at least one batch here or one table of `recordings`")?;
        let mut numbered = discovery.batches.iter().enumerate();
        numbered
            .try_for_each(|(index, batch)| self.checked(&batches.item(index), batch.check()))?;
        let mut numbered = discovery.recordings.iter().enumerate();
        numbered.try_for_each(|(index, cases)| {
            self.checked(&path.key("recordings").item(index), cases.check())
        })
    }

    fn track(&self, track: &TrackRun, path: &KeyPath) -> Result<(), SpecError> {
        self.policies(&track.policies, &path.key("policies"))?;
        self.mode(&track.mode, &path.key("mode"))?;
        let as_list = |size: Option<usize>| size.map(|size| vec![size]);
        let (gp, real) = (as_list(track.gp_points), as_list(track.real_points));
        self.sizes(&track.policies, Size::GpPoints, gp.as_deref(), &path.key("gp_points"))?;
        self.sizes(&track.policies, Size::RealPoints, real.as_deref(), &path.key("real_points"))
    }

    fn not_empty<T: PartialEq>(&self, values: &[T], path: &KeyPath) -> Result<(), SpecError> {
        self.unless(!values.is_empty(), path, "at least one value")?;
        for (index, value) in values.iter().enumerate() {
            self.unless(!values[..index].contains(value), &path.item(index), "each value once")?;
        }
        Ok(())
    }

    pub(super) fn policies(&self, names: &[String], path: &KeyPath) -> Result<(), SpecError> {
        self.not_empty(names, path)?;
        for (index, name) in names.iter().enumerate() {
            let outside = self.experiment.policies.outside.keys().map(String::as_str);
            let allowed: Vec<&str> =
                policies::REGISTRY.iter().map(|entry| entry.name).chain(outside).collect();
            let expected = one_near(&allowed, name);
            self.unless(allowed.contains(&name.as_str()), &path.item(index), &expected)?;
            let asks_model =
                policies::find(name).is_some_and(|entry| entry.model == ModelAccess::AtRest);
            let expected = format!(
                "a model with equations (`simulated`, `constant_curvature`), as policy `{name}` \
                 needs"
            );
            let model = KeyPath::default().key("model");
            self.unless(!asks_model || has_tip_model(&self.experiment.model), &model, &expected)?;
            let needs_random_robots =
                policies::find(name).is_some_and(PolicyEntry::uses_randomised_robots);
            let expected = format!("a `simulated` model, as policy `{name}` needs");
            let simulated = matches!(self.experiment.model, PlantSpec::Simulated(_));
            self.unless(!needs_random_robots || simulated, &model, &expected)?;
        }
        Ok(())
    }

    fn mode(&self, name: &str, path: &KeyPath) -> Result<(), SpecError> {
        let allowed: Vec<&str> = self.experiment.modes.keys().map(String::as_str).collect();
        self.unless(allowed.contains(&name), path, &one_near(&allowed, name))
    }

    /// Sizes must be given when a policy is built from that part, and none may exceed the data.
    pub(super) fn sizes(
        &self,
        names: &[String],
        part: Size,
        sizes: Option<&[usize]>,
        path: &KeyPath,
    ) -> Result<(), SpecError> {
        let uses = |name: &String| policies::find(name).is_some_and(|entry| uses(entry, part));
        match (sizes, names.iter().find(|name| uses(name))) {
            (None, Some(name)) => Err(self.wrong(path, format!("sizes for policy `{name}`"))),
            (None, None) => Ok(()),
            (Some(_), None) => {
                Err(self.wrong(path, "no such key: none of these policies uses this number"))
            }
            (Some(sizes), Some(_)) => {
                self.not_empty(sizes, path)?;
                if part == Size::GpPoints {
                    self.gp_sizes(sizes, path)
                } else {
                    self.real_sizes(sizes, path)
                }
            }
        }
    }

    pub(super) fn gp_sizes(&self, sizes: &[usize], path: &KeyPath) -> Result<(), SpecError> {
        let (gp, inputs) = (&self.experiment.gp, self.experiment.model.tendons() + POSITION_INPUTS);
        let range = gp.mean.least_rows(inputs)..=self.experiment.gp_points.points();
        self.fits(sizes, path, range, "predefined points")?;
        let max_points = gp.most_points();
        let hint =
            if gp.approximation.is_exact() { "; `gp.approximation: sgpr` takes more" } else { "" };
        let kind = if gp.approximation.is_exact() { "an exact" } else { "a sparse" };
        for (index, size) in sizes.iter().enumerate() {
            self.unless(
                *size <= max_points,
                &self.item(path, index),
                &format!("at most {max_points} points for {kind} process{hint}"),
            )?;
        }
        Ok(())
    }

    fn real_sizes(&self, sizes: &[usize], path: &KeyPath) -> Result<(), SpecError> {
        self.fits(sizes, path, 10..=self.experiment.explore.points, "collected points")?;
        let samples = |size: &usize| self.experiment.explore.starts(*size);
        for (index, size) in sizes.iter().enumerate() {
            let result = self.experiment.network.check_rows(*size, &samples(size));
            self.enough(result, &self.item(path, index))?;
        }
        Ok(())
    }

    /// A network needs a window of rows for training and a row for validation.
    fn enough(&self, result: Result<(), LearnError>, path: &KeyPath) -> Result<(), SpecError> {
        result.map_err(|error| {
            let expected = match error {
                LearnError::TooFewRows { needed, why, .. } => {
                    format!("about {needed} or more, enough for {why}")
                }
                other => other.to_string(),
            };
            self.wrong(path, expected)
        })
    }

    fn fits(
        &self,
        sizes: &[usize],
        path: &KeyPath,
        range: RangeInclusive<usize>,
        what: &str,
    ) -> Result<(), SpecError> {
        for (index, size) in sizes.iter().enumerate() {
            let expected = format!("{} to {}, the number of {what}", range.start(), range.end());
            self.unless(range.contains(size), &self.item(path, index), &expected)?;
        }
        Ok(())
    }

    /// The path of a size: a single size is the value of its key, several are a list.
    fn item(&self, path: &KeyPath, index: usize) -> KeyPath {
        Some(path.item(index))
            .filter(|item| self.document.has(item))
            .unwrap_or_else(|| path.clone())
    }
}
