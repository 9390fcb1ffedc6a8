//! Blind cases of discovery. The truth is drawn and sealed in a stage of its own: beside the recording, which is made
//! from it, only the score reads it. What looks into the recording has the recording alone.

use super::{Added, Stages, status};
use crate::benchmark;
use crate::benchmark::{
    CaseAnswer, CaseBatch, CaseDesign, CatalogueSpan, Commands, Prior, PublicCase, ScoredCase, Truth,
};
use crate::discovery::{Options, discover};
use crate::effects::Model;
use crate::runner::graph::{Handle, StageKind};
use crate::runner::outcomes::Outcomes;
use crate::runner::source_digest::{DISCOVERY, ROBOT};
use crate::specs::{DiscoveryRun, PlantSpec};
use crate::tasks::ExploreOptions;

const COMMANDS: StageKind = StageKind { name: "blind_commands", sources: ROBOT, cost_ms: 300 };
const SPAN: StageKind = StageKind { name: "blind_span", sources: ROBOT, cost_ms: 15_000 };
const TRUTH: StageKind = StageKind { name: "blind_truth", sources: ROBOT, cost_ms: 3_000 };
const RECORDING: StageKind = StageKind { name: "blind_recording", sources: ROBOT, cost_ms: 500 };
const DISCOVER: StageKind = StageKind { name: "discover", sources: DISCOVERY, cost_ms: 15_000 };
const SCORE: StageKind = StageKind { name: "blind_score", sources: DISCOVERY, cost_ms: 1 };
/// All of this file.
pub(super) const KINDS: [StageKind; 6] = [COMMANDS, SPAN, TRUTH, RECORDING, DISCOVER, SCORE];

/// The stages of one case.
pub(crate) struct BlindStages {
    case: u64,
    batch: CaseBatch,
    correlation: f64,
    truth: Handle<Truth>,
    score: Handle<ScoredCase>,
}

impl BlindStages {
    /// Numbers of the stages whose results the case's row is made of.
    pub(crate) fn wanted(&self) -> [usize; 2] {
        [self.truth.number(), self.score.number()]
    }

    /// Number of the stage that ends it.
    pub(crate) fn last(&self) -> usize {
        self.score.number()
    }

    /// The case in words.
    pub(crate) fn label(&self, seed: u64) -> String {
        let (case, group, samples) = (self.case, self.batch.group.name(), self.batch.samples);
        format!("discovery seed {seed} case {case} {group} samples {samples}")
    }

    /// What it adds to the tables; a failure is a row that says so.
    pub(crate) fn scored(&self, outcomes: &Outcomes) -> ScoredCase {
        let truth = outcomes.get(self.truth).ok();
        let failed = |failure: super::Failure| {
            benchmark::failed(self.case, &self.batch, self.correlation, truth, &failure.to_string())
        };
        outcomes.get(self.score).cloned().unwrap_or_else(failed)
    }
}

/// A set of commands and, where the oracle has been asked about them, what it knows.
type CommandStages = (Handle<Commands>, Option<Handle<CatalogueSpan>>);

/// What expanding a part of the experiment yields.
type Expanded<T> = Result<T, super::Failure>;

/// What cases are made of.
struct Benchmark<'a> {
    run: &'a DiscoveryRun,
    /// The model as it is given to whoever looks into a recording.
    model: &'a Model,
    /// The same with cells as long as those of the look: what strengths and the oracle are computed with.
    quick: Model,
    priors: Vec<Prior>,
}

impl Stages<'_> {
    /// All blind cases of the experiment, in the order of its batches.
    pub(crate) fn blind(&mut self) -> Expanded<Vec<BlindStages>> {
        let spec = self.spec;
        let (Some(run), PlantSpec::Simulated(plant)) = (&spec.runs.discovery, &spec.model) else {
            return Ok(Vec::new());
        };
        let mut quick = plant.model.clone();
        let resolution = &mut quick.robot.resolution;
        resolution.motion_tolerance_m = resolution.motion_tolerance_m.max(run.options.motion_tolerance_m);
        resolution.cell_m = resolution.cell_m.max(run.options.cell_m);
        let priors = run.options.uncertain.iter().map(prior).collect();
        let benchmark = Benchmark { run, model: &plant.model, quick, priors };
        let all: usize = run.batches.iter().map(|batch| batch.cases).sum();
        let mut case = self.repetition * all as u64;
        let mut cases = Vec::with_capacity(all);
        for batch in &run.batches {
            // Kinds and sizes go on from one repetition to the next.
            let first = self.repetition as usize * batch.cases;
            for number in first..first + batch.cases {
                cases.push(self.blind_case(&benchmark, batch, number, case)?);
                case += 1;
            }
        }
        Ok(cases)
    }

    fn blind_case(
        &mut self,
        benchmark: &Benchmark,
        batch: &CaseBatch,
        number: usize,
        case: u64,
    ) -> Expanded<BlindStages> {
        let run = benchmark.run;
        let (commands, span) = self.blind_commands(benchmark, batch, number, case)?;
        // Kinds take their turn within each size.
        let sizes = batch.shifts_m.len();
        let robot = CaseDesign {
            model: benchmark.quick.clone(),
            group: batch.group,
            number: number / sizes,
            shift_m: batch.shifts_m[number % sizes],
            noise_m: batch.noise_m,
            priors: benchmark.priors.clone(),
            truth: run.truth,
            oracle: run.oracle,
            seed: self.seed.child("blind").index(case).0,
        };
        let correlation = batch.correlations[robot.number % batch.correlations.len()];
        let truth = self.blind_truth(&robot, commands, span, case)?;
        let recording = self.blind_recording(robot, truth, commands, correlation, case)?;
        let answer = self.discover(benchmark.model, &run.options, recording, case)?;
        let (model, own) = (benchmark.model.clone(), batch.clone());
        let params = (case, own.clone(), correlation, model.clone());
        let inputs = [truth.number(), answer.number()];
        let label = self.label(&format!("score of case {case}"));
        let score = self.graph.stage(SCORE, label, &params, &inputs, move |given| {
            Ok(benchmark::score(case, &own, correlation, &model, given.get(truth)?, given.get(answer)?))
        })?;
        Ok(BlindStages { case, batch: batch.clone(), correlation, truth, score })
    }

    /// The commands of a case: its own, or for cases that the oracle judges those of several.
    fn blind_commands(
        &mut self,
        benchmark: &Benchmark,
        batch: &CaseBatch,
        number: usize,
        case: u64,
    ) -> Expanded<CommandStages> {
        let explore = ExploreOptions { points: batch.samples, trajectories: batch.trials, ..self.spec.explore };
        let judged = batch.group.judged();
        let seed = if judged {
            let shared = number / benchmark.run.oracle.cases_per_commands;
            self.seed.child("blind_judged").index(batch.samples as u64).index(shared as u64)
        } else {
            self.seed.child("blind").index(case).child("commands")
        };
        let (step_s, label, model) = (self.step_s(), self.label("blind commands"), benchmark.quick.clone());
        let params = (model.clone(), explore, step_s, seed.0);
        let commands = self.graph.stage(COMMANDS, label, &params, &[], move |_| {
            benchmark::explore_commands(&model, &explore, step_s, seed).map_err(status)
        })?;
        if !judged {
            return Ok((commands, None));
        }
        let (model, priors, noise_m) = (benchmark.quick.clone(), benchmark.priors.clone(), batch.noise_m);
        let params = (model.clone(), priors.clone(), noise_m);
        let label = self.label("span of the catalogue");
        let span = self.graph.stage(SPAN, label, &params, &[commands.number()], move |given| {
            CatalogueSpan::new(&model, given.get(commands)?, &priors, noise_m).map_err(status)
        })?;
        Ok((commands, Some(span)))
    }

    /// What is hidden: the sealed label.
    fn blind_truth(
        &mut self,
        robot: &CaseDesign,
        commands: Handle<Commands>,
        span: Option<Handle<CatalogueSpan>>,
        case: u64,
    ) -> Added<Truth> {
        let inputs: Vec<usize> = [commands.number()].into_iter().chain(span.map(Handle::number)).collect();
        let (params, robot) = (robot.clone(), robot.clone());
        let label = self.label(&format!("truth of case {case}"));
        self.graph.stage(TRUTH, label, &params, &inputs, move |given| {
            let span = span.map(|span| given.get(span)).transpose()?;
            benchmark::draw(&robot, given.get(commands)?, span).map_err(status)
        })
    }

    fn blind_recording(
        &mut self,
        robot: CaseDesign,
        truth: Handle<Truth>,
        commands: Handle<Commands>,
        correlation: f64,
        case: u64,
    ) -> Added<PublicCase> {
        let params = (robot.clone(), correlation);
        let inputs = [truth.number(), commands.number()];
        let label = self.label(&format!("recording of case {case}"));
        self.graph.stage(RECORDING, label, &params, &inputs, move |given| {
            benchmark::measure_case(&robot, given.get(truth)?, given.get(commands)?, correlation).map_err(status)
        })
    }

    /// The answer to a recording: of the model, the recording and the options alone.
    fn discover(
        &mut self,
        model: &Model,
        options: &Options,
        recording: Handle<PublicCase>,
        case: u64,
    ) -> Added<CaseAnswer> {
        let (model, options) = (model.clone(), options.clone());
        let params = (model.clone(), options.clone());
        let label = self.label(&format!("discovery in case {case}"));
        self.graph.stage(DISCOVER, label, &params, &[recording.number()], move |given| {
            let presented = given.get(recording)?;
            let mut options = options.clone();
            options.left_out.extend(presented.left_out.iter().cloned());
            let found = discover(&model, &presented.recording(), None, &options).map_err(status)?;
            Ok(CaseAnswer::new(&found.findings, found.alternatives.stiffness_only_m, found.alternatives.gp_m))
        })
    }
}

fn prior(one: &crate::discovery::Uncertainty) -> Prior {
    Prior { effect: one.effect.clone(), parameter: one.parameter.clone(), deviation: one.deviation }
}
