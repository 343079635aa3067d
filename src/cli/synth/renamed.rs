//! Options that have other names now: refused, with the new one.

use clap::Args;

use crate::error::{Error, Result};

/// The former names, not shown in help.
#[derive(Debug, Args)]
pub struct RenamedOptions {
    /// Now `--distance-floor`.
    #[arg(long, hide = true, allow_hyphen_values = true)]
    noise: Option<String>,
    /// Now `--repair-rounds`.
    #[arg(long, hide = true, allow_hyphen_values = true)]
    mends: Option<String>,
    /// Now `--reuse-penalty`.
    #[arg(long, hide = true, allow_hyphen_values = true)]
    evenness: Option<String>,
    /// Now `--spectrum`.
    #[arg(long, hide = true, allow_hyphen_values = true)]
    energy: Option<String>,
}

impl RenamedOptions {
    /// Refuses a former name.
    pub fn refuse(&self) -> Result<()> {
        let names = [
            ("noise", &self.noise, "distance-floor"),
            ("mends", &self.mends, "repair-rounds"),
            ("evenness", &self.evenness, "reuse-penalty"),
            ("energy", &self.energy, "spectrum"),
        ];
        let given = names
            .into_iter()
            .find_map(|(old, value, new)| Some((old, value.as_ref()?, new)));
        match given {
            None => Ok(()),
            Some((old, value, new)) => Err(Error::option(
                old,
                "a former name of this option",
                format!("--{new} {value}"),
            )),
        }
    }
}
