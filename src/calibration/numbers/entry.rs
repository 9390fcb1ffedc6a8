//! Entries of `--fit`: which numbers they name, where these start, and on which scale they are
//! fitted.

use super::number::{Coordinate, FitNumber};
use super::path;
use crate::base::BadOption;
use crate::calibration::error::CalibrationError;
use crate::effects::{Model, ModelParameter};

/// The short names that `--fit` has always had, and their paths. All are fitted on a logarithmic
/// scale.
pub const SHORT_NAMES: &[(&str, &str)] = &[
    ("youngs_modulus_pa", "robot.backbone.youngs_modulus_pa"),
    ("compliance_m_per_n", "robot.sections.compliance_m_per_n"),
    ("disk_mass_kg", "robot.disks.mass_kg"),
    ("tendon_radius_m", "robot.tendons.radius_m"),
    ("damping_time_s", "robot.damping_time_s"),
    ("length_m", "robot.backbone.length_m"),
];

/// How far below its present value a number is tried, in its scale, to tell whether it may be
/// negative.
const PROBE: f64 = 1e-3;

/// An entry of `--fit`: `PATH`, `PATH=start`, `PATH~deviation` or `PATH=start~deviation`.
struct Entry<'a> {
    pattern: &'a str,
    start: Option<f64>,
    deviation: Option<f64>,
}

/// The numbers that `entries` name.
///
/// # Errors
/// [`CalibrationError`] for the first entry that names none, and for a number that is named twice.
pub(crate) fn numbers(
    model: &Model,
    entries: &[String],
) -> Result<Vec<FitNumber>, CalibrationError> {
    let mut numbers: Vec<FitNumber> = Vec::new();
    for text in entries {
        let entry = Entry::read(text)?;
        for number in entry.numbers(model)? {
            let twice = |member: &ModelParameter| {
                numbers.iter().any(|other| other.members.contains(member))
            };
            if number.members.iter().any(twice) {
                return Err(CalibrationError::Repeated(number.name));
            }
            numbers.push(number);
        }
    }
    Ok(numbers)
}

impl Entry<'_> {
    fn read(text: &str) -> Result<Entry<'_>, CalibrationError> {
        let number = |part: &str, expected| {
            let value = part.trim().parse::<f64>().ok().filter(|value| value.is_finite());
            value.ok_or_else(|| CalibrationError::Entry {
                entry: text.to_owned(),
                found: part.to_owned(),
                expected,
            })
        };
        let (rest, deviation) =
            text.split_once('~').map_or((text, None), |(rest, part)| (rest, Some(part)));
        let (pattern, start) =
            rest.split_once('=').map_or((rest, None), |(rest, part)| (rest, Some(part)));
        let start = start.map(|part| number(part, "a number to start from")).transpose()?;
        let wide = "a standard deviation above 0, in the unit of the number";
        let deviation = deviation.map(|part| number(part, wide)).transpose()?;
        if let Some(negative) = deviation.filter(|&deviation| deviation <= 0.0) {
            let (entry, found) = (text.to_owned(), negative.to_string());
            return Err(CalibrationError::Entry { entry, found, expected: wide });
        }
        Ok(Entry { pattern: pattern.trim(), start, deviation })
    }

    fn numbers(&self, model: &Model) -> Result<Vec<FitNumber>, CalibrationError> {
        if let Some(&(name, path)) = SHORT_NAMES.iter().find(|(name, _)| *name == self.pattern) {
            let members = path::named(model, path)?;
            let value = self.start.map_or_else(|| value_of(&members[0], model), Ok)?;
            BadOption::unless_positive(name, value)?;
            return Ok(vec![self.number(
                name.to_owned(),
                members,
                vec![value],
                Coordinate::Logarithm,
            )]);
        }
        let Some((each, together)) = tied(self.pattern) else {
            let all = path::named(model, self.pattern)?;
            return all
                .into_iter()
                .map(|member| self.of(model, member.path().to_owned(), vec![member]))
                .collect();
        };
        let mut members = Vec::new();
        for pattern in each {
            members.extend(path::named(model, &pattern)?);
        }
        self.of(model, together, members).map(|number| vec![number])
    }

    /// A number with the coordinate that the range of its members allows.
    fn of(
        &self,
        model: &Model,
        name: String,
        members: Vec<ModelParameter>,
    ) -> Result<FitNumber, CalibrationError> {
        let model_values: Vec<f64> =
            members.iter().map(|member| value_of(member, model)).collect::<Result<_, _>>()?;
        let start: Vec<f64> =
            model_values.iter().map(|&value| self.start.unwrap_or(value)).collect();
        let mut ranges =
            members.iter().zip(&start).map(|(member, &start)| range(member, model, start));
        let first = ranges.next().unwrap_or(Range::Any);
        // Members of unlike ranges share the coordinate that is valid for all.
        let widest = ranges
            .fold(first, |widest, range| if range == first { widest } else { Range::NotNegative });
        let scale = |member: &ModelParameter| {
            let there = self.start.and_then(|start| member.with_value(model, start).ok());
            // An angle is as sure near 270° as near 0°.
            match member.unit() {
                "deg" => 10.0,
                "rad" => 0.1,
                _ => member.scale(there.as_ref().unwrap_or(model)).unwrap_or(1.0),
            }
        };
        let unit = members.iter().map(scale).fold(0.0, f64::max);
        let smallest = start.iter().copied().fold(f64::INFINITY, f64::min);
        let coordinate = match widest {
            Range::Positive if smallest > 0.0 => Coordinate::Logarithm,
            Range::Any => Coordinate::Linear { unit, low: f64::NEG_INFINITY },
            // All members move alike, so the smallest reaches zero first.
            _ => Coordinate::Linear { unit, low: -smallest / unit },
        };
        Ok(self.number(name, members, start, coordinate))
    }

    fn number(
        &self,
        name: String,
        members: Vec<ModelParameter>,
        start: Vec<f64>,
        scale: Coordinate,
    ) -> FitNumber {
        let size = match scale {
            Coordinate::Logarithm => start[0],
            Coordinate::Linear { unit, .. } => unit,
        };
        let deviation = self.deviation;
        FitNumber {
            name,
            members,
            start,
            scale,
            prior: deviation.map(|deviation| deviation / size),
            deviation,
        }
    }
}

/// The range of a number, as far as its sign goes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Range {
    Any,
    NotNegative,
    Positive,
}

/// Whether the model allows the number to be zero or negative.
fn range(member: &ModelParameter, model: &Model, start: f64) -> Range {
    let allowed =
        |value: f64| member.with_value(model, value).is_ok_and(|model| model.check().is_ok());
    let size = member.scale(model).unwrap_or(1.0);
    // The model's own checks are asked, so no range needs to be listed here.
    if start < 0.0 || allowed(-PROBE * size) {
        Range::Any
    } else if allowed(0.0) {
        Range::NotNegative
    } else {
        Range::Positive
    }
}

fn value_of(member: &ModelParameter, model: &Model) -> Result<f64, CalibrationError> {
    let unknown =
        |_| CalibrationError::Unknown { name: member.path().to_owned(), suggestion: String::new() };
    member.value(model).map_err(unknown)
}

/// Patterns of the members of a number such as `angles_deg[0+3+6]`, or of all of a list `[+]`, and
/// its name; `None` for a pattern without `+`. The members keep their differences, or their ratios
/// on a logarithmic scale.
fn tied(pattern: &str) -> Option<(Vec<String>, String)> {
    let (before, rest) = pattern.split_once('[')?;
    let (inside, after) = rest.split_once(']')?;
    if !inside.contains('+') {
        return None;
    }
    let all = inside == "+";
    let each = if all { vec!["*"] } else { inside.split('+').collect() };
    Some((
        each.iter().map(|index| format!("{before}[{index}]{after}")).collect(),
        pattern.to_owned(),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::numbers::number::with_coordinates;

    fn fitted(entries: &[&str]) -> Vec<FitNumber> {
        let entries: Vec<String> = entries.iter().map(|entry| (*entry).to_owned()).collect();
        numbers(&Model::default(), &entries).unwrap()
    }

    #[test]
    fn the_range_decides_the_scale() {
        let all = fitted(&[
            "backbone.youngs_modulus_pa",
            "sections.compliance_m_per_n",
            "tendons.angles_deg[1]",
        ]);
        assert!(all[0].is_logarithmic() && !all[1].is_logarithmic() && !all[2].is_logarithmic());
        assert!((all[1].value(all[1].low())).abs() < 1e-15, "a compliance may be zero and no less");
        assert!(all[2].low().is_infinite() && all[2].value(0.0) == 90.0);
        assert!(
            fitted(&["compliance_m_per_n"])[0].is_logarithmic(),
            "short names stay as they are"
        );
    }

    #[test]
    fn members_of_a_tied_number_keep_their_differences() {
        let number = &fitted(&["robot.tendons.angles_deg[0+2]~3"])[0];
        let model =
            with_coordinates(&Model::default(), std::slice::from_ref(number), &[0.5]).unwrap();
        let angles = &model.robot.tendons.angles_deg;
        assert!(
            (angles[2] - angles[0] - 180.0).abs() < 1e-12 && angles[0] > 1.0 && angles[1] == 90.0,
            "{angles:?}"
        );
        assert_eq!(fitted(&["robot.tendons.angles_deg[+]"])[0].members.len(), 4);
        assert_eq!(number.deviation, Some(3.0));
    }

    #[test]
    fn starts_and_deviations_stand_behind_the_path() {
        let number = &fitted(&["robot.backbone.length_m=0.2~0.01"])[0];
        assert!(number.value(0.0) == 0.2 && (number.prior.unwrap() - 0.05).abs() < 1e-12);
        let refused =
            |entry: &str| numbers(&Model::default(), &[entry.to_owned()]).unwrap_err().to_string();
        assert!(refused("robot.backbone.length_m=long").contains("found `long`"));
        assert!(refused("robot.backbone.length_m~-1").contains("above 0"));
        let twice = ["length_m".to_owned(), "robot.backbone.length_m".to_owned()];
        assert!(numbers(&Model::default(), &twice).unwrap_err().to_string().contains("twice"));
    }
}
