//! The surface with its textures as one GLB: base colour with alpha, normal map, displaced geometry.

use std::path::Path;

use clap::ValueEnum;
use glam::DVec3;
use serde::Serialize;

use crate::error::{Error, Result};
use crate::exemplar::channels::ChannelKind;
use crate::format::gltf::{self, AlphaMode, GltfMaterial, GltfMesh};
use crate::mesh::tangents::corner_tangents;
use crate::mesh::tessellation::TexturedMesh;
use crate::progress::Progress;
use crate::textures::base_color::{base_color, png8};
use crate::textures::channel::SampleChannel;
use crate::textures::image_file::bits8;
use crate::textures::relief::{Cut, cut, displace, own_normals};
use crate::textures::surface_color::SurfaceColor;
use crate::textures::texture::Texture;

/// What to do with texels that are not opaque.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Transparency {
    /// Texels with an alpha below one half are holes
    #[default]
    Mask,
    /// They are blended with what lies behind; programs may draw overlapping surfaces in the wrong order
    Blend,
}

/// How the model is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
pub struct ModelOptions {
    /// Displace the surface of the model along its normals by X mesh units per unit of the height channel; triangles
    /// are subdivided to about one texel
    #[arg(
        long,
        value_name = "X",
        allow_negative_numbers = true,
        help_heading = "Model"
    )]
    pub displace: Option<f64>,
    /// What to do with texels that are not opaque
    #[arg(long, value_enum, default_value_t, help_heading = "Model")]
    pub transparency: Transparency,
    /// Matte colour of the surface where the texture is transparent, in place of holes: sRGB, numbers from 0 to 255
    #[arg(long, value_name = "R,G,B|#RRGGBB", help_heading = "Model")]
    pub surface_color: Option<SurfaceColor>,
}

/// The largest displacement, in mesh units per unit of height.
const MOST_DISPLACED: f64 = 1e9;
/// The roughness of surfaces of which nothing is known: between satin and chalk.
pub(super) const ROUGHNESS: f32 = 0.8;

/// A surface whose colours are those of its vertices; `is_unlit` where they have their light in them.
pub(super) fn vertex_material(is_unlit: bool) -> GltfMaterial<'static> {
    GltfMaterial {
        base_color: None,
        normal_map: None,
        alpha: AlphaMode::Opaque,
        roughness: ROUGHNESS,
        is_unlit,
    }
}

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
        }?;
        match (self.surface_color, self.transparency) {
            (Some(color), Transparency::Blend) => Err(Error::option(
                "surface-color",
                format!("{color} beside --transparency blend"),
                "one of the two: over a plain colour nothing is transparent",
            )),
            _ => Ok(()),
        }
    }

    /// Refuses displacement without heights, and a plain colour below a texture without alpha.
    pub fn check_kinds(&self, kinds: impl Iterator<Item = ChannelKind>) -> Result<()> {
        let kinds: Vec<ChannelKind> = kinds.collect();
        match self.displace {
            Some(amount) if !kinds.contains(&ChannelKind::Height) => Err(Error::option(
                "displace",
                format!("{amount}, but no channel is a height"),
                "a channel of kind height",
            )),
            _ => Ok(()),
        }?;
        match self.surface_color {
            Some(color) if !kinds.contains(&ChannelKind::Alpha) => {
                Err(color.unseen("no channel is alpha"))
            }
            _ => Ok(()),
        }
    }

    /// Refuses channels of the sample that leave an option without effect.
    pub fn check_channels(&self, channels: &[SampleChannel]) -> Result<()> {
        self.check_kinds(channels.iter().map(|channel| channel.kind))?;
        let alpha = channels
            .iter()
            .find(|channel| channel.kind == ChannelKind::Alpha);
        match (self.surface_color, alpha) {
            (Some(color), Some(alpha)) if alpha.is_one() => {
                Err(color.unseen(&format!("channel `{}` is 1 at every texel", alpha.name)))
            }
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
    // Choose the textures.
    options.check_kinds(textures.iter().map(|texture| texture.kind))?;
    let first = |kind| textures.iter().find(|texture| texture.kind == kind);
    let alpha = first(ChannelKind::Alpha);
    let normals = first(ChannelKind::Normal);
    // Displace the surface.
    let relief = match (options.displace, first(ChannelKind::Height)) {
        (Some(amount), Some(heights)) => Some(relief(subject, heights, amount, normals, progress)?),
        _ => None,
    };
    let surface = relief
        .as_ref()
        .map_or(subject.surface, |relief| &relief.surface);
    // Encode the images.
    let base_color = base_color(first(ChannelKind::Color), alpha, options.surface_color)?;
    let normal_map = normals
        .map(|texture| png8(texture, &bits8(texture), false))
        .transpose()?;
    let material = GltfMaterial {
        base_color: base_color.as_deref(),
        normal_map: normal_map.as_deref(),
        alpha: match (
            alpha.filter(|_| options.surface_color.is_none()),
            options.transparency,
        ) {
            (None, _) => AlphaMode::Opaque,
            (_, Transparency::Mask) => AlphaMode::Mask,
            (_, Transparency::Blend) => AlphaMode::Blend,
        },
        roughness: ROUGHNESS,
        is_unlit: subject.is_lit,
    };
    progress.check()?;
    // Write it.
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
            colors: None,
            attributes: &[],
            uvs: Some(bytemuck::cast_slice(corner_uvs)),
            tangents: tangents.as_deref().map(|tangents| {
                let tangents: &[[[f32; 4]; 3]] = bytemuck::cast_slice(tangents);
                tangents
            }),
            material: Some(material),
        },
    )
}
