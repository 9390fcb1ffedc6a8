//! Parameters of a model by path: the variables of derivatives, of calibration and of discovery.

use std::fmt;
use std::ops::Range;

use serde_json::{Number, Value};

use crate::base::Point3;
use crate::effects::{Model, Robot};
use crate::rod::Resolution;

/// A real-valued parameter of a model file, of the robot, of one of its effects, of a tracked
/// point or of a drive. Integers (counts, tendon numbers)
/// and the numerical resolution are excluded.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ModelParameter {
    /// Its path, such as `robot.backbone.youngs_modulus_pa`, `robot.gravity_m_s2[0]`,
    /// `effects[0].mass_kg`, `tracking.points.p1.offset_m[0]` or `drives.servo_1.gains[0]`.
    path: String,
    /// Its unit; `1` for a plain ratio.
    unit: &'static str,
}

/// Why a parameter cannot be read or written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// The model has no parameter at this path.
    #[error("the model has no number at `{0}`")]
    Unknown(String),
    /// A value that is not finite.
    #[error("{0}: {1} is not a finite number")]
    NotFinite(String, f64),
}

/// Why a derivative along a motion does not exist.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VariationError {
    /// The model has no such parameter.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// Index of a variable (from 0) whose smallest perturbation changes the discretisation, such as
    /// the end of a tendon at the tip. Only finite differences of whole motions apply.
    #[error(
        "variable {0} (from 0) changes the discretisation of the rod: no derivative along the \
         motion"
    )]
    NotPerturbable(usize),
    /// A tendon or an axis that does not exist.
    #[error("variable {0} (from 0) names a tendon or an axis that this robot does not have")]
    Missing(usize),
    /// A parameter that cannot be perturbed in either direction.
    #[error("{0}: no value near the current one is in range")]
    OutOfRange(String),
}

/// The variable of a derivative.
#[derive(Clone, Debug, PartialEq)]
pub enum Variable {
    /// A parameter of the model.
    Parameter(ModelParameter),
    /// The commands to a tendon (from 0), displacements in metres or tensions in newtons, with
    /// these indices in the trial (from 0).
    Command {
        /// The tendon.
        tendon: usize,
        /// The commands that change together.
        commands: Range<usize>,
    },
    /// A constant force on the tip along an axis of the world, newtons.
    Force(usize),
    /// A constant moment on the tip about an axis of the world, newton metres.
    Moment(usize),
}

/// Units by suffix, and a typical magnitude for parameters that are zero.
const UNITS: &[(&str, &str, f64)] = &[
    ("_n_s2_m3", "N s²/m³", 0.1),
    ("_kg_m3", "kg/m³", 1e3),
    ("_kg_m2", "kg m²", 1e-6),
    ("_m_s2", "m/s²", 1.0),
    ("_m_per_n", "m/N", 1e-4),
    ("_n_m2", "N m²", 1e-3),
    ("_rad_m", "rad/m", 1.0),
    ("_kg_m", "kg/m", 0.1),
    ("_n_m", "N/m", 100.0),
    ("_1_m", "1/m", 5.0),
    ("_nm", "N m", 0.01),
    ("_pa", "Pa", 1e6),
    ("_deg", "deg", 10.0),
    ("_rad", "rad", 0.1),
    ("_kg", "kg", 0.01),
    ("_s", "s", 0.1),
    ("_n", "N", 0.1),
    ("_m", "m", 5e-3),
    ("", "1", 0.1),
];

impl ModelParameter {
    /// All parameters of `model`, in the order of its file.
    pub fn all(model: &Model) -> Vec<ModelParameter> {
        let mut parameters = Vec::new();
        if let Ok(Value::Object(robot)) = serde_json::to_value(&model.robot) {
            for (key, value) in robot.iter().filter(|(key, _)| *key != "resolution") {
                collect(value, &format!("robot.{key}"), &mut parameters);
            }
        }
        for (index, effect) in model.effects.iter().enumerate() {
            let Ok(value) = serde_json::to_value(effect) else { continue };
            for (key, value) in value[effect.card().name].as_object().into_iter().flatten() {
                collect(value, &format!("effects[{index}].{key}"), &mut parameters);
            }
        }
        if let Ok(obstacles) = serde_json::to_value(&model.obstacles) {
            collect(&obstacles, "obstacles", &mut parameters);
        }
        if let (Ok(tracking), Ok(drives)) =
            (serde_json::to_value(&model.tracking), serde_json::to_value(&model.drives))
        {
            collect(&tracking, "tracking", &mut parameters);
            collect(&drives, "drives", &mut parameters);
        }
        parameters
    }

    /// The parameter of `model` at `path`.
    ///
    /// # Errors
    /// [`ParameterError::Unknown`] when there is none.
    pub fn named(model: &Model, path: &str) -> Result<ModelParameter, ParameterError> {
        let unknown = || ParameterError::Unknown(path.to_owned());
        ModelParameter::all(model)
            .into_iter()
            .find(|parameter| parameter.path == path)
            .ok_or_else(unknown)
    }

    /// Its path in the model file, without the effect's name.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Its unit.
    pub fn unit(&self) -> &'static str {
        self.unit
    }

    /// Its value in `model`.
    ///
    /// # Errors
    /// [`ParameterError::Unknown`] when the model has no such number.
    pub fn value(&self, model: &Model) -> Result<f64, ParameterError> {
        let (root, pointer) = self.place(model)?;
        root.pointer(&pointer).and_then(Value::as_f64).ok_or_else(|| self.unknown())
    }

    /// `model` with this value changed; [`Model::check`] checks the range.
    ///
    /// # Errors
    /// [`ParameterError`] when the model has no such number or `value` is not finite.
    pub fn with_value(&self, model: &Model, value: f64) -> Result<Model, ParameterError> {
        let (mut root, pointer) = self.place(model)?;
        let number = Number::from_f64(value)
            .ok_or_else(|| ParameterError::NotFinite(self.path.clone(), value))?;
        *root.pointer_mut(&pointer).filter(|leaf| leaf.is_f64()).ok_or_else(|| self.unknown())? =
            Value::Number(number);
        let mut changed: Model = serde_json::from_value(root).map_err(|_| self.unknown())?;
        changed.robot.resolution = model.robot.resolution;
        Ok(changed)
    }

    /// Its scale: its magnitude, or the typical magnitude for its unit where it is nearly zero.
    ///
    /// # Errors
    /// As [`ModelParameter::value`].
    pub fn scale(&self, model: &Model) -> Result<f64, ParameterError> {
        let typical = UNITS.iter().find(|(_, unit, _)| *unit == self.unit).map_or(1.0, |row| row.2);
        let size = self.value(model)?.abs();
        Ok(if size > 0.1 * typical { size } else { typical })
    }

    /// Finite-difference derivative of `points` of whole models: central with a step of `step`
    /// times the scale, or one-sided of second order where the other side is out of range.
    ///
    /// # Errors
    /// Those of `points`, and [`ParameterError`] when the model has no such number.
    pub fn differences<E: From<VariationError>>(
        &self,
        model: &Model,
        step: f64,
        points: &dyn Fn(&Model) -> Result<Vec<Point3>, E>,
    ) -> Result<Vec<Point3>, E> {
        let step = step * self.scale(model).map_err(VariationError::from)?;
        let value = self.value(model).map_err(VariationError::from)?;
        let at = |steps: f64| -> Result<Option<Vec<Point3>>, E> {
            let candidate =
                self.with_value(model, value + steps * step).map_err(VariationError::from)?;
            if candidate.check().is_ok() { points(&candidate).map(Some) } else { Ok(None) }
        };
        let weighted = |terms: &[(f64, Option<Vec<Point3>>)]| -> Option<Vec<Point3>> {
            let terms: Vec<(f64, &Vec<Point3>)> = terms
                .iter()
                .map(|(weight, points)| Some((*weight, points.as_ref()?)))
                .collect::<Option<_>>()?;
            let sum = |row: usize| -> Point3 {
                std::array::from_fn(|axis| {
                    terms.iter().map(|(weight, all)| weight * all[row][axis] / step).sum()
                })
            };
            Some((0..terms[0].1.len()).map(sum).collect())
        };
        let (before, after) = (at(-1.0)?, at(1.0)?);
        let rates = match (before, after) {
            // (f₁ − f₋₁) / 2 h.
            (Some(before), Some(after)) => weighted(&[(-0.5, Some(before)), (0.5, Some(after))]),
            // (−3 f₀ + 4 f₁ − f₂) / 2 h, and its mirror image.
            (None, after) => weighted(&[(-1.5, at(0.0)?), (2.0, after), (-0.5, at(2.0)?)]),
            (before, None) => weighted(&[(1.5, at(0.0)?), (-2.0, before), (0.5, at(-2.0)?)]),
        };
        rates.ok_or_else(|| VariationError::OutOfRange(self.path.clone()).into())
    }

    /// The model as a JSON tree and the JSON pointer of the parameter.
    fn place(&self, model: &Model) -> Result<(Value, String), ParameterError> {
        // JSON cannot hold the infinite values of the numerical resolution.
        let robot = Robot { resolution: Resolution::default(), ..model.robot.clone() };
        let model = Model { robot, ..model.clone() };
        let root = serde_json::to_value(&model).map_err(|_| self.unknown())?;
        let mut pointer = format!("/{}", self.path.replace(']', "").replace(['.', '['], "/"));
        if let Some(rest) = pointer.strip_prefix("/effects/") {
            let (index, field) = rest.split_once('/').ok_or_else(|| self.unknown())?;
            let effect = index.parse().ok().and_then(|index: usize| model.effects.get(index));
            pointer = format!(
                "/effects/{index}/{}/{field}",
                effect.ok_or_else(|| self.unknown())?.card().name
            );
        }
        Ok((root, pointer))
    }

    fn unknown(&self) -> ParameterError {
        ParameterError::Unknown(self.path.clone())
    }
}

impl fmt::Display for ModelParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.path)
    }
}

/// Adds the parameters at and below `value`.
fn collect(value: &Value, path: &str, parameters: &mut Vec<ModelParameter>) {
    match value {
        Value::Number(number) if number.is_f64() => {
            let name =
                path.rsplit('.').next().unwrap_or_default().split('[').next().unwrap_or_default();
            let unit = UNITS.iter().find(|(end, ..)| name.ends_with(end)).map_or("1", |row| row.1);
            parameters.push(ModelParameter { path: path.to_owned(), unit });
        }
        Value::Array(items) => {
            items
                .iter()
                .enumerate()
                .for_each(|(index, item)| collect(item, &format!("{path}[{index}]"), parameters));
        }
        Value::Object(fields) => {
            fields
                .iter()
                .for_each(|(key, item)| collect(item, &format!("{path}.{key}"), parameters));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::CATALOGUE;

    /// The suffix of a name gives the unit of its card.
    #[test]
    fn names_say_the_units_of_the_cards() {
        for parameter in CATALOGUE
            .iter()
            .flat_map(|card| card.parameters)
            .filter(|p| !["number", "flag"].contains(&p.unit))
        {
            let name = parameter.name.split('[').next().unwrap();
            let unit = UNITS.iter().find(|(end, ..)| name.ends_with(end)).unwrap().1;
            assert_eq!(unit, parameter.unit, "{}", parameter.name);
        }
    }
}
