//! The options given on the command line.

use std::collections::BTreeSet;

use clap::{ArgMatches, Command, parser::ValueSource};
use serde_json::{Map, Value};

use crate::failure::Failure;

/// The options given to a command, and the values of all its options.
#[derive(Debug, Default)]
pub(crate) struct Given {
    /// The fields of the options that are on the command line.
    explicit: BTreeSet<String>,
    /// Every option with its value, including defaults, by its long name.
    options: Map<String, Value>,
}

/// Options that do not affect results, or that reports name elsewhere.
const LEFT_OUT: [&str; 7] = ["json", "quiet", "threads", "output", "help", "inputs", "input"];

/// The options that take a length.
const LENGTHS: [&str; 6] = ["weld", "max_error", "errors", "exact", "radius", "tolerance"];

impl Given {
    /// The values in `matches` for the arguments of a command.
    pub(crate) fn new(command: &Command, matches: &ArgMatches) -> Self {
        let mut given = Self::default();
        for argument in command.get_arguments() {
            let id = argument.get_id().as_str();
            let Some(source) = matches.value_source(id) else { continue };
            if source == ValueSource::CommandLine {
                given.explicit.insert(id.to_owned());
            }
            let Some(name) = argument.get_long() else { continue };
            if LEFT_OUT.contains(&id) {
                continue;
            }
            let raw = matches.get_raw(id).into_iter().flatten();
            let mut values: Vec<Value> = raw.map(|v| as_json(&v.to_string_lossy())).collect();
            let value = match values.len() {
                1 => values.remove(0),
                _ => Value::Array(values),
            };
            // Switches that are off are omitted.
            if value != Value::Bool(false) {
                given.options.insert(name.to_owned(), value);
            }
        }
        given
    }

    /// Every option with its value, including defaults.
    pub(crate) fn options(&self) -> &Map<String, Value> {
        &self.options
    }

    /// Whether the option is on the command line.
    pub(crate) fn has(&self, field: &str) -> bool {
        self.explicit.contains(field)
    }

    /// Refuses options without effect, with the reason.
    pub(crate) fn refuse(&self, fields: &[&str], because: &str) -> Result<(), Failure> {
        match fields.iter().find(|field| self.has(field)) {
            Some(field) => {
                let name = field.replace('_', "-");
                Err(Failure::Usage(format!("--{name} would do nothing here: {because}")))
            }
            None => Ok(()),
        }
    }

    /// Refuses `--relative` if no length is given.
    pub(crate) fn check_relative(&self) -> Result<(), Failure> {
        if LENGTHS.iter().any(|field| self.has(field)) {
            return Ok(());
        }
        self.refuse(&["relative"], "no length is given that could be relative")
    }
}

/// Numbers and switches as such, everything else as text.
fn as_json(text: &str) -> Value {
    match serde_json::from_str(text) {
        Ok(value @ (Value::Number(_) | Value::Bool(_))) => value,
        _ => Value::String(text.to_owned()),
    }
}
