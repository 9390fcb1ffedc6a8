//! The `--sweep` option: `gp.kernel=a,b`, `gp.starts=1:9:3`, `log:…`, `random:…`.

use super::path::KeyPath;
use serde_yaml::{Mapping, Value};

/// What is expected after `=`.
pub(crate) const EXPECTED: &str = "values `a,b,c`, or `from:to:count`, `log:from:to:count`, \
                                   `random:from:to:count`, each with `:whole` for whole numbers";

/// The path and the values of `--sweep`, the values as in YAML.
///
/// # Errors
/// The malformed part.
pub(crate) fn parse(text: &str) -> Result<(KeyPath, Value), String> {
    let (path, values) = text.split_once('=').ok_or_else(|| format!("`{text}`"))?;
    let path = KeyPath::parse(path.trim())?;
    Ok((path, series(values.trim())?))
}

fn series(text: &str) -> Result<Value, String> {
    let parts: Vec<&str> = text.split(':').map(str::trim).collect();
    let number = |text: &str| text.parse::<f64>().is_ok();
    let (kind, numbers) = match parts.as_slice() {
        ["log", rest @ ..] => ("log_range", rest),
        ["random", rest @ ..] => ("random", rest),
        all @ [first, second, ..] if number(first) && number(second) => ("range", all),
        _ => return list(text),
    };
    let (numbers, flags) = numbers.split_at(numbers.len().min(3));
    let malformed = || format!("`{text}`");
    let mut form = Mapping::new();
    for (key, number) in ["from", "to", "count"].iter().zip(numbers) {
        let number: Value = serde_yaml::from_str(number).map_err(|_| malformed())?;
        form.insert(Value::from(*key), number);
    }
    for flag in flags {
        if !matches!((*flag, kind), ("whole", _) | ("log", "random")) {
            return Err(malformed());
        }
        form.insert(Value::from(*flag), Value::Bool(true));
    }
    let complete =
        numbers.len() == 3 && form.values().all(|value| value.is_number() || value.is_bool());
    if complete {
        Ok(Value::Mapping(Mapping::from_iter([(Value::from(kind), form.into())])))
    } else {
        Err(malformed())
    }
}

/// Values between commas, each as YAML; commas inside brackets or quotes separate nothing.
fn list(text: &str) -> Result<Value, String> {
    serde_yaml::from_str(&format!("[{text}]")).map_err(|_| format!("`{text}`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn yaml(text: &str) -> Value {
        serde_yaml::from_str(text).unwrap()
    }

    #[test]
    fn every_form_of_the_option_has_one_in_yaml() {
        let cases = [
            ("matern32, matern52", "[matern32, matern52]"),
            ("[50],[50, 100]", "[[50], [50, 100]]"),
            ("0.005:0.03:6", "{range: {from: 0.005, to: 0.03, count: 6}}"),
            ("log:1e-3:1e-1:5", "{log_range: {from: 1e-3, to: 1e-1, count: 5}}"),
            ("log:50:1000:4:whole", "{log_range: {from: 50, to: 1000, count: 4, whole: true}}"),
            ("random:-1:1:20", "{random: {from: -1, to: 1, count: 20}}"),
            ("random:1:10:20:log", "{random: {from: 1, to: 10, count: 20, log: true}}"),
            ("../models/a.yaml", "[../models/a.yaml]"),
            ("", "[]"),
        ];
        for (option, expected) in cases {
            assert_eq!(series(option), Ok(yaml(expected)), "{option}");
        }
        for malformed in [
            "1:2",
            "1:2:3:4",
            "log:1:2",
            "log:a:2:3",
            "random:1:2:3:loud",
            "1:2:3:log",
            "[1",
            "1:2:x",
        ] {
            assert!(series(malformed).is_err(), "{malformed}");
        }
        assert!(parse("gp.kernel").is_err());
        assert!(parse("gp..kernel=1").is_err());
    }
}
