//! What the parser of the command line refuses, in the words of every other error.

use std::error::Error;
use std::fmt;

use clap::CommandFactory;
use clap::error::{ContextKind, ContextValue, ErrorKind};

use crate::cli::CommandLine;
use crate::cli::failure::likely_names::suggestion;
use crate::cli::failure::number_text;

/// One refusal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::cli) struct Refusal {
    /// The option it is about, without dashes.
    pub option: Option<String>,
    /// What was found and what was expected.
    pub says: String,
    /// What to do; may be empty.
    pub hint: String,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.says)?;
        match self.hint.as_str() {
            "" => Ok(()),
            hint => write!(f, "\n  hint: {hint}"),
        }
    }
}

impl Refusal {
    /// What the parser says against `words`; `None` where its own text says it best.
    pub(in crate::cli) fn of(error: &clap::Error, words: &[String]) -> Option<Self> {
        let argument = text(error, ContextKind::InvalidArg);
        let says = match error.kind() {
            ErrorKind::InvalidValue => invalid_value(error),
            ErrorKind::ValueValidation => refused_value(error),
            ErrorKind::UnknownArgument => return Some(unknown_argument(error, words)),
            ErrorKind::InvalidSubcommand => invalid_command(error),
            ErrorKind::MissingRequiredArgument => missing(error),
            ErrorKind::ArgumentConflict => conflict(error),
            _ => return None,
        };
        Some(Self {
            option: argument.as_deref().and_then(option_name),
            says,
            hint: format!("`{} --help` explains it", command_of(words)),
        })
    }
}

/// `mesotex bake` of what was typed.
fn command_of(words: &[String]) -> String {
    let command = words.get(1).filter(|word| {
        let known = ["--", "-"];
        !known.iter().any(|dash| word.starts_with(dash))
    });
    match command {
        Some(command) if is_command(command) => format!("mesotex {command}"),
        _ => "mesotex".into(),
    }
}

fn is_command(word: &str) -> bool {
    CommandLine::command().find_subcommand(word).is_some()
}

fn texts(error: &clap::Error, kind: ContextKind) -> Vec<String> {
    match error.get(kind) {
        Some(ContextValue::String(text)) => vec![text.clone()],
        Some(ContextValue::Strings(texts)) => texts.clone(),
        _ => Vec::new(),
    }
}

fn text(error: &clap::Error, kind: ContextKind) -> Option<String> {
    texts(error, kind).into_iter().next()
}

/// The name in `--size <N>`.
fn option_name(argument: &str) -> Option<String> {
    let name = argument.strip_prefix("--")?;
    let end = name.find(|c: char| !c.is_alphanumeric() && c != '-');
    Some(name[..end.unwrap_or(name.len())].to_owned())
}

/// `--size` of `--size <N>`; a positional argument as it is.
fn short(argument: &str) -> String {
    match option_name(argument) {
        Some(name) => format!("--{name}"),
        None => argument.to_owned(),
    }
}

fn invalid_value(error: &clap::Error) -> String {
    let argument = text(error, ContextKind::InvalidArg).unwrap_or_default();
    let value = text(error, ContextKind::InvalidValue).unwrap_or_default();
    let known = texts(error, ContextKind::ValidValue);
    let one_of = match known.as_slice() {
        [] => "a value after it".to_owned(),
        _ => format!("one of {}", known.join(", ")),
    };
    let meant = suggestion(&value, known.iter().map(String::as_str));
    let found = match value.as_str() {
        "" => "no value",
        value => value,
    };
    format!("{}: {found}; expected {one_of}{meant}", short(&argument))
}

fn refused_value(error: &clap::Error) -> String {
    let argument = short(&text(error, ContextKind::InvalidArg).unwrap_or_default());
    let value = text(error, ContextKind::InvalidValue).unwrap_or_default();
    let Some(fault) = error.source() else {
        return format!("{argument}: {value}");
    };
    if let Some(expected) = number(error, &value) {
        return format!("{argument}: {value}; expected {expected}");
    }
    let fault = fault.to_string();
    match fault.contains(&value) {
        true => format!("{argument}: {fault}"),
        false => format!("{argument}: {value}: {fault}"),
    }
}

/// What number was expected, where a number's parser refused the value.
fn number(error: &clap::Error, value: &str) -> Option<String> {
    number_text::explain(value, error.source()?)
}

fn unknown_argument(error: &clap::Error, words: &[String]) -> Refusal {
    let command = command_of(words);
    let found = text(error, ContextKind::InvalidArg).unwrap_or_default();
    let see = format!("`{command} --help` lists the options");
    if let Some(option) = option_before_number(&found, words) {
        return Refusal {
            says: format!("{option}: {found}; expected a number that is not negative"),
            option: option_name(option),
            hint: format!("`{command} --help` explains it"),
        };
    }
    if !found.starts_with('-') {
        return Refusal {
            option: None,
            says: format!("`{found}`: one argument more than `{command}` takes"),
            hint: format!("outputs are given with -o, as in `-o {found}`; {see}"),
        };
    }
    let meant = match text(error, ContextKind::SuggestedArg) {
        Some(name) => format!("; did you mean `{}`?", short(&name)),
        None => String::new(),
    };
    Refusal {
        option: option_name(&found),
        says: format!("`{command}` has no option {}{meant}", short(&found)),
        hint: see,
    }
}

/// The option that a negative number stands behind.
fn option_before_number<'a>(found: &str, words: &'a [String]) -> Option<&'a str> {
    let digits = found.strip_prefix('-')?;
    if !digits.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
        return None;
    }
    let at = words.iter().position(|word| word.starts_with(found))?;
    let before = words.get(at.checked_sub(1)?)?;
    before.starts_with('-').then_some(before.as_str())
}

fn invalid_command(error: &clap::Error) -> String {
    let found = text(error, ContextKind::InvalidSubcommand).unwrap_or_default();
    let root = CommandLine::command();
    let known: Vec<&str> = root
        .get_subcommands()
        .map(clap::Command::get_name)
        .collect();
    let meant = suggestion(&found, known.iter().copied());
    format!(
        "`{found}` is not a command; expected one of {}{meant}",
        known.join(", ")
    )
}

fn missing(error: &clap::Error) -> String {
    let missing = texts(error, ContextKind::InvalidArg);
    let are = if missing.len() == 1 { "is" } else { "are" };
    format!("{} {are} missing", missing.join(" and "))
}

fn conflict(error: &clap::Error) -> String {
    let first = text(error, ContextKind::InvalidArg).unwrap_or_default();
    let others: Vec<String> = texts(error, ContextKind::PriorArg)
        .iter()
        .map(|argument| short(argument))
        .collect();
    match others.as_slice() {
        [only] if *only == short(&first) => format!("{only}: given twice; expected once"),
        _ => format!(
            "{} cannot be given with {}",
            short(&first),
            others.join(" and ")
        ),
    }
}
