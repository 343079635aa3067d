//! A material: a folder of maps or a recipe; which file plays which role, and why others play none.

use std::path::Path;

use crate::btf::bake::maps::{MaterialSet, read_set};
use crate::cli::bake::with_files;
use crate::cli::outcome::Outcome;
use crate::error::Result;

/// Reads a recipe or the names of a folder's files, and says what a bake would make of them.
pub fn describe(path: &Path) -> Result<Outcome> {
    // Read the set and name its files.
    let set = read_set(path)?;
    let outcome = with_files(Outcome::default().line(headline(path, &set)), &set);
    let kind = if is_recipe(path) {
        "material recipe"
    } else {
        "material set"
    };
    let outcome = outcome
        .figure("kind", kind)
        .figure("name", set.name.as_str());
    // Tell why a set without a recipe cannot be baked.
    let Ok(recipe) = &set.recipe else {
        let error = set
            .recipe
            .err()
            .map(|error| error.to_string())
            .unwrap_or_default();
        return Ok(outcome
            .line(format!("cannot be baked: {error}"))
            .figure("usable", false)
            .figure("objection", error));
    };
    // Look for files that are not there.
    let missing: Vec<String> = recipe
        .files()
        .iter()
        .filter(|file| !file.is_file())
        .map(|file| file.display().to_string())
        .collect();
    let outcome = match missing.is_empty() {
        true => outcome.next(format!(
            "mesotex bake {} -o {}.sample",
            path.display(),
            set.name
        )),
        false => outcome.line(format!("cannot be baked: missing {}", missing.join(", "))),
    };
    Ok(outcome
        .figure("usable", missing.is_empty())
        .figure("missing", missing))
}

fn is_recipe(path: &Path) -> bool {
    path.is_file() || path.join("material.toml").is_file()
}

fn headline(path: &Path, set: &MaterialSet) -> String {
    if is_recipe(path) {
        return format!("material recipe `{}`", set.name);
    }
    let naming = set.naming.map_or(String::new(), |library| {
        format!(", named as {library} names files")
    });
    let used = set.files.iter().filter(|file| file.used).count();
    format!(
        "material set `{}`{naming}: {} files, {used} of them used",
        set.name,
        set.files.len()
    )
}
