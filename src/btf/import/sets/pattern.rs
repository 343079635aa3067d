//! Angles in names by a pattern of the user, as `tl{tl}_pl{pl}_tv{tv}_pv{pv}`.
//!
//! `{tl}` and `{pl}` stand for θ and φ of the light, `{tv}` and `{pv}` for those of the view, in degrees; `*` for
//! anything; all else for itself. A pattern may begin and end anywhere in a file's name. One with a `/` is looked for
//! in the path below the folder. Where a pattern has no view, it is directly above.

use regex_lite::Regex;

use crate::btf::import::sets::angles::Angles;
use crate::error::{Error, Result};

/// The placeholders: θ and φ of the light, θ and φ of the view.
const KEYS: [&str; 4] = ["tl", "pl", "tv", "pv"];
/// An angle, as a regular expression.
const NUMBER: &str = r"[-+]?[0-9]+(?:\.[0-9]+)?";
/// What a pattern may be.
const EXPECTED: &str = "a pattern with {tl} and {pl}, {tv} and {pv}, or all four, each once";

/// A pattern ready for use.
#[derive(Debug)]
pub(super) struct Pattern {
    regex: Regex,
    with_folders: bool,
}

impl Pattern {
    /// Reads a pattern; a direction needs both its angles.
    pub(super) fn parse(text: &str) -> Result<Self> {
        let refused =
            |found: String| Error::option("pattern", format!("`{text}` {found}"), EXPECTED);
        let (regex, keys) = expression(text).map_err(refused)?;
        let whole = |a: &str, b: &str| keys.contains(&a) == keys.contains(&b);
        if keys.is_empty() || !whole("tl", "pl") || !whole("tv", "pv") {
            return Err(refused("lacks an angle".into()));
        }
        Ok(Self {
            regex: Regex::new(&regex).map_err(|error| refused(error.to_string()))?,
            with_folders: text.contains('/'),
        })
    }

    /// The angles in a path; `None` where the pattern does not fit.
    pub(super) fn angles(&self, path: &str) -> Option<Angles> {
        let name = match self.with_folders {
            true => path,
            false => path.rsplit('/').next().unwrap_or(path),
        };
        let found = self.regex.captures(name)?;
        let angle = |key: &str| match found.name(key) {
            None => Some(0.0),
            Some(text) => text.as_str().parse::<f64>().ok(),
        };
        Some(Angles::new(
            [angle("tv")?, angle("pv")?],
            [angle("tl")?, angle("pl")?],
        ))
    }
}

/// The regular expression of a pattern, and the placeholders it has; what is wrong with it in words.
fn expression(text: &str) -> std::result::Result<(String, Vec<&'static str>), String> {
    let (mut regex, mut seen) = (String::new(), Vec::new());
    let mut rest = text;
    while let Some(sign) = rest.chars().next() {
        let placeholder = |key: &&str| rest.starts_with(&format!("{{{key}}}"));
        let length = match KEYS.into_iter().find(placeholder) {
            Some(key) if seen.contains(&key) => return Err(format!("has {{{key}}} twice")),
            Some(key) => {
                seen.push(key);
                regex += &format!("(?P<{key}>{NUMBER})");
                key.len() + "{}".len()
            }
            None if sign == '{' => return Err("has a placeholder that is not known".into()),
            None => {
                let itself = regex_lite::escape(sign.encode_utf8(&mut [0; 4]));
                regex += if sign == '*' { ".*" } else { &itself };
                sign.len_utf8()
            }
        };
        rest = &rest[length..];
    }
    Ok((regex, seen))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(pattern: &str, path: &str) -> Option<Angles> {
        Pattern::parse(pattern).unwrap().angles(path)
    }

    #[test]
    fn patterns_find_their_angles() {
        let expected = Some(Angles::new([30.0, 60.0], [15.5, -20.0]));
        for (pattern, path) in [
            (
                "tl{tl}_pl{pl}_tv{tv}_pv{pv}",
                "a/x_tl15.5_pl-20_tv30_pv60.png",
            ),
            ("v{tv}-{pv}/*_{tl}_{pl}.", "set/v30-60/cam_1_15.5_-20.jpg"),
            (
                "{tl} {pl} {tv} {pv}.(final)",
                "+15.5 -20.0 030 060.(final).exr",
            ),
        ] {
            assert_eq!(found(pattern, path), expected, "{pattern}");
        }
        assert_eq!(
            found("l{tl}p{pl}", "l9p8.png"),
            Some(Angles::new([0.0, 0.0], [9.0, 8.0]))
        );
        assert_eq!(found("l{tl}p{pl}", "l9/p8.png"), None);
        assert_eq!(found("l{tl}p{pl}", "l9q8.png"), None);
    }

    #[test]
    fn broken_patterns_are_refused() {
        for (pattern, says) in [
            ("", "lacks an angle"),
            ("{tl}", "lacks an angle"),
            ("{tl}{pl}{tv}", "lacks an angle"),
            ("{tl}{pl}{tl}", "{tl} twice"),
            ("{theta}", "not known"),
        ] {
            let error = Pattern::parse(pattern).unwrap_err().to_string();
            assert!(
                error.contains(says) && error.contains("--pattern"),
                "{error}"
            );
        }
    }
}
