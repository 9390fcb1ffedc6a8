//! Which of many predefined points are measured: the sparse choice of the paper (section IV-B) and
//! others. A rule is one file and one line of `selections!`. No rule sees outputs: they are not
//! measured yet.

use serde::{Deserialize, Serialize};

use super::{LearnError, Standardiser};
use crate::base::{Rows, Seed};

macro_rules! selections {
    ($($(#[$doc:meta])* $name:ident = $module:ident),* $(,)?) => {
        $(mod $module;)*

        /// A rule by which points are chosen.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum Selection {
            $($(#[$doc])* $name),*
        }

        impl Selection {
            /// Every rule.
            pub const ALL: &[Selection] = &[$(Selection::$name),*];

            fn rule(self) -> fn(&Rows, usize, Seed) -> Vec<usize> {
                match self { $(Selection::$name => $module::choose),* }
            }
        }
    };
}

selections! {
    /// The paper's: clusters of consecutive points, one drawn from each.
    #[default]
    Clusters = clusters,
    /// Drawn evenly from all.
    Random = random,
    /// Each farthest from the preceding points.
    FarthestPoint = farthest_point,
    /// Nearest to the centres of k-means.
    KMeans = k_means,
    /// Each at the largest variance of a Gaussian process of the preceding points.
    GreatestVariance = greatest_variance,
    /// Each at the largest variance of a quadratic fit to the preceding points.
    DOptimal = d_optimal,
}

impl Selection {
    /// Numbers (from 0, rising) of `count` of the rows of `inputs`. Distances count in standard
    /// deviations of each column.
    ///
    /// # Errors
    /// [`LearnError::TooFewRows`] when more are asked for than there are, [`LearnError::Setting`]
    /// for none.
    pub fn choose(self, inputs: &Rows, count: usize, seed: Seed) -> Result<Vec<usize>, LearnError> {
        LearnError::unless_setting(count > 0, "gp_points", count, "at least 1 point")?;
        if count > inputs.len() {
            let why = "points to choose from";
            return Err(LearnError::TooFewRows { found: inputs.len(), needed: count, why });
        }
        let all: Vec<usize> = (0..inputs.len()).collect();
        let scale = Standardiser::fit(inputs, &all);
        let mut standardised = Rows::new(inputs.width());
        for row in inputs.iter() {
            let row: Vec<f64> = row.iter().enumerate().map(|(d, x)| scale.apply(d, *x)).collect();
            standardised.push(&row);
        }
        let mut chosen = self.rule()(&standardised, count, seed);
        // The rows of a recording stay in their order.
        chosen.sort_unstable();
        Ok(chosen)
    }
}

/// Squared distance of two points.
fn squared_distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// The number of the largest value; the first of equal ones.
fn largest(values: &[f64]) -> usize {
    (1..values.len()).fold(0, |best, i| if values[i] > values[best] { i } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A serpentine of 12 × 10 points.
    fn grid() -> Rows {
        let mut rows = Rows::new(2);
        for i in 0..12 {
            (0..10)
                .map(|j| if i % 2 == 0 { j } else { 9 - j })
                .for_each(|j| rows.push(&[f64::from(i), f64::from(j)]));
        }
        rows
    }

    /// Largest distance of a point from the nearest chosen one.
    fn gap(rows: &Rows, chosen: &[usize]) -> f64 {
        let nearest = |row: &[f64]| {
            chosen
                .iter()
                .map(|&i| squared_distance(row, rows.row(i)))
                .fold(f64::INFINITY, f64::min)
                .sqrt()
        };
        rows.iter().map(nearest).fold(0.0, f64::max)
    }

    #[test]
    fn every_rule_chooses_as_many_distinct_points_as_asked() {
        let rows = grid();
        for &rule in Selection::ALL {
            for count in [1, 2, 17, 119, 120] {
                let chosen = rule.choose(&rows, count, Seed(3)).unwrap();
                assert_eq!(chosen.len(), count, "{rule:?}");
                assert!(
                    chosen.windows(2).all(|pair| pair[0] < pair[1]) && chosen[count - 1] < 120,
                    "{rule:?}"
                );
                assert_eq!(
                    chosen,
                    rule.choose(&rows, count, Seed(3)).unwrap(),
                    "{rule:?} is repeatable"
                );
            }
            assert!(
                rule.choose(&rows, 0, Seed(3)).is_err()
                    && rule.choose(&rows, 121, Seed(3)).is_err()
            );
        }
    }

    #[test]
    fn points_that_coincide_are_no_trouble() {
        let mut rows = Rows::new(2);
        (0..30).for_each(|i| rows.push(&[f64::from(i % 3), 1.0]));
        for &rule in Selection::ALL {
            assert_eq!(rule.choose(&rows, 20, Seed(3)).unwrap().len(), 20, "{rule:?}");
        }
    }

    #[test]
    fn rules_that_spread_points_leave_smaller_gaps_than_chance() {
        let rows = grid();
        let of = |rule: Selection| gap(&rows, &rule.choose(&rows, 15, Seed(3)).unwrap());
        let by_chance: f64 = (0..20)
            .map(|seed| gap(&rows, &Selection::Random.choose(&rows, 15, Seed(seed)).unwrap()))
            .sum::<f64>()
            / 20.0;
        for rule in [Selection::FarthestPoint, Selection::KMeans, Selection::GreatestVariance] {
            assert!(of(rule) < 0.8 * by_chance, "{rule:?}: {} by chance {by_chance}", of(rule));
        }
    }

    #[test]
    fn an_optimal_design_for_a_quadratic_holds_corners_and_centre() {
        let mut rows = Rows::new(2);
        (0..25).for_each(|i| rows.push(&[f64::from(i % 5), f64::from(i / 5)]));
        let chosen = Selection::DOptimal.choose(&rows, 9, Seed(0)).unwrap();
        assert!([0, 4, 20, 24].iter().all(|corner| chosen.contains(corner)), "{chosen:?}");
    }
}
