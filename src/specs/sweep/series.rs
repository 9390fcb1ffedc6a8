//! The values of a swept field: a list, an even or logarithmic range, random samples, or values
//! with names.

use crate::base::Seed;
use crate::data::tables::{SIGNIFICANT_DIGITS, round_significant};
use crate::specs::document::mismatch::{describe, deserialize};
use crate::specs::document::path::{KeyPath, Step};
use rand::RngExt;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_yaml::{Number, Value};
use std::collections::{BTreeMap, HashSet};

/// Most values of one field; more indicate a mistyped count.
pub(crate) const MAX_VALUES: usize = 100_000;

/// The forms of values.
pub(crate) const FORMS: &str = "a list, or one of `range`, `log_range`, `random`, `named`";

/// One value of a swept field.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SweepValue {
    /// Its name in tables and figures.
    pub(crate) name: String,
    /// The value in the spec.
    pub(crate) value: Value,
    /// Its position in the field's entry; none when it was computed.
    pub(crate) below: Option<Step>,
}

/// An error in the values of a field: the path below them, what was found, what was expected.
pub(crate) type Wrong = (KeyPath, String, String);

/// The forms of values other than a list, for the schema.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
#[allow(dead_code)] // only its schema is used
pub(crate) enum SeriesForm {
    /// Evenly spaced values, both ends included.
    Range(EvenRange),
    /// Logarithmically spaced values, both ends included.
    LogRange(LogRange),
    /// Random values, reproducible.
    Random(RandomDraw),
    /// Values with names for tables and figures.
    Named(BTreeMap<String, serde_json::Value>),
}

/// Evenly spaced values, both ends included.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct EvenRange {
    /// First value.
    from: f64,
    /// Last value.
    to: f64,
    /// Number of values, at least 2; or `step`.
    count: Option<usize>,
    /// Distance between neighbouring values; or `count`.
    step: Option<f64>,
    /// Round to whole numbers; equal rounded values count once.
    #[serde(default)]
    whole: bool,
}

/// Logarithmically spaced values, both ends included.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LogRange {
    /// First value, above 0.
    from: f64,
    /// Last value.
    to: f64,
    /// Number of values, at least 2.
    count: usize,
    /// Round to whole numbers; equal rounded values count once.
    #[serde(default)]
    whole: bool,
}

/// Values drawn from a uniform or a log-uniform distribution.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RandomDraw {
    /// Smallest value.
    from: f64,
    /// Largest value.
    to: f64,
    /// Number of values, at least 2.
    count: usize,
    /// Draw log-uniformly.
    #[serde(default)]
    log: bool,
    /// Round to whole numbers; equal rounded values count once.
    #[serde(default)]
    whole: bool,
    /// Root of the draw; by default the spec's seed.
    seed: Option<u64>,
}

/// Expands `written` to values. Random values come from the child `sweep`, `field` of `seed`, with
/// one generator per sample, so that a larger count keeps the first samples.
///
/// # Errors
/// The first invalid value.
pub(crate) fn expand(
    written: &Value,
    field: &KeyPath,
    seed: Seed,
) -> Result<Vec<SweepValue>, Wrong> {
    let values = match written {
        Value::Sequence(items) => listed(items)?,
        Value::Mapping(form) if form.len() == 1 => {
            let (kind, settings) = form.iter().next().unwrap_or((&Value::Null, &Value::Null));
            match kind.as_str() {
                Some("range") => even(&read::<EvenRange>(settings, "range")?)?,
                Some("log_range") => logarithmic(&read::<LogRange>(settings, "log_range")?)?,
                Some("random") => random(&read::<RandomDraw>(settings, "random")?, field, seed)?,
                Some("named") => named(settings)?,
                _ => return Err(wrong("", format!("the unknown key `{}`", name(kind)), FORMS)),
            }
        }
        other => return Err(wrong("", describe(other), FORMS)),
    };
    if values.is_empty() {
        return Err(wrong("", "no values".to_owned(), "at least one value"));
    }
    each_once(&values)?;
    Ok(values)
}

fn wrong(below: &str, found: impl Into<String>, expected: impl Into<String>) -> Wrong {
    (KeyPath::parse(below).unwrap_or_default(), found.into(), expected.into())
}

fn listed(items: &[Value]) -> Result<Vec<SweepValue>, Wrong> {
    if items.len() > MAX_VALUES {
        return Err(too_many("", items.len()));
    }
    let sweep_value = |(index, value): (usize, &Value)| SweepValue {
        name: name(value),
        value: value.clone(),
        below: Some(Step::Item(index)),
    };
    Ok(items.iter().enumerate().map(sweep_value).collect())
}

fn named(settings: &Value) -> Result<Vec<SweepValue>, Wrong> {
    let Value::Mapping(mapping) = settings else {
        return Err(wrong("named", describe(settings), "a mapping from names to values"));
    };
    let sweep_value = |(key, value): (&Value, &Value)| SweepValue {
        name: name(key),
        value: value.clone(),
        below: None,
    };
    Ok(mapping.iter().map(sweep_value).collect())
}

fn even(range: &EvenRange) -> Result<Vec<SweepValue>, Wrong> {
    ordered("range", range.from, range.to)?;
    let span = range.to - range.from;
    let (steps, step) = match (range.count, range.step) {
        (Some(count), None) => (counted("range", count)? - 1, span / (count - 1) as f64),
        (None, Some(step)) if step > 0.0 && step.is_finite() => {
            // Rounding must not lose the end where the step divides the span.
            let steps = (span / step * (1.0 + 1e-12)).floor();
            if steps < 1.0 {
                return Err(wrong(
                    "range.step",
                    step.to_string(),
                    format!("at most {span}, from one end to the other"),
                ));
            }
            if steps >= MAX_VALUES as f64 {
                return Err(too_many("range.step", steps as usize + 1));
            }
            (steps as usize, step)
        }
        (None, Some(step)) => {
            return Err(wrong("range.step", step.to_string(), "a finite number above 0"));
        }
        (Some(_), Some(_)) => return Err(wrong("range", "both `count` and `step`", "one of them")),
        (None, None) => return Err(wrong("range", "neither `count` nor `step`", "one of them")),
    };
    let value = |index: usize| range.from + step * index as f64;
    // The last value is exactly the end if the steps reach it.
    let is_end = |index: usize| index == steps && (value(index) - range.to).abs() <= 1e-9 * span;
    let values = (0..=steps).map(|index| if is_end(index) { range.to } else { value(index) });
    Ok(numbers(values, range.whole, [range.from, range.to]))
}

fn logarithmic(range: &LogRange) -> Result<Vec<SweepValue>, Wrong> {
    positive("log_range", range.from, range.to)?;
    let steps = counted("log_range", range.count)? - 1;
    let ratio = (range.to / range.from).ln();
    let values = (0..=steps).map(|index| match index {
        0 => range.from,
        _ if index == steps => range.to,
        _ => range.from * (ratio * index as f64 / steps as f64).exp(),
    });
    Ok(numbers(values, range.whole, [range.from, range.to]))
}

fn random(random: &RandomDraw, field: &KeyPath, seed: Seed) -> Result<Vec<SweepValue>, Wrong> {
    if random.log {
        positive("random", random.from, random.to)?
    } else {
        ordered("random", random.from, random.to)?
    }
    let seed = random.seed.map_or(seed, Seed).child("sweep").child(&field.to_string());
    let values = (0..counted("random", random.count)? as u64).map(|index| {
        let share: f64 = seed.index(index).rng().random();
        if random.log {
            random.from * (share * (random.to / random.from).ln()).exp()
        } else {
            random.from + share * (random.to - random.from)
        }
    });
    Ok(numbers(values, random.whole, [f64::NAN; 2]))
}

fn read<T: DeserializeOwned>(settings: &Value, form: &str) -> Result<T, Wrong> {
    let below = |key: KeyPath| KeyPath([KeyPath::default().key(form).0, key.0].concat());
    deserialize(settings, &[]).map_err(|wrong| (below(wrong.key), wrong.found, wrong.expected))
}

fn ordered(form: &str, from: f64, to: f64) -> Result<(), Wrong> {
    let expected = "two finite numbers, `from` below `to`";
    if from.is_finite() && to.is_finite() && from < to {
        return Ok(());
    }
    Err(wrong(&format!("{form}.from"), format!("{from} to {to}"), expected))
}

fn positive(form: &str, from: f64, to: f64) -> Result<(), Wrong> {
    if from > 0.0 {
        return ordered(form, from, to);
    }
    Err(wrong(&format!("{form}.from"), from.to_string(), "a number above 0"))
}

fn counted(form: &str, count: usize) -> Result<usize, Wrong> {
    match count {
        0 | 1 => Err(wrong(&format!("{form}.count"), count.to_string(), "at least 2 values")),
        2..=MAX_VALUES => Ok(count),
        _ => Err(too_many(&format!("{form}.count"), count)),
    }
}

fn too_many(below: &str, found: usize) -> Wrong {
    wrong(below, format!("{found} values"), format!("at most {MAX_VALUES}"))
}

fn each_once(values: &[SweepValue]) -> Result<(), Wrong> {
    let mut names = HashSet::new();
    match values.iter().find(|sweep_value| !names.insert(&sweep_value.name)) {
        None => Ok(()),
        Some(repeated) => {
            let path = KeyPath(repeated.below.iter().cloned().collect());
            Err((path, format!("`{}` twice", repeated.name), "each value once".to_owned()))
        }
    }
}

/// Computed numbers, rounded to the digits of tables, so that the published values are the ones
/// that were run; `exact` ones are not rounded. Whole results become integers, and those that round
/// to the same are one.
fn numbers(values: impl Iterator<Item = f64>, whole: bool, exact: [f64; 2]) -> Vec<SweepValue> {
    let rounded = |value: f64| match whole {
        true => value.round(),
        false if exact.contains(&value) => value,
        false => round_significant(value, SIGNIFICANT_DIGITS),
    };
    let sweep_value = |value: f64| {
        // Integer fields do not accept `3.0`.
        let number = if value.fract() == 0.0 && value.abs() < 1e15 {
            Number::from(value as i64)
        } else {
            Number::from(value)
        };
        let value = Value::Number(number);
        SweepValue { name: name(&value), value, below: None }
    };
    let mut names = HashSet::new();
    let is_new = |one: &SweepValue| !whole || names.insert(one.name.clone());
    values.map(rounded).map(sweep_value).filter(is_new).collect()
}

/// A value in one cell of a table.
fn name(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Number(number) if !number.is_f64() => number.to_string(),
        Value::Number(number) => number.as_f64().map_or_else(|| number.to_string(), number_name),
        Value::Null => "null".to_owned(),
        Value::Bool(flag) => flag.to_string(),
        other => serde_json::to_string(other).unwrap_or_else(|_| describe(other)),
    }
}

/// A number as in published tables.
fn number_name(value: f64) -> String {
    let value = round_significant(value, SIGNIFICANT_DIGITS);
    if value != 0.0 && !(1e-4..1e15).contains(&value.abs()) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> Result<Vec<String>, String> {
        let field = KeyPath::parse("gp.noise_floor").unwrap();
        let values = expand(&serde_yaml::from_str(text).unwrap(), &field, Seed(7));
        values.map(|values| values.into_iter().map(|one| one.name).collect()).map_err(
            |(path, found, expected)| format!("{path}: found {found}, expected {expected}"),
        )
    }

    #[test]
    fn values_are_what_a_person_would_write() {
        let cases = [
            ("{range: {from: 0.005, to: 0.03, count: 6}}", "0.005 0.01 0.015 0.02 0.025 0.03"),
            ("{range: {from: 0, to: 1, step: 0.1}}", "0 0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8 0.9 1"),
            ("{range: {from: 0, to: 1, step: 0.4}}", "0 0.4 0.8"),
            ("{log_range: {from: 1e-3, to: 0.1, count: 3}}", "0.001 0.01 0.1"),
            ("{log_range: {from: 50, to: 1000, count: 4, whole: true}}", "50 136 368 1000"),
            ("{range: {from: 1, to: 2, count: 9, whole: true}}", "1 2"),
            ("{log_range: {from: 1, to: 10, count: 9, whole: true}}", "1 2 3 4 6 7 10"),
            ("{log_range: {from: 1e-6, to: 1e-4, count: 3}}", "1e-6 1e-5 0.0001"),
            ("[matern32, 3, 2.5, true, null, [1, 2]]", "matern32 3 2.5 true null [1,2]"),
            ("{named: {none: [], heavy: [{tip_load: {mass_kg: 0.1}}]}}", "none heavy"),
        ];
        for (text, expected) in cases {
            assert_eq!(names(text).map(|names| names.join(" ")), Ok(expected.to_owned()), "{text}");
        }
        let whole = expand(
            &serde_yaml::from_str("{range: {from: 1, to: 5, count: 3}}").unwrap(),
            &KeyPath::default(),
            Seed(0),
        );
        assert!(
            whole.unwrap().iter().all(|one| one.value.is_u64() || one.value.is_i64()),
            "fields that count take them"
        );
    }

    #[test]
    fn random_values_repeat_and_more_of_them_begin_alike() {
        let draw = |text: &str| names(text).unwrap();
        let few = draw("{random: {from: 2, to: 3, count: 5}}");
        assert_eq!(few, draw("{random: {from: 2, to: 3, count: 9}}")[..5]);
        assert_ne!(few, draw("{random: {from: 2, to: 3, count: 5, seed: 8}}"));
        assert_eq!(
            few,
            draw("{random: {from: 2, to: 3, count: 5, seed: 7}}"),
            "the spec's seed is the default"
        );
        let log: Vec<f64> = draw("{random: {from: 1e-6, to: 1, count: 400, log: true}}")
            .iter()
            .map(|x| x.parse().unwrap())
            .collect();
        let below = log.iter().filter(|&&value| value < 1e-3).count();
        assert!(
            (150..250).contains(&below),
            "half of the values lie in the lower half of the decades: {below}"
        );
        assert!(log.iter().all(|value| (1e-6..1.0).contains(value)));
    }

    #[test]
    fn what_makes_no_series_is_refused() {
        let cases = [
            ("[]", "(whole document): found no values"),
            ("3", "(whole document): found 3, expected a list, or one of"),
            (
                "{rang: {}}",
                "(whole document): found the unknown key `rang`, expected a list, or one of",
            ),
            ("{range: {from: 0, to: 1}}", "range: found neither `count` nor `step`"),
            ("{range: {from: 0, to: 1, count: 3, step: 1}}", "range: found both"),
            ("{range: {from: 0, to: 1, count: 1}}", "range.count: found 1, expected at least 2"),
            ("{range: {from: 0, to: 1, count: 0}}", "range.count: found 0, expected at least 2"),
            (
                "{range: {from: 1, to: 1, count: 3}}",
                "range.from: found 1 to 1, expected two finite numbers",
            ),
            ("{range: {from: 0, to: .inf, count: 3}}", "range.from: found 0 to inf"),
            ("{range: {from: 0, to: 1, step: 2}}", "range.step: found 2, expected at most 1"),
            (
                "{range: {from: 0, to: 1, step: 1e-9}}",
                "range.step: found 1000000001 values, expected at most",
            ),
            (
                "{range: {from: 0, to: 1, count: 1000000}}",
                "range.count: found 1000000 values, expected at most",
            ),
            ("{range: {from: 0, to: 1, cuont: 3}}", "range.cuont: found the unknown key `cuont`"),
            (
                "{range: {from: 0, to: x, count: 3}}",
                "range.to: found text \"x\", expected a number",
            ),
            (
                "{log_range: {from: 0, to: 1, count: 3}}",
                "log_range.from: found 0, expected a number above 0",
            ),
            (
                "{log_range: {from: 2, to: 1, count: 3}}",
                "log_range.from: found 2 to 1, expected two finite numbers",
            ),
            (
                "{random: {from: -1, to: 1, count: 3, log: true}}",
                "random.from: found -1, expected a number above 0",
            ),
            ("{random: {to: 1, count: 3}}", "random.from: found no such key"),
            ("[1, 2, 1.0]", "found `1` twice"),
        ];
        for (text, expected) in cases {
            let said = names(text).unwrap_err();
            assert!(said.contains(expected), "{text}\n  {said}\n  {expected}");
        }
    }
}
