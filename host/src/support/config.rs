//! The user's configuration file: defaults of options, for those who do not want to repeat them. The command line comes
//! before the environment, and the environment before this file.
//!
//! ```toml
//! # For every command that has the option.
//! port = "/dev/ttyACM0"
//! color = "never"
//!
//! # For one command.
//! [export]
//! units = "t-mm"
//! ```

use std::env;
use std::path::{Path, PathBuf};

use clap::{Arg, ArgAction, Command, ValueEnum};
use massline_toml::{TomlError, excerpt, line_of};
use toml::de::{DeTable, DeValue};

use crate::output::ColorChoice;
use crate::{Error, Result};
use massline_client::PORT_VARIABLE;
use massline_files::toml_file;

/// Environment variable with the path of the file; empty for no file.
pub(crate) const VARIABLE: &str = "MASSLINE_CONFIG";
/// Code of the errors of this module.
const MALFORMED: &str = "config_malformed";

/// A configuration file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Config {
    path: PathBuf,
    entries: Vec<Entry>,
}

/// A key of the file and what is written there.
#[derive(Clone, Debug, PartialEq)]
struct Entry {
    key: String,
    line: usize,
    value: Value,
}

#[derive(Clone, Debug, PartialEq)]
enum Value {
    /// A value of an option, or several, as they would stand on the command line.
    Words(Vec<String>),
    /// The options of a command.
    Table(Vec<Entry>),
    /// What no option takes, as it is written.
    Other(String),
}

/// What is wrong with an entry.
struct EntryError {
    line: usize,
    text: String,
}

impl Config {
    /// The file that the environment names, else the one in the user's folder for configurations, if it is there.
    ///
    /// # Errors
    /// Exit 2 when the file cannot be read or is not TOML.
    pub(crate) fn of_user() -> Result<Self> {
        let named = env::var_os(VARIABLE);
        let path = match named {
            Some(path) if path.is_empty() => return Ok(Self::default()),
            Some(path) => PathBuf::from(path),
            None => match usual_path() {
                Some(path) if path.is_file() => path,
                _ => return Ok(Self::default()),
            },
        };
        let text = toml_file::read(&path, MALFORMED).map_err(|e| advised(&e.to_string()))?;
        let config = Self { path, entries: Vec::new() };
        match massline_toml::parse(&text) {
            Ok(table) => Ok(Self { entries: entries(table.get_ref(), &text), ..config }),
            Err(error) => {
                let line = error.line(&text);
                let TomlError { key, message, .. } = error;
                let colon = if key.is_empty() { "" } else { ": " };
                Err(config.error(&EntryError { line, text: format!("{key}{colon}{message}") }))
            }
        }
    }

    /// What it says about colours.
    pub(crate) fn color(&self) -> Option<ColorChoice> {
        let entry = self.entries.iter().find(|entry| entry.key == "color")?;
        match &entry.value {
            Value::Words(words) => ColorChoice::from_str(words.first()?, false).ok(),
            Value::Table(_) | Value::Other(_) => None,
        }
    }

    /// The command line with these defaults.
    ///
    /// # Errors
    /// Exit 2 for an option or a command that does not exist, and for a value that the option does not take.
    pub(crate) fn apply(&self, mut command: Command) -> Result<Command> {
        for entry in &self.entries {
            let changed = match &entry.value {
                Value::Table(of_command) => set_command(command, entry, of_command),
                _ if is_in_environment(&entry.key) => Ok(command),
                _ => set_everywhere(command, entry),
            };
            command = changed.map_err(|wrong| self.error(&wrong))?;
        }
        Ok(command)
    }

    fn error(&self, EntryError { line, text }: &EntryError) -> Error {
        advised(&format!("{}:{line}: {text}", self.path.display()))
    }
}

/// The keys of a table.
fn entries(table: &DeTable, text: &str) -> Vec<Entry> {
    let mut table_entries = Vec::new();
    for (key, value) in table {
        let words = match value.get_ref() {
            DeValue::Array(values) => values.iter().map(|value| word(value.get_ref())).collect(),
            other => word(other).map(|word| vec![word]),
        };
        let written = || excerpt(text.get(value.span()).unwrap_or_default());
        table_entries.push(Entry {
            key: key.get_ref().clone().into_owned(),
            line: line_of(text, key.span().start),
            value: match value.get_ref() {
                DeValue::Table(below) => Value::Table(entries(below, text)),
                _ => words.map_or_else(|| Value::Other(written()), Value::Words),
            },
        });
    }
    table_entries
}

/// A value as on the command line.
fn word(value: &DeValue) -> Option<String> {
    match value {
        DeValue::String(text) => Some(text.clone().into_owned()),
        DeValue::Integer(number) => {
            let digits = number.as_str().replace('_', "");
            Some(i64::from_str_radix(&digits, number.radix()).ok()?.to_string())
        }
        DeValue::Float(number) => Some(number.as_str().replace('_', "")),
        _ => None,
    }
}

/// A command line in which a command has these defaults.
fn set_command(
    command: Command,
    entry: &Entry,
    of_command: &[Entry],
) -> Result<Command, EntryError> {
    let name = &entry.key;
    if command.find_subcommand(name).is_none() {
        let text = format!("[{name}]: there is no such command");
        return Err(EntryError { line: entry.line, text });
    }
    let mut failed = None;
    let command = command.mut_subcommand(name, |mut command| {
        for entry in of_command {
            let changed = match &entry.value {
                Value::Table(below) => set_command(command.clone(), entry, below),
                _ if is_in_environment(&entry.key) && has(&command, &entry.key) => continue,
                _ => with_default(command.clone(), entry),
            };
            match changed {
                Ok(changed) => command = changed,
                Err(EntryError { line, text }) => {
                    failed = Some(EntryError { line, text: format!("[{name}]: {text}") });
                }
            }
        }
        command
    });
    failed.map_or(Ok(command), Err)
}

/// Where a configuration lies when nothing else is said.
pub(crate) fn usual_path() -> Option<PathBuf> {
    let folder =
        |variable: &str| env::var_os(variable).filter(|v| !v.is_empty()).map(PathBuf::from);
    let base = if cfg!(windows) {
        folder("APPDATA")?
    } else {
        folder("XDG_CONFIG_HOME").or_else(|| Some(folder("HOME")?.join(".config")))?
    };
    Some(base.join(Path::new("massline/config.toml")))
}

/// Whether a variable of the environment states this option.
fn is_in_environment(key: &str) -> bool {
    key == "port" && env::var_os(PORT_VARIABLE).is_some_and(|value| !value.is_empty())
}

/// An error with the way out.
fn advised(text: &str) -> Error {
    let advice = format!("correct the configuration, or do without it: {VARIABLE}= massline …");
    Error::input(MALFORMED, format!("{text}; {advice}"))
}

/// The option of this name with this default, in every command that has it.
fn set_everywhere(command: Command, entry: &Entry) -> Result<Command, EntryError> {
    let Entry { key, line, .. } = entry;
    if command.find_subcommand(key).is_some() {
        let text = format!("{key}: this is a command; its options stand below one line [{key}]");
        return Err(EntryError { line: *line, text });
    }
    if !has(&command, key) {
        let text = format!("{key}: no command has the option --{key}");
        return Err(EntryError { line: *line, text });
    }
    set_below(command, entry)
}

fn set_below(mut command: Command, entry: &Entry) -> Result<Command, EntryError> {
    if option(&command, &entry.key).is_some() {
        command = with_default(command, entry)?;
    }
    let names: Vec<String> = command.get_subcommands().map(|c| c.get_name().to_owned()).collect();
    for name in names {
        let mut failed = None;
        command = command.mut_subcommand(name, |command| {
            set_below(command.clone(), entry).unwrap_or_else(|wrong| {
                failed = Some(wrong);
                command
            })
        });
        if let Some(wrong) = failed {
            return Err(wrong);
        }
    }
    Ok(command)
}

fn has(command: &Command, key: &str) -> bool {
    option(command, key).is_some() || command.get_subcommands().any(|command| has(command, key))
}

fn option<'c>(command: &'c Command, key: &str) -> Option<&'c Arg> {
    command.get_arguments().find(|arg| arg.get_long() == Some(key))
}

/// A command whose option of this name has this default.
fn with_default(command: Command, entry: &Entry) -> Result<Command, EntryError> {
    let key = &entry.key;
    let wrong = |text: String| EntryError { line: entry.line, text: format!("{key}: {text}") };
    let Some(arg) = option(&command, key) else {
        let command = command.get_name();
        return Err(wrong(format!("`massline {command}` has no option --{key}")));
    };
    if !arg.get_action().takes_values() {
        return Err(wrong("this option is a switch; give it on the command line".into()));
    }
    let values = match &entry.value {
        Value::Words(words) if words.is_empty() => {
            return Err(wrong("the list is empty; leave the line out".into()));
        }
        Value::Words(words) if words.len() > 1 && !takes_several(arg) => {
            return Err(wrong(format!("one value is wanted, and here are {}", words.len())));
        }
        Value::Words(words) => words.clone(),
        Value::Other(written) => {
            let text = format!("give a text, a number, or a list of them, and not {written}");
            return Err(wrong(text));
        }
        Value::Table(_) => return Err(wrong("this is an option, and no command".into())),
    };
    let possible = arg.get_possible_values();
    let is_possible = |word: &String| possible.iter().any(|value| value.matches(word, false));
    if let (false, Some(other)) =
        (possible.is_empty(), values.iter().find(|word| !is_possible(word)))
    {
        let known: Vec<_> = possible.iter().map(|value| value.get_name().to_owned()).collect();
        return Err(wrong(format!("\"{other}\" is not one of {}", known.join(", "))));
    }
    check(arg, key, &values).map_err(wrong)?;
    let id = arg.get_id().clone();
    // The command line lives as long as the program.
    let values = values.into_iter().map(|value| &*value.leak());
    Ok(command.mut_arg(id, |arg| arg.required(false).default_values(values)))
}

fn takes_several(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::Append) || arg.get_value_delimiter().is_some()
}

/// Refuses values that the option does not take. Left to the command line, the error would blame the person who typed
/// it.
fn check(arg: &Arg, key: &str, values: &[String]) -> Result<(), String> {
    // The command line lives as long as the program.
    let long: &'static str = key.to_owned().leak();
    let mut alone = Arg::new("value")
        .long(long)
        .action(ArgAction::Append)
        .value_parser(arg.get_value_parser().clone());
    if let Some(delimiter) = arg.get_value_delimiter() {
        alone = alone.value_delimiter(delimiter);
    }
    let words = values.iter().map(|value| format!("--{key}={value}"));
    let parsed =
        Command::new("massline").no_binary_name(true).arg(alone).try_get_matches_from(words);
    parsed.map(|_| ()).map_err(|error| {
        let text = error.to_string();
        let text = text.lines().next().unwrap_or_default();
        text.strip_prefix("error: ").unwrap_or(text).to_owned()
    })
}
