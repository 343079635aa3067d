//! `[matrix]`: keys of a scene that have several values each. Every combination of values is a run.

use std::collections::BTreeSet;

use toml::Value;

use crate::cli::failure::likely_names::suggestion;
use crate::cli::run::document::{Document, Key, Section};
use crate::cli::run::faults::{Faults, Place};
use crate::cli::run::sections::SECTIONS;
use crate::cli::run::tag::{Tag, text_of};

/// The section that says what varies.
pub(super) const SECTION: &str = "matrix";
/// Keys at the top of a scene that may vary.
const TOP: [&str; 3] = ["sample", "seed", "surface"];
/// The most runs of one scene.
const MOST_RUNS: usize = 100_000;

/// What varies in a scene.
#[derive(Debug, Default)]
pub(super) struct Matrix {
    axes: Vec<Axis>,
}

/// One key and its values.
#[derive(Debug)]
struct Axis {
    /// The key with its dots, as it is written.
    name: String,
    path: KeyPath,
    line: usize,
    choices: Vec<Choice>,
}

/// The key of a scene that an axis sets.
#[derive(Clone, Debug, PartialEq, Eq)]
struct KeyPath {
    /// Its section; `None` for the top of the scene.
    section: Option<String>,
    /// The rendering, where the key is that of one of them.
    rendering: Option<String>,
    /// The key.
    key: String,
}

#[derive(Clone, Debug)]
struct Choice {
    value: Value,
    text: String,
}

/// One combination of values, set in the scene.
#[derive(Clone, Debug)]
pub(super) struct Variant {
    /// The scene with these values.
    pub(super) document: Document,
    /// What they add to the names of outputs.
    pub(super) tags: Vec<Tag>,
}

impl Matrix {
    /// Takes the section out of a scene; what is wrong with it goes to `faults`.
    pub(super) fn take(document: &mut Document, faults: &mut Faults) -> Self {
        let mut axes = Vec::new();
        for section in document.sections.extract_if(.., |s| s.name == SECTION) {
            if section.listed {
                faults.data(&section.head(), "two pairs of brackets; expected [matrix]");
            }
            if section.keys.is_empty() {
                faults.data(
                    &section.head(),
                    "empty; expected `\"SECTION.KEY\" = [VALUE, VALUE]`",
                );
            }
            for key in &section.keys {
                for (name, value) in dotted(&key.name, &key.value) {
                    axes.extend(Axis::of(name, key.line, value, faults));
                }
            }
        }
        axes.sort_by(|a, b| (a.line, &a.name).cmp(&(b.line, &b.name)));
        let matrix = Self { axes };
        matrix.check(document, faults);
        matrix
    }

    /// Refuses keys that the scene cannot vary, and more runs than one scene may have.
    fn check(&self, document: &Document, faults: &mut Faults) {
        for axis in &self.axes {
            axis.check(document, faults);
        }
        let mut paths: Vec<&KeyPath> = Vec::new();
        for axis in &self.axes {
            if paths.contains(&&axis.path) {
                faults.data(&axis.place(), "given twice; expected one list");
            }
            paths.push(&axis.path);
        }
        let counts = self.axes.iter().map(|axis| axis.choices.len());
        let runs = counts.fold(1usize, usize::saturating_mul);
        if runs > MOST_RUNS {
            let says = format!("{runs} runs; at most {MOST_RUNS} fit one scene: write several");
            faults.data(&self.axes[0].place(), says);
        }
    }

    /// Every combination of values; the last axis varies fastest.
    pub(super) fn variants(&self, document: &Document) -> Vec<Variant> {
        let mut variants = vec![Variant {
            document: document.clone(),
            tags: Vec::new(),
        }];
        for axis in &self.axes {
            let with_choices = variants.iter().flat_map(|variant| {
                let choices = axis.choices.iter();
                choices.map(|choice| axis.applied(choice, variant.clone()))
            });
            variants = with_choices.collect();
        }
        variants
    }

    /// Whether the seed of whole runs varies.
    pub(super) fn varies_seed(&self) -> bool {
        let is_seed = |axis: &Axis| axis.path.section.is_none() && axis.path.key == "seed";
        self.axes.iter().any(is_seed)
    }
}

/// A key with its dots: `"bake.size" = […]`, `bake.size = […]` and `[matrix.bake]` with `size = […]` are one.
fn dotted(name: &str, value: &Value) -> Vec<(String, Value)> {
    match value {
        Value::Table(table) => {
            let inner = table.iter();
            inner
                .flat_map(|(key, value)| dotted(&format!("{name}.{key}"), value))
                .collect()
        }
        value => vec![(name.to_owned(), value.clone())],
    }
}

impl KeyPath {
    fn of(name: &str) -> Self {
        let Some((section, rest)) = name.split_once('.') else {
            return Self {
                section: None,
                rendering: None,
                key: name.to_owned(),
            };
        };
        let (rendering, key) = match rest.rsplit_once('.') {
            Some((rendering, key)) if section == "render" => (Some(rendering.to_owned()), key),
            _ => (None, rest),
        };
        Self {
            section: Some(section.to_owned()),
            rendering,
            key: key.to_owned(),
        }
    }

    /// Whether the key is set in a section.
    fn is_in(&self, section: &Section) -> bool {
        let name = section.key("name").and_then(|key| key.value.as_str());
        let is_rendering = match &self.rendering {
            Some(rendering) => name.unwrap_or("frames") == rendering,
            None => true,
        };
        Some(&section.name) == self.section.as_ref() && is_rendering
    }
}

impl Axis {
    fn of(name: String, line: usize, value: Value, faults: &mut Faults) -> Option<Self> {
        let place = Place::new(line, format!("[{SECTION}] {name}"));
        let path = KeyPath::of(&name);
        let values = match value {
            Value::Array(values) if !values.is_empty() => values,
            other => {
                faults.data(&place, format!("`{other}`; expected a list of values"));
                return None;
            }
        };
        for (at, value) in values.iter().enumerate() {
            if !is_choice(value) {
                let expected = "a string, a number, true or false, or a list of them";
                faults.data(&place, format!("`{value}`; expected {expected}"));
            }
            if values[..at].contains(value) {
                faults.data(&place, format!("`{value}` twice"));
            }
        }
        let choices = named(&path.key, values);
        let mut texts = BTreeSet::new();
        for choice in &choices {
            if !texts.insert(&choice.text) {
                let says = format!(
                    "`{}` would name outputs `{}`, as an earlier value does; give the file another name",
                    choice.value, choice.text
                );
                faults.data(&place, says);
            }
        }
        Some(Self {
            name,
            path,
            line,
            choices,
        })
    }

    fn place(&self) -> Place {
        Place::new(self.line, format!("[{SECTION}] {}", self.name))
    }

    /// Refuses a key that is no scene's, or is set there already.
    fn check(&self, document: &Document, faults: &mut Faults) {
        let KeyPath {
            section,
            rendering,
            key,
        } = &self.path;
        // Check that the scene has such a key, and find whether it is set.
        let is_set = match section {
            None => {
                if !TOP.contains(&key.as_str()) {
                    let known = TOP.iter().chain(&SECTIONS).copied();
                    let meant = suggestion(key, known);
                    let says = "may not vary; expected sample, surface, seed or SECTION.KEY";
                    faults.data(&self.place(), format!("{says}{meant}"));
                }
                document.keys.iter().find(|other| other.name == *key)
            }
            Some(section) => {
                if !SECTIONS.contains(&section.as_str()) {
                    let meant = suggestion(section, SECTIONS.iter().copied());
                    faults.data(&self.place(), format!("no section [{section}]{meant}"));
                    return;
                }
                let sections: Vec<&Section> = self.sections(document).collect();
                if section == "render" && sections.is_empty() {
                    let named = rendering
                        .as_ref()
                        .map(|name| format!(" of the name {name}"));
                    let says = format!("no [[render]]{}", named.unwrap_or_default());
                    faults.data(&self.place(), says);
                }
                if section == "render" && key == "name" {
                    faults.data(
                        &self.place(),
                        "may not vary; outputs are named after the values",
                    );
                }
                sections.into_iter().find_map(|section| section.key(key))
            }
        };
        // Refuse one that is set too.
        if let Some(other) = is_set {
            let says = format!("line {} sets this key too; remove one of them", other.line);
            faults.data(&self.place(), says);
        }
    }

    fn sections<'a>(&'a self, document: &'a Document) -> impl Iterator<Item = &'a Section> {
        let sections = document.sections.iter();
        sections.filter(|section| self.path.is_in(section))
    }

    /// A run with one of the values.
    fn applied(&self, choice: &Choice, mut variant: Variant) -> Variant {
        let KeyPath { section, key, .. } = &self.path;
        let key = Key {
            name: key.clone(),
            line: self.line,
            value: choice.value.clone(),
            varied: Some(format!("[{SECTION}] {} = {}", self.name, choice.value)),
        };
        let document = &mut variant.document;
        match section {
            None => document.keys.push(key),
            Some(name) => {
                if !document.sections.iter().any(|other| self.path.is_in(other)) {
                    document.sections.push(Section {
                        name: name.clone(),
                        line: self.line,
                        ..Section::default()
                    });
                }
                let sections = document.sections.iter_mut();
                sections
                    .filter(|section| self.path.is_in(section))
                    .for_each(|section| section.add(key.clone()));
            }
        }
        variant.tags.push(Tag {
            section: section.clone().unwrap_or_else(|| self.path.key.clone()),
            rendering: self.path.rendering.clone(),
            text: choice.text.clone(),
        });
        variant
    }
}

fn is_choice(value: &Value) -> bool {
    match value {
        Value::Array(values) => values
            .iter()
            .all(|value| !value.is_array() && is_choice(value)),
        Value::Table(_) | Value::Datetime(_) => false,
        _ => true,
    }
}

/// Values with what they are called in names; a path is recognised by its folder too where its end does not tell it.
fn named(key: &str, values: Vec<Value>) -> Vec<Choice> {
    let texts = |folders: usize| -> Vec<String> {
        values
            .iter()
            .map(|value| text_of(key, value, folders))
            .collect()
    };
    let (short, long) = (texts(0), texts(1));
    let is_shared = |text: &String| short.iter().filter(|other| *other == text).count() > 1;
    let chosen: Vec<String> = short
        .iter()
        .zip(&long)
        .map(|(short, long)| if is_shared(short) { long } else { short }.clone())
        .collect();
    let choices = values.into_iter().zip(chosen);
    choices
        .map(|(value, text)| Choice { value, text })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// The tags of every run, and the values that its section `[bake]` has.
    fn runs(text: &str) -> Result<Vec<(String, String)>, String> {
        let mut faults = Faults::default();
        let mut document = Document::parse(text, &mut faults);
        let matrix = Matrix::take(&mut document, &mut faults);
        let faults = faults.into_result(Path::new("scene.toml"));
        faults.map_err(|error| error.to_string())?;
        let described = matrix.variants(&document).into_iter().map(|variant| {
            let tags: Vec<String> = variant.tags.into_iter().map(|tag| tag.text).collect();
            let bake = variant.document.sections.iter().find(|s| s.name == "bake");
            let keys = bake.into_iter().flat_map(|section| &section.keys);
            let keys: Vec<String> = keys
                .map(|key| format!("{}={}", key.name, key.value))
                .collect();
            (tags.join("-"), keys.join(" "))
        });
        Ok(described.collect())
    }

    #[test]
    fn every_combination_is_a_run() {
        let text = "[bake]\nsize = 16\n[matrix]\n\"bake.material\" = [\"m/a.toml\", \"m/b.toml\"]\nsynth.seed = [0, 1]\n";
        let expected = [("a", 0), ("a", 1), ("b", 0), ("b", 1)].map(|(material, seed)| {
            (
                format!("{material}-seed{seed}"),
                format!("material=\"m/{material}.toml\" size=16"),
            )
        });
        assert_eq!(runs(text).unwrap(), expected);
    }

    #[test]
    fn files_of_one_name_are_told_by_their_folders() {
        let text = "[matrix]\nbake.material = [\"oak/m.toml\", \"elm/m.toml\", \"n.toml\"]\n";
        let tags: Vec<String> = runs(text).unwrap().into_iter().map(|run| run.0).collect();
        assert_eq!(tags, ["oak-m", "elm-m", "n"]);
        let same = "[matrix]\nbake.material = [\"a/b/m.toml\", \"c/b/m.toml\"]\n";
        assert!(runs(same).unwrap_err().contains("would name outputs `b-m`"));
    }

    #[test]
    fn what_cannot_vary_is_named() {
        let refused = |lines: &str| {
            let text =
                format!("[bake]\nsize = 16\n[[render]]\nname = \"still\"\n[matrix]\n{lines}\n");
            runs(&text).unwrap_err()
        };
        for (lines, says) in [
            (
                "bake.size = [16, 32]",
                "line 6: [matrix] bake.size: line 2 sets this key too",
            ),
            ("bake.views = \"x\"", "`\"x\"`; expected a list of values"),
            ("bake.views = []", "expected a list of values"),
            ("bake.views = [1, 1]", "`1` twice"),
            (
                "bake.views = [1979-05-27]",
                "`1979-05-27`; expected a string",
            ),
            ("bak.size = [1]", "no section [bak]; did you mean `bake`"),
            ("name = [\"a\"]", "[matrix] name: may not vary"),
            ("render.name = [\"a\"]", "may not vary"),
            (
                "render.stil.fill = [0, 1]",
                "no [[render]] of the name stil",
            ),
            ("", "[matrix]: empty"),
        ] {
            let text = refused(lines);
            assert!(text.contains(says), "{lines}: {text}");
        }
        let many: Vec<String> = (0..400).map(|n| n.to_string()).collect();
        let many = many.join(", ");
        let text = refused(&format!("knn.k = [{many}]\nsynth.seed = [{many}]"));
        assert!(text.contains("160000 runs; at most 100000"), "{text}");
    }
}
