//! The TOML description of a material: which maps, how deep, how large.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::{DeserializeOwned, IgnoredAny};
use toml::Spanned;

use crate::btf::bake::maps::normal_map::NormalKind;
use crate::btf::bake::maps::normals::NormalY;
use crate::btf::bake::maps::packed::{PackedChannel, PackedOrder};
use crate::error::{Error, Result};
use crate::format::guard::guarded;
use crate::format::text;

/// The largest recipe read, in bytes.
const LARGEST_FILE: u64 = 1 << 20;

/// A colour: constant, or a map.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Color {
    /// Linear Rec. 709, 0 to 1.
    Constant([f32; 3]),
    /// An image file, relative to the recipe.
    Map(PathBuf),
}

/// A number from 0 to 1: constant, or a map.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Scalar {
    /// The same everywhere.
    Constant(f32),
    /// An image file, relative to the recipe; colour maps are averaged over their channels.
    Map(PathBuf),
}

/// A packed image with the order of its channels.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PackedMap {
    pub(super) file: PathBuf,
    pub(super) order: PackedOrder,
}

/// How the numbers of a colour map stand for light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ColorEncoding {
    /// By the sRGB curve.
    Srgb,
    /// In proportion.
    Linear,
}

/// Where the relief comes from, and how deep it is.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
pub struct ReliefRecipe {
    /// Height map: white is high. This or `normal`; a plane with neither.
    pub height: Option<PathBuf>,
    /// Height of map value 1 over map value 0 (needs `width-mm` or `texel-mm`).
    pub height_mm: Option<f64>,
    /// The same as a share of the map's width, instead of `height-mm`.
    pub depth: Option<f64>,
    /// Width of the whole map.
    pub width_mm: Option<f64>,
    /// Side of one texel of the height (or normal) map, instead of `width-mm`.
    pub texel_mm: Option<f64>,
    /// Tangent-space normal map, integrated to heights where there is no height map.
    pub normal: Option<PathBuf>,
    /// Where green points in the normal map.
    pub normal_y: NormalY,
    /// How the normal map stores its vectors.
    pub normal_kind: NormalKind,
}

impl Default for ReliefRecipe {
    fn default() -> Self {
        Self {
            height: None,
            height_mm: None,
            depth: None,
            width_mm: None,
            texel_mm: None,
            normal: None,
            normal_y: NormalY::Auto,
            normal_kind: NormalKind::Auto,
        }
    }
}

/// How the surface reflects.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
pub struct SurfaceRecipe {
    /// Base colour.
    pub albedo: Color,
    /// Whether the albedo map is sRGB; default: integers are, floats are not.
    pub albedo_encoding: Option<ColorEncoding>,
    /// Roughness of the coat, α its square; none: a matte surface without coat.
    pub roughness: Option<Scalar>,
    /// The same as gloss, 1 − roughness; instead of `roughness`.
    pub gloss: Option<Scalar>,
    /// 0 dielectric, 1 metal; none: 0.
    pub metallic: Option<Scalar>,
    /// An image with a map per channel; `roughness`, `gloss` and `metallic` go before its channels.
    pub packed: Option<PathBuf>,
    /// What red, green and blue of the packed image hold.
    pub packed_order: PackedOrder,
    /// Reflectance of the coat at normal incidence where it is no metal.
    pub reflectance: f32,
    /// Slope angle σ of Oren and Nayar's diffuse facets, in degrees; none: Lambert.
    pub oren_nayar_deg: Option<f32>,
}

impl Default for SurfaceRecipe {
    fn default() -> Self {
        Self {
            albedo: Color::Constant([0.5; 3]),
            albedo_encoding: None,
            roughness: None,
            gloss: None,
            metallic: None,
            packed: None,
            packed_order: PackedOrder::default(),
            reflectance: 0.04,
            oren_nayar_deg: None,
        }
    }
}

/// A material file. Lengths in millimetres; maps by path, relative to the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// What the material is called; default: the file's name.
    pub name: String,
    /// The relief.
    pub relief: ReliefRecipe,
    /// The reflectance.
    pub surface: SurfaceRecipe,
    /// Whether opposite borders continue each other.
    pub tileable: bool,
    /// Where the maps are.
    pub folder: PathBuf,
}

impl Default for Recipe {
    fn default() -> Self {
        Self {
            name: String::new(),
            relief: ReliefRecipe::default(),
            surface: SurfaceRecipe::default(),
            tileable: true,
            folder: PathBuf::new(),
        }
    }
}

/// The keys of a material file.
const KEYS: [&str; 19] = [
    "name",
    "height",
    "height-mm",
    "depth",
    "width-mm",
    "texel-mm",
    "normal",
    "normal-y",
    "normal-kind",
    "albedo",
    "albedo-encoding",
    "roughness",
    "gloss",
    "metallic",
    "packed",
    "packed-order",
    "reflectance",
    "oren-nayar-deg",
    "tileable",
];

/// The keys that belong to no group.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Head {
    name: Option<String>,
    tileable: Option<bool>,
}

impl Recipe {
    /// The files it names, for a command that must not write over them.
    pub fn files(&self) -> Vec<PathBuf> {
        let maps = self.maps().into_iter();
        maps.map(|(_, file, _)| self.folder.join(file)).collect()
    }

    /// The maps it names: role, file, and what the file is used as.
    pub(super) fn maps(&self) -> Vec<(&'static str, PathBuf, String)> {
        let scalar = |scalar: &Option<Scalar>| match scalar {
            Some(Scalar::Map(file)) => Some(file.clone()),
            _ => None,
        };
        let albedo = match &self.surface.albedo {
            Color::Map(file) => Some(file.clone()),
            Color::Constant(_) => None,
        };
        let packed = format!("packed: {}", self.surface.packed_order.describe());
        [
            ("height", self.relief.height.clone(), "height"),
            (
                "normal",
                self.relief.normal.clone(),
                "normal, integrated to a relief",
            ),
            ("albedo", albedo, "albedo"),
            ("roughness", scalar(&self.surface.roughness), "roughness"),
            (
                "gloss",
                scalar(&self.surface.gloss),
                "roughness = 1 − gloss",
            ),
            ("metallic", scalar(&self.surface.metallic), "metallic"),
            ("packed", self.surface.packed.clone(), &packed),
        ]
        .into_iter()
        .filter_map(|(role, file, used_as)| Some((role, file?, used_as.to_owned())))
        .collect()
    }

    /// Whether roughness is a channel of the packed image.
    pub(super) fn rough_is_packed(&self) -> bool {
        let channels = [PackedChannel::Roughness, PackedChannel::Gloss];
        let own = self.surface.roughness.is_some() || self.surface.gloss.is_some();
        !own && channels.iter().any(|&channel| self.packs(channel))
    }

    /// Whether metalness is a channel of the packed image.
    pub(super) fn metal_is_packed(&self) -> bool {
        self.surface.metallic.is_none() && self.packs(PackedChannel::Metallic)
    }

    fn packs(&self, channel: PackedChannel) -> bool {
        self.surface.packed.is_some() && self.surface.packed_order.place_of(channel).is_some()
    }

    /// Width of the material in millimetres, its relief map being `columns` wide; `None` if unsaid.
    pub(super) fn width_of(&self, columns: u32) -> Result<Option<f64>> {
        match (self.relief.width_mm, self.relief.texel_mm) {
            (Some(_), Some(_)) => {
                Err(Error::data("width-mm", "given with texel-mm").expected("one of the two"))
            }
            (Some(width), None) => Ok(Some(width)),
            (None, texel) => Ok(texel.map(|mm| mm * f64::from(columns))),
        }
    }

    fn check(&self) -> Result<()> {
        // Check the lengths.
        for (name, value) in [
            ("height-mm", self.relief.height_mm),
            ("depth", self.relief.depth),
            ("width-mm", self.relief.width_mm),
            ("texel-mm", self.relief.texel_mm),
        ] {
            if let Some(value) = value.filter(|v| !(*v > 0.0 && v.is_finite())) {
                return Err(Error::data(name, value.to_string()).expected("a number > 0"));
            }
        }
        // Check that no two say the same.
        if self.relief.depth.is_some() && self.relief.height_mm.is_some() {
            return Err(Error::data("depth", "given with height-mm").expected("one of the two"));
        }
        if self.relief.height.is_some() && self.relief.normal.is_some() {
            return Err(Error::data("normal", "given with height")
                .expected("one of the two: normals follow from heights"));
        }
        self.check_packed()?;
        // Check the numbers of the surface.
        let unit = |v: f32| (0.0..=1.0).contains(&v);
        let scalar = |s: &Option<Scalar>| !matches!(s, Some(Scalar::Constant(v)) if !unit(*v));
        let color =
            !matches!(self.surface.albedo, Color::Constant(rgb) if !rgb.into_iter().all(unit));
        for (name, sound) in [
            ("albedo", color),
            ("roughness", scalar(&self.surface.roughness)),
            ("gloss", scalar(&self.surface.gloss)),
            ("metallic", scalar(&self.surface.metallic)),
            ("reflectance", unit(self.surface.reflectance)),
        ] {
            if !sound {
                return Err(Error::data(name, "a number outside 0 to 1").expected("0 to 1"));
            }
        }
        if self
            .surface
            .oren_nayar_deg
            .is_some_and(|v| !(0.0..=90.0).contains(&v))
        {
            return Err(Error::data("oren-nayar-deg", "no angle of slopes").expected("0 to 90"));
        }
        Ok(())
    }

    /// Refuses two ways to say one roughness, and a packed image of which nothing is used.
    fn check_packed(&self) -> Result<()> {
        if self.surface.roughness.is_some() && self.surface.gloss.is_some() {
            return Err(Error::data("gloss", "given with roughness")
                .expected("one of the two: gloss is 1 − roughness"));
        }
        if self.surface.packed.is_some() && !self.rough_is_packed() && !self.metal_is_packed() {
            return Err(Error::data("packed", "none of its channels is used")
                .expected("no roughness, gloss or metallic beside it, or no packed image"));
        }
        if self.surface.packed.is_none() && self.surface.packed_order != PackedOrder::default() {
            return Err(Error::data("packed-order", "given without packed")
                .expected("the packed image as well"));
        }
        if self.relief.normal.is_none() && self.relief.normal_kind != NormalKind::Auto {
            return Err(Error::data("normal-kind", "given without a normal map")
                .expected("`normal` as well"));
        }
        Ok(())
    }
}

/// Reads and checks a recipe.
pub(super) fn read(path: &Path) -> Result<Recipe> {
    let mut recipe = guarded(path, || parse(&text::read(path, LARGEST_FILE)?.text))?;
    if recipe.name.is_empty() {
        recipe.name = default_name(path);
    }
    recipe.folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
    Ok(recipe)
}

/// The file's own name, or its folder's where the file is called `material`.
fn default_name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    let folder = path.parent().and_then(Path::file_name);
    match folder {
        Some(folder) if stem == "material" => folder.to_string_lossy().into_owned(),
        _ => stem.to_string_lossy().into_owned(),
    }
}

/// Every group reads its own keys of the text; what none of them knows is refused first.
pub(super) fn parse(text: &str) -> Result<Recipe> {
    let keys: BTreeMap<Spanned<String>, IgnoredAny> = read_keys(text)?;
    if let Some(unknown) = keys
        .keys()
        .find(|key| !KEYS.contains(&key.as_ref().as_str()))
    {
        let expected = KEYS.map(|key| format!("`{key}`")).join(", ");
        let found = format!(
            "unknown field `{}`, expected one of {expected}",
            unknown.as_ref()
        );
        return Err(fault(text, Some(unknown.span()), found));
    }
    let Head { name, tileable } = read_keys(text)?;
    let recipe = Recipe {
        name: name.unwrap_or_default(),
        relief: read_keys(text)?,
        surface: read_keys(text)?,
        tileable: tileable.unwrap_or(true),
        folder: PathBuf::new(),
    };
    recipe.check()?;
    Ok(recipe)
}

/// The keys of the text that `T` knows.
fn read_keys<T: DeserializeOwned>(text: &str) -> Result<T> {
    toml::from_str(text).map_err(|error| fault(text, error.span(), error.message().to_owned()))
}

fn fault(text: &str, span: Option<Range<usize>>, found: String) -> Error {
    let before = span.map_or(0, |span| span.start.min(text.len()));
    let line = 1 + text[..before].matches('\n').count();
    Error::data(format!("line {line}"), found).advice("docs/bake.md lists the fields of a material")
}
