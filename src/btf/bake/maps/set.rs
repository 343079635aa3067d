//! A material as its files make it: the recipe, what each file is used for, and what stays at defaults.

use std::path::{Path, PathBuf};

use crate::btf::bake::maps::recipe::{Color, Recipe, Scalar};
use crate::error::Result;

/// What a file of a material is used for, or why not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileUse {
    /// The file, relative to the material's folder.
    pub file: PathBuf,
    /// What it shows, as far as its name says.
    pub role: String,
    /// Whether the bake reads it.
    pub used: bool,
    /// What it is used as, or why it is not used.
    pub why: String,
}

/// A role that no file plays, and what stands in for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DefaultRole {
    /// The role.
    pub role: &'static str,
    /// What the bake takes in its place.
    pub value: String,
}

/// A material with the files it is made of.
#[derive(Debug)]
pub struct MaterialSet {
    /// What the material is called.
    pub name: String,
    /// Whose way of naming files the folder follows, where names show it.
    pub naming: Option<&'static str>,
    /// Every file of the folder that is not hidden; of a recipe, those it names.
    pub files: Vec<FileUse>,
    /// Roles that no file plays.
    pub defaults: Vec<DefaultRole>,
    /// The recipe, or why the files make none.
    pub recipe: Result<Recipe>,
}

impl MaterialSet {
    pub(super) fn new(
        name: String,
        naming: Option<&'static str>,
        files: Vec<FileUse>,
        recipe: Result<Recipe>,
    ) -> Self {
        let defaults = recipe.as_ref().map(defaults).unwrap_or_default();
        Self {
            name,
            naming,
            files,
            defaults,
            recipe,
        }
    }

    /// The set of a recipe that was written by hand.
    pub(super) fn of_recipe(recipe: Recipe) -> Self {
        let used = |(role, file, why): (&str, PathBuf, String)| FileUse {
            file,
            role: role.to_owned(),
            used: true,
            why,
        };
        let files = recipe.maps().into_iter().map(used).collect();
        Self::new(recipe.name.clone(), None, files, Ok(recipe))
    }

    /// A line per file and per role without one.
    pub fn lines(&self) -> Vec<String> {
        let used = self.files.iter().filter(|file| file.used);
        let unused = self.files.iter().filter(|file| !file.used);
        let mut lines: Vec<String> = used
            .map(|file| format!("{}: {}", file.file.display(), file.why))
            .collect();
        let left = |file: &FileUse| {
            let (name, role, why) = (file.file.display(), &file.role, &file.why);
            format!("{name}: not used ({role}): {why}")
        };
        lines.extend(unused.map(left));
        lines.extend(
            self.defaults
                .iter()
                .map(|role| format!("no {} map: {}", role.role, role.value)),
        );
        lines
    }
}

fn defaults(recipe: &Recipe) -> Vec<DefaultRole> {
    let mut defaults = Vec::new();
    let mut add = |role, value: String| defaults.push(DefaultRole { role, value });
    if recipe.relief.height.is_none() && recipe.relief.normal.is_none() {
        add("height or normal", "the surface is a plane".into());
    }
    if let Color::Constant([r, g, b]) = recipe.surface.albedo {
        add("albedo", format!("{r} {g} {b} everywhere, linear"));
    }
    let number = |scalar: &Option<Scalar>, none: &str| match scalar {
        Some(Scalar::Constant(number)) => Some(format!("{number} everywhere")),
        Some(Scalar::Map(_)) => None,
        None => Some(none.to_owned()),
    };
    if !recipe.rough_is_packed() {
        let (scalar, role) = match &recipe.surface.gloss {
            Some(_) => (&recipe.surface.gloss, "gloss"),
            None => (&recipe.surface.roughness, "roughness"),
        };
        if let Some(value) = number(scalar, "the surface is matte, without a coat") {
            add(role, value);
        }
    }
    let metallic = number(&recipe.surface.metallic, "0 everywhere, no metal");
    if let Some(value) = metallic.filter(|_| !recipe.metal_is_packed()) {
        add("metallic", value);
    }
    defaults
}

/// The set of a path: a recipe, or a folder.
pub(super) fn read(path: &Path) -> Result<MaterialSet> {
    let inside = path.join("material.toml");
    if path.is_dir() && !inside.is_file() {
        return super::folder::survey(path);
    }
    let file = if path.is_dir() { &inside } else { path };
    super::recipe::read(file).map(MaterialSet::of_recipe)
}
