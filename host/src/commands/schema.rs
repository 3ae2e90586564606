//! `massline schema`: the JSON schemas of the documents that other programs read.

use clap::builder::PossibleValuesParser;

use crate::Result;
use crate::output::{Output, table};
use massline_report::document::{DescribedDocument, DocumentKind, SchemaList};

/// Arguments of `massline schema`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A key may be added to a document at any time. `schema_version` counts changes that a program has to
know of.

Examples:
  massline schema
  massline schema result > result.schema.json")]
pub struct Args {
    /// Name of the document; without it, all of them are listed.
    #[arg(value_parser = PossibleValuesParser::new(DocumentKind::ALL.map(|kind| kind.name)))]
    document: Option<String>,
}

/// Prints the schema, or the list of all.
///
/// # Errors
/// When stdout cannot be written.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let named = |kind: &&DocumentKind| Some(kind.name) == args.document.as_deref();
    if let Some(kind) = DocumentKind::ALL.iter().find(named) {
        return output.verbatim(kind.schema.trim_end());
    }
    let mut table = table();
    table.set_header(["document", "what it is", "printed by"]);
    for kind in &DocumentKind::ALL {
        let commands =
            if kind.commands.is_empty() { "all".to_owned() } else { kind.commands.join(", ") };
        table.add_row([kind.name, kind.summary, commands.as_str()]);
    }
    let entry = |kind: &DocumentKind| DescribedDocument {
        document: kind.name,
        summary: kind.summary,
        commands: kind.commands,
    };
    let documents = DocumentKind::ALL.iter().map(entry).collect();
    output.answer_table(&SchemaList { documents }, &table)
}
