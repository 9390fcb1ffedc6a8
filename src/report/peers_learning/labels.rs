//! Names of packages and tasks, and their order.

use super::ratios::{OURS, TaskRows};

/// Packages in their order, and their names.
const PACKAGES: [(&str, &str); 6] = [
    (OURS, "spinebench"),
    ("scipy", "NumPy/SciPy by hand"),
    ("scikit_learn", "scikit-learn"),
    ("gpy", "GPy"),
    ("gpytorch", "GPyTorch"),
    ("pytorch", "PyTorch"),
];

/// The packages among these in their order, unknown ones last.
pub(super) fn order<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut found = crate::report::order::distinct(names);
    found.sort_by_key(|name| rank(name));
    found
}

/// Position of a package in its order; an unknown one follows the last.
pub(super) fn rank(peer: &str) -> usize {
    PACKAGES.iter().position(|(known, _)| *known == peer).unwrap_or(PACKAGES.len())
}

/// Name of a package.
pub(super) fn name(peer: &str) -> &str {
    PACKAGES.iter().find(|(known, _)| *known == peer).map_or(peer, |(_, name)| name)
}

/// What is done, with its size.
pub(super) fn title(task: &TaskRows) -> String {
    let size = task.size;
    match task.task {
        "fit" => format!("fit, N = {}", grouped(size)),
        "evaluation" => format!("likelihood and gradient, N = {}", grouped(size)),
        "predict_one" => format!("1 prediction, N = {}", grouped(size)),
        "predict_many" => format!("10,000 predictions, N = {}", grouped(size)),
        "epoch" => "Elman epoch".to_owned(),
        "until_error" => "Elman to 0.2 mm".to_owned(),
        "product_f64" => "matrix product, double precision".to_owned(),
        "product_f32" => "matrix product, single precision".to_owned(),
        other => format!("{other}, {size}"),
    }
}

/// 1000 as 1,000.
fn grouped(number: u64) -> String {
    if number < 1000 { number.to_string() } else { format!("{},{:03}", number / 1000, number % 1000) }
}
