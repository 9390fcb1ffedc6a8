//! A rod whose tendons stand where their drives are: the model of a robot of several segments as
//! controllers may ask it.

use crate::base::{Displacements, NoRestPose, Point3, RestPose, TendonCommand, TipModel};
use crate::effects::{DrivenModel, Model};
use crate::rod::Direction;

/// The rod with the effects of its model, held at the displacements of all tendons.
pub(super) struct DisplacedRod {
    /// Brought to rest where a question asks for it.
    driven: DrivenModel,
    /// Moves as the robot is commanded; nothing before the first command.
    moving: Option<DrivenModel>,
    lever_m: f64,
    /// Whether a pose depends on those before it.
    remembers: bool,
    /// The displacements that `driven` rests at, where the last question has an answer.
    resting_m: Option<Displacements>,
}

impl DisplacedRod {
    pub(super) fn new(model: &Model) -> DisplacedRod {
        DisplacedRod {
            driven: DrivenModel::new(model, &[]),
            moving: None,
            lever_m: model.robot.lever_m(),
            remembers: model.remembers_at_rest(),
            resting_m: None,
        }
    }

    /// Settles at these displacements, with memory from where the robot is.
    fn settle(&mut self, pulls_m: &[f64]) -> Result<Point3, NoRestPose> {
        let commands = commands(pulls_m);
        if self.resting_m.as_deref() != Some(pulls_m) {
            self.resting_m = None;
            if self.remembers {
                self.start_where_the_robot_is();
            }
            if let Err(error) = self.driven.settle(&commands) {
                // What a failed solve leaves behind is no start for the next.
                self.start_where_the_robot_is();
                return Err(NoRestPose(error.to_string()));
            }
            self.resting_m = Some(pulls_m.to_vec());
        }
        Ok(self.driven.observation(&commands, 0.0).tip_m)
    }

    fn start_where_the_robot_is(&mut self) {
        match &self.moving {
            Some(moving) => self.driven.clone_from(moving),
            None => self.driven.restart(),
        }
    }
}

fn commands(pulls_m: &[f64]) -> Vec<TendonCommand> {
    pulls_m.iter().map(|&pull_m| TendonCommand::Pull(pull_m)).collect()
}

impl TipModel for DisplacedRod {
    fn bends(&self) -> usize {
        self.driven.rod().params().tendons.len()
    }

    fn takes_displacements(&self) -> bool {
        true
    }

    fn lever_m(&self) -> f64 {
        self.lever_m
    }

    fn restart(&mut self) {
        self.driven.restart();
        (self.moving, self.resting_m) = (None, None);
    }

    fn follow(&mut self, pulls_m: &[f64], duration_s: f64) -> Result<Option<Point3>, NoRestPose> {
        let commands = commands(pulls_m);
        let moving = self.moving.get_or_insert_with(|| {
            let mut moving = self.driven.clone();
            moving.restart();
            moving
        });
        let moved = if duration_s.is_finite() {
            moving.advance(&commands, duration_s)
        } else {
            moving.settle(&commands)
        };
        moved.map_err(|error| NoRestPose(error.to_string()))?;
        let tip_m = moving.observation(&commands, 0.0).tip_m;
        if self.remembers {
            self.resting_m = None;
        }
        Ok(Some(tip_m))
    }

    fn at_rest(&mut self, pulls_m: &[f64]) -> Result<RestPose, NoRestPose> {
        let tip_m = self.settle(pulls_m)?;
        Ok(RestPose { pulls_m: pulls_m.to_vec(), tip_m })
    }

    fn tip_per_bend(&mut self, pulls_m: &[f64]) -> Result<Vec<Point3>, NoRestPose> {
        self.settle(pulls_m)?;
        let directions: Vec<Direction> = (0..pulls_m.len()).map(Direction::Pull).collect();
        // The derivative is taken on a copy: the model hands its rod out to be read.
        let rates = self.driven.rod().clone().tip_jacobian(&directions);
        let rates =
            rates.ok_or_else(|| NoRestPose("the tangent at rest is singular".to_owned()))?;
        Ok(rates.iter().map(|rate| rate.position_m.into()).collect())
    }
}
