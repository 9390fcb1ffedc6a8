//! How well commands through a response explain the motion of a tip, at one offset of the clocks
//! and at the best.

use nalgebra::{Matrix3, Vector3};

use super::fit_sums::{AXES, FitSums};
use super::step_response::StepResponse;
use crate::base::Point3;

/// Commands as steps in time.
pub(crate) struct CommandSteps {
    /// When each row was, seconds, increasing.
    pub(crate) time_s: Vec<f64>,
    /// Rows of commands, each in force to the next one.
    pub(crate) rows: Vec<Vec<f64>>,
}

/// Parts of the recording that the jackknife leaves out in turn.
pub(super) const BLOCKS: usize = 10;
/// Smallest number of tracked frames.
pub(super) const MIN_FRAMES: usize = 50;
/// Share of the commands that the tracking must cover.
const MIN_COVERED_SHARE: f64 = 0.5;
/// Resolution of the estimate, seconds.
pub(super) const RESOLUTION_S: f64 = 1e-5;
/// Most Newton steps.
const MAX_NEWTON_STEPS: usize = 15;
/// Dampings of a Newton step that are tried in turn, as shares of the diagonal.
const DAMPINGS: [f64; 6] = [0.0, 1e-3, 1e-2, 0.1, 1.0, 10.0];
/// Step of differences, in mean delays for the offset and in logarithms for the response.
const DIFFERENCE_STEP: f64 = 0.02;

/// Deviations and rates of every row and component.
pub(super) type States = [Vec<[f64; 2]>];

/// An offset with its response, and the share of the squares that they leave unexplained.
#[derive(Clone, Copy)]
pub(super) struct OffsetCandidate {
    pub(super) offset_s: f64,
    pub(super) response: StepResponse,
    pub(super) unexplained: f64,
}

/// Tracked tips and commands.
pub(super) struct TipMotion<'a> {
    pub(super) commands: &'a CommandSteps,
    /// Times on the tracker's clock and tips, metres.
    pub(super) frames: Vec<(f64, Point3)>,
    /// Median step of the commands, seconds.
    pub(super) step_s: f64,
}

impl TipMotion<'_> {
    /// Deviation of the response from each command when it comes into force, and its rate,
    /// component by component.
    pub(super) fn states(&self, response: StepResponse) -> Vec<Vec<[f64; 2]>> {
        let CommandSteps { time_s, rows } = self.commands;
        let mut states = vec![vec![[0.0; 2]; rows[0].len()]];
        for row in 1..rows.len() {
            let after = response.after(time_s[row] - time_s[row - 1]);
            let follow = |(k, [deviation, rate]): (usize, &[f64; 2])| {
                let propagated = |[a, b]: [f64; 2]| a * deviation + b * rate;
                [
                    propagated(after.deviation) + rows[row - 1][k] - rows[row][k],
                    propagated(after.rate),
                ]
            };
            states.push(states[row - 1].iter().enumerate().map(follow).collect());
        }
        states
    }

    /// Sums of every block at an offset and a response; none where too little of the commands is
    /// covered.
    pub(super) fn blocks(
        &self,
        offset_s: f64,
        response: StepResponse,
        states: &States,
        blocks: usize,
    ) -> Option<Vec<FitSums>> {
        let CommandSteps { time_s, rows } = self.commands;
        let end_s = time_s[time_s.len() - 1] + self.step_s;
        let width = 1 + rows[0].len() + AXES;
        let mut sums = vec![FitSums::new(width); blocks];
        // Centred features keep the sums of squares exact.
        let centre = &rows[0];
        let first_tip = self.frames[0].1;
        let mut features_and_tip = vec![1.0; width];
        let mut row = 0;
        let mut covered = 0;
        for &(frame_s, tip) in &self.frames {
            let now_s = frame_s + offset_s;
            if now_s < time_s[0] || now_s > end_s {
                continue;
            }
            while row + 1 < rows.len() && time_s[row + 1] <= now_s {
                row += 1;
            }
            let [of_deviation, of_rate] = response.after(now_s - time_s[row]).deviation;
            let (features, tip_from_first) = features_and_tip[1..].split_at_mut(width - 1 - AXES);
            for (k, feature) in features.iter_mut().enumerate() {
                let [deviation, rate] = states[row][k];
                *feature = rows[row][k] + of_deviation * deviation + of_rate * rate - centre[k];
            }
            tip_from_first
                .iter_mut()
                .enumerate()
                .for_each(|(axis, value)| *value = tip[axis] - first_tip[axis]);
            sums[row * blocks / rows.len()].add(&features_and_tip);
            covered += 1;
        }
        let span_s = self.frames[self.frames.len() - 1].0 - self.frames[0].0;
        let expected_frames = (end_s - time_s[0]).min(span_s) / span_s.max(f64::MIN_POSITIVE)
            * self.frames.len() as f64;
        (covered as f64 >= MIN_COVERED_SHARE * expected_frames
            && covered >= MIN_FRAMES.min(self.frames.len()))
        .then_some(sums)
    }

    /// Share of the squares that stays unexplained at an offset and a response, without one block.
    fn unexplained(&self, offset_s: f64, response: StepResponse, without: Option<usize>) -> f64 {
        let count = if without.is_some() { BLOCKS } else { 1 };
        let Some(blocks) = self.blocks(offset_s, response, &self.states(response), count) else {
            return 1.0;
        };
        let kept = blocks
            .iter()
            .enumerate()
            .filter(|(block, _)| Some(*block) != without)
            .map(|(_, sums)| sums);
        let all = kept.fold(FitSums::new(blocks[0].width), |mut all, sums| {
            all.merge(sums);
            all
        });
        all.unexplained()
    }

    /// The offset and response that leave least, near a start, with steps from the first to the
    /// second of `reach_s`: a search along the coordinates, and along the valley in which an offset
    /// and the mean delay of the response make up for each other. `is_fixed` keeps the offset.
    pub(super) fn refined(
        &self,
        start: OffsetCandidate,
        reach_s: [f64; 2],
        without: Option<usize>,
        is_fixed: bool,
    ) -> OffsetCandidate {
        let at = |offset_s: f64, response: StepResponse| OffsetCandidate {
            offset_s,
            response,
            unexplained: self.unexplained(offset_s, response, without),
        };
        // A pattern search: the best of the neighbours as long as one is better, else half of the
        // step.
        let mut best = at(start.offset_s, start.response);
        let ([mut step_s, finest_s], mut factor) = (reach_s, 1.6_f64);
        while step_s > finest_s {
            let delay_s = best.response.mean_delay_s();
            let mut nearby = best;
            for (factor, step_s) in [(factor, step_s), (factor.recip(), -step_s)] {
                let longer = ((delay_s + step_s) / delay_s).max(0.5);
                let shapes = [(factor, 1.0), (1.0, factor), (factor, factor.recip())];
                let valley = [(longer, 1.0), (1.0, longer), (factor, 1.0), (1.0, factor)];
                let along = |&(time, damping): &(f64, f64)| {
                    let response = best.response.scaled(time, damping);
                    (response.mean_delay_s() - delay_s, response)
                };
                let mut tries: Vec<(f64, StepResponse)> =
                    shapes.iter().map(|shape| (0.0, along(shape).1)).collect();
                if !is_fixed {
                    tries.push((step_s, best.response));
                    tries.extend(valley.iter().map(along));
                }
                for (shift_s, response) in tries {
                    let tried = at(best.offset_s + shift_s, response);
                    if tried.unexplained < nearby.unexplained {
                        nearby = tried;
                    }
                }
            }
            if nearby.unexplained < best.unexplained {
                best = nearby;
            } else {
                (step_s, factor) = (0.5 * step_s, factor.sqrt());
            }
        }
        best
    }

    /// The optimum near a good start: damped Newton steps in the offset (in mean delays) and the
    /// logarithms of the response, with derivatives by central differences.
    pub(super) fn polished(
        &self,
        start: OffsetCandidate,
        without: Option<usize>,
    ) -> OffsetCandidate {
        let delay_s = start.response.mean_delay_s();
        let at = |p: &Vector3<f64>| {
            let (offset_s, response) =
                (start.offset_s + delay_s * p.x, start.response.scaled(p.y.exp(), p.z.exp()));
            OffsetCandidate {
                offset_s,
                response,
                unexplained: self.unexplained(offset_s, response, without),
            }
        };
        let (mut place, mut best) = (Vector3::zeros(), at(&Vector3::zeros()));
        for _ in 0..MAX_NEWTON_STEPS {
            let (gradient, curvature) =
                derivatives(&|p| at(p).unexplained, &place, best.unexplained);
            let previous_s = best.offset_s;
            let damped = |damping: &f64| {
                let size =
                    curvature.diagonal().map(|entry| damping * entry.abs().max(f64::MIN_POSITIVE));
                let step = (curvature + Matrix3::from_diagonal(&size)).cholesky()?.solve(&gradient);
                let tried = at(&(place - step));
                (tried.unexplained < best.unexplained).then_some((place - step, tried))
            };
            let Some((next, improved)) = DAMPINGS.iter().find_map(damped) else { break };
            (place, best) = (next, improved);
            if (best.offset_s - previous_s).abs() < RESOLUTION_S {
                break;
            }
        }
        best
    }

    /// The same motion with at most so many frames.
    pub(super) fn thinned(&self, max_frames: usize) -> TipMotion<'_> {
        let every = self.frames.len().div_ceil(max_frames).max(1);
        TipMotion { frames: self.frames.iter().copied().step_by(every).collect(), ..*self }
    }
}

/// Gradient and matrix of second derivatives of `function`, which is `value` at `place`, by central
/// differences.
fn derivatives(
    function: &dyn Fn(&Vector3<f64>) -> f64,
    place: &Vector3<f64>,
    value: f64,
) -> (Vector3<f64>, Matrix3<f64>) {
    let step = |axis: usize, size: f64| Vector3::ith(axis, size * DIFFERENCE_STEP);
    let ends: [[f64; 2]; 3] =
        std::array::from_fn(|axis| [1.0, -1.0].map(|size| function(&(place + step(axis, size)))));
    let gradient =
        Vector3::from_fn(|axis, _| (ends[axis][0] - ends[axis][1]) / (2.0 * DIFFERENCE_STEP));
    let mut curvature = Matrix3::zeros();
    for a in 0..3 {
        curvature[(a, a)] =
            (ends[a][0] + ends[a][1] - 2.0 * value) / (DIFFERENCE_STEP * DIFFERENCE_STEP);
        for b in 0..a {
            let both = [1.0, -1.0].map(|size| function(&(place + step(a, size) + step(b, size))));
            let single: f64 = ends[a].iter().chain(&ends[b]).sum();
            let mixed = (both[0] + both[1] + 2.0 * value - single)
                / (2.0 * DIFFERENCE_STEP * DIFFERENCE_STEP);
            (curvature[(a, b)], curvature[(b, a)]) = (mixed, mixed);
        }
    }
    (gradient, curvature)
}
