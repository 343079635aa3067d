//! How a surface is prepared: the options shared by `mesh` and `synth`, checked.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use crate::error::{Error, Result};
use crate::mesh::field::guides::{Alignment, FieldEnergy, GuideOptions};
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::neighborhood::{Neighborhood, check_level_widths, level_widths};
use crate::progress::Progress;

/// How a surface is prepared.
#[derive(Clone, Debug, PartialEq, Serialize, Args)]
#[serde(rename_all = "kebab-case")]
pub struct SurfaceOptions {
    /// Levels of the mesh pyramid, each with a quarter of the vertices (Tong 2002 §5.1). Set by
    /// synthesis.
    #[arg(skip = SurfaceOptions::default().levels)]
    pub levels: u32,
    /// Width of the neighbourhood in texels, odd. Set by the neighbour table in synthesis.
    #[arg(skip = SurfaceOptions::default().neighborhood)]
    pub neighborhood: u32,
    /// Width of the parent level's neighbourhood in texels, odd. Set by the neighbour table.
    #[arg(skip = SurfaceOptions::default().coarse_neighborhood)]
    pub coarse_neighborhood: u32,
    /// Mesh units that a texel of the finest level covers. [default: √(area / referenced vertices)]
    #[arg(long)]
    pub texel: Option<f64>,
    /// Edges with a larger angle between their triangles, in degrees, are creases, which retiled levels keep.
    #[arg(long, default_value_t = SurfaceOptions::default().crease)]
    pub crease: f64,
    /// Directions that the orientation field takes exactly: a JSON file `{"guides": [{"vertex": 7, "direction":
    /// [x,y,z]}, {"point": [x,y,z], "direction": [x,y,z]}]}`. The mesh's own sx, sy, sz (PLY) are used as well.
    #[arg(long, value_name = "FIELD.json")]
    pub guide: Option<PathBuf>,
    /// Transition and direction of a progressively-variant texture at some vertices: a JSON file `{"keys":
    /// [{"vertex": 7, "transition": 0.5, "direction": [x,y,z]}, {"point": [x,y,z], "transition": 1}]}`. They replace
    /// the mesh's own transition (PLY).
    #[arg(long, value_name = "KEYS.json")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keys: Option<PathBuf>,
    /// What the field follows where no direction is given.
    #[arg(long, value_enum, default_value_t = Alignment::Smooth)]
    pub align: Alignment,
    /// A direction in space that the field follows where it lies along the surface, as x,y,z.
    #[arg(
        long,
        value_delimiter = ',',
        allow_hyphen_values = true,
        value_name = "X,Y,Z"
    )]
    pub direction: Option<Vec<f64>>,
    /// The energy that the orientation field minimises or maximises.
    #[arg(long, value_enum, default_value_t = FieldEnergy::Dirichlet)]
    #[serde(skip_serializing_if = "FieldEnergy::is_default")]
    pub field_energy: FieldEnergy,
    /// Seed of everything drawn at random.
    #[arg(skip)]
    pub seed: u64,
}

impl Default for SurfaceOptions {
    fn default() -> Self {
        Self {
            levels: 4,
            neighborhood: 7,
            coarse_neighborhood: 3,
            texel: None,
            crease: 40.0,
            guide: None,
            keys: None,
            align: Alignment::Smooth,
            direction: None,
            field_energy: FieldEnergy::Dirichlet,
            seed: 0,
        }
    }
}

impl SurfaceOptions {
    /// The same options for the square windows of as many levels, finest first.
    #[must_use]
    pub fn with_neighborhoods(self, neighborhoods: &[Neighborhood]) -> Self {
        let (levels, [neighborhood, coarse_neighborhood]) = level_widths(neighborhoods);
        Self {
            levels,
            neighborhood,
            coarse_neighborhood,
            ..self
        }
    }

    /// What guides the orientation field.
    pub fn guides(&self) -> GuideOptions {
        GuideOptions {
            guide: self.guide.clone(),
            keys: self.keys.clone(),
            align: self.align,
            direction: self.direction.clone(),
            energy: self.field_energy,
        }
    }

    /// Checks every field.
    pub fn validate(&self) -> Result<()> {
        check_level_widths(self.levels, [self.neighborhood, self.coarse_neighborhood])?;
        check_texel(self.texel)?;
        self.guides().validate()?;
        check_crease(self.crease)
    }

    /// Mesh units a texel covers on a mesh: as asked, or √(area / referenced vertices).
    pub fn texel_on(&self, mesh: &TriangleMesh) -> Result<f64> {
        texel_on(mesh, self.texel)
    }
}

/// Checks a texel that is asked for.
pub fn check_texel(texel: Option<f64>) -> Result<()> {
    match texel {
        Some(texel) if !(texel.is_finite() && texel > 0.0) => Err(Error::option(
            "texel",
            texel.to_string(),
            "a length above 0",
        )),
        _ => Ok(()),
    }
}

/// Mesh units per texel on a mesh: as asked, or √(area / referenced vertices).
pub fn texel_on(mesh: &TriangleMesh, asked: Option<f64>) -> Result<f64> {
    let area = mesh.area();
    if !(area > 0.0 && area.is_finite()) {
        return Err(Error::data("mesh", format!("area {area}")).expected("a surface"));
    }
    let Some(texel) = asked else {
        return Ok((area / mesh.referenced_count() as f64).sqrt());
    };
    let largest = f64::from(mesh.diagonal());
    if (LEAST_TEXEL * largest..=largest).contains(&texel) {
        return Ok(texel);
    }
    Err(Error::option(
        "texel",
        texel.to_string(),
        format!(
            "at most {largest}, the diagonal of the mesh's box, and no less than {LEAST_TEXEL:e} of it; with \
             --texel {:.3e} each vertex covers one texel",
            (area / mesh.referenced_count() as f64).sqrt()
        ),
    ))
}

/// The smallest texel, as a share of the mesh's size: positions are no finer by far.
const LEAST_TEXEL: f64 = 1e-12;

/// Checks a crease angle in degrees.
fn check_crease(degrees: f64) -> Result<()> {
    if degrees > 0.0 && degrees <= 180.0 {
        return Ok(());
    }
    Err(Error::option(
        "crease",
        degrees.to_string(),
        "an angle above 0 and up to 180 degrees",
    ))
}

/// Vertices per texel, and texels per vertex, beyond which a texel is hardly meant.
const VERTICES_PER_TEXEL: f64 = 16.0;
const TEXELS_PER_VERTEX: f64 = 64.0;

/// Says so when the texel hardly fits the mesh, before work is wasted.
pub fn warn_of_texel(mesh: &TriangleMesh, texel: f64, progress: Progress<'_>) {
    let share = mesh.area() / mesh.referenced_count() as f64;
    if texel * texel > VERTICES_PER_TEXEL * share {
        progress.warn(format!(
            "a texel of {texel} covers {:.0} vertices: patches are large and slow, and detail below it is lost; \
             ask for a smaller --texel or fewer vertices",
            texel * texel / share
        ));
    }
    if texel * texel * TEXELS_PER_VERTEX < share {
        progress.warn(format!(
            "each vertex covers {:.0} texels of {texel}: the texture is undersampled; retile the mesh \
             with mesotex mesh --vertices {:.0}, or ask for a larger --texel",
            share / (texel * texel),
            (mesh.area() / (texel * texel)).ceil()
        ));
    }
}
