//! A scene file (TOML) → the stages it stands for.
//!
//! A section is a stage and a key one of its options, so that a scene says just what the command
//! line would; the files between the stages are named after the scene.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use toml::Value;

use crate::cli::endings::check_stem;
use crate::cli::failure::likely_names::suggestion;
use crate::cli::run::document::{Document, Key, Section};
use crate::cli::run::faults::{Faults, Place};
use crate::render::Axis;

/// Keys at the top of a scene.
const TOP: [&str; 5] = ["name", "output", "seed", "sample", "surface"];
/// Sections of a scene, in the order of their stages.
pub const SECTIONS: [&str; 9] = [
    "bake", "import", "exemplar", "textons", "gram", "knn", "mesh", "synth", "render",
];
/// Sections without effect beside `[exemplar]`, which does their work.
const DONE_BY_EXEMPLAR: [&str; 3] = ["textons", "gram", "knn"];

/// A scene, as its file says it; paths are relative to the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// What the outputs are called: NAME.sample, NAME.textons.npz …
    pub name: String,
    /// The folder of all outputs.
    pub output: PathBuf,
    /// Seed of everything drawn at random; `--seed` goes before it.
    pub seed: Option<u64>,
    /// A sample that exists already; instead of `bake`, `import` or `exemplar`.
    sample: Option<PathBuf>,
    /// A mesh that is used as it is; instead of `[mesh]`.
    surface: Option<PathBuf>,
    /// The text it was read from.
    pub document: Document,
}

/// One stage before its options are parsed: a command, its files, and the section of its options.
#[derive(Clone, Debug, PartialEq)]
pub struct Draft {
    /// What the user reads: the command, and for renderings their name.
    pub name: String,
    /// The command.
    pub command: &'static str,
    /// The key of the section that names the inputs; empty where other stages make them.
    pub input_key: &'static str,
    /// Its inputs.
    pub inputs: Vec<PathBuf>,
    /// Its output.
    pub output: PathBuf,
    /// Its options.
    pub section: Section,
}

impl Draft {
    /// The command line, without the program and without the options in `left_out`.
    pub fn words(&self, left_out: &[String]) -> Vec<String> {
        let mut words = vec![self.command.to_owned()];
        words.extend(self.inputs.iter().map(|path| path_word(path)));
        words.extend(["-o".into(), path_word(&self.output)]);
        for key in self.options().filter(|key| !left_out.contains(&key.name)) {
            push_option(&mut words, &key.name, &key.value);
        }
        words
    }

    /// The keys that are options of the command.
    pub fn options(&self) -> impl Iterator<Item = &Key> {
        let own = [
            self.input_key,
            if self.command == "render" { "name" } else { "" },
        ];
        self.section
            .keys
            .iter()
            .filter(move |key| !own.contains(&key.name.as_str()))
    }
}

/// A path as a word of a command line: one that begins with `-` is no option.
fn path_word(path: &Path) -> String {
    let text = path.to_string_lossy();
    match text.starts_with('-') {
        true => format!("./{text}"),
        false => text.into_owned(),
    }
}

fn push_option(words: &mut Vec<String>, key: &str, value: &Value) {
    match value {
        Value::Boolean(true) => words.push(format!("--{key}")),
        Value::Boolean(false) => {}
        Value::String(text) => words.push(format!("--{key}={text}")),
        Value::Array(values) => values
            .iter()
            .for_each(|value| push_option(words, key, value)),
        other => words.push(format!("--{key}={other}")),
    }
}

impl Scene {
    /// Reads a scene from its text; what is wrong with it goes to `faults`.
    pub fn parse(text: &str, faults: &mut Faults) -> Self {
        let mut scene = Self {
            output: ".".into(),
            document: Document::parse(text, faults),
            ..Self::default()
        };
        if faults.is_empty() {
            scene.take_top(faults);
            scene.check_sections(faults);
        }
        scene
    }

    fn take_top(&mut self, faults: &mut Faults) {
        for key in &self.document.keys {
            let place = Place::new(key.line, &key.name);
            match (key.name.as_str(), &key.value) {
                ("name", Value::String(name)) if is_plain(name) => {
                    self.name.clone_from(name);
                    if let Err(error) = check_stem("name", Path::new(name), &["sample", "map.ply"])
                    {
                        faults.data(&place, error.to_string().trim_start_matches("--name: "));
                    }
                }
                ("name", other) => faults.data(&place, format!("`{other}`; {PLAIN}")),
                ("output", Value::String(path)) => self.output = path.into(),
                ("sample", Value::String(path)) => self.sample = Some(path.into()),
                ("surface", Value::String(path)) => self.surface = Some(path.into()),
                ("seed", Value::Integer(seed)) if *seed >= 0 => self.seed = Some(*seed as u64),
                ("seed", other) => {
                    faults.data(&place, format!("`{other}`; expected a number of 0 or more"))
                }
                (name, other) if TOP.contains(&name) => {
                    faults.data(&place, format!("`{other}`; expected a path"));
                }
                (name, _) => {
                    let known = TOP.iter().chain(&SECTIONS).copied();
                    faults.data(&place, format!("unknown{}", suggestion(name, known)));
                }
            }
        }
        if !self.document.keys.iter().any(|key| key.name == "name") {
            faults.data(
                &Place::new(0, ""),
                "no `name`; expected `name = \"NAME\"`, which the outputs are called after",
            );
        }
    }

    fn check_sections(&self, faults: &mut Faults) {
        for section in &self.document.sections {
            let name = section.name.as_str();
            if !SECTIONS.contains(&name) {
                let known = SECTIONS.iter().chain(&TOP).copied();
                faults.data(
                    &section.head(),
                    format!("unknown{}", suggestion(name, known)),
                );
            } else if name == "render" && !section.listed {
                faults.data(&section.head(), "one pair of brackets; expected [[render]]");
            } else if name != "render" && section.listed {
                faults.data(
                    &section.head(),
                    format!("two pairs of brackets; expected one [{name}]"),
                );
            } else if self.has("exemplar") && DONE_BY_EXEMPLAR.contains(&name) {
                faults.data(
                    &section.head(),
                    "without effect beside [exemplar]; its options stand there",
                );
            }
        }
        self.check_source(
            "sample",
            &["bake", "import", "exemplar"],
            self.sample.is_some(),
            faults,
        );
        self.check_source("surface", &["mesh"], self.surface.is_some(), faults);
    }

    /// Sample and mesh each come from one place: the key, or one of the sections.
    fn check_source(&self, key: &str, sections: &[&str], has_key: bool, faults: &mut Faults) {
        let named = sections.iter().filter(|name| self.has(name));
        let mut given: Vec<String> = named.map(|name| format!("[{name}]")).collect();
        given.extend(has_key.then(|| format!("`{key} = …`")));
        if given.len() == 1 {
            return;
        }
        let list: Vec<String> = sections.iter().map(|name| format!("[{name}]")).collect();
        let found = match given.len() {
            0 => format!("no source of the {key}"),
            _ => format!("{} sources of the {key}: {}", given.len(), given.join(", ")),
        };
        let expected = format!("expected one of {} or `{key} = PATH`", list.join(", "));
        faults.data(&Place::new(0, ""), format!("{found}; {expected}"));
    }

    /// Whether there is a section of this name.
    pub fn has(&self, section: &str) -> bool {
        self.section(section).is_some()
    }

    /// What a key of a section is set to.
    pub fn value(&self, section: &str, key: &str) -> Option<&Value> {
        Some(&self.section(section)?.key(key)?.value)
    }

    /// Sets a key; the section is added where there is none.
    pub fn set(&mut self, section: &str, key: &str, value: Value) {
        let sections = &mut self.document.sections;
        let place = sections.iter().position(|other| other.name == section);
        let place = place.unwrap_or_else(|| {
            sections.push(Section {
                name: section.to_owned(),
                ..Section::default()
            });
            sections.len() - 1
        });
        sections[place].set(key, value);
    }

    /// Takes a key away.
    pub fn unset(&mut self, section: &str, key: &str) {
        let of_name = |other: &&mut Section| other.name == section;
        for section in self.document.sections.iter_mut().filter(of_name) {
            section.keys.retain(|other| other.name != key);
        }
    }

    /// The sections of renderings.
    pub fn renderings(&mut self) -> impl Iterator<Item = &mut Section> {
        let sections = self.document.sections.iter_mut();
        sections.filter(|section| section.name == "render")
    }

    fn section(&self, name: &str) -> Option<&Section> {
        self.document
            .sections
            .iter()
            .find(|section| section.name == name)
    }

    fn file(&self, suffix: &str) -> PathBuf {
        let name = format!("{}.{suffix}", self.name);
        match self.output.as_os_str() == "." {
            true => name.into(),
            false => self.output.join(name),
        }
    }

    /// The sample and the map.
    pub fn sample_and_map(&self) -> [PathBuf; 2] {
        let sample = self.sample.clone();
        let sample = sample.unwrap_or_else(|| self.file("sample"));
        [sample, self.file(self.kind_of_map())]
    }

    /// A page: NAME.KIND.html.
    pub fn page(&self, kind: &str) -> PathBuf {
        self.file(&format!("{kind}.html"))
    }

    /// The axis that points up in the first sequence of frames.
    pub fn up(&self) -> Axis {
        self.axis("up").unwrap_or_default()
    }

    /// The front that the first sequence of frames states.
    pub fn front(&self) -> Option<Axis> {
        self.axis("front")
    }

    fn axis(&self, option: &str) -> Option<Axis> {
        let section = self.section("render")?;
        let name = section.key(option)?.value.as_str()?;
        Axis::from_str(name, true).ok()
    }

    /// What the file of the map ends with.
    fn kind_of_map(&self) -> &'static str {
        let says = |section: &Section, key: &str, wanted: &str| {
            let value = section.key(key).and_then(|key| key.value.as_str());
            value == Some(wanted)
        };
        let is_onto_faces = self.section("synth").is_some_and(|section| {
            says(section, "onto", "faces") || says(section, "method", "choosy")
        });
        if is_onto_faces {
            "faces.ply"
        } else {
            "map.ply"
        }
    }

    /// The stages of the scene, in order.
    pub fn drafts(&self, faults: &mut Faults) -> Vec<Draft> {
        let [sample, map] = self.sample_and_map();
        let surface = self
            .surface
            .clone()
            .unwrap_or_else(|| self.file("mesh.ply"));
        let (space, table) = (self.file("space.npz"), self.file("knn.npz"));
        let mut drafts = Vec::new();
        for (command, key) in [("bake", "material"), ("import", "path")] {
            drafts.extend(self.source(command, key, self.file("sample"), faults));
        }
        if self.has("exemplar") {
            drafts.extend(self.source(
                "exemplar",
                "images",
                self.file("sample").with_extension(""),
                faults,
            ));
        } else {
            let textons = self.file("textons.npz");
            drafts.push(self.link("textons", vec![sample.clone()], textons.clone()));
            drafts.push(self.link("gram", vec![textons], space.clone()));
            drafts.push(self.link("knn", vec![space.clone()], table.clone()));
        }
        drafts.extend(self.source("mesh", "input", surface.clone(), faults));
        drafts.push(self.link("synth", vec![space, table, surface], map.clone()));
        for section in self
            .document
            .sections
            .iter()
            .filter(|section| section.name == "render")
        {
            let name = sequence_name(section, faults);
            drafts.push(Draft {
                name: format!("render {name}"),
                command: "render",
                input_key: "",
                inputs: vec![sample.clone(), map.clone()],
                output: self.file(&name),
                section: section.clone(),
            });
        }
        drafts
    }

    /// A stage whose inputs other stages make.
    fn link(&self, command: &'static str, inputs: Vec<PathBuf>, output: PathBuf) -> Draft {
        let empty = || Section {
            name: command.into(),
            ..Section::default()
        };
        Draft {
            name: command.into(),
            command,
            input_key: "",
            inputs,
            output,
            section: self.section(command).cloned().unwrap_or_else(empty),
        }
    }

    /// A stage whose inputs its section names under `key`; none where the scene has no such section.
    fn source(
        &self,
        command: &'static str,
        key: &'static str,
        output: PathBuf,
        faults: &mut Faults,
    ) -> Option<Draft> {
        let section = self.section(command)?;
        let inputs = named_inputs(section, key, faults);
        if section.key(key).is_none() && section.key("preset").is_none() {
            let preset = if command == "bake" {
                " or `preset = NAME`"
            } else {
                ""
            };
            faults.data(
                &section.head(),
                format!("no `{key}`; expected `{key} = PATH`{preset}"),
            );
        }
        Some(Draft {
            input_key: key,
            ..self.link(command, inputs, output)
        })
    }
}

const PLAIN: &str = "expected letters, digits, `-`, `_` and `.`";

fn is_plain(name: &str) -> bool {
    !name.is_empty()
        && name
            .chars()
            .all(|c| c.is_alphanumeric() || "-_.".contains(c))
}

/// What a sequence of frames is called.
fn sequence_name(section: &Section, faults: &mut Faults) -> String {
    match section.key("name") {
        None => "frames".into(),
        Some(key) => match &key.value {
            Value::String(name) if is_plain(name) => name.clone(),
            other => {
                faults.data(&section.place(key), format!("`{other}`; {PLAIN}"));
                "frames".into()
            }
        },
    }
}

/// The files a section names under `key`: a string or a list of strings, or none.
fn named_inputs(section: &Section, key: &str, faults: &mut Faults) -> Vec<PathBuf> {
    let Some(key) = section.key(key) else {
        return Vec::new();
    };
    let values = match &key.value {
        Value::Array(values) => values.as_slice(),
        value => std::slice::from_ref(value),
    };
    let mut inputs = Vec::new();
    for value in values {
        match value {
            Value::String(path) => inputs.push(path.into()),
            other => faults.data(&section.place(key), format!("`{other}`; expected a path")),
        }
    }
    inputs
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "name = \"a\"\noutput = \"out\"\n[bake]\npreset = \"weave\"\nsize = 64\n\
        [textons]\ntextons = 20\nluminance = true\n[mesh]\ninput = \"b.obj\"\n\
        [[render]]\nname = \"sweep\"\nframes = 24\n[[render]]\n";

    fn commands(text: &str) -> std::result::Result<Vec<String>, String> {
        let mut faults = Faults::default();
        let drafts = Scene::parse(text, &mut faults).drafts(&mut faults);
        faults
            .into_result(Path::new("scene.toml"))
            .map_err(|error| error.to_string())?;
        Ok(drafts
            .iter()
            .map(|draft| draft.words(&[]).join(" "))
            .collect())
    }

    #[test]
    fn sections_become_commands() {
        assert_eq!(
            commands(SCENE).unwrap(),
            [
                "bake -o out/a.sample --preset=weave --size=64",
                "textons out/a.sample -o out/a.textons.npz --luminance --textons=20",
                "gram out/a.textons.npz -o out/a.space.npz",
                "knn out/a.space.npz -o out/a.knn.npz",
                "mesh b.obj -o out/a.mesh.ply",
                "synth out/a.space.npz out/a.knn.npz out/a.mesh.ply -o out/a.map.ply",
                "render out/a.sample out/a.map.ply -o out/a.sweep --frames=24",
                "render out/a.sample out/a.map.ply -o out/a.frames",
            ]
        );
    }

    #[test]
    fn faces_have_a_map_of_their_own_kind() {
        let scene = SCENE.replace("[mesh]", "[synth]\nmethod = \"choosy\"\n[mesh]");
        let commands = commands(&scene).unwrap();
        let synth =
            "synth out/a.space.npz out/a.knn.npz out/a.mesh.ply -o out/a.faces.ply --method=choosy";
        assert_eq!(commands[5], synth);
        assert!(commands[6].starts_with("render out/a.sample out/a.faces.ply"));
    }

    #[test]
    fn names_that_begin_with_a_dash_are_no_options() {
        let scene = SCENE.replace("b.obj", "--json").replace("\"a\"", "\"-a\"");
        let scene = scene.replace("output = \"out\"\n", "");
        let commands = commands(&scene).unwrap();
        assert_eq!(commands[0], "bake -o ./-a.sample --preset=weave --size=64");
        assert_eq!(commands[4], "mesh ./--json -o ./-a.mesh.ply");
    }

    #[test]
    fn incomplete_scenes_are_refused() {
        let refused = |from: &str, to: &str| commands(&SCENE.replace(from, to)).unwrap_err();
        assert!(
            refused("[bake]", "[baker]").contains("line 3: [baker]: unknown; did you mean `bake`")
        );
        assert!(
            refused("output = \"out\"", "sample = \"x\"")
                .contains("2 sources of the sample: [bake], `sample")
        );
        assert!(refused("[mesh]\ninput = \"b.obj\"\n", "").contains("no source of the surface"));
        assert!(refused("name = \"a\"", "name = \"a/b\"").contains("line 1: name: `\"a/b\"`"));
        assert!(refused("name = \"sweep\"", "name = \"../up\"").contains("line 12: [render] name"));
        assert!(refused("[[render]]\nname", "[render]\nname").contains("line"));
        assert!(
            refused("[bake]\npreset = \"weave\"", "[exemplar]\nimages = 3")
                .contains("[textons]: without effect")
        );
        assert!(
            refused("preset = \"weave\"\n", "").contains("`material = PATH` or `preset = NAME`")
        );
    }
}
