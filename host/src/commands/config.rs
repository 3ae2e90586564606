//! The user's configuration file: defaults of options, for those who do not want to repeat them. The command line comes before
//! the environment, and the environment before this file.
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
use toml::{Table, Value};

use crate::client::PORT_VARIABLE;
use crate::error::{Error, Result};
use crate::output::ColorChoice;
use crate::toml_file;

/// Environment variable with the path of the file; empty for no file.
pub(super) const VARIABLE: &str = "MASSLINE_CONFIG";
/// Code of the errors of this module.
const MALFORMED: &str = "config_malformed";

/// A configuration file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Config {
    path: PathBuf,
    defaults: Table,
}

impl Config {
    /// The file that the environment names, else the one in the user's folder for configurations, if it is there.
    ///
    /// # Errors
    /// Exit 2 when the file cannot be read or is not TOML.
    pub(super) fn of_user() -> Result<Self> {
        let named = env::var_os(VARIABLE);
        let path = match named {
            Some(path) if path.is_empty() => return Ok(Self::default()),
            Some(path) => PathBuf::from(path),
            None => match usual_path() {
                Some(path) if path.is_file() => path,
                _ => return Ok(Self::default()),
            },
        };
        let read = || {
            let text = toml_file::read(&path, MALFORMED)?;
            toml_file::parse(&text, &path.display().to_string(), MALFORMED)
        };
        let defaults = read().map_err(|error| advised(&error))?;
        Ok(Self { path, defaults })
    }

    /// What it says about colours.
    pub(super) fn color(&self) -> Option<ColorChoice> {
        ColorChoice::from_str(self.defaults.get("color")?.as_str()?, false).ok()
    }

    /// The command line with these defaults.
    ///
    /// # Errors
    /// Exit 2 for an option or a command that does not exist, and for a value that the option does not take.
    pub(super) fn apply(&self, mut command: Command) -> Result<Command> {
        for (key, value) in &self.defaults {
            let within = |error: Error| advised(&error.within(self.path.display()));
            command = match value {
                Value::Table(of_command) => {
                    self.of_command(command, key, of_command).map_err(within)?
                }
                _ if is_in_environment(key) => command,
                _ => everywhere(command, key, value).map_err(within)?,
            };
        }
        Ok(command)
    }

    fn of_command(&self, command: Command, name: &str, defaults: &Table) -> Result<Command> {
        if command.find_subcommand(name).is_none() {
            return Err(Error::input(MALFORMED, format!("[{name}]: there is no such command")));
        }
        let mut failed = None;
        let command = command.mut_subcommand(name, |mut command| {
            for (key, value) in defaults {
                let changed = match value {
                    Value::Table(below) => self.of_command(command.clone(), key, below),
                    _ if is_in_environment(key) && has(&command, key) => continue,
                    _ => with_default(command.clone(), key, value),
                };
                match changed {
                    Ok(changed) => command = changed,
                    Err(error) => failed = Some(error.within(format!("[{name}]"))),
                }
            }
            command
        });
        failed.map_or(Ok(command), Err)
    }
}

/// Where a configuration lies when nothing else is said.
pub(super) fn usual_path() -> Option<PathBuf> {
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
fn advised(error: &Error) -> Error {
    let text =
        format!("{error}; correct the configuration, or do without it: {VARIABLE}= massline …");
    Error::input(MALFORMED, text)
}

/// The option of this name with this default, in every command that has it.
fn everywhere(command: Command, key: &str, value: &Value) -> Result<Command> {
    if !has(&command, key) {
        return Err(no_option(key));
    }
    below(command, key, value)
}

fn below(mut command: Command, key: &str, value: &Value) -> Result<Command> {
    if option(&command, key).is_some() {
        command = with_default(command, key, value)?;
    }
    let names: Vec<String> = command.get_subcommands().map(|c| c.get_name().to_owned()).collect();
    for name in names {
        let mut failed = None;
        command = command.mut_subcommand(name, |command| {
            below(command.clone(), key, value).unwrap_or_else(|error| {
                failed = Some(error);
                command
            })
        });
        if let Some(error) = failed {
            return Err(error);
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
fn with_default(command: Command, key: &str, value: &Value) -> Result<Command> {
    let Some(arg) = option(&command, key) else { return Err(no_option(key)) };
    if !arg.get_action().takes_values() {
        let text = format!("{key}: this option is a switch; give it on the command line");
        return Err(Error::input(MALFORMED, text));
    }
    let values = match value {
        Value::Array(values) => values.iter().map(word).collect::<Option<Vec<_>>>(),
        value => word(value).map(|word| vec![word]),
    };
    let wrong = || {
        let text = format!("{key}: give a text, a number, or an array of them, and not {value}");
        Error::input(MALFORMED, text)
    };
    let values = values.ok_or_else(wrong)?;
    let possible = arg.get_possible_values();
    let is_possible = |word: &String| possible.iter().any(|of| of.matches(word, false));
    if let (false, Some(wrong)) =
        (possible.is_empty(), values.iter().find(|word| !is_possible(word)))
    {
        let known: Vec<_> = possible.iter().map(|of| of.get_name().to_owned()).collect();
        let text = format!("{key}: \"{wrong}\" is not one of {}", known.join(", "));
        return Err(Error::input(MALFORMED, text));
    }
    check(arg, key, &values)?;
    let id = arg.get_id().clone();
    // The command line lives as long as the program.
    let values = values.into_iter().map(|value| &*value.leak());
    Ok(command.mut_arg(id, |arg| arg.required(false).default_values(values)))
}

/// Refuses values that the option does not take. Left to the command line, the error would blame the person who typed it.
fn check(arg: &Arg, key: &str, values: &[String]) -> Result<()> {
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
        let text = text.strip_prefix("error: ").unwrap_or(text);
        Error::input(MALFORMED, format!("{key}: {text}"))
    })
}

/// A value as on the command line.
fn word(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Integer(number) => Some(number.to_string()),
        Value::Float(number) => Some(number.to_string()),
        _ => None,
    }
}

fn no_option(key: &str) -> Error {
    Error::input(MALFORMED, format!("{key}: no command has the option --{key}"))
}
