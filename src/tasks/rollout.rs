//! What a learned forward model (eq. 17) makes of the commands of a recording: section IV-B's "learned dynamic neural
//! network" in the place of the rod.

use super::{TaskError, Transitions};
use crate::base::{Point3, Rows};
use crate::policies::ForwardModel;

/// The commands of `samples` played on a forward model, which starts each trajectory where the recording does and is
/// then on its own.
///
/// # Errors
/// [`TaskError::Model`] when the model gives a number that is not finite.
pub fn rollout(samples: &Transitions, model: &mut dyn ForwardModel) -> Result<Transitions, TaskError> {
    let mut predicted = Transitions { from_m: Rows::new(3), to_m: Rows::new(3), ..samples.clone() };
    for range in samples.trajectories() {
        let home_m = samples.from_m.row(range.start);
        let mut from_m: Point3 = [home_m[0], home_m[1], home_m[2]];
        model.reset(&from_m);
        for index in range {
            let to_m = model.next_m(samples.pulls_m.row(index))?;
            predicted.from_m.push(&from_m);
            predicted.to_m.push(&to_m);
            from_m = to_m;
        }
    }
    Ok(predicted)
}
