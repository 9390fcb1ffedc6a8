//! Friction of tendons in their guides: the tension falls along the path.
//!
//! Capstan equation (Euler–Eytelwein): where a tendon slides towards its drive, the tension at arc
//! length s is τ exp(−μ Θ(s)), with τ at the drive and Θ the angle by which the path has turned
//! since the base; where it slides the other way, τ exp(+μ Θ). Between the two the friction is
//! mobilised by a share from −1 to 1, which the drive's displacement changes in proportion until
//! the tendon slips (Dahl 1968 without rounding). A tendon that is held by its tension slips once
//! the tension has changed by the factor that carries the tip over the dead band.

use nalgebra::Vector3;

use super::boundary_conditions::{SolveConditions, TendonConstraint};
use super::system::{RodEquations, Workspace};
use crate::rod::params::tendon::Tendon;

/// Friction of one tendon at one instant, and what decides how it changes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct TendonSliding {
    /// Mobilised share of the friction: 1 where the tendon slides towards its drive, −1 where it
    /// slides away.
    pub(crate) share: f64,
    /// Displacement of the drive, metres, pretension included.
    pull_m: f64,
    /// Tension at the drive, N.
    tension_n: f64,
}

/// A tendon as the solver has it.
struct PulledTendon {
    /// Tension at the drive, N.
    tension_n: f64,
    /// Angle by which the whole path turns, radians.
    turn_rad: f64,
    /// How much shorter the path is than at home, metres.
    shortening_m: f64,
}

/// Tension below which a tendon under a prescribed tension carries no friction, N.
const MIN_TENSION_N: f64 = 1e-9;

impl TendonSliding {
    /// At home, before the tendon has slid.
    pub(crate) fn at_home(tendon: &Tendon) -> TendonSliding {
        TendonSliding { share: 0.0, pull_m: tendon.pretension_m, tension_n: 0.0 }
    }

    /// After the drive has gone to `constraint`, with the tendon as it is `now`.
    fn moved(
        self,
        tendon: &Tendon,
        constraint: &TendonConstraint,
        now: PulledTendon,
    ) -> TendonSliding {
        let PulledTendon { tension_n, turn_rad, shortening_m } = now;
        match *constraint {
            TendonConstraint::Length(pull_m) => {
                // Dahl's law without rounding: a straight line up to the slip.
                let change = (pull_m - self.pull_m) / tendon.presliding_m;
                TendonSliding { share: (self.share + change).clamp(-1.0, 1.0), pull_m, tension_n }
            }
            TendonConstraint::Tension(tension_n) => {
                // This change holds the tension at the tip while the tendon sticks.
                let ratio = (tension_n.max(MIN_TENSION_N) / self.tension_n.max(MIN_TENSION_N)).ln();
                let change =
                    ratio / (tendon.friction_coefficient * turn_rad).max(f64::MIN_POSITIVE);
                // Its drive follows the path, so the path's shortening is where it stands.
                TendonSliding {
                    share: (self.share + change).clamp(-1.0, 1.0),
                    pull_m: shortening_m,
                    tension_n,
                }
            }
        }
    }
}

impl RodEquations {
    /// All tendons at home, before they have slid.
    pub(crate) fn tendons_at_home(&self) -> Vec<TendonSliding> {
        self.params.tendons.iter().map(TendonSliding::at_home).collect()
    }

    /// Updates, for the shape and tendon paths in `workspace`, the tension at every Gauss point as
    /// a share of that at the drive.
    pub(crate) fn update_tension_shares(
        &self,
        tensions_n: &[f64],
        conditions: &SolveConditions,
        workspace: &mut Workspace,
    ) {
        for (i, tendon) in
            self.params.tendons.iter().enumerate().filter(|(_, tendon)| tendon.has_friction())
        {
            let turn_rad = self.turn_along(i, workspace);
            let shortening_m = self.home_lengths_m[i] - workspace.lengths_m[i];
            let now = PulledTendon { tension_n: tensions_n[i], turn_rad, shortening_m };
            let sliding = conditions.sliding[i].moved(tendon, &conditions.constraints[i], now);
            workspace.sliding[i] = sliding;
            // Capstan: the exponent grows with the turned angle, which stands in `share` until
            // here.
            let exponent = -tendon.friction_coefficient * sliding.share;
            let shares =
                workspace.tension_shares.iter_mut().skip(i).step_by(self.params.tendons.len());
            shares.for_each(|share| *share = (exponent * *share).exp());
        }
    }

    /// Writes the angle by which the path of tendon `i` has turned since its start, radians, into
    /// the tension shares of the Gauss points; returns the whole angle.
    fn turn_along(&self, i: usize, workspace: &mut Workspace) -> f64 {
        let count = self.params.tendons.len();
        let Workspace { shape, tangents, tension_shares, .. } = workspace;
        let (mut turned_rad, mut last): (f64, Option<Vector3<f64>>) = (0.0, None);
        for g in 0..self.grid.nodes.len() {
            let (guide, k) = (&self.guides[g * count + i], g * count + i);
            if guide.present {
                let direction = shape.node_r[g] * tangents[k];
                let before = last.unwrap_or_else(|| {
                    let [x, y] = guide.slope;
                    if self.params.tendons[i].start_m > 0.0 {
                        direction
                    } else {
                        shape.end_r[0] * Vector3::new(x, y, 1.0).normalize()
                    }
                });
                // Angle between two unit vectors, accurate where it is small.
                turned_rad += 2.0 * (0.5 * (direction - before).norm()).min(1.0).asin();
                last = Some(direction);
            }
            tension_shares[k] = turned_rad;
        }
        turned_rad
    }
}
