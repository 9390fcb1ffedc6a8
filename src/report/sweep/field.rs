//! A swept field as an axis: linear or logarithmic for numbers, equidistant for names.

use super::words::{key_words, value_words};
use crate::data::tables::{SIGNIFICANT_DIGITS, round_significant};
use crate::report::drawing::{Axis, signed, text_width};
use crate::report::style::{SMALL, TEXT};
use std::collections::{HashMap, HashSet};

/// Ratio of largest to smallest value from which an axis is logarithmic.
const MIN_LOG_RATIO: f64 = 20.0;
/// Up to this number, the values are the ticks.
const MAX_VALUE_TICKS: usize = 9;

/// Suffixes of names and their units.
const UNITS: [(&str, &str); 12] = [
    ("_m_per_n", "m/N"),
    ("_kg_m3", "kg/m³"),
    ("_n_m2", "N m²"),
    ("_rad_m", "rad/m"),
    ("_pa", "Pa"),
    ("_kg", "kg"),
    ("_hz", "Hz"),
    ("_rad", "rad"),
    ("_deg", "°"),
    ("_m", "m"),
    ("_s", "s"),
    ("_n", "N"),
];

/// The scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AxisScale {
    Linear,
    Log,
    Names,
}

/// A swept field.
pub(super) struct SweptAxis {
    name: String,
    axis_scale: AxisScale,
    /// Lengths below a metre are shown in millimetres.
    millimetres: bool,
    /// Its values: numbers ascending, names in order of appearance.
    pub(super) values: Vec<String>,
    numbers: HashMap<String, usize>,
}

impl SweptAxis {
    pub(super) fn new(name: &str, cells: &[String]) -> SweptAxis {
        let mut seen = HashSet::new();
        let mut values: Vec<String> =
            cells.iter().filter(|cell| seen.insert(*cell)).cloned().collect();
        let numbers: Option<Vec<f64>> = values.iter().map(|value| number(value)).collect();
        let axis_scale = numbers.map_or(AxisScale::Names, |mut numbers| {
            numbers.sort_by(f64::total_cmp);
            values.sort_by(|one, other| {
                number(one).unwrap_or(0.0).total_cmp(&number(other).unwrap_or(0.0))
            });
            axis_scale(&numbers)
        });
        let short = |value: &String| number(value).is_some_and(|length_m| length_m.abs() < 1.0);
        let millimetres = unit_of(name).1 == Some("m") && values.iter().all(short);
        let numbers = values.iter().cloned().zip(0..).collect();
        SweptAxis { name: name.to_owned(), axis_scale, millimetres, values, numbers }
    }

    /// A value as text within `room`: a number in plain notation, a long name (of a file)
    /// shortened.
    pub(super) fn shown(&self, value: &str, room: f64) -> String {
        match number(value).filter(|_| self.millimetres) {
            Some(length_m) => {
                written(&round_significant(1e3 * length_m, SIGNIFICANT_DIGITS).to_string())
            }
            None => shown(value, room),
        }
    }

    /// Whether the values are numbers, so that a line may join neighbours.
    pub(super) fn is_number(&self) -> bool {
        self.axis_scale != AxisScale::Names
    }

    /// Index of a value.
    pub(super) fn index(&self, value: Option<&&str>) -> Option<usize> {
        self.numbers.get(*value?).copied()
    }

    /// Position of a value along the axis.
    pub(super) fn place(&self, value: &str) -> f64 {
        let index = || self.index(Some(&value)).unwrap_or(0) as f64;
        match self.axis_scale {
            AxisScale::Linear => number(value).unwrap_or(f64::NAN),
            AxisScale::Log => number(value).unwrap_or(f64::NAN).log10(),
            AxisScale::Names => index(),
        }
    }

    /// What the field sets in words, else its name, with its unit, shortened from the front to fit.
    pub(super) fn label(&self, room: f64) -> String {
        let (stem, unit) = unit_of(&self.name);
        let unit = unit
            .map(|unit| if self.millimetres { " (mm)".to_owned() } else { format!(" ({unit})") });
        let unit = unit.unwrap_or_default();
        // The place in a list of cells says nothing to a reader.
        let stem: String = stem
            .split('[')
            .map(|part| part.split_once(']').map_or(part, |(_, rest)| rest))
            .collect();
        let mut stem =
            stem.strip_prefix("spec.").or(stem.strip_prefix("runs.reach.")).unwrap_or(&stem);
        stem = key_words(stem).unwrap_or(stem);
        let mut head = "";
        while text_width(&format!("{head}{stem}{unit}"), TEXT, false) > room {
            let Some((_, tail)) = stem.split_once('.') else { break };
            (head, stem) = ("…", tail);
        }
        format!("{head}{stem}{unit}")
    }

    /// An axis `long` hundredths of an inch long.
    pub(super) fn axis(&self, long: f64) -> Axis {
        let label = self.label(long + 40.0);
        if self.axis_scale == AxisScale::Names {
            let room = long / self.values.len() as f64 - 6.0;
            let names: Vec<String> =
                self.values.iter().map(|value| self.shown(value, room)).collect();
            return Axis::categories(&label, &names);
        }
        let places: Vec<f64> = self.values.iter().map(|value| self.place(value)).collect();
        let (low, high) = crate::report::drawing::range(places.iter().copied());
        let room = 0.05 * (high - low);
        let axis =
            Axis::exact(&label, low - room, high + room, (long / 45.0).clamp(3.0, 7.0) as usize);
        let axis = if self.millimetres { self.in_millimetres(axis) } else { axis };
        let value_ticks =
            places.into_iter().zip(self.values.iter().map(|value| self.shown(value, long)));
        let value_ticks: Vec<(f64, String)> = value_ticks.collect();
        if self.values.len() <= MAX_VALUE_TICKS
            && apart(&value_ticks, long / (axis.high - axis.low))
        {
            return Axis { ticks: value_ticks, ..axis };
        }
        if self.axis_scale != AxisScale::Log {
            return axis;
        }
        let ticks = decades(axis.low, axis.high);
        let ticks =
            ticks.into_iter().map(|value| (value.log10(), self.shown(&format!("{value:e}"), long)));
        Axis { ticks: ticks.collect(), ..axis }
    }

    /// An axis of metres with round numbers of millimetres.
    fn in_millimetres(&self, axis: Axis) -> Axis {
        if self.axis_scale != AxisScale::Linear {
            return axis;
        }
        let millimetres =
            Axis::exact(&axis.label, 1e3 * axis.low, 1e3 * axis.high, axis.ticks.len().max(3));
        Axis {
            ticks: millimetres
                .ticks
                .into_iter()
                .map(|(place, label)| (1e-3 * place, label))
                .collect(),
            ..axis
        }
    }
}

/// The stem of a field's name, and the unit that its suffix names.
fn unit_of(name: &str) -> (&str, Option<&'static str>) {
    let with_unit =
        UNITS.iter().find_map(|(end, unit)| name.strip_suffix(end).map(|stem| (stem, Some(*unit))));
    with_unit.unwrap_or((name, None))
}

fn number(cell: &str) -> Option<f64> {
    cell.parse().ok().filter(|value: &f64| value.is_finite())
}

/// The scale for ascending numbers: logarithmic for a constant ratio or a wide range.
fn axis_scale(numbers: &[f64]) -> AxisScale {
    let (Some(first), Some(last)) = (numbers.first(), numbers.last()) else {
        return AxisScale::Linear;
    };
    if *first <= 0.0 || numbers.len() < 3 {
        return AxisScale::Linear;
    }
    let ratio = numbers[1] / first;
    let constant = numbers.windows(2).all(|pair| (pair[1] / pair[0] / ratio - 1.0).abs() < 1e-3);
    if constant || last / first >= MIN_LOG_RATIO { AxisScale::Log } else { AxisScale::Linear }
}

/// Whether labels at these positions do not overlap; `scale` in hundredths of an inch per unit.
fn apart(ticks: &[(f64, String)], scale: f64) -> bool {
    let half = |label: &str| 0.5 * text_width(label, SMALL, false) + 3.0;
    ticks
        .windows(2)
        .all(|pair| scale * (pair[1].0 - pair[0].0) > half(&pair[0].1) + half(&pair[1].1))
}

/// Ticks at powers of ten; where these are few, also at twice and five times each.
fn decades(low: f64, high: f64) -> Vec<f64> {
    let few = high - low < 2.0;
    let factors: &[f64] = if few { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let [first, last] = if few { [low.floor(), high.ceil()] } else { [low.ceil(), high.floor()] };
    let powers: Vec<i32> = (first as i32..=last as i32).collect();
    let step = powers.len().div_ceil(7).max(1);
    let values = powers
        .into_iter()
        .step_by(step)
        .flat_map(|power| factors.iter().map(move |f| f * 10f64.powi(power)));
    values.filter(|value| (low..=high).contains(&value.log10())).collect()
}

/// A number in plain notation, with a minus sign (U+2212).
fn written(value: &str) -> String {
    let Some(number) = number(value) else { return value.to_owned() };
    let decimal = signed(number, 6);
    let decimal = if decimal.contains('.') {
        decimal.trim_end_matches('0').trim_end_matches('.')
    } else {
        &decimal
    };
    let exact = decimal
        .replace('−', "-")
        .parse::<f64>()
        .is_ok_and(|read| (read / number - 1.0).abs() < 1e-6);
    if number == 0.0 || (exact && number.abs() < 1e6) {
        decimal.to_owned()
    } else {
        format!("{number:.3e}").replace('-', "−")
    }
}

fn shown(value: &str, room: f64) -> String {
    let text = if number(value).is_some() {
        written(value)
    } else {
        value_words(value.trim_end_matches(".yaml"))
    };
    if text_width(&text, SMALL, false) <= room {
        return text;
    }
    let mut letters: Vec<char> = text.rsplit('/').next().unwrap_or(&text).chars().collect();
    let full_length = letters.len();
    while letters.len() > 1 {
        let mark = if letters.len() < full_length { "…" } else { "" };
        let text: String = letters.iter().collect::<String>() + mark;
        if text_width(&text, SMALL, false) <= room {
            return text;
        }
        letters.pop();
    }
    String::new()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(name: &str, values: &[&str]) -> SweptAxis {
        SweptAxis::new(name, &values.iter().map(|value| (*value).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn numbers_are_even_or_logarithmic_and_names_keep_their_order() {
        assert_eq!(field("a.b", &["0.03", "0.01", "0.02"]).values, ["0.01", "0.02", "0.03"]);
        assert_eq!(field("a.b", &["0.01", "0.02", "0.03"]).axis_scale, AxisScale::Linear);
        assert_eq!(field("a.b", &["1e-3", "0.01", "0.1"]).axis_scale, AxisScale::Log);
        assert_eq!(field("a.b", &["20", "40", "80"]).axis_scale, AxisScale::Log);
        assert_eq!(field("a.b", &["50", "100", "200", "1500"]).axis_scale, AxisScale::Log);
        assert_eq!(field("a.b", &["-1", "10", "100"]).axis_scale, AxisScale::Linear);
        let names = field("gp.kernel", &["se_ard", "matern52", "se_ard"]);
        assert_eq!((names.axis_scale, names.values.len()), (AxisScale::Names, 2));
        assert_eq!(names.place("matern52"), 1.0);
    }

    #[test]
    fn labels_carry_the_unit_and_shorten_from_the_front() {
        assert_eq!(field("policies.c.error_m", &["1"]).label(400.0), "policies.c.error (m)");
        let short = field("policies.c.error_m", &["0.005", "0.015"]);
        assert_eq!(
            (short.label(400.0), short.shown("0.015", 60.0)),
            ("policies.c.error (mm)".into(), "15".into())
        );
        assert_eq!(field("runs.reach[0].gp_points[0]", &["1"]).label(400.0), "real points");
        assert_eq!(field("spec.control_hz", &["1"]).label(400.0), "control rate (Hz)");
        let long = field("plant.simulated.model.robot.backbone.youngs_modulus_pa", &["1"]);
        assert_eq!(long.label(200.0), "…backbone.youngs_modulus (Pa)");
        assert_eq!(shown("../models/tentacle.yaml", 60.0), "tentacle");
        assert_eq!(
            (written("1e-5"), written("0.015"), written("-2")),
            ("0.00001".into(), "0.015".into(), "−2".into())
        );
        assert_eq!((written("1e-9"), written("2.33e9")), ("1.000e−9".into(), "2.330e9".into()));
    }

    #[test]
    fn a_few_values_are_the_ticks_and_many_leave_round_ones() {
        let ticks = |field: &SweptAxis, long| {
            field.axis(long).ticks.into_iter().map(|(_, label)| label).collect::<Vec<_>>()
        };
        assert_eq!(
            ticks(&field("a.b", &["0.005", "0.01", "0.03"]), 300.0),
            ["0.005", "0.01", "0.03"]
        );
        let many: Vec<String> = (0..200).map(|value| value.to_string()).collect();
        assert!(ticks(&SweptAxis::new("a.b", &many), 300.0).len() < 10);
        let many: Vec<String> =
            (0..60).map(|step| format!("{:e}", 10f64.powf(f64::from(step) / 10.0 - 3.0))).collect();
        assert_eq!(
            ticks(&SweptAxis::new("a.b", &many), 300.0).first().map(String::as_str),
            Some("0.001")
        );
    }
}
