//! A scene file (TOML) → the stages it stands for.
//!
//! A section is a stage and a key one of its options, so that a scene says just what the command
//! line would; the files between the stages are named after the scene. With a `[matrix]` a text is several
//! scenes, and a file is named after the values that reach it too.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use toml::Value;

use crate::cli::endings::check_stem;
use crate::cli::failure::likely_names::suggestion;
use crate::cli::run::document::{Document, Section};
use crate::cli::run::draft::Draft;
use crate::cli::run::faults::{Faults, Place};
use crate::cli::run::matrix::{self, Matrix};
use crate::cli::run::sections::SECTIONS;
use crate::cli::run::side_outputs::mark_side_outputs;
use crate::cli::run::tag::Tag;
use crate::render::Axis;
use crate::synthesis::Method;

/// Keys at the top of a scene.
const TOP: [&str; 5] = ["name", "output", "seed", "sample", "surface"];
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
    /// The values of `[matrix]` that it has.
    pub tags: Vec<Tag>,
    /// Whether the seed is one of them.
    pub has_own_seed: bool,
}

impl Scene {
    /// Reads the scenes of a text: one, or one for every run of its `[matrix]`. What is wrong goes to `faults`.
    pub fn all(text: &str, faults: &mut Faults) -> Vec<Self> {
        let mut document = Document::parse(text, faults);
        let matrix = Matrix::take(&mut document, faults);
        if !faults.is_empty() {
            return Vec::new();
        }
        let variants = matrix.variants(&document).into_iter();
        let scenes = variants.map(|variant| {
            let mut scene = Self {
                output: ".".into(),
                document: variant.document,
                tags: variant.tags,
                has_own_seed: matrix.varies_seed(),
                ..Self::default()
            };
            scene.take_top(faults);
            scene.check_sections(faults);
            scene.tag_side_outputs();
            scene
        });
        scenes.collect()
    }

    /// The values of `[matrix]` that reach a stage, as names of outputs state them.
    fn variant_of(&self, stage: &str, rendering: Option<&str>) -> String {
        let reaching = self.tags.iter().filter(|tag| tag.reaches(stage, rendering));
        let texts: Vec<&str> = reaching.map(|tag| tag.text.as_str()).collect();
        texts.join("-")
    }

    /// All values of `[matrix]`, as names state them; empty where nothing varies.
    pub fn variant(&self) -> String {
        let texts: Vec<&str> = self.tags.iter().map(|tag| tag.text.as_str()).collect();
        texts.join("-")
    }

    /// What the whole run is called.
    pub fn title(&self) -> String {
        dashed(&self.name, &self.variant())
    }

    /// Names files beside products after the varied values too.
    fn tag_side_outputs(&mut self) {
        for at in 0..self.document.sections.len() {
            let section = &self.document.sections[at];
            let mark = self.variant_of(&section.name, name_of_rendering(section));
            if !mark.is_empty() {
                mark_side_outputs(&mut self.document.sections[at], &format!("-{mark}"));
            }
        }
    }

    fn take_top(&mut self, faults: &mut Faults) {
        for key in &self.document.keys {
            let place = key.place();
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
                    let known = TOP
                        .iter()
                        .chain(&SECTIONS)
                        .copied()
                        .chain([matrix::SECTION]);
                    faults.data(&place, format!("unknown{}", suggestion(name, known)));
                }
            }
        }
        if !self.document.keys.iter().any(|key| key.name == "name") {
            faults.data(
                &Place::new(0, ""),
                "no `name`; expected `name = \"NAME\"`, after which the outputs are named",
            );
        }
    }

    fn check_sections(&self, faults: &mut Faults) {
        for section in &self.document.sections {
            let name = section.name.as_str();
            if !SECTIONS.contains(&name) {
                let known = SECTIONS
                    .iter()
                    .chain(&TOP)
                    .copied()
                    .chain([matrix::SECTION]);
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
                    "no effect beside [exemplar], which has these options itself",
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

    /// What a stage writes: NAME.SUFFIX, the varied values that reach the stage after the name.
    fn file(&self, stage: &str, suffix: &str) -> PathBuf {
        self.named(&self.variant_of(stage, None), suffix)
    }

    fn named(&self, variant: &str, suffix: &str) -> PathBuf {
        let name = format!("{}.{suffix}", dashed(&self.name, variant));
        match self.output.as_os_str() == "." {
            true => name.into(),
            false => self.output.join(name),
        }
    }

    /// The sample and the map.
    pub fn sample_and_map(&self) -> [PathBuf; 2] {
        let sample = self.sample.clone();
        let sample = sample.unwrap_or_else(|| self.file(self.source_of_sample(), "sample"));
        [sample, self.file("synth", self.kind_of_map())]
    }

    /// A page: NAME.KIND.html.
    pub fn page(&self, kind: &str) -> PathBuf {
        self.named(&self.variant(), &format!("{kind}.html"))
    }

    /// The section that makes the sample.
    fn source_of_sample(&self) -> &'static str {
        let sources = ["bake", "import", "exemplar"];
        let found = sources.into_iter().find(|section| self.has(section));
        found.unwrap_or("bake")
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
        let section = self.section("synth");
        let value = |name| section?.key(name)?.value.as_str();
        let method = value("method").and_then(|name| Method::from_str(name, false).ok());
        if value("onto") == Some("faces") || method.is_some_and(Method::writes_faces) {
            "faces.ply"
        } else {
            "map.ply"
        }
    }

    /// The stages of the scene, in order.
    pub fn drafts(&self, faults: &mut Faults) -> Vec<Draft> {
        // Name what stages hand on.
        let [sample, map] = self.sample_and_map();
        let surface = self
            .surface
            .clone()
            .unwrap_or_else(|| self.file("mesh", "mesh.ply"));
        let makers = match self.has("exemplar") {
            true => ["exemplar"; 2],
            false => ["gram", "knn"],
        };
        let space = self.file(makers[0], "space.npz");
        let table = self.file(makers[1], "knn.npz");
        // List the stages of the sample.
        let mut drafts = Vec::new();
        for (command, key) in [("bake", "material"), ("import", "path")] {
            drafts.extend(self.source(command, key, self.file(command, "sample"), faults));
        }
        if self.has("exemplar") {
            let stem = self.file("exemplar", "sample").with_extension("");
            drafts.extend(self.source("exemplar", "images", stem, faults));
        } else {
            let textons = self.file("textons", "textons.npz");
            drafts.push(self.link("textons", vec![sample.clone()], textons.clone(), faults));
            drafts.push(self.link("gram", vec![textons], space.clone(), faults));
            drafts.push(self.link("knn", vec![space.clone()], table.clone(), faults));
        }
        // List those of the surface.
        drafts.extend(self.source("mesh", "input", surface.clone(), faults));
        drafts.push(self.link("synth", vec![space, table, surface], map.clone(), faults));
        // List the renderings.
        for section in self
            .document
            .sections
            .iter()
            .filter(|section| section.name == "render")
        {
            let name = sequence_name(section, faults);
            let variant = self.variant_of("render", Some(&name));
            drafts.push(Draft {
                name: format!("render {name}"),
                command: "render",
                input_key: "",
                inputs: vec![sample.clone(), map.clone()],
                output: self.named(&variant, &name),
                section: section.clone(),
                seed: self.seed_of(section, faults),
                variant,
            });
        }
        drafts
    }

    /// A stage whose inputs other stages make.
    fn link(
        &self,
        command: &'static str,
        inputs: Vec<PathBuf>,
        output: PathBuf,
        faults: &mut Faults,
    ) -> Draft {
        let empty = || Section {
            name: command.into(),
            ..Section::default()
        };
        let section = self.section(command).cloned().unwrap_or_else(empty);
        Draft {
            name: command.into(),
            command,
            input_key: "",
            inputs,
            output,
            seed: self.seed_of(&section, faults),
            section,
            variant: self.variant_of(command, None),
        }
    }

    /// The seed of a stage: its section's own, or that of a run whose seed varies.
    fn seed_of(&self, section: &Section, faults: &mut Faults) -> Option<u64> {
        let of_run = self.seed.filter(|_| self.has_own_seed);
        let Some(key) = section.key("seed") else {
            return of_run;
        };
        match key.value.as_integer().map(u64::try_from) {
            Some(Ok(seed)) => Some(seed),
            _ => {
                let says = format!("`{}`; expected a number of 0 or more", key.value);
                faults.data(&section.place(key), says);
                None
            }
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
            ..self.link(command, inputs, output, faults)
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

/// A name and what is told apart by, with a dash between them.
fn dashed(name: &str, variant: &str) -> String {
    match variant {
        "" => name.to_owned(),
        variant => format!("{name}-{variant}"),
    }
}

/// The default name of a sequence of frames.
const FRAMES: &str = "frames";

/// The name of a section's sequence of frames; `None` of other sections.
fn name_of_rendering(section: &Section) -> Option<&str> {
    let name = || section.key("name")?.value.as_str();
    (section.name == "render").then(|| name().unwrap_or(FRAMES))
}

/// What a sequence of frames is called.
fn sequence_name(section: &Section, faults: &mut Faults) -> String {
    match section.key("name") {
        None => FRAMES.into(),
        Some(key) => match &key.value {
            Value::String(name) if is_plain(name) => name.clone(),
            other => {
                faults.data(&section.place(key), format!("`{other}`; {PLAIN}"));
                FRAMES.into()
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
        let scenes = Scene::all(text, &mut faults);
        let of_scene = |scene: &Scene| scene.drafts(&mut faults);
        let drafts: Vec<Draft> = scenes.iter().flat_map(of_scene).collect();
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
    fn files_are_named_after_the_values_that_reach_them() {
        let scene = SCENE.replace("input = \"b.obj\"\n", "").replace(
            "[bake]",
            "[matrix]\nmesh.input = [\"b.obj\", \"c.obj\"]\nsynth.seed = [4]\n\
             render.sweep.fill = [0.5]\n[bake]",
        );
        let scene = scene.replace("[textons]\n", "[textons]\nreport = \"t.json\"\n");
        let scene = scene + "[synth]\nreport = \"out/s.json\"\n";
        let commands = commands(&scene).unwrap();
        assert_eq!(commands.len(), 16);
        assert_eq!(
            commands[8..],
            [
                "bake -o out/a.sample --preset=weave --size=64",
                "textons out/a.sample -o out/a.textons.npz --luminance --report=t.json --textons=20",
                "gram out/a.textons.npz -o out/a.space.npz",
                "knn out/a.space.npz -o out/a.knn.npz",
                "mesh c.obj -o out/a-c.mesh.ply",
                "synth out/a.space.npz out/a.knn.npz out/a-c.mesh.ply -o out/a-c-seed4.map.ply \
                 --report=out/s-c-seed4.json",
                "render out/a.sample out/a-c-seed4.map.ply -o out/a-c-seed4-fill0.5.sweep --fill=0.5 --frames=24",
                "render out/a.sample out/a-c-seed4.map.ply -o out/a-c-seed4.frames",
            ]
        );
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
                .contains("[textons]: no effect")
        );
        assert!(
            refused("preset = \"weave\"\n", "").contains("`material = PATH` or `preset = NAME`")
        );
    }
}
