//! The transitions of an exploration, in order of time.

use serde::{Deserialize, Serialize};

use crate::base::{Displacements, Observation, Point3, Rows};

/// Transitions (x_i, u_i) → x_{i+1} of one or more trajectories; each trajectory starts at rest at
/// home.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Transitions {
    /// Measured tip before each step, metres, three columns.
    pub from_m: Rows,
    /// Displacements during the step, metres, one column for each tendon.
    pub pulls_m: Rows,
    /// Measured tip after the step, metres, three columns.
    pub to_m: Rows,
    /// Index of the first transition of each trajectory.
    pub starts: Vec<usize>,
}

impl Transitions {
    /// An empty trajectory of a robot with this number of tendons.
    pub(super) fn begin(tendons: usize) -> Self {
        Transitions {
            from_m: Rows::new(3),
            pulls_m: Rows::new(tendons),
            to_m: Rows::new(3),
            starts: vec![0],
        }
    }

    /// Appends the step from one observation to the next.
    pub(super) fn push(&mut self, from_m: &Point3, after: &Observation) {
        self.from_m.push(from_m);
        self.pulls_m.push(&after.pulls_m);
        self.to_m.push(&after.tip_m);
    }

    /// Number of transitions.
    pub fn len(&self) -> usize {
        self.to_m.len()
    }

    /// True when there is no transition.
    pub fn is_empty(&self) -> bool {
        self.to_m.is_empty()
    }

    /// The index range of each trajectory.
    pub fn trajectories(&self) -> Vec<std::ops::Range<usize>> {
        let ends = self.starts.iter().skip(1).copied().chain([self.len()]);
        self.starts.iter().copied().zip(ends).map(|(start, end)| start..end).collect()
    }

    /// The commands of one trajectory.
    pub fn commands(&self, range: std::ops::Range<usize>) -> Vec<Displacements> {
        range.map(|index| self.pulls_m.row(index).to_vec()).collect()
    }

    /// Joins trajectories that were recorded separately.
    pub fn concat(parts: &[Transitions]) -> Transitions {
        let mut joined = Transitions::begin(parts.first().map_or(0, |part| part.pulls_m.width()));
        joined.starts.clear();
        for part in parts {
            // Indices count from the beginning of the joined table.
            joined.starts.extend(part.starts.iter().map(|start| start + joined.to_m.len()));
            for index in 0..part.len() {
                joined.from_m.push(part.from_m.row(index));
                joined.pulls_m.push(part.pulls_m.row(index));
                joined.to_m.push(part.to_m.row(index));
            }
        }
        joined
    }

    /// The first `count` transitions.
    pub fn first(&self, count: usize) -> Transitions {
        let indices: Vec<usize> = (0..count.min(self.len())).collect();
        Transitions {
            from_m: self.from_m.select(&indices),
            pulls_m: self.pulls_m.select(&indices),
            to_m: self.to_m.select(&indices),
            starts: self.starts.iter().copied().filter(|start| *start < indices.len()).collect(),
        }
    }
}
