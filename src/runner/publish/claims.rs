//! The paper's claims against the rows: reproduced, not reproduced or undecided.
//!
//! A relation gives one number per seed and the range in which the claim holds. The 95 % interval
//! of the number's mean over seeds (Student's t; seeds are independent repetitions of the whole
//! experiment, and numbers that compare two cells are differences within a seed, so that what the
//! cells share cancels) decides: inside the range it is reproduced, outside it is not, across its
//! border or from too few seeds it is undecided.

use super::metrics::{Tables, value};
use crate::math::distribution::wilson_95;
use crate::math::summary::{interval_95, mean};
use crate::rows::experiment::ClaimRow;
use crate::rows::population::RobotClaimRow;
use crate::runner::campaign::ANY_TRAINING;
use crate::specs::{ClaimMetric, PaperClaim, Relation};

/// Seeds below which no claim is decided.
pub const SEEDS_NEEDED: usize = 10;

/// Evaluates the claims of an experiment over these seeds, once per kind of training where networks
/// take part.
pub fn evaluate(
    experiment: &str,
    claims: &[PaperClaim],
    tables: &Tables,
    seeds: &[u64],
    trainings: &[String],
) -> Vec<ClaimRow> {
    let judge = |claim, training: &str| judge(experiment, claim, tables, seeds, training);
    let mut rows = Vec::new();
    for claim in claims {
        let depends = |metric: &ClaimMetric| {
            metric.depends_on_training() || depends_on_simulating_network(metric, tables)
        };
        if claim.relation.metrics().iter().any(depends) {
            rows.extend(trainings.iter().map(|training| judge(claim, training)));
        } else {
            rows.push(judge(claim, ANY_TRAINING));
        }
    }
    rows
}

/// Gaussian processes depend on the training when p_sim comes from the forward network.
fn depends_on_simulating_network(metric: &ClaimMetric, tables: &Tables) -> bool {
    matches!(metric, ClaimMetric::GpError { .. })
        && tables.published.gps.iter().any(|row| row.training != ANY_TRAINING)
}

/// On how many robots each claim holds, where every seed has a robot of its own.
pub(crate) fn per_robot(
    claims: &[PaperClaim],
    tables: &Tables,
    seeds: &[u64],
    trainings: &[String],
) -> Vec<RobotClaimRow> {
    let row = |claim: &PaperClaim, training: &String| {
        let [from, to] = accepted_range(&claim.relation);
        let values: Vec<f64> = seeds
            .iter()
            .filter_map(|&seed| seed_value(&claim.relation, tables, seed, training))
            .collect();
        let holding = values.iter().filter(|seed_value| (from..to).contains(*seed_value)).count();
        let [low_95, high_95] = wilson_95(holding as u64, values.len() as u64);
        RobotClaimRow {
            claim: claim.claim.clone(),
            statement: claim.statement.clone(),
            training: training.clone(),
            robots: values.len() as u64,
            held: holding as u64,
            share: holding as f64 / values.len() as f64,
            low_95,
            high_95,
        }
    };
    trainings
        .iter()
        .flat_map(|training| claims.iter().map(move |claim| row(claim, training)))
        .collect()
}

fn judge(
    experiment: &str,
    claim: &PaperClaim,
    tables: &Tables,
    seeds: &[u64],
    training: &str,
) -> ClaimRow {
    let values: Vec<f64> = seeds
        .iter()
        .filter_map(|&seed| seed_value(&claim.relation, tables, seed, training))
        .collect();
    let interval = interval_95(&values);
    let [low_95, high_95] = interval.unwrap_or([f64::NAN; 2]);
    let decided = interval.filter(|_| values.len() >= SEEDS_NEEDED);
    let range = accepted_range(&claim.relation);
    let [holds_above, holds_below] =
        range.map(|limit| if limit.is_finite() { limit } else { f64::NAN });
    ClaimRow {
        experiment: experiment.to_owned(),
        claim: claim.claim.clone(),
        statement: claim.statement.clone(),
        quantity: claim.relation.quantity(),
        training: training.to_owned(),
        holds_above,
        holds_below,
        paper: claim.paper.unwrap_or(f64::NAN),
        ours: mean(&values),
        low_95,
        high_95,
        unit: unit(&claim.relation),
        seeds: values.len() as u64,
        verdict: decided.map_or("undecided", |interval| verdict(interval, range)).to_owned(),
    }
}

/// The interval against the open range in which the claim holds.
fn verdict([low, high]: [f64; 2], [from, to]: [f64; 2]) -> &'static str {
    if low > from && high < to {
        "reproduced"
    } else if high <= from || low >= to {
        "not reproduced"
    } else {
        "undecided"
    }
}

/// The range of the number in which the claim holds.
fn accepted_range(relation: &Relation) -> [f64; 2] {
    match relation {
        Relation::Less { .. } | Relation::Falls { .. } | Relation::Alike { .. } => {
            [f64::NEG_INFINITY, 0.0]
        }
        Relation::Between { low, high, .. } => [*low, *high],
        Relation::Near { figure, tolerance, .. } => [figure - tolerance, figure + tolerance],
        Relation::NoGain { margin, .. } => [-margin, f64::INFINITY],
    }
}

/// The number of a relation for one seed; `None` when a metric is missing.
fn seed_value(relation: &Relation, tables: &Tables, seed: u64, training: &str) -> Option<f64> {
    let values =
        relation.metrics().into_iter().map(|metric| value(tables, &metric, seed, training));
    let values = values.collect::<Option<Vec<f64>>>()?;
    match relation {
        Relation::Less { times, .. } => Some(values.first()? - times * values.get(1)?),
        Relation::Between { .. } | Relation::Near { .. } => values.first().copied(),
        Relation::Falls { values: sizes, .. } => slope_per_decade(sizes, &values),
        Relation::NoGain { .. } => values.split_first().map(|(from, beyond)| mean(beyond) - from),
        Relation::Alike { times, .. } => {
            let largest = values.iter().copied().reduce(f64::max)?;
            let smallest = values.iter().copied().reduce(f64::min)?;
            Some(largest - times * smallest)
        }
    }
}

/// Least-squares slope of `values` over the decimal logarithm of `sizes`.
#[allow(clippy::cast_precision_loss)]
fn slope_per_decade(sizes: &[u64], values: &[f64]) -> Option<f64> {
    let decades: Vec<f64> = sizes.iter().map(|&size| (size as f64).log10()).collect();
    let (centre, level) = (mean(&decades), mean(values));
    let covariance: f64 = decades.iter().zip(values).map(|(x, y)| (x - centre) * (y - level)).sum();
    let variance: f64 = decades.iter().map(|x| (x - centre).powi(2)).sum();
    let slope = covariance / variance;
    slope.is_finite().then_some(slope)
}

fn unit(relation: &Relation) -> String {
    let unit = relation.metrics().first().map_or("", ClaimMetric::unit);
    if matches!(relation, Relation::Falls { .. }) {
        format!("{unit}/decade")
    } else {
        unit.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Published;
    use crate::rows::experiment::{GpRow, GpScore};

    fn gps(errors: &[f64]) -> Tables {
        let row = |(seed, &error): (usize, &f64)| GpRow {
            seed: seed as u64,
            training: "any".into(),
            score: GpScore {
                points: 100,
                kernel: "se_ard".into(),
                cross_validation_mae_m: error,
                log_marginal_likelihood: 0.0,
                noise_x_m: 0.0,
                at_range_end: String::new(),
                noise_y_m: 0.0,
                noise_z_m: 0.0,
            },
        };
        Tables::from(Published {
            gps: errors.iter().enumerate().map(row).collect(),
            ..Published::default()
        })
    }

    fn near(figure: f64, errors: &[f64]) -> ClaimRow {
        let relation =
            Relation::Near { metric: ClaimMetric::GpError { points: 100 }, figure, tolerance: 0.5 };
        let claim = PaperClaim {
            claim: "gp".into(),
            statement: "gp".into(),
            paper: Some(figure),
            relation,
        };
        let seeds: Vec<u64> = (0..errors.len() as u64).collect();
        evaluate("table1", &[claim], &gps(errors), &seeds, &["paper".into()]).remove(0)
    }

    #[test]
    fn the_interval_decides() {
        let spread = |centre: f64| -> Vec<f64> {
            (0..10).map(|k| centre + 0.1 * f64::from(k % 3 - 1)).collect()
        };
        assert_eq!(near(2.0, &spread(2.0)).verdict, "reproduced");
        assert_eq!(near(2.0, &spread(3.0)).verdict, "not reproduced");
        assert_eq!(near(2.0, &spread(2.5)).verdict, "undecided");
        let few = near(2.0, &spread(2.0)[..9]);
        assert_eq!((few.verdict.as_str(), few.seeds), ("undecided", 9));
        assert_eq!(near(2.0, &spread(2.0)).training, "any");
    }

    #[test]
    fn a_seed_without_a_value_is_not_counted() {
        let mut errors = vec![2.0; 11];
        errors[3] = f64::NAN;
        assert_eq!(near(2.0, &errors).seeds, 10);
    }

    #[test]
    fn slopes_are_per_tenfold_data() {
        let slope = slope_per_decade(&[10, 100, 1000], &[5.0, 3.0, 1.0]).unwrap();
        assert!((slope + 2.0).abs() < 1e-12);
        assert_eq!(slope_per_decade(&[10, 10], &[1.0, 2.0]), None);
    }
}
