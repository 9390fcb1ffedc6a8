//! Rollout of a learned forward model (eq. 17) over the commands of a recording: section IV-B's
//! "learned dynamic neural network" in place of the rod.

use crate::base::{Point3, Rows};
use crate::policies::ForwardModel;
use crate::tasks::{TaskError, Transitions};

/// The response of a forward model to the commands of `samples`. Each trajectory starts at the
/// recorded tip and continues from the model's own predictions.
///
/// # Errors
/// [`TaskError::Model`] when the model returns a number that is not finite.
pub fn rollout(
    samples: &Transitions,
    model: &mut dyn ForwardModel,
) -> Result<Transitions, TaskError> {
    let mut predicted = Transitions { from_m: Rows::new(3), to_m: Rows::new(3), ..samples.clone() };
    for range in samples.trajectories() {
        let home_m = samples.from_m.row(range.start);
        let mut from_m: Point3 = [home_m[0], home_m[1], home_m[2]];
        model.reset(&from_m);
        for index in range {
            let to_m = model.next_m(samples.pulls_m.row(index))?;
            predicted.from_m.push(&from_m);
            predicted.to_m.push(&to_m);
            // Free run: errors add up, as they do where no tip is measured.
            from_m = to_m;
        }
    }
    Ok(predicted)
}
