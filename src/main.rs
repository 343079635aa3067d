//! The `mesotex` command: parse, dispatch, exit code; nothing else.

use std::process::ExitCode;

fn main() -> ExitCode {
    mesotex::cli::main()
}
