//! The numbers that a calibration fits, and their coordinates.

use crate::effects::{Model, ModelParameter};

/// A number to fit: one of the model file, or several that change together.
#[derive(Clone, Debug)]
pub(crate) struct FitNumber {
    /// Its name in the report: its short name, or its path.
    pub(crate) name: String,
    /// The numbers of the model file that it changes.
    pub(crate) members: Vec<ModelParameter>,
    /// Their values at coordinate 0.
    pub(crate) start: Vec<f64>,
    /// How its coordinate is read.
    pub(crate) scale: Coordinate,
    /// Standard deviation of the prior around coordinate 0, in coordinates; none: no prior.
    pub(crate) prior: Option<f64>,
    /// The same in the unit of the number.
    pub(crate) deviation: Option<f64>,
}

/// How a coordinate changes a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Coordinate {
    /// value = start · exp(x): numbers that are positive.
    Logarithm,
    /// value = start + unit · x, x at least `low`.
    Linear { unit: f64, low: f64 },
}

impl FitNumber {
    /// Its value at a coordinate; the first one's where several change together.
    pub(crate) fn value(&self, x: f64) -> f64 {
        self.member_value(0, x)
    }

    fn member_value(&self, member: usize, x: f64) -> f64 {
        match self.scale {
            Coordinate::Logarithm => self.start[member] * x.exp(),
            Coordinate::Linear { unit, low } if low.is_finite() => {
                (self.start[member] + unit * x).max(0.0)
            }
            Coordinate::Linear { unit, .. } => self.start[member] + unit * x,
        }
    }

    /// The coordinate at which its first member has a value, within its bound.
    pub(crate) fn coordinate(&self, value: f64) -> f64 {
        let x = match self.scale {
            Coordinate::Logarithm => (value / self.start[0]).ln(),
            Coordinate::Linear { unit, .. } => (value - self.start[0]) / unit,
        };
        if x.is_finite() { x.max(self.low()) } else { 0.0 }
    }

    /// The value of a member of the model at a coordinate; `None` when it is none of this number's.
    pub(crate) fn value_of(&self, member: &ModelParameter, x: f64) -> Option<f64> {
        let index = self.members.iter().position(|other| other == member)?;
        Some(self.member_value(index, x))
    }

    /// Derivative of a member's value with respect to the coordinate.
    pub(crate) fn slope(&self, member: usize, x: f64) -> f64 {
        match self.scale {
            Coordinate::Logarithm => self.start[member] * x.exp(),
            Coordinate::Linear { unit, .. } => unit,
        }
    }

    /// Least coordinate.
    pub(crate) fn low(&self) -> f64 {
        match self.scale {
            Coordinate::Logarithm => f64::NEG_INFINITY,
            Coordinate::Linear { low, .. } => low,
        }
    }

    /// Largest change of the coordinate in one step: a factor of 4, or five units.
    pub(crate) fn longest_step(&self) -> f64 {
        match self.scale {
            Coordinate::Logarithm => 1.4,
            Coordinate::Linear { .. } => 5.0,
        }
    }

    /// Whether it is fitted on a logarithmic scale.
    #[cfg(test)]
    pub(crate) fn is_logarithmic(&self) -> bool {
        self.scale == Coordinate::Logarithm
    }

    /// Unit of its value.
    pub(crate) fn unit(&self) -> &'static str {
        self.members[0].unit()
    }

    /// `model` with this number at a coordinate.
    fn applied(&self, model: Model, x: f64) -> Option<Model> {
        let mut members = self.members.iter().enumerate();
        members.try_fold(model, |model, (index, member)| {
            member.with_value(&model, self.member_value(index, x)).ok()
        })
    }
}

/// `model` with all numbers at their coordinates; `None` when that is no model.
pub(crate) fn with_coordinates(model: &Model, numbers: &[FitNumber], x: &[f64]) -> Option<Model> {
    let changed = numbers
        .iter()
        .zip(x)
        .try_fold(model.clone(), |model, (number, &x)| number.applied(model, x))?;
    // A step may leave the range of a number, or of two together (sections longer than the
    // backbone).
    changed.check().is_ok().then_some(changed)
}
