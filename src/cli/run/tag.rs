//! What the outputs of a scene with a `[matrix]` are named after: the varied values that reach them.

use std::path::{Component, Path};

use toml::Value;

use crate::cli::run::sections::SECTIONS;

/// One value of `[matrix]`, as it stands in the names of outputs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tag {
    /// The section whose key varies; for a key at the top of the scene, that key.
    pub section: String,
    /// The rendering it is for, where it is for one of them.
    pub rendering: Option<String>,
    /// What it adds to names.
    pub text: String,
}

impl Tag {
    /// Whether the value reaches what a stage makes; `rendering` names a sequence of frames.
    pub fn reaches(&self, stage: &str, rendering: Option<&str>) -> bool {
        if self.section == "seed" {
            return true;
        }
        let is_of_rendering = self.rendering.is_none() || self.rendering.as_deref() == rendering;
        let meets_surface = stage != "mesh" || place(&self.section) == place("mesh");
        is_of_rendering && meets_surface && place(&self.section) <= place(stage)
    }
}

/// Where in the chain a section, or a key at the top of the scene, comes in.
fn place(section: &str) -> Option<usize> {
    let section = match section {
        "sample" => "bake",
        "surface" => "mesh",
        other => other,
    };
    SECTIONS.iter().position(|name| *name == section)
}

/// What a value of a key is called in names: what a path or a word ends in, without its ending, or the key and the
/// number. `folders` says how many of a path's folders are named too.
pub(super) fn text_of(key: &str, value: &Value, folders: usize) -> String {
    match value {
        Value::String(text) => plain(key, &path_text(text, folders)),
        Value::Boolean(true) => key.to_owned(),
        Value::Boolean(false) => format!("no-{key}"),
        Value::Array(values) => {
            let texts: Vec<String> = values
                .iter()
                .map(|value| text_of(key, value, folders))
                .collect();
            texts.join("_")
        }
        number => plain(key, &number.to_string()),
    }
}

/// The end of a path: `oak` for `woods/oak.toml`, and `woods-oak` with one folder.
fn path_text(text: &str, folders: usize) -> String {
    let components = Path::new(text).components().filter_map(|part| match part {
        Component::Normal(name) => Some(name.to_string_lossy().into_owned()),
        _ => None,
    });
    let mut names: Vec<String> = components.collect();
    if let Some(last) = names.last_mut() {
        *last = without_ending(last).to_owned();
    }
    let first = names.len().saturating_sub(folders + 1);
    names[first..].join("-")
}

/// A name without an ending; what follows the point of a number is none.
fn without_ending(name: &str) -> &str {
    match name.rsplit_once('.') {
        Some((stem, ending))
            if !stem.is_empty() && ending.starts_with(|c: char| c.is_alphabetic()) =>
        {
            stem
        }
        _ => name,
    }
}

/// A text of characters that names may have. The key goes before what would not tell by itself.
fn plain(key: &str, text: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_.".contains(c);
    let replaced: String = text
        .chars()
        .map(|c| if is_plain(c) { c } else { '-' })
        .collect();
    match replaced.starts_with(|c: char| c.is_alphabetic()) {
        true => replaced,
        false => format!("{key}{replaced}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tag(section: &str, rendering: Option<&str>) -> Tag {
        Tag {
            section: section.into(),
            rendering: rendering.map(str::to_owned),
            text: "x".into(),
        }
    }

    #[test]
    fn a_value_reaches_what_is_made_of_it() {
        let reached = |section: &str| {
            let tag = tag(section, None);
            let stages = SECTIONS.iter().filter(|stage| tag.reaches(stage, None));
            stages.copied().collect::<Vec<_>>().join(" ")
        };
        assert_eq!(reached("textons"), "textons gram knn synth render");
        assert_eq!(reached("knn"), "knn synth render");
        assert_eq!(reached("mesh"), "mesh synth render");
        assert_eq!(reached("surface"), "mesh synth render");
        assert_eq!(reached("render"), "render");
        assert_eq!(reached("seed").split(' ').count(), SECTIONS.len());
        assert!(!reached("sample").contains("mesh"));
        let sweep = tag("render", Some("sweep"));
        assert!(sweep.reaches("render", Some("sweep")) && !sweep.reaches("render", Some("still")));
    }

    #[test]
    fn values_are_told_by_their_ends() {
        let of_text = |text: &str| text_of("size", &Value::String(text.into()), 0);
        assert_eq!(of_text("woods/oak.toml"), "oak");
        assert_eq!(of_text("Bricks075_2K-PNG/"), "Bricks075_2K-PNG");
        assert_eq!(of_text("sun:30,40"), "sun-30-40");
        assert_eq!(of_text("640x480"), "size640x480");
        assert_eq!(of_text("../up.obj"), "up");
        let with_folder = text_of("material", &Value::String("a/b/maps.toml".into()), 1);
        assert_eq!(with_folder, "b-maps");
        assert_eq!(text_of("seed", &Value::Integer(3), 0), "seed3");
        assert_eq!(text_of("texel", &Value::Float(0.5), 0), "texel0.5");
        assert_eq!(text_of("angle", &Value::Integer(-30), 0), "angle-30");
        assert_eq!(text_of("orient", &Value::Boolean(false), 0), "no-orient");
    }
}
