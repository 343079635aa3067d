//! `--once FILE.json`: a command that is done is not run again.
//!
//! The file is a record as `mesotex run` keeps one of a scene, here of a single command: its words, and the content of
//! what it read and wrote. A plan's shell list gives one to every task that makes its product as a whole.

use std::path::PathBuf;
use std::time::Instant;

use crate::cli::Command;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::run::record::Record;
use crate::cli::session::Session;
use crate::cli::subcommand::Subcommand;
use crate::error::{Error, Result};
use crate::format::ours::Format;

/// Options that change no byte of what a command writes, and whether a value follows.
const OF_THE_RUN: [(&str, bool); 7] = [
    ("--once", true),
    ("--threads", true),
    ("--quiet", false),
    ("-q", false),
    ("--verbose", false),
    ("-v", false),
    ("--json", false),
];

/// Runs a command, given as these words without the program, unless the record at `path` says that it is done.
pub(super) fn run(
    command: &Command,
    words: &[String],
    path: &PathBuf,
    session: &Session,
) -> Result<Outcome> {
    let files = command.files()?;
    check(path, &files)?;
    let mut record = Record::open(path)?;
    if record.is_damaged {
        let warning = format!(
            "{}: damaged, or of another version; the command runs again",
            path.display()
        );
        session.progress().warn(&warning);
    }
    let key = Record::key(&telling(words), session.seed());
    if record.is_done(&key, &files)? {
        record.close()?;
        let line = format!("{} skipped, nothing changed", words[0]);
        return Ok(Outcome::default().line(line).figure("skipped", true));
    }
    record.make_way(&files)?;
    let begun = Instant::now();
    let outcome = command.run(session)?;
    // What a file names may have changed while the command ran.
    let files = command.files()?;
    record.note(
        &key,
        (&files, &outcome.inside),
        begun.elapsed().as_secs_f64(),
    )?;
    Ok(outcome)
}

/// Refuses a record that would be written over an input or an output, and commands that name no output.
fn check(path: &PathBuf, files: &Files) -> Result<()> {
    if files.writes.is_empty() {
        return Err(Error::option(
            "once",
            format!("{}, of a command that names no output", path.display()),
            "a command with -o; `mesotex run` keeps a record of its own",
        ));
    }
    // What stands at the outputs is looked at by the command.
    let all = files
        .clone()
        .write("once", [path], Product::File(Format::Json));
    all.check(None, |_| true)
}

/// The words that tell a command apart from others.
fn telling(words: &[String]) -> Vec<String> {
    let mut told = Vec::new();
    let mut words = words.iter();
    while let Some(word) = words.next() {
        let (name, has_value_inside) = match word.split_once('=') {
            Some((name, _)) => (name, true),
            None => (word.as_str(), false),
        };
        match OF_THE_RUN.iter().find(|(option, _)| *option == name) {
            None => told.push(word.clone()),
            Some((_, true)) if !has_value_inside => {
                words.next();
            }
            Some(_) => {}
        }
    }
    told
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_the_run_tell_nothing() {
        let words = |line: &str| -> Vec<String> { line.split(' ').map(str::to_owned).collect() };
        let line = "gram a.npz --threads 2 -o b.npz --once=c.json --seed 3 -q --once c.json --json";
        assert_eq!(telling(&words(line)), words("gram a.npz -o b.npz --seed 3"));
    }
}
