//! Ranking of protocols by T-optimality (Atkinson & Fedorov, Biometrika 62, 1975): distance between
//! the rivals' predictions after refitting, in standard deviations, per minute.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::protocols::{CommandRange, Protocol, ProtocolTrial, protocols};
use crate::data::findings::Proposal;
use crate::data::tables::round_significant;
use crate::data::{Actuation, Recording};
use crate::discovery::fit::ar1_noise::Ar1Noise;
use crate::discovery::fit::candidate::{SetMember, effect_specs};
use crate::discovery::fit::nuisance::NuisanceColumn;
use crate::discovery::fit::nuisance_priors::UncertainParameters;
use crate::discovery::fit::simulate::{coarse, tips};
use crate::discovery::problem::Problem;
use crate::discovery::recording::samples::{Sample, Samples, TrialCommands};
use crate::effects::Model;

/// A proposed experiment with its commands.
#[derive(Clone, Debug)]
pub struct NextExperiment {
    /// Description and expected separation.
    pub proposal: Proposal,
    /// Commands for `collect`.
    pub commands: Recording,
}

/// Difference step of numerical derivatives, over the probe.
const DIFFERENCE: f64 = 0.1;

/// Significant digits of times.
const TIME_DIGITS: usize = 9;

impl Problem<'_> {
    /// The protocols for telling `rivals` apart, best per minute first; `noise`: measurement noise.
    pub(crate) fn rank_protocols(
        &self,
        rivals: &[Vec<SetMember>],
        noise: &Ar1Noise,
    ) -> Vec<NextExperiment> {
        if rivals.len() < 2 {
            return Vec::new();
        }
        let range =
            CommandRange::new(self.all.trials.iter().map(|trial| &trial.commands), self.all.step_s);
        let mut ranked: Vec<NextExperiment> = protocols(&range, self.model.robot.gravity_m_s2)
            .iter()
            .filter_map(|protocol| self.evaluate(protocol, rivals, noise))
            .collect();
        let rate = |next: &NextExperiment| next.proposal.separation / next.proposal.minutes;
        ranked.sort_by(|a, b| rate(b).total_cmp(&rate(a)));
        for (rank, next) in ranked.iter_mut().enumerate() {
            next.proposal.file = format!("next_{}_{}.csv", rank + 1, next.proposal.name);
        }
        ranked
    }

    fn evaluate(
        &self,
        protocol: &Protocol,
        rivals: &[Vec<SetMember>],
        noise: &Ar1Noise,
    ) -> Option<NextExperiment> {
        let mut model = self.model.clone();
        model.robot.gravity_m_s2 = protocol.gravity_m_s2.unwrap_or(model.robot.gravity_m_s2);
        let samples = self.protocol_samples(protocol);
        // A coarse model is enough for columns that only take off what a calibration would.
        let free = UncertainParameters::new(self.options, &self.candidates, &[], 1.0).columns(
            &coarse(&model),
            &[],
            &samples,
        );
        let simulated_m: Vec<Vec<f64>> = rivals
            .iter()
            .map(|members| tips(&model, &effect_specs(&self.candidates, members)?, &samples))
            .collect::<Option<_>>()?;
        let slopes: Vec<DMatrix<f64>> = rivals
            .iter()
            .zip(&simulated_m)
            .map(|(members, here)| self.slopes(&model, members, &samples, here))
            .collect();
        let mut separation = f64::INFINITY;
        for a in 0..rivals.len() {
            for b in (0..rivals.len()).filter(|&b| b != a) {
                let apart: Vec<f64> =
                    simulated_m[a].iter().zip(&simulated_m[b]).map(|(a, b)| a - b).collect();
                // The hardest pair to tell apart decides, refitted in either direction.
                separation =
                    separation.min(separation_sigma(&samples, noise, &apart, &slopes[b], &free));
            }
        }
        // The last command of each trial is recorded for one more row.
        let rows: usize = protocol.trials.iter().map(|trial| trial.commands.len() + 1).sum();
        let minutes = protocol.setup_min + rows as f64 * protocol.step_s / 60.0;
        let proposal = Proposal {
            name: protocol.name.to_owned(),
            what: protocol.what.clone(),
            minutes,
            separation,
            file: String::new(),
        };
        Some(NextExperiment { proposal, commands: self.protocol_commands(protocol) })
    }

    /// Jacobian of a rival's tip.
    fn slopes(
        &self,
        model: &Model,
        members: &[SetMember],
        samples: &Samples,
        here: &[f64],
    ) -> DMatrix<f64> {
        let mut columns = Vec::new();
        for (k, member) in members.iter().enumerate() {
            let candidate = &self.candidates[member.candidate];
            for parameter in candidate.fitted() {
                let there = [DIFFERENCE, -DIFFERENCE].into_iter().find_map(|share| {
                    let mut moved = members.to_vec();
                    moved[k].values = candidate.moved(
                        &member.values,
                        parameter,
                        share * candidate.probe(parameter),
                    );
                    tips(model, &effect_specs(&self.candidates, &moved)?, samples)
                });
                columns.extend(there.map(|there| {
                    DVector::from_iterator(
                        here.len(),
                        there.iter().zip(here).map(|(there, here)| there - here),
                    )
                }));
            }
        }
        if columns.is_empty() {
            DMatrix::zeros(here.len(), 0)
        } else {
            DMatrix::from_columns(&columns)
        }
    }

    fn protocol_samples(&self, protocol: &Protocol) -> Samples {
        let mut samples =
            Samples { trials: Vec::new(), rows: Vec::new(), clock_deviation_s: None, ..self.all };
        for (trial, ProtocolTrial { commands, load_kg }) in protocol.trials.iter().enumerate() {
            samples.trials.push(TrialCommands {
                number: trial as u64,
                tensions: self.all.trials[0].tensions,
                known_load_kg: *load_kg,
                ..TrialCommands::new(commands.clone(), vec![protocol.step_s; commands.len()])
            });
            let sample = |row: usize| Sample::of_tip(trial, row, row as f64 * protocol.step_s);
            samples.rows.extend((0..=commands.len()).map(sample));
        }
        samples
    }

    fn protocol_commands(&self, protocol: &Protocol) -> Recording {
        let width = protocol.trials[0].commands.width();
        let actuation =
            if self.all.trials[0].tensions { Actuation::Tensions } else { Actuation::Lengths };
        let mut commands = Recording::new(actuation, width);
        let mut loads = Vec::new();
        for (trial, ProtocolTrial { commands: rows, load_kg }) in protocol.trials.iter().enumerate()
        {
            // The last command is held for a step like all others, so its row is repeated.
            for (k, row) in rows.iter().chain(rows.iter().last()).enumerate() {
                commands.trial.push(trial as u64);
                commands.time_s.push(round_significant(k as f64 * protocol.step_s, TIME_DIGITS));
                commands.commands.push(row);
                loads.push(*load_kg);
            }
        }
        commands.known_load_kg = loads.iter().any(|load| *load > 0.0).then_some(loads);
        commands
    }
}

/// Norm of `apart`, in standard deviations, after a fit of the `slopes` and of the `free` columns
/// (with a prior deviation each).
fn separation_sigma(
    samples: &Samples,
    noise: &Ar1Noise,
    apart: &[f64],
    slopes: &DMatrix<f64>,
    free: &[NuisanceColumn],
) -> f64 {
    let white = |values: &[f64]| DVector::from_vec(noise.whiten(samples, values));
    let target = white(apart);
    let mut columns: Vec<DVector<f64>> = free.iter().map(|(column, _)| white(column)).collect();
    columns.extend(slopes.column_iter().map(|column| white(column.as_slice())));
    if columns.is_empty() {
        return target.norm();
    }
    let all = DMatrix::from_columns(&columns);
    let mut normal = all.tr_mul(&all);
    for (k, (_, deviation)) in free.iter().enumerate() {
        normal[(k, k)] += deviation.powi(-2);
    }
    for k in free.len()..columns.len() {
        // Zero columns keep their parameter.
        normal[(k, k)] = normal[(k, k)] * (1.0 + 1e-9) + 1e-12;
    }
    let right = all.tr_mul(&target);
    let explained = Cholesky::new(normal).map_or(0.0, |factor| right.dot(&factor.solve(&right)));
    (target.norm_squared() - explained).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discovery::fit::simulate::circling;
    use crate::discovery::options::Options;

    /// A weight follows gravity and a force does not: remounting the base separates them; other
    /// protocols do so only by inertia.
    #[test]
    fn a_weight_and_a_force_like_it_are_told_apart_by_turning_the_base() {
        let model = Model::default();
        let options = Options::default();
        let problem = Problem::new(&model, circling(&model, &[]), None, &options).unwrap();
        let member = |name: &str, values: Vec<f64>| {
            let candidate =
                problem.candidates.iter().position(|one| one.card.name == name).unwrap();
            vec![SetMember { candidate, values }]
        };
        let force_n = model.robot.gravity_m_s2.map(|g| 0.01 * g).to_vec();
        let rivals = [member("tip_load", vec![0.01]), member("tip_force", force_n)];
        let noise = Ar1Noise { sigma_m: [5e-4; 3], correlation: 0.0 };
        let found = problem.rank_protocols(&rivals, &noise);
        assert_eq!(found.len(), 7);
        let proposals: Vec<&Proposal> = found.iter().map(|next| &next.proposal).collect();
        let rates: Vec<f64> = proposals.iter().map(|one| one.separation / one.minutes).collect();
        assert!(rates.is_sorted_by(|a, b| a >= b), "{rates:?}");
        assert_eq!(proposals[0].file, format!("next_1_{}.csv", proposals[0].name));
        let (turned, others): (Vec<&Proposal>, Vec<&Proposal>) =
            proposals.iter().copied().partition(|one| one.name == "base_remounted");
        let most = others.iter().map(|one| one.separation).fold(0.0, f64::max);
        assert!(turned[0].separation > 4.0 * most, "{proposals:?}");
        // A single rival needs no experiment.
        assert!(problem.rank_protocols(&rivals[..1], &noise).is_empty());
    }
}
