//! `spinebench collect`.

use super::simulate::{failures, same_tendons};
use super::{Ended, Outcome};
use clap::Args;
use spinebench::base::{Plant, Seed};
use spinebench::data::{Actuation, Recording};
use spinebench::specs::{PlantSpec, SimulatedSpec, read_plant};
use spinebench::tasks::{PlayOptions, play, record_trial, step_s};
use std::path::{Path, PathBuf};

/// Plays commands on a plant and records what its tracker measures.
#[derive(Args)]
pub(super) struct Collect {
    /// Plant file, such as `simulated: {model: real.yaml, noise_m: 0.0005}`.
    #[arg(long, value_name = "PLANT.yaml")]
    plant: PathBuf,
    /// Commands: a recording, whose tip columns may be missing; CSV or Parquet.
    #[arg(long, value_name = "IN.csv")]
    commands: PathBuf,
    /// Recording to write; CSV or Parquet.
    #[arg(long, value_name = "REC.csv")]
    out: PathBuf,
    /// Seed of the measurement noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Every row is measured once the robot has come to rest under its command.
    #[arg(long = "static")]
    at_rest: bool,
}

impl Collect {
    pub(super) fn carry_out(self) -> Outcome {
        let plant = read_plant(&self.plant).map_err(Ended::bad)?;
        let commands = Recording::read_commands(&self.commands).map_err(Ended::bad)?;
        same_tendons(&self.commands, &commands, plant.tendons())?;
        match plant {
            PlantSpec::Simulated(plant) => self.simulate(&plant, &commands),
            other => self.record(&other, &commands),
        }
    }

    /// A simulated robot is solved as finely as `simulate` does, in steps as uneven as the commands'.
    fn simulate(&self, plant: &SimulatedSpec, commands: &Recording) -> Outcome {
        let options = PlayOptions {
            at_rest: self.at_rest,
            noise_m: plant.noise_m,
            travel_m: plant.travel_m,
            seed: Seed(self.seed),
        };
        let mut recorded = play(&plant.model, commands, &options);
        let failed = failures(&recorded);
        // A tracker sees the tip; what only the simulation knows stays out of a measurement.
        recorded.extra.clone_from(&commands.extra);
        recorded.tip_quaternion = None;
        recorded.write(&self.out).map_err(Ended::bad)?;
        if failed > 0 {
            let (all, out) = (recorded.len(), self.out.display());
            eprintln!("note: {failed} of {all} rows could not be measured; they have valid = 0 in {out}");
        }
        Ok(())
    }

    /// Any other plant is driven trial by trial. What has been recorded stands beside the recording until it is whole, so
    /// that a session that ends early goes on where it ended.
    fn record(&self, plant: &PlantSpec, commands: &Recording) -> Outcome {
        let file = self.commands.display();
        if self.at_rest {
            let kind = plant.kind();
            return Err(Ended::BadInput(format!("--static: found a {kind} plant, expected a simulated one")));
        }
        if commands.actuation != Actuation::Lengths {
            return Err(Ended::BadInput(format!(
                "{file}, line 1: found tensions, expected displacements (tendon_1_m…)"
            )));
        }
        let step_s = step_s(commands).map_err(|error| Ended::BadInput(format!("{file}: {error}")))?;
        let session = Session::open(&self.out, commands)?;
        let mut plant = plant.build(step_s).map_err(Ended::failed)?;
        session.go_on(plant.as_mut(), commands, Seed(self.seed))
    }
}

/// A recording under way.
struct Session<'a> {
    out: &'a Path,
    part: PathBuf,
    done: Vec<Recording>,
}

impl<'a> Session<'a> {
    /// What an earlier session has left of the recording `out` of these `commands`.
    fn open(out: &'a Path, commands: &Recording) -> Result<Session<'a>, Ended> {
        let extension = out.extension().map_or("csv".into(), |extension| extension.to_string_lossy().into_owned());
        let part = out.with_extension(format!("part.{extension}"));
        if !part.exists() {
            return Ok(Session { out, part, done: Vec::new() });
        }
        let earlier = Recording::read(&part).map_err(Ended::bad)?;
        let count = earlier.len();
        let same = count <= commands.len()
            && earlier.trial == commands.trial[..count]
            && earlier.time_s == commands.time_s[..count]
            && (0..count).all(|row| earlier.commands.row(row) == commands.commands.row(row));
        if !same {
            let part = part.display();
            return Err(Ended::BadInput(format!(
                "{part}: found a recording of other commands, expected the first trials of these; remove it to begin anew"
            )));
        }
        let (done, all) = (earlier.trials().len(), commands.trials().len());
        eprintln!("note: {}: goes on after {done} of {all} trials", part.display());
        Ok(Session { out, part, done: vec![earlier] })
    }

    fn go_on(mut self, plant: &mut dyn Plant, commands: &Recording, seed: Seed) -> Outcome {
        let (trials, recorded) = (commands.trials(), self.done.iter().map(Recording::len).sum::<usize>());
        let mut hung_kg = 0.0;
        for (number, rows) in trials.iter().filter(|(_, rows)| rows.start >= recorded) {
            let load_kg = commands.known_load_kg.as_ref().map_or(0.0, |load| load[rows.start]);
            if load_kg != hung_kg {
                ask(&format!("trial {number}: hang {:.1} g on the tip (0: take it off)", load_kg * 1e3))?;
                hung_kg = load_kg;
            }
            match record_trial(plant, commands, rows.clone(), seed.index(*number)) {
                Ok(trial) => self.keep(trial)?,
                Err(error) => {
                    let (done, all) = (self.trials(), trials.len());
                    let words = "the same command goes on from there";
                    return Err(Ended::No(format!(
                        "trial {number}: {error}; {done} of {all} trials are kept, {words}"
                    )));
                }
            }
        }
        let whole = Recording::joined(&self.done).map_err(Ended::failed)?;
        whole.write(self.out).map_err(Ended::bad)?;
        if self.part.exists() {
            std::fs::remove_file(&self.part).map_err(|error| Ended::No(format!("{}: {error}", self.part.display())))?;
        }
        Ok(())
    }

    fn trials(&self) -> usize {
        self.done.iter().map(|part| part.trials().len()).sum()
    }

    fn keep(&mut self, trial: Recording) -> Outcome {
        self.done.push(trial);
        let all = Recording::joined(&self.done).map_err(Ended::failed)?;
        all.write(&self.part).map_err(Ended::bad)
    }
}

/// Waits until somebody has done what only hands can do.
fn ask(what: &str) -> Outcome {
    eprint!("{what}, then press Enter: ");
    let mut line = String::new();
    match std::io::stdin().read_line(&mut line) {
        Ok(count) if count > 0 => Ok(()),
        _ => Err(Ended::No(format!("nobody there to do this: {what}"))),
    }
}
