//! The number of a model that few robots have: likely one in another unit.

use spinebench::effects::Model;
use std::path::Path;

/// The number of the model in `file` that is furthest outside the range of most robots, with its
/// key; `None` where all are usual.
pub(crate) fn unusual_number(file: &Path, model: &Model) -> Option<String> {
    let (key, value) = model.robot.suspect()?;
    let file = file.display();
    Some(format!("{file}: {key}: found {value}, which few robots have; check its unit"))
}
