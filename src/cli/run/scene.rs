//! A scene file (TOML) → the commands it stands for.
//!
//! A section is a stage and a key one of its options, so that a scene says just what the command
//! line would; the files between the stages are named after the scene.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::{Table, Value};

use crate::error::{Error, Result};

/// A scene, as its file says it; paths are relative to the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// What the outputs are called: NAME.sample, NAME.textons.npz …
    pub name: String,
    /// The folder of all outputs.
    #[serde(default = "here")]
    pub output: PathBuf,
    /// Seed of everything drawn at random; `--seed` goes before it.
    pub seed: Option<u64>,
    /// A sample that exists already; instead of `bake`, `import` or `exemplar`.
    sample: Option<PathBuf>,
    /// A mesh that is used as it is; instead of `[mesh]`.
    surface: Option<PathBuf>,
    bake: Option<Table>,
    import: Option<Table>,
    exemplar: Option<Table>,
    #[serde(default)]
    textons: Table,
    #[serde(default)]
    gram: Table,
    #[serde(default)]
    knn: Table,
    mesh: Option<Table>,
    #[serde(default)]
    synth: Table,
    #[serde(default)]
    render: Vec<Table>,
}

fn here() -> PathBuf {
    PathBuf::from(".")
}

/// One command of a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stage {
    /// What the user reads: the command, and for renderings their name.
    pub name: String,
    /// The command line, without the program.
    pub words: Vec<String>,
    /// Files and folders it reads.
    pub inputs: Vec<PathBuf>,
    /// Files and folders it writes.
    pub outputs: Vec<PathBuf>,
}

impl Scene {
    /// Reads a scene file.
    pub fn read(path: &Path) -> Result<Self> {
        let text = fs::read_to_string(path).map_err(Error::io(path, "read"))?;
        Self::parse(&text).map_err(|error| error.in_file(path))
    }

    fn parse(text: &str) -> Result<Self> {
        let scene: Self = toml::from_str(text).map_err(|error| {
            Error::data("scene", error.to_string().trim_end())
                .expected("a scene as docs/scenes.md describes it")
        })?;
        let plain = |c: char| c.is_alphanumeric() || "-_.".contains(c);
        if scene.name.is_empty() || !scene.name.chars().all(plain) {
            return Err(Error::data("name", format!("`{}`", scene.name))
                .expected("letters, digits, `-`, `_` and `.`"));
        }
        Ok(scene)
    }

    /// The commands of the scene, in order.
    pub fn stages(&self) -> Result<Vec<Stage>> {
        let mut stages = self.appearance_stages()?;
        stages.extend(self.mesh_stage()?);
        stages.push(self.synth_stage()?);
        for table in &self.render {
            stages.push(self.render_stage(table)?);
        }
        Ok(stages)
    }

    fn file(&self, suffix: &str) -> PathBuf {
        let name = format!("{}.{suffix}", self.name);
        if self.output == here() {
            name.into()
        } else {
            self.output.join(name)
        }
    }

    fn sample_path(&self) -> PathBuf {
        self.sample.clone().unwrap_or_else(|| self.file("sample"))
    }

    fn surface_path(&self) -> Result<PathBuf> {
        match (&self.surface, &self.mesh) {
            (Some(surface), None) => Ok(surface.clone()),
            (None, Some(_)) => Ok(self.file("mesh.ply")),
            _ => Err(Error::data("scene", "no one source of the mesh")
                .expected("either `surface = FILE` or a section [mesh]")),
        }
    }

    fn appearance_stages(&self) -> Result<Vec<Stage>> {
        let sources = [
            self.bake.is_some(),
            self.import.is_some(),
            self.exemplar.is_some(),
            self.sample.is_some(),
        ];
        if sources.iter().filter(|&&given| given).count() != 1 {
            return Err(Error::data("scene", "no one source of the sample")
                .expected("one of [bake], [import], [exemplar] or `sample = FOLDER`"));
        }
        if let Some(table) = &self.exemplar {
            return Ok(vec![self.exemplar_stage(table)?]);
        }
        let mut stages = Vec::new();
        if let Some(table) = &self.bake {
            stages.push(self.sample_stage("bake", "material", table)?);
        }
        if let Some(table) = &self.import {
            stages.push(self.sample_stage("import", "path", table)?);
        }
        let link = |command: &str, table, input: PathBuf, output| {
            stage(command, table, &[], vec![input], output)
        };
        let (textons, space) = (self.file("textons.npz"), self.file("space.npz"));
        stages.push(link(
            "textons",
            &self.textons,
            self.sample_path(),
            textons.clone(),
        )?);
        stages.push(link("gram", &self.gram, textons, space.clone())?);
        stages.push(link("knn", &self.knn, space, self.file("knn.npz"))?);
        Ok(stages)
    }

    /// `bake` or `import`: their one input is named in the section.
    fn sample_stage(&self, command: &str, input: &str, table: &Table) -> Result<Stage> {
        let inputs = named_inputs(command, input, table)?;
        stage(command, table, &[input], inputs, self.file("sample"))
    }

    fn exemplar_stage(&self, table: &Table) -> Result<Stage> {
        let inputs = named_inputs("exemplar", "images", table)?;
        let base = self.file("sample").with_extension("");
        let mut stage = stage("exemplar", table, &["images"], inputs, base)?;
        stage.outputs = vec![
            self.file("sample"),
            self.file("space.npz"),
            self.file("knn.npz"),
        ];
        Ok(stage)
    }

    fn mesh_stage(&self) -> Result<Option<Stage>> {
        let output = self.surface_path()?;
        let Some(table) = &self.mesh else {
            return Ok(None);
        };
        let inputs = named_inputs("mesh", "input", table)?;
        stage("mesh", table, &["input"], inputs, output).map(Some)
    }

    fn synth_stage(&self) -> Result<Stage> {
        let inputs = vec![
            self.file("space.npz"),
            self.file("knn.npz"),
            self.surface_path()?,
        ];
        stage("synth", &self.synth, &[], inputs, self.file("map.ply"))
    }

    fn render_stage(&self, table: &Table) -> Result<Stage> {
        let name = match table.get("name") {
            None => "frames",
            Some(Value::String(name)) => name,
            Some(other) => return Err(bad_value("render", "name", other, "a string")),
        };
        let inputs = vec![self.sample_path(), self.file("map.ply")];
        let mut stage = stage("render", table, &["name"], inputs, self.file(name))?;
        stage.name = format!("render {name}");
        Ok(stage)
    }
}

/// The command `command INPUTS… -o OUTPUT --key=value…`; keys in `own` are the scene's, not options.
fn stage(
    command: &str,
    table: &Table,
    own: &[&str],
    inputs: Vec<PathBuf>,
    output: PathBuf,
) -> Result<Stage> {
    let mut words = vec![command.to_owned()];
    words.extend(
        inputs
            .iter()
            .map(|path| path.to_string_lossy().into_owned()),
    );
    words.extend(["-o".into(), output.to_string_lossy().into_owned()]);
    for (key, value) in table.iter().filter(|(key, _)| !own.contains(&key.as_str())) {
        push_option(&mut words, command, key, value)?;
    }
    Ok(Stage {
        name: command.into(),
        words,
        inputs,
        outputs: vec![output],
    })
}

fn push_option(words: &mut Vec<String>, command: &str, key: &str, value: &Value) -> Result<()> {
    match value {
        Value::Boolean(true) => words.push(format!("--{key}")),
        Value::Boolean(false) => {}
        Value::String(text) => words.push(format!("--{key}={text}")),
        Value::Integer(number) => words.push(format!("--{key}={number}")),
        Value::Float(number) => words.push(format!("--{key}={number}")),
        Value::Array(values) => {
            for value in values {
                push_option(words, command, key, value)?;
            }
        }
        other => {
            return Err(bad_value(
                command,
                key,
                other,
                "a number, string, boolean or list",
            ));
        }
    }
    Ok(())
}

/// The files a section names under `key`: a string or a list of strings, or none.
fn named_inputs(command: &str, key: &str, table: &Table) -> Result<Vec<PathBuf>> {
    let path = |value: &Value| match value {
        Value::String(path) => Ok(PathBuf::from(path)),
        other => Err(bad_value(command, key, other, "a path")),
    };
    match table.get(key) {
        None => Ok(Vec::new()),
        Some(Value::Array(values)) => values.iter().map(path).collect(),
        Some(value) => Ok(vec![path(value)?]),
    }
}

fn bad_value(command: &str, key: &str, found: &Value, expected: &str) -> Error {
    Error::data(format!("[{command}] {key}"), format!("`{found}`")).expected(expected)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "name = \"a\"\noutput = \"out\"\n[bake]\npreset = \"weave\"\nsize = 64\n\
        [textons]\ntextons = 20\nluminance = true\n[mesh]\ninput = \"b.obj\"\n\
        [[render]]\nname = \"sweep\"\nframes = 24\n[[render]]\n";

    #[test]
    fn sections_become_commands() {
        let stages = Scene::parse(SCENE).unwrap().stages().unwrap();
        let commands: Vec<String> = stages.iter().map(|stage| stage.words.join(" ")).collect();
        assert_eq!(
            commands,
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
    fn incomplete_scenes_are_refused() {
        let refused = |from: &str, to: &str| {
            let scene = Scene::parse(&SCENE.replace(from, to));
            scene
                .and_then(|scene| scene.stages())
                .unwrap_err()
                .to_string()
        };
        assert!(refused("[bake]", "[baker]").contains("baker"));
        assert!(refused("output = \"out\"", "sample = \"x\"").contains("source of the sample"));
        assert!(refused("[mesh]\ninput = \"b.obj\"\n", "").contains("source of the mesh"));
        assert!(refused("size = 64", "size = {}").contains("[bake] size"));
        assert!(refused("name = \"a\"", "name = \"a/b\"").contains("a/b"));
    }
}
