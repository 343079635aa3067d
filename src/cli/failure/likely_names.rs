//! Names that were likely meant.

use std::fs;
use std::path::Path;

/// How alike two names are that are likely meant for each other (Jaro-Winkler, 1 the same).
const ALIKE: f64 = 0.75;
/// The same for files: their endings are alike by habit.
const ALIKE_FILES: f64 = 0.88;

/// `; did you mean `NAME`?` for the known name that is nearest to what was written, or nothing.
pub(in crate::cli) fn suggestion<'a>(
    written: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> String {
    match most_alike(written, known, ALIKE) {
        Some(name) => format!("; did you mean `{name}`?"),
        None => String::new(),
    }
}

fn most_alike<'a>(
    written: &str,
    known: impl IntoIterator<Item = &'a str>,
    least: f64,
) -> Option<&'a str> {
    let likeness = |name: &&str| strsim::jaro_winkler(written, name);
    let best = known
        .into_iter()
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    best.filter(|name| likeness(name) >= least)
}

/// A hint for a path that is not there: a name beside it that is much like it, or the folder that is missing.
pub(super) fn hint(path: &Path) -> String {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return format!("\n  hint: there is no folder {}", folder.display());
    }
    let names: Vec<String> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| !name.starts_with('.'))
        .collect();
    let written = path.file_name().unwrap_or_default().to_string_lossy();
    match most_alike(&written, names.iter().map(String::as_str), ALIKE_FILES) {
        Some(name) => {
            let meant = path.with_file_name(name);
            format!("\n  hint: did you mean {}?", meant.display())
        }
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names_are_suggested_and_far_ones_are_not() {
        let known = ["neighborhood", "k", "min-separation"];
        assert!(suggestion("neighbourhood", known).contains("`neighborhood`"));
        assert_eq!(suggestion("colour", known), "");
    }

    #[test]
    fn a_file_with_a_name_much_like_it_is_suggested() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["weave.sample", "cobbles.sample"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let hint_for = |name: &str| hint(&folder.path().join(name));
        assert!(hint_for("weav.sample").ends_with("weave.sample?"));
        assert_eq!(hint_for("bark.npz"), "");
        assert!(hint_for("nowhere/weave.sample").contains("no folder"));
    }
}
