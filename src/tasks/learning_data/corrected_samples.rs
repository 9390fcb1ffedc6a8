//! The approximated real data of policy B (eq. 24): simulated samples corrected by the error model,
//! p_exp = p_sim − e_gp.

use crate::base::{Point3, Rows};
use crate::policies::ErrorModel;
use crate::tasks::{TaskError, Transitions};

/// Corrects every position of `samples` by the error at the displacements that led to it; at the
/// start of a trajectory all displacements are zero.
///
/// # Errors
/// [`TaskError::NotFinite`] when the error model returns a number that is not finite.
pub fn correct_samples(
    samples: &Transitions,
    error: &dyn ErrorModel,
) -> Result<Transitions, TaskError> {
    let mut corrected = Transitions { from_m: Rows::new(3), to_m: Rows::new(3), ..samples.clone() };
    let home_pulls_m = vec![0.0; samples.pulls_m.width()];
    for range in samples.trajectories() {
        let mut from_m = corrected_m(error, &home_pulls_m, samples.from_m.row(range.start))?;
        for index in range {
            let to_m = corrected_m(error, samples.pulls_m.row(index), samples.to_m.row(index))?;
            corrected.from_m.push(&from_m);
            corrected.to_m.push(&to_m);
            // The end of a step is the start of the next, so that both are corrected alike.
            from_m = to_m;
        }
    }
    Ok(corrected)
}

fn corrected_m(
    error: &dyn ErrorModel,
    pulls_m: &[f64],
    p_sim_m: &[f64],
) -> Result<Point3, TaskError> {
    let p_sim_m = [p_sim_m[0], p_sim_m[1], p_sim_m[2]];
    let error_m = error.error_m(pulls_m, &p_sim_m);
    let p_exp_m: Point3 = std::array::from_fn(|axis| p_sim_m[axis] - error_m[axis]);
    if p_exp_m.iter().all(|value| value.is_finite()) {
        Ok(p_exp_m)
    } else {
        Err(TaskError::NotFinite("error model"))
    }
}
