//! Blind cases of discovery. The truth is drawn and sealed in a stage of its own: beside the
//! recording, which is made from it, only the score reads it. What looks into the recording has the
//! recording alone.

use super::Stages;
use crate::benchmark::{
    self, CaseBatch, CaseDesign, CaseSetting, CatalogueSpan, Commands, Prior, RecordedCase,
    RecordedCases, ScoredCase, Truth,
};
use crate::data::DataError;
use crate::discovery::Options;
use crate::effects::Model;
use crate::runner::execute::outcomes::Outcomes;
use crate::runner::graph::stage::Handle;
use crate::runner::jobs::discovery::baselines::{BASELINES, BASELINES_RECORDED};
use crate::runner::jobs::discovery::blind::{
    COMMANDS, CommandParams, RECORDED_TRUTH, RECORDING, SPAN, SpanParams, TRUTH,
};
use crate::runner::jobs::discovery::blind_score::{SCORE, ScoreParams};
use crate::runner::jobs::discovery::discover::{
    DISCOVER, DISCOVER_RECORDED, RecordedFile, RecordedParams,
};
use crate::specs::{DiscoveryRun, PlantSpec};
use crate::tasks::ExploreOptions;

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
            let setting = CaseSetting {
                number: self.case,
                batch: &self.batch,
                correlation: self.correlation,
            };
            benchmark::failed(setting, truth, &failure.to_string())
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
    /// The same with cells as long as those of the look: what strengths and the oracle are computed
    /// with.
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
        resolution.motion_tolerance_m =
            resolution.motion_tolerance_m.max(run.options.motion_tolerance_m);
        resolution.cell_m = resolution.cell_m.max(run.options.cell_m);
        let priors = run.options.uncertain.iter().map(prior).collect();
        let benchmark = Benchmark { run, model: &plant.model, quick, priors };
        let unreadable = |error: DataError| super::Failure {
            stage: "recordings".to_owned(),
            status: error.to_string(),
        };
        let recorded =
            run.recordings.iter().map(RecordedCases::cases).collect::<Result<Vec<_>, _>>();
        let recorded: Vec<RecordedCase> =
            recorded.map_err(unreadable)?.into_iter().flatten().collect();
        let cases_per_repetition =
            run.batches.iter().map(|batch| batch.cases).sum::<usize>() + recorded.len();
        let mut case = self.repetition * cases_per_repetition as u64;
        let mut cases = Vec::with_capacity(cases_per_repetition);
        for batch in &run.batches {
            // Kinds and sizes go on from one repetition to the next.
            let first = self.repetition as usize * batch.cases;
            for number in first..first + batch.cases {
                cases.push(self.blind_case(&benchmark, batch, number, case)?);
                case += 1;
            }
        }
        for recorded in recorded {
            cases.push(self.recorded_case(&plant.model, &run.options, recorded, case)?);
            case += 1;
        }
        Ok(cases)
    }

    /// A recording of others, whose truth its table tells.
    fn recorded_case(
        &mut self,
        model: &Model,
        options: &Options,
        recorded: RecordedCase,
        case: u64,
    ) -> Expanded<BlindStages> {
        let RecordedCase { recording, baseline, truth, batch } = recorded;
        let label = self.label(&format!("truth of case {case}"));
        let truth = self.graph.stage(&RECORDED_TRUTH, label, truth, ())?;
        let label = self.label(&format!("discovery in case {case}"));
        let params = || RecordedParams {
            model: model.clone(),
            options: options.clone(),
            measured: RecordedFile(recording.clone()),
            baseline: baseline.clone().map(RecordedFile),
        };
        let answer = self.graph.stage(&DISCOVER_RECORDED, label, params(), ())?;
        let label = self.label(&format!("methods of comparison in case {case}"));
        let baselines = self.graph.stage(&BASELINES_RECORDED, label, params(), ())?;
        let label = self.label(&format!("score of case {case}"));
        let params =
            ScoreParams { case, batch: batch.clone(), correlation: 0.0, model: model.clone() };
        let score = self.graph.stage(&SCORE, label, params, (truth, answer, baselines))?;
        Ok(BlindStages { case, batch, correlation: 0.0, truth, score })
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
        // What is hidden: the sealed label.
        let label = self.label(&format!("truth of case {case}"));
        let truth = self.graph.stage(&TRUTH, label, robot.clone(), (commands, span))?;
        let label = self.label(&format!("recording of case {case}"));
        let recording =
            self.graph.stage(&RECORDING, label, (robot, correlation), (truth, commands))?;
        // The answer depends on the model, the recording and the options alone.
        let label = self.label(&format!("discovery in case {case}"));
        let params = || (benchmark.model.clone(), run.options.clone());
        let answer = self.graph.stage(&DISCOVER, label, params(), recording)?;
        let label = self.label(&format!("methods of comparison in case {case}"));
        let baselines = self.graph.stage(&BASELINES, label, params(), recording)?;
        let label = self.label(&format!("score of case {case}"));
        let params =
            ScoreParams { case, batch: batch.clone(), correlation, model: benchmark.model.clone() };
        let score = self.graph.stage(&SCORE, label, params, (truth, answer, baselines))?;
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
        let explore = ExploreOptions {
            points: batch.samples,
            trajectories: batch.trials,
            ..self.spec.explore
        };
        let judged = batch.group.judged();
        let seed = if judged {
            let shared = number / benchmark.run.oracle.cases_per_commands;
            self.seed.child("blind_judged").index(batch.samples as u64).index(shared as u64)
        } else {
            self.seed.child("blind").index(case).child("commands")
        };
        let params = CommandParams {
            model: benchmark.quick.clone(),
            explore,
            step_s: self.step_s(),
            seed: seed.0,
        };
        let commands = self.graph.stage(&COMMANDS, self.label("blind commands"), params, ())?;
        if !judged {
            return Ok((commands, None));
        }
        let (model, priors, noise_m) =
            (benchmark.quick.clone(), benchmark.priors.clone(), batch.noise_m);
        let params = SpanParams { model, priors, noise_m };
        let span =
            self.graph.stage(&SPAN, self.label("span of the catalogue"), params, commands)?;
        Ok((commands, Some(span)))
    }
}

fn prior(uncertainty: &crate::discovery::Uncertainty) -> Prior {
    Prior {
        effect: uncertainty.effect.clone(),
        parameter: uncertainty.parameter.clone(),
        deviation: uncertainty.deviation,
    }
}
