//! `spinebench schema`.

use super::shared::print_all;
use crate::cli::{CommandError, CommandResult};
use clap::{Args, ValueEnum};
use spinebench::report::page::keys_table;
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

impl SchemaKind {
    fn schema(self) -> serde_json::Value {
        specs::schema(match self {
            SchemaKind::Experiment => SchemaOf::Experiment,
            SchemaKind::Plant => SchemaOf::Plant,
            SchemaKind::Model => SchemaOf::Model,
            SchemaKind::Map => SchemaOf::Map,
        })
    }
}

/// The keys of a kind of file as a Markdown table.
pub(crate) fn keys_markdown(kind: &str) -> Result<String, String> {
    let kind = SchemaKind::from_str(kind, true)?;
    Ok(keys_table(&kind.schema()))
}

impl SchemaCommand {
    pub(crate) fn execute(self) -> CommandResult {
        let schema = self.kind.schema();
        let text = serde_json::to_string_pretty(&schema).map_err(CommandError::failed)?;
        print_all((text + "\n").as_bytes());
        Ok(())
    }
}
