//! Materials from image maps: a TOML recipe or a folder, read, brought to one texel grid, checked.
//!
//! In: a [`Recipe`] and [`MapOptions`]. Out: a [`Material`]. Colour maps are decoded from sRGB unless
//! the recipe or the file (floats) says otherwise; height, roughness, metallic and normal maps are used
//! as they stand. Everything is resampled to the texel grid by area means, heights after their terraces
//! and normals after their integration.

mod folder;
mod normal_map;
pub(in crate::btf) mod normals;
mod packed;
mod reading;
mod recipe;
mod relief;
mod resample;
mod set;

use std::path::Path;

use clap::ValueEnum;
use glam::Vec3;

pub use crate::btf::bake::maps::folder::{Shown, shown_by_names};
pub use crate::btf::bake::maps::normal_map::NormalKind;
pub use crate::btf::bake::maps::normals::NormalY;
pub use crate::btf::bake::maps::packed::{PackedChannel, PackedOrder};
pub use crate::btf::bake::maps::recipe::{Color, Recipe, ReliefRecipe, Scalar, SurfaceRecipe};
pub use crate::btf::bake::maps::set::{DefaultRole, FileUse, MaterialSet};

use crate::btf::bake::brdf::Diffuse;
use crate::btf::bake::maps::reading::MapReader;
use crate::btf::bake::maps::resample::resampled;
use crate::btf::bake::material::Material;
use crate::btf::bake::steepness::Steepness;
use crate::error::{Error, Result};
use crate::format::image::{Alpha, Flags, FloatImage, ReadOptions, SourceEncoding};
use crate::grid::TexelGrid;
use crate::progress::Progress;

/// Relief of a material that does not say how deep it is, as a share of its width.
const DEFAULT_DEPTH: f64 = 0.05;

/// What the borders of the maps mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Tiling {
    /// Opposite borders continue each other.
    Wrap,
    /// Beyond a border the material is mirrored, and the sample is not tileable.
    Mirror,
}

/// What to do about the steps of an 8-bit height map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Terraces {
    /// Keep the steps.
    #[default]
    Keep,
    /// Smooth the map, each value by at most half a step.
    Smooth,
}

/// How maps become a material; what is not given is taken from the recipe.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
#[command(next_help_heading = "Options of maps")]
pub struct MapOptions {
    /// Height of map value 1 over map value 0, in millimetres (with --width-mm).
    #[arg(long, value_name = "MM")]
    pub height_mm: Option<f64>,
    /// Width of the whole map in millimetres.
    #[arg(long, value_name = "MM")]
    pub width_mm: Option<f64>,
    /// Height of map value 1 over map value 0 as a share of the map's width, instead of --height-mm.
    #[arg(long, value_name = "SHARE")]
    pub depth: Option<f64>,
    /// Whether opposite borders continue each other.
    #[arg(long, value_enum)]
    pub tiling: Option<Tiling>,
    /// Where green points in a normal map.
    #[arg(long, value_enum)]
    pub normal_y: Option<NormalY>,
    /// How a normal map stores its vectors.
    #[arg(long, value_enum)]
    pub normal_kind: Option<NormalKind>,
    /// What to do about the steps of an 8-bit height map.
    #[arg(long, value_enum, default_value_t = MapOptions::default().terraces)]
    pub terraces: Terraces,
    /// How the albedo map encodes light, whatever its file states. [default: as the material states, otherwise as the
    /// file states]
    #[arg(long, value_enum)]
    pub albedo_encoding: Option<SourceEncoding>,
    /// What to do with texels of the albedo map that are not opaque.
    #[arg(long, value_enum, default_value_t = MapOptions::default().alpha)]
    pub alpha: Alpha,
    /// The layer, part, view or channel to read from an OpenEXR file that has several; `mesotex info IMAGE` lists them.
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
}

impl MapOptions {
    /// Refuses numbers that are no lengths, and two ways to say one.
    pub fn validate(&self) -> Result<()> {
        for (option, value) in [
            ("height-mm", self.height_mm),
            ("width-mm", self.width_mm),
            ("depth", self.depth),
        ] {
            if let Some(value) = value.filter(|v| !(*v > 0.0 && v.is_finite())) {
                return Err(Error::option(option, value.to_string(), "a number > 0"));
            }
        }
        if self.depth.is_some() && self.height_mm.is_some() {
            return Err(Error::option(
                "depth",
                "given with --height-mm",
                "one of the two",
            ));
        }
        Ok(())
    }

    /// How each map is read.
    fn reading(&self) -> ReadOptions {
        ReadOptions {
            alpha: self.alpha,
            layer: self.layer.clone(),
            flags: Flags {
                layer: "--layer",
                encoding: "--albedo-encoding",
                alpha: "--alpha",
                orientation: "",
            },
            ..ReadOptions::default()
        }
    }

    /// Refuses a depth that the material's maps, or their unknown size, leave no room for.
    fn fit(&self, recipe: &Recipe) -> Result<()> {
        let deep = [("depth", self.depth), ("height-mm", self.height_mm)];
        let given = deep.into_iter().find(|(_, value)| value.is_some());
        let only_normals = recipe.relief.height.is_none() && recipe.relief.normal.is_some();
        match given {
            Some((option, _)) if only_normals => Err(Error::option(
                option,
                "given for a normal map",
                "no depth: normals determine the slopes",
            )),
            Some(("height-mm", _)) if recipe.width_of(1)?.is_none() => Err(Error::option(
                "height-mm",
                "given without the map's size",
                "--width-mm as well",
            )),
            _ => Ok(()),
        }?;
        let of_normals = [
            ("normal-y", self.normal_y.is_some()),
            ("normal-kind", self.normal_kind.is_some()),
        ];
        match of_normals.into_iter().find(|&(_, given)| given) {
            Some((option, _)) if recipe.relief.normal.is_none() => Err(Error::option(
                option,
                "given where no normal map is used",
                "a material whose relief comes from a normal map",
            )),
            _ => Ok(()),
        }
    }

    /// The recipe with what was asked on the command line put over it.
    fn over(&self, recipe: &Recipe) -> Recipe {
        let mut recipe = recipe.clone();
        if self.depth.is_some() {
            (recipe.relief.depth, recipe.relief.height_mm) = (self.depth, None);
        }
        if self.height_mm.is_some() {
            (recipe.relief.height_mm, recipe.relief.depth) = (self.height_mm, None);
        }
        if self.width_mm.is_some() {
            (recipe.relief.width_mm, recipe.relief.texel_mm) = (self.width_mm, None);
        }
        if let Some(tiling) = self.tiling {
            recipe.tileable = tiling == Tiling::Wrap;
        }
        recipe.relief.normal_y = self.normal_y.unwrap_or(recipe.relief.normal_y);
        recipe.relief.normal_kind = self.normal_kind.unwrap_or(recipe.relief.normal_kind);
        recipe
    }
}

/// Reads a recipe: a TOML file, a folder with `material.toml`, or a folder of maps with the names that
/// ambientCG, Poly Haven and others give them.
pub fn read_recipe(path: &Path) -> Result<Recipe> {
    read_set(path)?.recipe
}

/// The same with what each file is used for. A folder whose maps make no material has the reason in its
/// `recipe`.
pub fn read_set(path: &Path) -> Result<MaterialSet> {
    set::read(path)
}

/// The material of a recipe, `size` texels along the longer side. Slopes that no material has are warned
/// of, with the depth that would give plausible ones.
pub fn material(
    recipe: &Recipe,
    options: &MapOptions,
    size: u32,
    progress: Progress<'_>,
) -> Result<Loaded> {
    // Check the options.
    options.validate()?;
    if !(2..=16_384).contains(&size) {
        return Err(Error::option("size", size.to_string(), "2 to 16384 texels"));
    }
    let recipe = options.over(recipe);
    options.fit(&recipe)?;
    // Read the relief.
    let reader = MapReader::new(options.reading(), options.albedo_encoding, progress);
    let relief = relief::read(&recipe, options.terraces, size, &reader)?;
    let (width, height) = resample::fitted(relief.width, relief.height, size);
    let loader = Loader {
        recipe: &recipe,
        reader: &reader,
        source: (relief.width, relief.height),
        target: (width, height),
        progress,
    };
    // Read the other maps at its size.
    let heights = relief.resampled(width, height);
    let Coat {
        roughness,
        metallic,
    } = loader.coat()?;
    let material = Material {
        name: recipe.name.clone(),
        grid: TexelGrid {
            width,
            height,
            tileable: recipe.tileable,
        },
        texel_mm: recipe
            .width_of(relief.width)?
            .map(|mm| mm / f64::from(width)),
        heights,
        albedo: loader.albedo()?,
        roughness,
        metallic,
        reflectance: recipe.surface.reflectance,
        diffuse: match recipe.surface.oren_nayar_deg {
            Some(degrees) => Diffuse::OrenNayar(degrees.to_radians()),
            None => Diffuse::Lambert,
        },
    };
    // Warn of slopes that no material has.
    reader.check_layer()?;
    if let Some(warning) = relief
        .depth
        .and_then(|depth| Steepness::of(&material).objection(depth))
    {
        progress.warn(warning);
    }
    Ok(Loaded {
        material,
        source: [relief.width, relief.height],
        depth: relief.depth,
        notes: relief.notes,
    })
}

/// A material with what was found on the way.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The material, at the size it is baked.
    pub material: Material,
    /// Columns and rows of the map that the relief comes from.
    pub source: [u32; 2],
    /// Height of map value 1 over 0 as a share of the map's width; `None` where no height map gives the
    /// relief.
    pub depth: Option<f64>,
    /// What a report should say of the maps.
    pub notes: Vec<String>,
}

/// What a coat is made of, per texel; `None` as in [`Material`].
struct Coat {
    roughness: Option<Vec<f32>>,
    metallic: Option<Vec<f32>>,
}

/// Reads maps onto the texel grid.
struct Loader<'a> {
    recipe: &'a Recipe,
    reader: &'a MapReader<'a>,
    /// Sides of the height map, which the others should share.
    source: (u32, u32),
    target: (u32, u32),
    progress: Progress<'a>,
}

impl Loader<'_> {
    fn texels(&self) -> usize {
        self.target.0 as usize * self.target.1 as usize
    }

    fn albedo(&self) -> Result<Vec<Vec3>> {
        let file = match &self.recipe.surface.albedo {
            Color::Constant(rgb) => return Ok(vec![Vec3::from_array(*rgb); self.texels()]),
            Color::Map(file) => file,
        };
        let path = self.recipe.folder.join(file);
        let image = self
            .reader
            .color(&path, self.recipe.surface.albedo_encoding)?;
        let image = self.on_grid(image, &path)?;
        let colors = image.data.chunks_exact(3);
        Ok(colors
            .map(|c| Vec3::new(c[0], c[1], c[2]).clamp(Vec3::ZERO, Vec3::ONE))
            .collect())
    }

    fn scalar(&self, name: &str, scalar: Option<&Scalar>) -> Result<Option<Vec<f32>>> {
        Ok(match scalar {
            None => None,
            Some(Scalar::Constant(number)) => Some(vec![*number; self.texels()]),
            Some(Scalar::Map(file)) => {
                let path = self.recipe.folder.join(file);
                let image = self.on_grid(self.reader.data(&path)?.into_gray(), &path)?;
                check_unit(name, &image).map_err(|error| error.in_file(&path))?;
                Some(image.data)
            }
        })
    }

    /// Roughness and metalness: from maps or numbers of their own, else from a packed image.
    fn coat(&self) -> Result<Coat> {
        let recipe = self.recipe;
        let packed = match &recipe.surface.packed {
            Some(file) => Some(self.packed(file)?),
            None => None,
        };
        let channel = |wanted| -> Option<Vec<f32>> {
            let place = recipe.surface.packed_order.place_of(wanted)?;
            let texels = packed.as_ref()?.data.chunks_exact(3);
            Some(texels.map(|texel| texel[place]).collect())
        };
        let rough = |gloss: Vec<f32>| gloss.into_iter().map(|gloss| 1.0 - gloss).collect();
        let own = match self.scalar("gloss", recipe.surface.gloss.as_ref())? {
            Some(gloss) => Some(rough(gloss)),
            None => self.scalar("roughness", recipe.surface.roughness.as_ref())?,
        };
        let roughness = own
            .or_else(|| channel(PackedChannel::Roughness))
            .or_else(|| channel(PackedChannel::Gloss).map(rough));
        let metallic = self.scalar("metallic", recipe.surface.metallic.as_ref())?;
        Ok(Coat {
            roughness,
            metallic: metallic.or_else(|| channel(PackedChannel::Metallic)),
        })
    }

    /// A packed image on the grid, its numbers as they stand.
    fn packed(&self, file: &Path) -> Result<FloatImage> {
        let path = self.recipe.folder.join(file);
        let image = self.reader.data(&path)?;
        if image.channels != 3 {
            return Err(Error::data("channels", image.channels.to_string())
                .expected("3: a packed image holds a map per channel")
                .in_file(&path));
        }
        let image = self.on_grid(image, &path)?;
        check_unit("packed", &image).map_err(|error| error.in_file(&path))?;
        Ok(image)
    }

    /// Checks a map and resamples it; says so when it has other sides than the height map.
    fn on_grid(&self, image: FloatImage, path: &Path) -> Result<FloatImage> {
        image.check_finite().map_err(|error| error.in_file(path))?;
        let (width, height) = self.source;
        if (image.width, image.height) != self.source {
            check_same_shape(&image, self.source).map_err(|error| error.in_file(path))?;
            self.progress.warn(format!(
                "{}: {} × {} texels where the relief has {width} × {height}; resampled",
                path.display(),
                image.width,
                image.height
            ));
        }
        Ok(resampled(&image, self.target.0, self.target.1))
    }
}

fn check_unit(name: &str, image: &FloatImage) -> Result<()> {
    match image.data.iter().find(|v| !(0.0..=1.0).contains(*v)) {
        Some(bad) => Err(Error::data(name, bad.to_string()).expected("0 to 1")),
        None => Ok(()),
    }
}

/// Refuses a map of another aspect ratio: it cannot belong to the relief.
fn check_same_shape(image: &FloatImage, (width, height): (u32, u32)) -> Result<()> {
    let across = u64::from(image.width) * u64::from(height);
    let down = u64::from(image.height) * u64::from(width);
    if across.abs_diff(down) * 100 > across.max(down) {
        return Err(
            Error::data("size", format!("{} × {}", image.width, image.height))
                .expected(format!("the proportions of the relief, {width} × {height}"))
                .advice("crop the map so that all maps show the same piece of material"),
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests;
