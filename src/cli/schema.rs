//! `spinebench schema`.

use super::{Ended, Outcome};
use clap::{Args, ValueEnum};
use spinebench::specs::{self, SchemaOf};
use std::io::Write as _;

/// Prints the JSON Schema of a kind of file, for editors that complete and check YAML.
#[derive(Args)]
pub(super) struct Schema {
    /// Kind of file.
    #[arg(value_enum, default_value_t = Kind::Experiment)]
    kind: Kind,
}

#[derive(Clone, Copy, ValueEnum)]
enum Kind {
    /// What `run` and `plan` take.
    Experiment,
    /// What `--plant` takes.
    Plant,
    /// What `--model` takes.
    Model,
}

impl Schema {
    pub(super) fn carry_out(self) -> Outcome {
        let schema = specs::schema(match self.kind {
            Kind::Experiment => SchemaOf::Experiment,
            Kind::Plant => SchemaOf::Plant,
            Kind::Model => SchemaOf::Model,
        });
        let text = serde_json::to_string_pretty(&schema).map_err(Ended::failed)?;
        // A reader that has seen enough closes the pipe: no error.
        let _ = writeln!(std::io::stdout(), "{text}");
        Ok(())
    }
}
