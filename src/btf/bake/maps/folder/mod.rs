//! Folders of maps, by the names that public libraries and programs give their files: which file plays
//! which role, and why the others play none.
//!
//! [`names`] cuts names into words and sets the asset's own name aside, [`roles`] knows the words,
//! [`choice`] takes one file per role, [`listing`] finds the files. [`shown_by_names`] tells what files of
//! any list show, for commands other than `bake`.

mod choice;
mod listing;
mod names;
mod roles;

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::btf::bake::maps::folder::choice::{Candidate, Ranking, naming};
use crate::btf::bake::maps::folder::names::{Word, own_words, words_of};
use crate::btf::bake::maps::folder::roles::{BUMP, OPACITY, PREVIEW, Role, Told, told, unreal};
use crate::btf::bake::maps::normals::NormalY;
use crate::btf::bake::maps::packed::PackedChannel;
use crate::btf::bake::maps::recipe::{
    Color, PackedMap, Recipe, ReliefRecipe, Scalar, SurfaceRecipe,
};
use crate::btf::bake::maps::set::MaterialSet;
use crate::error::{Error, Result};

/// Looks through a folder of maps. What keeps them from being a material is in the set's `recipe`.
pub(super) fn survey(folder: &Path) -> Result<MaterialSet> {
    let listing = listing::of(folder)?;
    let candidates = candidates(&listing.images);
    let mut ranking = Ranking::new(candidates);
    let name = asset_name(folder);
    let recipe = recipe(folder, &name, &mut ranking);
    let naming = naming(&listing.images);
    let mut files = ranking.into_uses();
    files.extend(listing.others);
    files.sort_by(|a, b| a.file.cmp(&b.file));
    let recipe = recipe.map_err(|error| error.in_file(folder));
    Ok(MaterialSet::new(name, naming, files, recipe))
}

fn asset_name(folder: &Path) -> String {
    fs::canonicalize(folder)
        .ok()
        .and_then(|path| path.file_name().map(|n| n.to_string_lossy().into_owned()))
        .unwrap_or_default()
}

/// What each image's name says. Previews are set aside first: their names need not share the asset's.
fn candidates(images: &[PathBuf]) -> Vec<Candidate> {
    let (previews, maps): (Vec<Named>, Vec<Named>) =
        images.iter().map(Named::new).partition(Named::is_preview);
    let words: Vec<Vec<Word>> = maps.iter().map(|map| map.words.clone()).collect();
    let of_map = |(map, (own, told)): (Named, (Range<usize>, Option<Told>))| {
        Candidate::new(map.file, &map.words, own, told)
    };
    let of_preview = |preview: Named| {
        let whole = 0..preview.words.len();
        Candidate::new(
            preview.file,
            &preview.words,
            whole.clone(),
            told(&preview.words, whole),
        )
    };
    let maps = maps.into_iter().zip(told_together(&words)).map(of_map);
    maps.chain(previews.into_iter().map(of_preview)).collect()
}

/// The own words of each of several names, and what they say.
fn told_together(words: &[Vec<Word>]) -> Vec<(Range<usize>, Option<Told>)> {
    let own = own_words(words, |at, range| told(&words[at], range).is_some());
    let is_unreal = words.len() > 1 && words.iter().all(|words| begins_with_t(words));
    let tell = if is_unreal { unreal } else { told };
    let of = |(words, own): (&Vec<Word>, Range<usize>)| (own.clone(), tell(words, own));
    words.iter().zip(own).map(of).collect()
}

/// What the name of an image says it shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// Colour.
    Color,
    /// How high the surface is.
    Height,
    /// Normals.
    Normal,
    /// How opaque it is.
    Opacity,
    /// Something else, as roughness, metal, occlusion, parts of a pattern.
    Other,
}

/// What the names of images of one list say they show, one for each; nothing where a name says nothing.
pub fn shown_by_names(files: &[PathBuf]) -> Vec<Option<Shown>> {
    let words: Vec<Vec<Word>> = files.iter().map(|file| words_of(file)).collect();
    let shown = |(words, (_, told)): (&Vec<Word>, (Range<usize>, Option<Told>))| {
        let told = told?;
        Some(match told.role {
            Role::Albedo => Shown::Color,
            Role::Height => Shown::Height,
            Role::Normal(_) => Shown::Normal,
            // A bake takes every mask for one of opacity; here a mask may be one of anything.
            Role::Other(other) if other.name == OPACITY && words[told.at].text != "mask" => {
                Shown::Opacity
            }
            _ => Shown::Other,
        })
    };
    words.iter().zip(told_together(&words)).map(shown).collect()
}

/// An image with the words of its name.
struct Named<'a> {
    file: &'a Path,
    words: Vec<Word>,
}

impl<'a> Named<'a> {
    fn new(file: &'a PathBuf) -> Self {
        Self {
            file,
            words: words_of(file),
        }
    }

    fn is_preview(&self) -> bool {
        let told = told(&self.words, 0..self.words.len());
        told.is_some_and(|told| told.role.name() == PREVIEW)
    }
}

/// Whether a name begins as `T_Rock_N`.
fn begins_with_t(words: &[Word]) -> bool {
    matches!(words, [first, second, ..] if first.text == "t" && !second.glued)
}

/// The recipe of what the files show.
fn recipe(folder: &Path, name: &str, ranking: &mut Ranking) -> Result<Recipe> {
    // Take the best map of each role.
    let (height, normal) = relief(ranking)?;
    let albedo = ranking.take("albedo", |told| told.role == Role::Albedo)?;
    let roughness = ranking.take("roughness", |told| told.role == Role::Roughness)?;
    let gloss = match &roughness {
        None => ranking.take("roughness = 1 − gloss", |told| told.role == Role::Gloss)?,
        Some(_) => {
            ranking.pass_over("the roughness map takes precedence", |told| {
                told.role == Role::Gloss
            });
            None
        }
    };
    let metallic = ranking.take("metallic", |told| told.role == Role::Metallic)?;
    let packed = packed(
        ranking,
        roughness.is_some() || gloss.is_some(),
        metallic.is_some(),
    )?;
    // Refuse a folder without relief.
    if height.is_none() && normal.is_none() {
        return Err(Error::data("folder", no_relief(ranking))
            .expected("a height, displacement or normal map")
            .advice(
                "name the maps in a material.toml (docs/bake.md), or as ambientCG, Poly Haven, Poliigon \
                 and other libraries do (docs/formats-in.md)",
            ));
    }
    Ok(Recipe {
        name: name.to_owned(),
        relief: ReliefRecipe {
            height,
            normal_y: normal.as_ref().map_or(NormalY::Auto, |&(_, y)| y),
            normal: normal.map(|(file, _)| file),
            ..ReliefRecipe::default()
        },
        surface: SurfaceRecipe {
            albedo: albedo.map_or(SurfaceRecipe::default().albedo, Color::Map),
            roughness: roughness.map(Scalar::Map),
            gloss: gloss.map(Scalar::Map),
            metallic: metallic.map(Scalar::Map),
            packed: packed.as_ref().map(|packed| packed.file.clone()),
            packed_order: packed.map(|packed| packed.order).unwrap_or_default(),
            ..SurfaceRecipe::default()
        },
        folder: folder.to_path_buf(),
        ..Recipe::default()
    })
}

/// The maps there are, where none of them shows a relief.
fn no_relief(ranking: &Ranking) -> String {
    let known = ranking.known();
    match known.is_empty() {
        true => "no map in it whose name states what it shows".into(),
        false => format!("no relief among its maps: {}", known.join(", ")),
    }
}

/// A height map, or the normal map that stands in for it, with the way its green points.
type ReliefMaps = (Option<PathBuf>, Option<(PathBuf, NormalY)>);

/// Height maps go first. A bump map has a relief of unknown depth: normals go before it.
fn relief(ranking: &mut Ranking) -> Result<ReliefMaps> {
    let is_normal = |told: &Told| matches!(told.role, Role::Normal(_));
    let height = |told: &Told| told.role == Role::Height && told.rank != BUMP;
    if let Some(file) = ranking.take("height", height)? {
        ranking.pass_over("the height map gives the relief", is_normal);
        ranking.pass_over("the height map gives the relief", |told| {
            told.role == Role::Height
        });
        return Ok((Some(file), None));
    }
    // Both conventions show the same relief: the one whose green points along +y goes first.
    for y in [NormalY::Up, NormalY::Down, NormalY::Auto] {
        let what = "normal, integrated to a relief";
        if let Some(file) = ranking.take(what, |told| told.role == Role::Normal(y))? {
            ranking.pass_over("another normal map gives the relief", is_normal);
            let why = "the normal map gives the relief, with its true slopes";
            ranking.pass_over(why, |told| told.role == Role::Height);
            return Ok((None, Some((file, y))));
        }
    }
    let what = "height (a bump map: its depth is not known)";
    Ok((ranking.take(what, |told| told.role == Role::Height)?, None))
}

/// The packed map, where it holds what no map of its own does.
fn packed(ranking: &mut Ranking, has_rough: bool, has_metal: bool) -> Result<Option<PackedMap>> {
    let is_packed = |told: &Told| matches!(told.role, Role::Packed(_));
    let adds = |told: &Told| match told.role {
        Role::Packed(order) => {
            let rough = order.place_of(PackedChannel::Roughness).is_some();
            let metal = order.place_of(PackedChannel::Metallic).is_some();
            (rough && !has_rough) || (metal && !has_metal)
        }
        _ => false,
    };
    let Some((file, told)) = ranking.take_told("packed", adds)? else {
        ranking.pass_over("roughness and metalness have maps of their own", is_packed);
        return Ok(None);
    };
    let Role::Packed(order) = told.role else {
        return Ok(None);
    };
    let ignored = |is: bool, what: &str| {
        if is {
            format!("; {what} has a map of its own")
        } else {
            String::new()
        }
    };
    let what = format!(
        "packed: {}; occlusion is not used{}{}",
        order.describe(),
        ignored(has_rough, "roughness"),
        ignored(has_metal, "metalness"),
    );
    ranking.describe(&file, what);
    Ok(Some(PackedMap { file, order }))
}

#[cfg(test)]
mod tests;
