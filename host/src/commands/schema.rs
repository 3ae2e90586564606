//! `massline schema`: the JSON schemas of the documents that other programs read.

use clap::builder::PossibleValuesParser;

use crate::Result;
use crate::output::{Output, table};
use massline_report::document::{Described, DescribedDocument, SchemaList};

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
    #[arg(value_parser = PossibleValuesParser::new(Described::ALL.map(|of| of.name)))]
    document: Option<String>,
}

/// Prints the schema, or the list of all.
///
/// # Errors
/// When stdout cannot be written.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let named = |of: &&Described| Some(of.name) == args.document.as_deref();
    if let Some(described) = Described::ALL.iter().find(named) {
        return output.verbatim(format!("{:#}", described.schema().to_value()));
    }
    let mut all = table();
    all.set_header(["document", "what it is", "printed by"]);
    for of in &Described::ALL {
        let commands =
            if of.commands.is_empty() { "all".to_owned() } else { of.commands.join(", ") };
        all.add_row([of.name, of.summary, commands.as_str()]);
    }
    let entry = |of: &Described| DescribedDocument {
        document: of.name,
        summary: of.summary,
        commands: of.commands,
    };
    let documents = Described::ALL.iter().map(entry).collect();
    output.answer_table(&SchemaList { documents }, &all)
}
