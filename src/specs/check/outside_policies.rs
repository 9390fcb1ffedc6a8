//! Checks of policies from outside: their names, and the files that hold them.

use super::experiment::is_name;
use crate::policies::{self, OutsidePolicy};
use crate::specs::document::error::SpecError;
use crate::specs::document::locate::PathEnd;
use crate::specs::document::merged::Document;
use crate::specs::document::path::KeyPath;
use crate::specs::experiment::spec::Experiment;

/// Refuses names that are taken and files that hold no policy of this robot.
pub(super) fn outside_policies(document: &Document, spec: &Experiment) -> Result<(), SpecError> {
    let root = KeyPath::default().key("policies").key("outside");
    for (name, policy) in &spec.policies.outside {
        let path = root.key(name);
        let refuse =
            |found: String, expected: String| document.refuse(&path, PathEnd::Key, found, expected);
        if !is_name(name) || policies::find(name).is_some() {
            let expected =
                "a name of letters, digits, `_` and `-` that no policy of the program has";
            return Err(refuse(format!("`{name}`"), expected.to_owned()));
        }
        let content = std::fs::read(policy.file()).map_err(|error| {
            refuse(
                format!("{}: {error}", policy.file().display()),
                "a file that can be read".into(),
            )
        })?;
        let tendons = spec.plant.tendons();
        let checked = policy.check_content(&content, tendons, &spec.policies.process);
        checked.map_err(|(found, expected)| {
            if let OutsidePolicy::Python(_) = policy {
                let class = path.key("python").key("class");
                document.refuse(&class, PathEnd::Value, found, expected)
            } else {
                refuse(found, expected)
            }
        })?;
    }
    Ok(())
}
