//! Names of packages and tasks, and their order.

use super::ratios::{OURS, TaskRows};
use crate::report::order::Labels;

/// Packages in their order, and their names.
pub(super) const PACKAGES: Labels = Labels(&[
    (OURS, "spinebench"),
    ("scipy", "NumPy/SciPy by hand"),
    ("scikit_learn", "scikit-learn"),
    ("gpy", "GPy"),
    ("gpytorch", "GPyTorch"),
    ("pytorch", "PyTorch"),
]);

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
    if number < 1000 {
        number.to_string()
    } else {
        format!("{},{:03}", number / 1000, number % 1000)
    }
}
