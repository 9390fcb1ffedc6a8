//! Parameters of effects as quantities: the unit that the name carries, in the size that a lab
//! speaks of.

use std::collections::BTreeMap;

use serde_json::Value;

use super::format::{NONE, decimals, number};
use crate::data::findings::FoundEffect;
use crate::report::drawing::signed;

/// A parameter, ready to print.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Quantity {
    /// Its key in the model, with the component where it is a vector.
    pub(super) key: String,
    /// Value with its unit.
    pub(super) value: String,
    /// Its 95 % interval with the unit; empty where there is none.
    pub(super) interval: String,
}

/// Ends of names, the factor to the unit that is printed, and that unit. The longer end stands
/// first.
const UNITS: [(&str, f64, &str); 14] = [
    ("_m_per_n", 1e3, "mm/N"),
    ("_rad_m", 1.0, "rad/m"),
    ("_kg_m3", 1.0, "kg/m³"),
    ("_kg_m", 1e3, "g/m"),
    ("_m_s2", 1.0, "m/s²"),
    ("_nm", 1e3, "mN m"),
    ("_kg", 1e3, "g"),
    ("_pa", 1e-6, "MPa"),
    ("_rad", 180.0 / std::f64::consts::PI, "°"),
    ("_deg", 1.0, "°"),
    ("_hz", 1.0, "Hz"),
    ("_m", 1e3, "mm"),
    ("_n", 1.0, "N"),
    ("_s", 1.0, "s"),
];

/// The parameters of an effect in the order of their keys, vectors by component.
pub(super) fn quantities(effect: &FoundEffect) -> Vec<Quantity> {
    let mut out = Vec::new();
    for (key, value) in &effect.parameters {
        let interval = interval_of(&effect.interval_95, key);
        match value {
            Value::Array(parts) => {
                let vector = interval.is_some_and(|ends| {
                    ends.as_array().is_some_and(|ends| ends.len() == parts.len())
                });
                for (index, part) in parts.iter().enumerate() {
                    let ends = interval.filter(|_| vector).and_then(|ends| ends.get(index));
                    out.push(quantity(&format!("{key}[{index}]"), key, part, ends));
                }
            }
            one => out.push(quantity(key, key, one, interval)),
        }
    }
    out
}

/// The interval of a parameter.
fn interval_of<'a>(intervals: &'a BTreeMap<String, Value>, key: &str) -> Option<&'a Value> {
    intervals.get(key).filter(|ends| !ends.is_null())
}

fn quantity(label: &str, key: &str, value: &Value, interval: Option<&Value>) -> Quantity {
    let (scale, unit) = unit(key);
    let ends = interval.and_then(ends).map(|ends| ends.map(|end| scale * end));
    let is_integer = value.is_u64() || value.is_i64();
    let value = match value.as_f64() {
        // A number of a tendon is no measurement.
        Some(value) if is_integer && ends.is_none() && unit.is_empty() => number(value, 1),
        Some(value) => with_unit(&rounded(scale * value, ends), unit),
        None if value.is_null() => NONE.to_owned(),
        None => value.as_str().map_or_else(|| value.to_string(), str::to_owned),
    };
    let interval = ends.map_or_else(String::new, |[low, high]| {
        with_unit(
            &format!("{} to {}", rounded(low, Some([low, high])), rounded(high, Some([low, high]))),
            unit,
        )
    });
    Quantity { key: label.to_owned(), value, interval }
}

/// Factor and unit of a parameter's name; none where it carries no unit.
fn unit(key: &str) -> (f64, &'static str) {
    UNITS
        .iter()
        .find(|(end, _, _)| key.ends_with(end))
        .map_or((1.0, ""), |(_, scale, unit)| (*scale, *unit))
}

/// Two finite numbers.
fn ends(interval: &Value) -> Option<[f64; 2]> {
    let ends = [interval.get(0)?.as_f64()?, interval.get(1)?.as_f64()?];
    ends.iter().all(|end| end.is_finite()).then_some(ends)
}

/// As many digits as the interval's half width bears, two of it where it begins with 1 to 3 and
/// else one (the Particle Data Group's rule); three without an interval.
fn rounded(value: f64, ends: Option<[f64; 2]>) -> String {
    match ends {
        Some([low, high]) if high > low => {
            let half = 0.5 * (high - low);
            let lead = half / 10f64.powf(half.log10().floor());
            signed(value, decimals(half, if lead < 3.55 { 2 } else { 1 }))
        }
        _ => number(value, 3),
    }
}

fn with_unit(value: &str, unit: &str) -> String {
    match unit {
        "" => value.to_owned(),
        "°" => format!("{value}°"),
        unit => format!("{value} {unit}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn effect(parameters: Value, intervals: Value) -> FoundEffect {
        FoundEffect {
            name: "some".to_owned(),
            parameters: serde_json::from_value(parameters).unwrap(),
            interval_95: serde_json::from_value(intervals).unwrap(),
            confidence: 1.0,
            confusable_with: Vec::new(),
        }
    }

    fn shown(parameters: Value, intervals: Value) -> Vec<[String; 3]> {
        quantities(&effect(parameters, intervals))
            .into_iter()
            .map(|one| [one.key, one.value, one.interval])
            .collect()
    }

    #[test]
    fn units_come_from_names_and_digits_from_intervals() {
        let shown = shown(
            json!({"mass_kg": 0.0197, "tendon": 2, "angle_rad": 0.05, "scale": 1.25, "compliance_m_per_n": 1e-4}),
            json!({"mass_kg": [0.0188, 0.0206], "scale": [1.2, 1.3]}),
        );
        let texts: Vec<[&str; 3]> =
            shown.iter().map(|one| one.each_ref().map(String::as_str)).collect();
        assert_eq!(
            texts,
            [
                ["angle_rad", "2.86°", ""],
                ["compliance_m_per_n", "0.100 mm/N", ""],
                ["mass_kg", "19.7 g", "18.8 to 20.6 g"],
                ["scale", "1.25", "1.20 to 1.30"],
                ["tendon", "2", ""],
            ]
        );
    }

    #[test]
    fn vectors_come_by_component_and_oddities_do_not_crash() {
        let vector = shown(
            json!({"force_n": [0.1, 0.0, -0.2]}),
            json!({"force_n": [[0.0, 0.2], null, [-0.3, -0.1]]}),
        );
        assert_eq!(vector[0], ["force_n[0]", "0.10 N", "0.00 to 0.20 N"]);
        assert_eq!(vector[1][2], "");
        assert_eq!(vector[2], ["force_n[2]", "−0.20 N", "−0.30 to −0.10 N"]);
        let odd = shown(
            json!({"a": null, "b": "<i>", "c": {"d": 1}, "e": []}),
            json!({"a": [1], "b": 3}),
        );
        assert_eq!(
            odd.iter().map(|one| one[1].as_str()).collect::<Vec<_>>(),
            ["–", "<i>", "{\"d\":1}"]
        );
    }
}
