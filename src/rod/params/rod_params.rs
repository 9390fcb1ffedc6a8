//! Parameters of one rod.

use std::sync::Arc;

use nalgebra::Vector3;

use super::contact::ContactSurface;
use super::hysteresis_law::MomentLaw;
use super::loads::{LineLoad, PointLoad, TipWrench};
use super::resolution::Resolution;
use super::span::{Span, Taper};
use super::spine::{CompressibleSection, PointMass};
use super::tendon::Tendon;

/// Parameters of one robot for the solver.
#[derive(Clone, Debug)]
pub struct RodParams {
    /// Cross-sections from base to tip; the last one ends at the tip.
    pub spans: Vec<Span>,
    /// Compressible sections, disjoint and in order.
    pub sections: Vec<CompressibleSection>,
    /// Lumped masses.
    pub masses: Vec<PointMass>,
    /// Tendons.
    pub tendons: Vec<Tendon>,
    /// Acceleration of gravity in the world frame, m/s².
    pub gravity_m_s2: Vector3<f64>,
    /// Base position in the world frame, metres.
    pub base_m: Vector3<f64>,
    /// Base orientation in the world frame as a rotation vector, radians.
    pub base_rotation_rad: Vector3<f64>,
    /// Viscous damping over stiffness of every strain (Kelvin–Voigt), s.
    pub damping_time_s: f64,
    /// Quadratic drag per length on each body axis, N s²/m³ (Till et al. 2019, eq. 5).
    pub drag_n_s2_m3: f64,
    /// Load at the tip.
    pub tip_load: TipWrench,
    /// Constant loads at other places.
    pub point_loads: Vec<PointLoad>,
    /// Constant loads over part of the rod.
    pub line_loads: Vec<LineLoad>,
    /// Obstacles, and the surface that touches them.
    pub contact: ContactSurface,
    /// History-dependent moment laws.
    pub moment_laws: Vec<Arc<dyn MomentLaw>>,
    /// Duration of the first rest after a restart, s; infinite: rate-dependent laws relax.
    pub rested_s: f64,
    /// Numerical resolution.
    pub resolution: Resolution,
}

/// Ends of tendons that are nearer than this share of the length are one.
const SAME_END: f64 = 1e-6;

impl RodParams {
    /// Relaxed length of the rod, metres.
    pub fn length_m(&self) -> f64 {
        self.spans.last().map_or(0.0, |span| span.end_m)
    }

    /// Where segment `number` (from 1 at the base) begins and ends, metres from the base: it ends
    /// where some tendons do, the last one at the tip. 0 is the whole rod.
    pub fn segment_m(&self, number: usize) -> [f64; 2] {
        let length_m = self.length_m();
        let mut ends_m: Vec<f64> = self.tendons.iter().map(|tendon| tendon.end_m).collect();
        ends_m.sort_by(f64::total_cmp);
        ends_m.dedup_by(|a, b| *a - *b < SAME_END * length_m);
        let end_m = |number: usize| ends_m.get(number - 1).copied().unwrap_or(length_m);
        match number {
            0 => [0.0, length_m],
            1 => [0.0, if ends_m.len() > 1 { end_m(1) } else { length_m }],
            _ => [end_m(number - 1), if number < ends_m.len() { end_m(number) } else { length_m }],
        }
    }

    /// The cross-section `position_m` from the base: a span that starts there.
    pub fn span_at(&self, position_m: f64) -> Span {
        let last = self.spans.len() - 1;
        let index = self.spans.iter().position(|span| position_m < span.end_m).unwrap_or(last);
        self.spans[index].from(self.start_of_span_m(index), position_m)
    }

    /// Where span `index` begins, metres from the base.
    pub fn start_of_span_m(&self, index: usize) -> f64 {
        if index == 0 { 0.0 } else { self.spans[index - 1].end_m }
    }

    /// Splits the spans so that one ends at `position_m`; effects that change part of the rod begin
    /// with this.
    pub fn split_at(&mut self, position_m: f64) {
        let Some(index) = self.spans.iter().position(|span| position_m < span.end_m) else {
            return;
        };
        let start_m = self.start_of_span_m(index);
        // Already an end: nothing to split.
        if position_m > start_m {
            let span = &self.spans[index];
            let second = span.from(start_m, position_m);
            let up_to_split = |[from, _]: [f64; 2], [to, _]: [f64; 2]| [from, to];
            let taper = Taper {
                outer: up_to_split(span.taper.outer, second.taper.outer),
                inner: up_to_split(span.taper.inner, second.taper.inner),
            };
            let first = Span { end_m: position_m, taper, ..span.clone() };
            self.spans[index] = second;
            self.spans.insert(index, first);
        }
    }

    /// The spans between `start_m` and `end_m`, split where they cross those places.
    pub fn spans_between(&mut self, start_m: f64, end_m: f64) -> impl Iterator<Item = &mut Span> {
        self.split_at(start_m);
        self.split_at(end_m);
        let first =
            self.spans.iter().position(|span| start_m < span.end_m).unwrap_or(self.spans.len());
        self.spans[first..].iter_mut().take_while(move |span| span.end_m <= end_m)
    }
}
