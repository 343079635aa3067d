//! What went wrong, as a person reads it on stderr and as a program reads it on stdout with `--json`.
//!
//! Every refusal says what was found, what was expected and what to do, whether it comes from the parser of
//! the command line, from a file or from the machine.

pub(in crate::cli) mod likely_names;
mod number_text;
pub(in crate::cli) mod refusal;

use std::path::Path;
use std::process::ExitCode;

use serde_json::{Value, json};

use crate::cli::failure::refusal::Refusal;
use crate::cli::terminal;
use crate::error::Error;

/// Exit code when the data or the machine is at fault.
const DATA: u8 = 1;
/// Exit code when the usage is at fault.
const USAGE: u8 = 2;

/// Prints an error; its exit code says who must act.
pub(in crate::cli) fn fail(error: &Error, as_json: bool) -> ExitCode {
    let code = exit_code(error);
    let hint = match error {
        Error::Io { path, source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
            likely_names::hint(path)
        }
        Error::Data(fault) => fault
            .path
            .as_deref()
            .map_or(String::new(), hint_where_missing),
        _ => String::new(),
    };
    terminal::print_error(&format!("{error}{hint}"));
    if as_json {
        terminal::print_report(&report(error, &hint, code));
    }
    ExitCode::from(code)
}

fn exit_code(error: &Error) -> u8 {
    match error {
        Error::Option { .. } | Error::Faults { usage: true, .. } => USAGE,
        _ => DATA,
    }
}

/// The parts of an error for a program, for a command that reports what it did before.
pub(in crate::cli) fn parts(error: &Error) -> Value {
    report(error, "", exit_code(error))["error"].take()
}

/// A hint where there is nothing at the path.
fn hint_where_missing(path: &Path) -> String {
    match path.exists() {
        true => String::new(),
        false => likely_names::hint(path),
    }
}

/// Prints what the parser refuses, or the help or version that was asked for.
pub(in crate::cli) fn refuse(error: &clap::Error, words: &[String]) -> ExitCode {
    if !error.use_stderr() {
        terminal::print_help(error);
        return ExitCode::SUCCESS;
    }
    let Some(refusal) = Refusal::of(error, words) else {
        terminal::print_help(error);
        return ExitCode::from(USAGE);
    };
    terminal::print_error(&refusal.to_string());
    if words.iter().any(|word| word == "--json") {
        let report = json!({"error": {
            "kind": "usage",
            "option": refusal.option,
            "message": refusal.says,
            "hint": refusal.hint,
            "exit_code": USAGE,
        }});
        terminal::print_report(&report);
    }
    ExitCode::from(USAGE)
}

/// An error for a program: `kind` is who must act, empty fields are left out.
fn report(error: &Error, hint: &str, code: u8) -> Value {
    let text = |path: &Path| path.to_string_lossy().into_owned();
    // Name the fields of the kind of error.
    let mut fields = match error {
        Error::Data(fault) => json!({
            "kind": "data",
            "file": fault.path.as_deref().map(text),
            "place": fault.place,
            "found": fault.found,
            "expected": fault.expected,
            "hint": match fault.advice.as_str() {
                "" => hint.trim_start_matches("\n  hint: "),
                advice => advice,
            },
        }),
        Error::Option {
            option,
            found,
            expected,
        } => json!({"kind": "usage", "option": option, "found": found, "expected": expected}),
        Error::Io { path, source, .. } => json!({
            "kind": "machine",
            "file": text(path),
            "found": source.to_string(),
            "hint": hint.trim_start_matches("\n  hint: "),
        }),
        Error::Faults { path, lines, usage } => json!({
            "kind": if *usage { "usage" } else { "data" },
            "file": text(path),
            "faults": lines,
        }),
        Error::Interrupted => json!({"kind": "interrupted"}),
    };
    // Leave out what is empty, and add what every error has.
    if let Value::Object(fields) = &mut fields {
        fields.retain(|_, value| !value.is_null() && value != "");
        fields.insert("message".into(), json!(error.to_string()));
        fields.insert("exit_code".into(), json!(code));
    }
    json!({ "error": fields })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_has_the_parts_of_the_message_and_no_empty_ones() {
        let error = Error::data("width", "0")
            .expected("1 or more")
            .in_file(Path::new("btf.json"));
        let report = report(&error, "", DATA);
        assert_eq!(
            report,
            json!({"error": {"kind": "data", "file": "btf.json", "place": "width", "found": "0",
                "expected": "1 or more", "message": "btf.json: width: 0; expected 1 or more", "exit_code": 1}})
        );
    }
}
