//! Checks of discovery options that name effects and parameters.

use crate::base::BadOption;
use crate::discovery::Options;
use crate::effects::{CATALOGUE, card};
use crate::specs::document::error::SpecError;
use crate::specs::document::merged::Document;
use crate::specs::document::mismatch::one_of;
use crate::specs::document::path::KeyPath;

/// Refuses names that are not in the catalogue and deviations that are not positive; `path` is the
/// path of the options in the document.
pub(crate) fn check_entries(
    document: &Document,
    options: &Options,
    path: &KeyPath,
) -> Result<(), SpecError> {
    let unless = |holds: bool, path: &KeyPath, expected: &[&str]| {
        if holds { Ok(()) } else { Err(document.wrong(path, one_of(expected))) }
    };
    let names: Vec<&str> = CATALOGUE.iter().map(|card| card.name).collect();
    for (index, name) in options.left_out.iter().enumerate() {
        unless(names.contains(&name.as_str()), &path.key("left_out").item(index), &names)?;
    }
    for (index, uncertainty) in options.uncertain.iter().enumerate() {
        let path = path.key("uncertain").item(index);
        let card = card(&uncertainty.effect)
            .ok_or_else(|| document.wrong(&path.key("effect"), one_of(&names)))?;
        let mut parameters: Vec<&str> =
            card.parameters.iter().map(|parameter| parameter.vector()).collect();
        parameters.dedup();
        unless(
            parameters.contains(&uncertainty.parameter.as_str()),
            &path.key("parameter"),
            &parameters,
        )?;
        BadOption::unless_positive("deviation", uncertainty.deviation)
            .map_err(|bad| document.wrong(&path.key(bad.key), bad.expected))?;
    }
    Ok(())
}
