//! A fit over lights: its size and its terms.

use std::path::Path;

use crate::btf::fits::{Colors, Fit};
use crate::cli::outcome::Outcome;
use crate::error::Result;

/// Reads a fit and describes its content; `name` is its format's.
pub fn describe(path: &Path, name: &str, read: fn(&Path) -> Result<Fit>) -> Result<Outcome> {
    let fit = read(path)?;
    let (colors, said) = match fit.colors {
        Colors::Lrgb => ("lrgb", "one sum times a colour"),
        Colors::Rgb => ("rgb", "a sum each for red, green and blue"),
    };
    Ok(Outcome::default()
        .line(format!(
            "{name}: {} × {} texels, {} terms per sum, {said}; seen from straight above",
            fit.width,
            fit.height,
            fit.basis.terms()
        ))
        .figure("kind", "fit")
        .figure("format", name)
        .figure("width", fit.width)
        .figure("height", fit.height)
        .figure("terms", fit.basis.terms())
        .figure("colors", colors)
        .next(format!(
            "mesotex import {} --lights bonn81 -o {}",
            path.display(),
            path.with_extension("sample").display()
        )))
}
