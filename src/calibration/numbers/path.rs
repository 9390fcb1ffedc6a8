//! Paths of numbers in a model file, as `--fit` names them: single numbers, and groups with `*`.

use serde_json::Value;
use strsim::levenshtein;

use crate::calibration::error::CalibrationError;
use crate::effects::{Model, ModelParameter};

/// The parameters of `model` that `pattern` names: a path such as `robot.tendons.angles_deg[3]`,
/// where `*` stands for any name or index and everything below the last one is included. `robot.`
/// may be left out, and the effect's name may stand after its index
/// (`effects[0].tip_load.mass_kg`).
///
/// # Errors
/// [`CalibrationError::Unknown`] with the nearest path, [`CalibrationError::NoNumber`] for a path
/// of something else.
pub(crate) fn named(model: &Model, pattern: &str) -> Result<Vec<ModelParameter>, CalibrationError> {
    let all = ModelParameter::all(model);
    for candidate in [pattern.to_owned(), format!("robot.{pattern}")] {
        let parameters: Vec<ModelParameter> = all
            .iter()
            .filter(|parameter| {
                spellings(model, parameter.path()).iter().any(|path| matches(&candidate, path))
            })
            .cloned()
            .collect();
        if !parameters.is_empty() {
            return Ok(parameters);
        }
    }
    for candidate in [pattern.to_owned(), format!("robot.{pattern}")] {
        if let Some(found) = something_else(model, &candidate) {
            return Err(CalibrationError::NoNumber { name: pattern.to_owned(), found });
        }
    }
    Err(CalibrationError::Unknown {
        name: pattern.to_owned(),
        suggestion: suggestion(model, pattern, &all),
    })
}

/// A path, and for an effect the one with its name after the index.
fn spellings(model: &Model, path: &str) -> Vec<String> {
    let mut spellings = vec![path.to_owned()];
    let parts = path.strip_prefix("effects[").and_then(|rest| rest.split_once("]."));
    if let Some((index, field)) = parts
        && let Some(effect) = index.parse().ok().and_then(|index: usize| model.effects.get(index))
    {
        spellings.push(format!("effects[{index}].{}.{field}", effect.card().name));
    }
    spellings
}

/// The steps of a path: `a.b[0]` is `a`, `b`, `[0]`.
fn steps(path: &str) -> Vec<String> {
    path.replace('[', ".[").split('.').filter(|step| !step.is_empty()).map(str::to_owned).collect()
}

/// Whether `path` is `pattern`, or below it when `pattern` has a `*`.
fn matches(pattern: &str, path: &str) -> bool {
    let (pattern, path) = (steps(pattern), steps(path));
    let complete = pattern.len() == path.len()
        || pattern.len() < path.len() && pattern.iter().any(|p| p.contains('*'));
    complete && pattern.iter().zip(&path).all(|(pattern, step)| like(pattern, step))
}

/// Whether one step, or one label, is like a pattern with any number of `*`.
pub(crate) fn like(pattern: &str, step: &str) -> bool {
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or_default();
    let Some(mut rest) = step.strip_prefix(first) else { return false };
    let parts: Vec<&str> = parts.collect();
    // Earliest match of each middle part leaves most text for those after it.
    let Some((last, middle)) = parts.split_last() else { return rest.is_empty() };
    for part in middle {
        let Some(place) = rest.find(part) else { return false };
        rest = &rest[place + part.len()..];
    }
    rest.ends_with(last)
}

/// What stands at a path that holds no real number.
fn something_else(model: &Model, path: &str) -> Option<String> {
    let mut root = serde_json::to_value(model).ok()?;
    if let Some(resolution) = root.pointer_mut("/robot/resolution") {
        resolution.take();
        if path.starts_with("robot.resolution") {
            return Some("the numerical resolution, which is not fitted".to_owned());
        }
    }
    let pointer = format!("/{}", path.replace(']', "").replace(['.', '['], "/"));
    match root.pointer(&pointer)? {
        Value::Array(items) => {
            Some(format!("a list of {}; `{path}[*]` selects all of it", items.len()))
        }
        Value::Object(_) => Some(format!("a group of keys; `{path}.*` selects all numbers in it")),
        Value::Number(number) => Some(format!("{number}, a whole number, which is not fitted")),
        Value::Null => None,
        other => Some(format!("`{other}`")),
    }
}

/// The end of a sentence that proposes what may have been meant.
fn suggestion(model: &Model, pattern: &str, all: &[ModelParameter]) -> String {
    if let Some(why) = left_out_key(model, pattern) {
        return why;
    }
    let last = |path: &str| {
        steps(path).into_iter().rfind(|step| !step.starts_with('[')).unwrap_or_default()
    };
    let distance = |path: &str| {
        let whole = levenshtein(pattern, path).min(levenshtein(&format!("robot.{pattern}"), path));
        // The last word carries the meaning, so a typing error there counts more.
        whole + 2 * levenshtein(&last(pattern), &last(path))
    };
    let nearest = all.iter().map(ModelParameter::path).min_by_key(|path| distance(path));
    nearest.map_or_else(String::new, |path| format!("; the nearest one is `{path}`"))
}

/// Whether the path is one that a model file may have, but this one leaves out.
fn left_out_key(model: &Model, pattern: &str) -> Option<String> {
    const OPTIONAL: &[&str] = &[
        "radii_m",
        "twists_rad_m",
        "elastic_length_m",
        "starts_m",
        "ends_m",
        "paths",
        "profile",
        "positions_m",
        "masses_kg",
        "bending_stiffness_n_m2",
        "axial_stiffness_n",
        "shear_stiffness_n",
        "torsion_stiffness_n_m2",
        "pieces",
        "loads",
        "drives",
        "points",
    ];
    let present = ModelParameter::all(model);
    let step = steps(pattern).into_iter().find(|step| OPTIONAL.contains(&step.as_str()))?;
    let absent = !present.iter().any(|parameter| steps(parameter.path()).contains(&step));
    absent
        .then(|| format!("; this model file omits `{step}`: add it to the file with a start value"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::EffectSpec;

    fn paths(pattern: &str) -> Vec<String> {
        let model = Model { effects: vec![EffectSpec::tip_load(0.02)], ..Model::default() };
        named(&model, pattern)
            .unwrap()
            .iter()
            .map(|parameter| parameter.path().to_owned())
            .collect()
    }

    #[test]
    fn stars_name_groups_and_what_is_below_them() {
        assert_eq!(paths("robot.tendons.angles_deg[3]"), ["robot.tendons.angles_deg[3]"]);
        assert_eq!(paths("tendons.angles_deg[*]").len(), 4);
        assert_eq!(paths("base_*").len(), 6);
        assert_eq!(paths("effects[0].tip_load.mass_kg"), ["effects[0].mass_kg"]);
        assert_eq!(paths("effects[*].*"), ["effects[0].mass_kg"]);
        assert_eq!(
            paths("robot.sections.*"),
            [
                "robot.sections.compliance_m_per_n",
                "robot.sections.length_m",
                "robot.sections.saturation_n"
            ]
        );
    }

    #[test]
    fn what_is_no_number_is_told_and_the_nearest_proposed() {
        let words = |pattern: &str| named(&Model::default(), pattern).unwrap_err().to_string();
        assert!(
            words("robot.backbone.youngs_modulus").ends_with("`robot.backbone.youngs_modulus_pa`")
        );
        assert!(
            words("poisson_ratio").ends_with("`robot.backbone.poisson_ratio`"),
            "{}",
            words("poisson_ratio")
        );
        assert!(words("robot.tendons.angles_deg").contains("`robot.tendons.angles_deg[*]`"));
        assert!(words("robot.sections").contains("a group of keys"));
        assert!(words("robot.disks.count").contains("a whole number"));
        assert!(words("robot.resolution.cell_m").contains("resolution"));
        assert!(words("robot.tendons.radii_m[0]").contains("omits `radii_m`"));
        assert!(words("robot.tendons.angles_deg[4]").contains("angles_deg["));
    }

    #[test]
    fn a_star_stands_for_any_text() {
        assert!(
            like("rep*_pair*", "rep1_pair12_same")
                && like("*", "")
                && like("a*c", "abc")
                && like("ab", "ab")
        );
        assert!(!like("a*c", "abd") && !like("ab", "abc") && !like("*x*", "abc"));
    }
}
