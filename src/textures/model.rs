//! The surface with its textures as one GLB: base colour with alpha, normal map, displaced geometry.

use std::path::Path;

use clap::ValueEnum;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::exemplar::channels::ChannelKind;
use crate::format::gltf::{self, AlphaMode, GltfMaterial, GltfMesh};
use crate::format::image::{PngImage, PngNumbers};
use crate::mesh::tangents::corner_tangents;
use crate::mesh::tessellation::TexturedMesh;
use crate::progress::Progress;
use crate::textures::image_file::bits8;
use crate::textures::relief::{Cut, cut, displace, own_normals};
use crate::textures::texture::Texture;

/// What becomes of texels that are not opaque.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Transparency {
    /// Texels of less than one half are holes
    #[default]
    Mask,
    /// They are mixed with what lies behind; programs may draw surfaces behind each other in the wrong order
    Blend,
}

/// How the model is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, clap::Args)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct ModelOptions {
    /// Move the surface of the model along its normals by X mesh units per unit of the height channel;
    /// triangles are cut to about a texel
    #[arg(
        long,
        value_name = "X",
        allow_negative_numbers = true,
        help_heading = "Model"
    )]
    pub displace: Option<f64>,
    /// What becomes of texels that are not opaque
    #[arg(long, value_enum, default_value_t, help_heading = "Model")]
    pub transparency: Transparency,
}

/// The largest displacement, in mesh units per unit of height.
const MOST_DISPLACED: f64 = 1e9;
/// The roughness of surfaces of which nothing is known: between satin and chalk.
const ROUGHNESS: f32 = 0.8;

impl ModelOptions {
    /// Refuses values that no model can have.
    pub fn validate(&self) -> Result<()> {
        match self.displace {
            Some(amount) if amount.is_nan() || amount.abs() > MOST_DISPLACED => Err(Error::option(
                "displace",
                amount.to_string(),
                "a number from -1e9 to 1e9",
            )),
            _ => Ok(()),
        }
    }

    /// Refuses displacement without heights.
    pub fn check_kinds(&self, mut kinds: impl Iterator<Item = ChannelKind>) -> Result<()> {
        match self.displace {
            Some(amount) if !kinds.any(|kind| kind == ChannelKind::Height) => Err(Error::option(
                "displace",
                format!("{amount}, but no channel is a height"),
                "a channel of kind height",
            )),
            _ => Ok(()),
        }
    }
}

/// A surface to be modelled.
pub struct Subject<'a> {
    /// It.
    pub surface: &'a TexturedMesh,
    /// Where its positions count from.
    pub origin: DVec3,
    /// The side of a texel of its atlas, in mesh units.
    pub texel: f64,
    /// Whether its colour holds light and shade already.
    pub is_lit: bool,
}

/// What a model came to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ModelFacts {
    /// Its triangles.
    pub triangles: usize,
    /// The longest edge that its triangles were cut to before they were moved, in mesh units.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edge: Option<f64>,
}

/// Writes the model. The first texture of each kind counts.
pub fn write(
    path: &Path,
    subject: &Subject<'_>,
    textures: &[Texture],
    options: &ModelOptions,
    progress: Progress<'_>,
) -> Result<ModelFacts> {
    options.validate()?;
    options.check_kinds(textures.iter().map(|texture| texture.kind))?;
    let first = |kind| textures.iter().find(|texture| texture.kind == kind);
    let alpha = first(ChannelKind::Alpha);
    let normals = first(ChannelKind::Normal);
    let relief = match (options.displace, first(ChannelKind::Height)) {
        (Some(amount), Some(heights)) => Some(relief(subject, heights, amount, normals, progress)?),
        _ => None,
    };
    let surface = relief
        .as_ref()
        .map_or(subject.surface, |relief| &relief.surface);
    let base_color = base_color(first(ChannelKind::Color), alpha)?;
    let normal_map = normals
        .map(|texture| png8(texture, &bits8(texture), false))
        .transpose()?;
    let material = GltfMaterial {
        base_color: base_color.as_deref(),
        normal_map: normal_map.as_deref(),
        alpha: match (alpha, options.transparency) {
            (None, _) => AlphaMode::Opaque,
            (_, Transparency::Mask) => AlphaMode::Mask,
            (_, Transparency::Blend) => AlphaMode::Blend,
        },
        roughness: ROUGHNESS,
        is_unlit: subject.is_lit,
    };
    progress.check()?;
    write_mesh(path, surface, subject.origin, material)?;
    Ok(ModelFacts {
        triangles: surface.mesh.triangles.len(),
        edge: relief.map(|relief| relief.edge),
    })
}

/// The surface in relief. Where there is a normal map it tells the shading, on the smooth surface's normals;
/// else the moved surface has its own.
fn relief(
    subject: &Subject<'_>,
    heights: &Texture,
    amount: f64,
    normals: Option<&Texture>,
    progress: Progress<'_>,
) -> Result<Cut> {
    let mut relief = cut(subject.surface.clone(), subject.texel, progress)?;
    displace(&mut relief.surface, heights, amount);
    if normals.is_none() {
        own_normals(&mut relief.surface);
    }
    Ok(relief)
}

/// Colour and alpha in one PNG; white where there is alpha alone.
fn base_color(color: Option<&Texture>, alpha: Option<&Texture>) -> Result<Option<Vec<u8>>> {
    let Some(any) = color.or(alpha) else {
        return Ok(None);
    };
    let texels = any.width as usize * any.height as usize;
    let colors = match color {
        Some(color) => {
            let numbers = bits8(color);
            let texels = numbers.chunks_exact(color.count);
            texels
                .map(|texel| [0, 1, 2].map(|at| texel[at % color.count]))
                .collect()
        }
        None => vec![[255; 3]; texels],
    };
    let Some(alpha) = alpha else {
        return png8(any, bytemuck::cast_slice(&colors), true).map(Some);
    };
    let alphas = bits8(alpha);
    let with_alpha: Vec<u8> = colors
        .iter()
        .zip(alphas)
        .flat_map(|([r, g, b], a)| [*r, *g, *b, a])
        .collect();
    png8(any, &with_alpha, true).map(Some)
}

fn png8(texture: &Texture, numbers: &[u8], is_srgb: bool) -> Result<Vec<u8>> {
    let image = PngImage {
        width: texture.width,
        height: texture.height,
        numbers: PngNumbers::Bits8(numbers),
        is_srgb,
    };
    image.encode()
}

fn write_mesh(
    path: &Path,
    surface: &TexturedMesh,
    origin: DVec3,
    material: GltfMaterial<'_>,
) -> Result<()> {
    let TexturedMesh {
        mesh,
        normals,
        corner_uvs,
    } = surface;
    let tangents = material
        .normal_map
        .map(|_| corner_tangents(mesh, normals, corner_uvs));
    gltf::write(
        path,
        &GltfMesh {
            origin: origin.to_array(),
            positions: bytemuck::cast_slice(&mesh.positions),
            normals: bytemuck::cast_slice(normals),
            triangles: &mesh.triangles,
            uvs: Some(bytemuck::cast_slice(corner_uvs)),
            tangents: tangents.as_deref().map(|tangents| {
                let tangents: &[[[f32; 4]; 3]] = bytemuck::cast_slice(tangents);
                tangents
            }),
            material: Some(material),
        },
    )
}
