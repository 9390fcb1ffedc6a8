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
use super::variation::ShapeVariation;
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

/// Change of direction between two Gauss points below which it has no derivative, radians.
const STRAIGHT_RAD: f64 = 1e-9;

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
            let exponent = self.friction_rate(i, workspace);
            let shares =
                workspace.tension_shares.iter_mut().skip(i).step_by(self.params.tendons.len());
            shares.for_each(|share| *share = (exponent * *share).exp());
        }
    }

    /// By what share the tension of tendon `i` changes where its path turns by a radian more.
    pub(crate) fn friction_rate(&self, i: usize, workspace: &Workspace) -> f64 {
        -self.params.tendons[i].friction_coefficient * workspace.sliding[i].share
    }

    /// Writes the angle by which the path of tendon `i` has turned since its start, radians, into
    /// the tension shares of the Gauss points; returns the whole angle.
    fn turn_along(&self, i: usize, workspace: &mut Workspace) -> f64 {
        let count = self.params.tendons.len();
        let (mut turned_rad, mut last): (f64, Option<Vector3<f64>>) = (0.0, None);
        for g in 0..self.grid.nodes.len() {
            let k = g * count + i;
            if self.guides[k].present {
                let direction = workspace.shape.node_r[g] * workspace.tangents[k];
                let before =
                    last.or_else(|| self.direction_at_base(i, g, workspace)).unwrap_or(direction);
                // Angle between two unit vectors, accurate where it is small.
                turned_rad += 2.0 * (0.5 * (direction - before).norm()).min(1.0).asin();
                last = Some(direction);
            }
            workspace.tension_shares[k] = turned_rad;
        }
        turned_rad
    }

    /// Derivative, over the unknowns, of the angle by which the path of tendon `i` has turned from
    /// its start to each Gauss point, in `rows` (zeros before).
    pub(crate) fn turn_derivative(
        &self,
        i: usize,
        workspace: &Workspace,
        variation: &ShapeVariation,
        rows: &mut [Vec<f64>],
    ) {
        let count = self.params.tendons.len();
        let direction = |g: usize| workspace.shape.node_r[g] * workspace.tangents[g * count + i];
        let mut last: Option<usize> = None;
        for g in (0..self.grid.nodes.len()).filter(|&g| self.guides[g * count + i].present) {
            let before = match last {
                Some(last) => {
                    let (done, rest) = rows.split_at_mut(g);
                    rest[0].copy_from_slice(&done[last]);
                    Some(direction(last))
                }
                None => self.direction_at_base(i, g, workspace),
            };
            let change = direction(g) - before.unwrap_or_else(|| direction(g));
            let chord = change.norm();
            if chord > STRAIGHT_RAD {
                // d 2 asin(|c|/2) = c · dc / (|c| √(1 − |c|²/4)).
                let along = change / (chord * (1.0 - 0.25 * chord * chord).max(1e-6).sqrt());
                self.add_direction_change((g, i), &along, (workspace, variation), &mut rows[g]);
                if let Some(last) = last {
                    let back = -along;
                    self.add_direction_change(
                        (last, i),
                        &back,
                        (workspace, variation),
                        &mut rows[g],
                    );
                }
            }
            last = Some(g);
        }
    }

    /// Adds the derivative of `along` · direction of the path of tendon `i` at Gauss point `g`.
    fn add_direction_change(
        &self,
        (g, i): (usize, usize),
        along: &Vector3<f64>,
        (workspace, variation): (&Workspace, &ShapeVariation),
        row: &mut [f64],
    ) {
        let (node, k) = (&self.grid.nodes[g], g * self.params.tendons.len() + i);
        let (r, t) = (&workspace.shape.node_r[g], &workspace.tangents[k]);
        // The path turns with the cross-section: along · (δθ × d) = δθ · (d × along) …
        let turn = (r * t).cross(along);
        let [x, y, z] = variation.node_turn[g].rows();
        for (slot, ((x, y), z)) in row.iter_mut().zip(x.iter().zip(y).zip(z)) {
            *slot += turn.x * x + turn.y * y + turn.z * z;
        }
        // … and within it as the strain moves the guide: (1 − t tᵀ) δpath / stretch.
        let body = r.tr_mul(along);
        let across = (body - t * t.dot(&body)) / workspace.stretches[k];
        let [x, y] = self.guides[k].offset_m;
        let by_strain = [
            across.z * y,
            -across.z * x,
            across.y * x - across.x * y,
            across.x,
            across.y,
            across.z,
        ];
        let by_wrench = workspace.shape.compliance[g].apply(&by_strain);
        for (c, value) in by_wrench.iter().enumerate() {
            let columns = node.offset[c]..node.offset[c] + self.grid.modes[c];
            for (slot, basis) in row[columns].iter_mut().zip(&node.basis) {
                *slot += value * basis;
            }
        }
    }

    /// Direction of the path of tendon `i` where it enters the rod, before its first Gauss point
    /// `g`; none where it leaves its sheath further out.
    fn direction_at_base(&self, i: usize, g: usize, workspace: &Workspace) -> Option<Vector3<f64>> {
        let [x, y] = self.guides[g * self.params.tendons.len() + i].slope;
        (self.params.tendons[i].start_m <= 0.0)
            .then(|| workspace.shape.end_r[0] * Vector3::new(x, y, 1.0).normalize())
    }
}
