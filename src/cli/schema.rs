//! `spinebench schema`.

use super::{CommandError, CommandResult};
use clap::{Args, ValueEnum};
use spinebench::specs::{self, SchemaOf};
use std::io::Write as _;

/// Prints the JSON Schema of a kind of file, for editors that complete and check YAML.
#[derive(Args)]
pub(super) struct SchemaCommand {
    /// SchemaKind of file.
    #[arg(value_enum, default_value_t = SchemaKind::Experiment)]
    kind: SchemaKind,
}

#[derive(Clone, Copy, ValueEnum)]
enum SchemaKind {
    /// What `run` and `plan` take.
    Experiment,
    /// What `--plant` takes.
    Plant,
    /// What `--model` takes.
    Model,
}

impl SchemaCommand {
    pub(super) fn execute(self) -> CommandResult {
        let schema = specs::schema(match self.kind {
            SchemaKind::Experiment => SchemaOf::Experiment,
            SchemaKind::Plant => SchemaOf::Plant,
            SchemaKind::Model => SchemaOf::Model,
        });
        let text = serde_json::to_string_pretty(&schema).map_err(CommandError::failed)?;
        // A reader that has seen enough closes the pipe: no error.
        let _ = writeln!(std::io::stdout(), "{text}");
        Ok(())
    }
}
