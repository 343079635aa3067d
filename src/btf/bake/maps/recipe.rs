//! The TOML description of a material: which maps, how deep, how large.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::btf::bake::maps::normal_map::NormalKind;
use crate::btf::bake::maps::normals::NormalY;
use crate::btf::bake::maps::packed::{PackedChannel, PackedOrder};
use crate::error::{Error, Result};
use crate::format::guard::guarded;
use crate::format::text;

/// The largest recipe read, in bytes.
const LARGEST_FILE: u64 = 1 << 20;

/// A colour: constant, or a map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Color {
    /// Linear Rec. 709, 0 to 1.
    Constant([f32; 3]),
    /// An image file, relative to the recipe.
    Map(PathBuf),
}

/// A number from 0 to 1: constant, or a map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ColorEncoding {
    /// By the sRGB curve.
    Srgb,
    /// In proportion.
    Linear,
}

/// A material file. Lengths in millimetres; maps by path, relative to the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Recipe {
    /// What the material is called; default: the file's name.
    pub name: String,
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
    /// Whether opposite borders continue each other.
    pub tileable: bool,
    /// Where the maps are.
    #[serde(skip)]
    pub folder: PathBuf,
}

impl Default for Recipe {
    fn default() -> Self {
        Self {
            name: String::new(),
            height: None,
            height_mm: None,
            depth: None,
            width_mm: None,
            texel_mm: None,
            normal: None,
            normal_y: NormalY::Auto,
            normal_kind: NormalKind::Auto,
            albedo: Color::Constant([0.5; 3]),
            albedo_encoding: None,
            roughness: None,
            gloss: None,
            metallic: None,
            packed: None,
            packed_order: PackedOrder::default(),
            reflectance: 0.04,
            oren_nayar_deg: None,
            tileable: true,
            folder: PathBuf::new(),
        }
    }
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
        let albedo = match &self.albedo {
            Color::Map(file) => Some(file.clone()),
            Color::Constant(_) => None,
        };
        let packed = format!("packed: {}", self.packed_order.describe());
        [
            ("height", self.height.clone(), "height"),
            (
                "normal",
                self.normal.clone(),
                "normal, integrated to a relief",
            ),
            ("albedo", albedo, "albedo"),
            ("roughness", scalar(&self.roughness), "roughness"),
            ("gloss", scalar(&self.gloss), "roughness = 1 − gloss"),
            ("metallic", scalar(&self.metallic), "metallic"),
            ("packed", self.packed.clone(), &packed),
        ]
        .into_iter()
        .filter_map(|(role, file, used_as)| Some((role, file?, used_as.to_owned())))
        .collect()
    }

    /// Whether roughness is a channel of the packed image.
    pub(super) fn rough_is_packed(&self) -> bool {
        let channels = [PackedChannel::Roughness, PackedChannel::Gloss];
        let own = self.roughness.is_some() || self.gloss.is_some();
        !own && channels.iter().any(|&channel| self.packs(channel))
    }

    /// Whether metalness is a channel of the packed image.
    pub(super) fn metal_is_packed(&self) -> bool {
        self.metallic.is_none() && self.packs(PackedChannel::Metallic)
    }

    fn packs(&self, channel: PackedChannel) -> bool {
        self.packed.is_some() && self.packed_order.place_of(channel).is_some()
    }

    /// Width of the material in millimetres, its relief map being `columns` wide; `None` if unsaid.
    pub(super) fn width_of(&self, columns: u32) -> Result<Option<f64>> {
        match (self.width_mm, self.texel_mm) {
            (Some(_), Some(_)) => {
                Err(Error::data("width-mm", "given with texel-mm").expected("one of both"))
            }
            (Some(width), None) => Ok(Some(width)),
            (None, texel) => Ok(texel.map(|mm| mm * f64::from(columns))),
        }
    }

    fn check(&self) -> Result<()> {
        for (name, value) in [
            ("height-mm", self.height_mm),
            ("depth", self.depth),
            ("width-mm", self.width_mm),
            ("texel-mm", self.texel_mm),
        ] {
            if let Some(value) = value.filter(|v| !(*v > 0.0 && v.is_finite())) {
                return Err(Error::data(name, value.to_string()).expected("a number > 0"));
            }
        }
        if self.depth.is_some() && self.height_mm.is_some() {
            return Err(Error::data("depth", "given with height-mm").expected("one of both"));
        }
        if self.height.is_some() && self.normal.is_some() {
            return Err(Error::data("normal", "given with height")
                .expected("one of both: normals follow from heights"));
        }
        self.check_packed()?;
        let unit = |v: f32| (0.0..=1.0).contains(&v);
        let scalar = |s: &Option<Scalar>| !matches!(s, Some(Scalar::Constant(v)) if !unit(*v));
        let color = !matches!(self.albedo, Color::Constant(rgb) if !rgb.into_iter().all(unit));
        for (name, sound) in [
            ("albedo", color),
            ("roughness", scalar(&self.roughness)),
            ("gloss", scalar(&self.gloss)),
            ("metallic", scalar(&self.metallic)),
            ("reflectance", unit(self.reflectance)),
        ] {
            if !sound {
                return Err(Error::data(name, "a number outside 0 to 1").expected("0 to 1"));
            }
        }
        if self
            .oren_nayar_deg
            .is_some_and(|v| !(0.0..=90.0).contains(&v))
        {
            return Err(Error::data("oren-nayar-deg", "no angle of slopes").expected("0 to 90"));
        }
        Ok(())
    }

    /// Refuses two ways to say one roughness, and a packed image of which nothing is used.
    fn check_packed(&self) -> Result<()> {
        if self.roughness.is_some() && self.gloss.is_some() {
            return Err(Error::data("gloss", "given with roughness")
                .expected("one of both: gloss is 1 − roughness"));
        }
        if self.packed.is_some() && !self.rough_is_packed() && !self.metal_is_packed() {
            return Err(Error::data("packed", "none of its channels is used")
                .expected("no roughness, gloss or metallic beside it, or no packed image"));
        }
        if self.packed.is_none() && self.packed_order != PackedOrder::default() {
            return Err(Error::data("packed-order", "given without packed")
                .expected("the packed image beside it"));
        }
        if self.normal.is_none() && self.normal_kind != NormalKind::Auto {
            return Err(Error::data("normal-kind", "given without a normal map")
                .expected("`normal` beside it"));
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

pub(super) fn parse(text: &str) -> Result<Recipe> {
    let recipe: Recipe = toml::from_str(text).map_err(|error| {
        let line = error.span().map_or(1, |span| {
            1 + text[..span.start.min(text.len())].matches('\n').count()
        });
        Error::data(format!("line {line}"), error.message().to_owned())
            .advice("docs/bake.md lists the fields of a material")
    })?;
    recipe.check()?;
    Ok(recipe)
}
