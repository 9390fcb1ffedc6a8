//! `spinebench schema`.

use super::shared::print_all;
use crate::cli::{CommandError, CommandResult};
use clap::{Args, ValueEnum};
use spinebench::specs::{self, SchemaOf};

/// Print the JSON Schema of a kind of file, for editors that complete and check YAML.
#[derive(Args)]
pub(crate) struct SchemaCommand {
    /// Kind of file.
    #[arg(value_enum, default_value_t = SchemaKind::Experiment)]
    kind: SchemaKind,
}

#[derive(Clone, Copy, ValueEnum)]
enum SchemaKind {
    /// Input of `run` and `plan`.
    Experiment,
    /// File for `--plant`.
    Plant,
    /// File for `--model`.
    Model,
    /// File for `import --map`.
    Map,
}

impl SchemaCommand {
    pub(crate) fn execute(self) -> CommandResult {
        let schema = specs::schema(match self.kind {
            SchemaKind::Experiment => SchemaOf::Experiment,
            SchemaKind::Plant => SchemaOf::Plant,
            SchemaKind::Model => SchemaOf::Model,
            SchemaKind::Map => SchemaOf::Map,
        });
        let text = serde_json::to_string_pretty(&schema).map_err(CommandError::failed)?;
        print_all((text + "\n").as_bytes());
        Ok(())
    }
}
