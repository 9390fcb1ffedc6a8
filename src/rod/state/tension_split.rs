//! How tendons share their pull where rigid ones leave that undetermined.
//!
//! Rigid tendons whose wrenches are linearly dependent have a family of tensions for the same
//! shape; the active set gives one with as few taut tendons as possible. The member of least norm
//! is that of equal tendons that stretch a little.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::rod::Rod;

/// A tendon with less slack counts as taut, metres.
const TIGHT_M: f64 = 2e-5;
/// Eigenvalues below this share of the largest belong to dependent wrenches.
const DEPENDENT: f64 = 1e-4;
/// Upper bound on projections.
const PROJECTIONS: usize = 500;
/// Tensions that differ by less are equal, N.
const SAME_N: f64 = 1e-3;

/// Tensions of the present equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub struct TensionSplit {
    /// The non-negative tensions of least norm for this shape, N.
    pub tensions_n: Vec<f64>,
    /// The tendons that are shorter than their drives allow.
    pub slack: Vec<bool>,
    /// Whether there are no others.
    pub is_determined: bool,
}

impl Rod {
    /// The tensions under drives at these displacements.
    pub fn tension_split(&self, pulls_m: &[f64]) -> TensionSplit {
        let mut tensions_n = self.tensions_n().to_vec();
        let room_m =
            self.following_pulls_m().into_iter().zip(pulls_m).map(|(now, pull)| now - pull);
        let slack: Vec<bool> = room_m
            .zip(&tensions_n)
            .map(|(room_m, tension)| *tension <= 0.0 && room_m > TIGHT_M)
            .collect();
        let tendons = &self.system.params.tendons;
        let rigid: Vec<usize> = (0..slack.len())
            .filter(|&i| !slack[i] && tendons[i].compliance_m_per_n == 0.0)
            .collect();
        let given = DVector::from_iterator(rigid.len(), rigid.iter().map(|&i| tensions_n[i]));
        let least = least_norm(&given, &self.dependence(&rigid));
        let is_determined = (&least - &given).amax() < SAME_N;
        if !is_determined {
            rigid.iter().zip(least.iter()).for_each(|(&i, tension)| tensions_n[i] = *tension);
        }
        TensionSplit { tensions_n, slack, is_determined }
    }

    /// The projection onto changes of the tensions of these tendons that change no wrench.
    fn dependence(&self, rigid: &[usize]) -> DMatrix<f64> {
        let (system, workspace) = (&self.system, &self.solver.workspace);
        let count = system.params.tendons.len();
        let offsets_m =
            system.guides.iter().map(|guide| guide.offset_m[0].hypot(guide.offset_m[1]));
        let arm_m = offsets_m.fold(0.0, f64::max);
        let mut gram = DMatrix::zeros(rigid.len(), rigid.len());
        if rigid.is_empty() || arm_m == 0.0 {
            return gram;
        }
        for (g, node) in system.grid.nodes.iter().enumerate() {
            let wrenches: Vec<[f64; 6]> = rigid
                .iter()
                .map(|&i| {
                    let share = workspace.tension_shares[g * count + i];
                    let [a, b, c, x, y, z] = system.tendon_wrench(g, i, workspace);
                    [a / arm_m, b / arm_m, c / arm_m, x, y, z].map(|part| share * part)
                })
                .collect();
            for (i, one) in wrenches.iter().enumerate() {
                for (j, other) in wrenches.iter().enumerate() {
                    let product: f64 = one.iter().zip(other).map(|(x, y)| x * y).sum();
                    gram[(i, j)] += node.weight_m * product;
                }
            }
        }
        let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(gram);
        let largest = eigenvalues.max();
        let mut projection = DMatrix::zeros(rigid.len(), rigid.len());
        for (value, vector) in eigenvalues.iter().zip(eigenvectors.column_iter()) {
            if *value < DEPENDENT * largest {
                projection += vector * vector.transpose();
            }
        }
        projection
    }
}

/// The point of least norm without negative parts that differs from `given` by what `projection`
/// keeps: Dykstra's alternating projections.
fn least_norm(given: &DVector<f64>, projection: &DMatrix<f64>) -> DVector<f64> {
    let mut point = DVector::zeros(given.len());
    let mut correction = DVector::zeros(given.len());
    for _ in 0..PROJECTIONS {
        let inside = given + projection * (&point - given);
        let next = (&inside + &correction).map(|part: f64| part.max(0.0));
        correction += inside - &next;
        let moved = (&next - &point).amax();
        point = next;
        if moved < 1e-9 {
            break;
        }
    }
    point
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_norm_shares_a_common_pull_and_stays_non_negative() {
        let dependent = DVector::from_vec(vec![0.5, -0.5, 0.5, -0.5]);
        let projection = &dependent * dependent.transpose();
        let shared = least_norm(&DVector::from_vec(vec![6.0, 0.0, 5.0, 0.0]), &projection);
        let expected = DVector::from_vec(vec![3.25, 2.75, 2.25, 2.75]);
        assert!((shared - expected).amax() < 1e-6);
        let bent = least_norm(&DVector::from_vec(vec![4.0, 0.0, 0.0, 0.0]), &projection);
        assert!((&bent - DVector::from_vec(vec![4.0, 0.0, 0.0, 0.0])).amax() < 1e-6, "{bent}");
    }
}
