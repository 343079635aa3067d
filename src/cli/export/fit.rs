//! `mesotex export --to ptm`: a sample of one view → a polynomial texture map.

use std::path::Path;

use clap::Args;

use crate::btf::fits::{Basis, Colors, fit_sample, ptm};
use crate::btf::sample::Sample;
use crate::cli::outcome::Outcome;
use crate::cli::session::Session;
use crate::error::{Error, Result};

/// How a sample is fitted.
#[derive(Clone, Debug, Default, PartialEq, Args)]
pub struct FitOptions {
    /// What a PTM stores per texel: `lrgb`, one polynomial that is multiplied by a colour, or `rgb`, one polynomial
    /// each for red, green and blue. [default: lrgb]
    #[arg(long, value_enum)]
    pub colors: Option<Colors>,
}

impl FitOptions {
    /// Refuses options of fits for another format.
    pub(super) fn validate(&self, is_fit: bool) -> Result<()> {
        match self.colors {
            Some(_) if !is_fit => {
                let found = "given for a format without fitted colours";
                Err(Error::option("colors", found, "--to ptm"))
            }
            _ => Ok(()),
        }
    }
}

/// Fits a sample and writes the file.
pub(super) fn run(
    sample: &Path,
    options: &FitOptions,
    output: &Path,
    session: &Session,
) -> Result<Outcome> {
    let colors = options.colors.unwrap_or(Colors::Lrgb);
    let opened = Sample::open(sample)?;
    let fitted = fit_sample(&opened, Basis::Polynomial, colors, session.progress())
        .map_err(|error| error.in_file(sample))?;
    ptm::write(output, &fitted.fit)?;
    Ok(Outcome::default()
        .line(format!(
            "PTM of {} × {} texels, fitted to {} lights",
            fitted.fit.width,
            fitted.fit.height,
            opened.image_count()
        ))
        .line(format!(
            "the fit leaves {:.2} of 255 display steps (root mean square over texels, colours and lights), as stored \
             {:.2}",
            fitted.residual, fitted.stored_residual
        ))
        .figure("format", "ptm")
        .figure("residual", fitted.residual)
        .figure("stored_residual", fitted.stored_residual)
        .wrote(output))
}
