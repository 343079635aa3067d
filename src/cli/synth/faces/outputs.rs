//! What `synth --onto faces` writes beside the face map.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::outputs::{Files, Product};
use crate::cli::synth::pictures::PictureArguments;
use crate::error::{Error, Result};
use crate::format::image::encode_srgb8;
use crate::format::ours::Format;
use crate::maps::face_map::FaceMap;
use crate::mesh::colored_vertices::{self, ColoredVertices};
use crate::sites::faces::pyramid::FacePyramid;
use crate::synthesis::faces::decorated::{CornerPlaces, with_own_corners};
use crate::synthesis::faces::levels_file::write_levels;
use crate::synthesis::recipes::choosy::ChoosyResult;
use crate::textures::face_channels::vertex_colors;
use crate::textures::face_model;

/// Further products of faces.
#[derive(Debug, Args)]
#[command(next_help_heading = "Faces")]
pub struct FaceOutputs {
    /// Write the surface as a GLB with a colour per face
    #[arg(long, value_name = "FILE.glb")]
    pub glb: Option<PathBuf>,
    /// Write the Gaussian and Laplacian pyramids of sample and surface
    #[arg(long, value_name = "FILE.npz")]
    pub levels_out: Option<PathBuf>,
}

impl FaceOutputs {
    /// Refuses products in colours where there are none.
    pub(super) fn refuse_without_colors(&self, pictures: &PictureArguments) -> Result<()> {
        let given = [
            ("glb", self.glb.is_some()),
            ("vertex-colors", pictures.vertex_colors.is_some()),
        ];
        match given.iter().find(|(_, is_given)| *is_given) {
            None => Ok(()),
            Some((option, _)) => Err(Error::option(
                *option,
                "the space has no colours",
                "--sample X.sample as well",
            )),
        }
    }

    /// Adds what is written.
    pub fn files(&self, files: Files) -> Files {
        files
            .write("glb", &self.glb, Product::File(Format::Model))
            .write(
                "levels-out",
                &self.levels_out,
                Product::File(Format::Archive),
            )
    }

    /// Writes what was asked for, vertex colours among it; returns the files.
    pub(super) fn write(
        &self,
        finished: (&FacePyramid, &ChoosyResult),
        map: &FaceMap,
        colors_at: Option<&Path>,
    ) -> Result<Vec<PathBuf>> {
        let mut written = Vec::new();
        let colors = map.colors.as_deref().unwrap_or_default();
        if let Some(path) = &self.glb {
            let corners = with_own_corners(map, CornerPlaces::Center)?;
            face_model::write(path, &corners, colors)?;
            written.push(path.clone());
        }
        if let Some(path) = colors_at {
            let linear = vertex_colors(map, colors);
            let colors: Vec<[u8; 3]> = linear.iter().map(|rgb| rgb.map(encode_srgb8)).collect();
            let vertices = ColoredVertices {
                srgb: &colors,
                ..ColoredVertices::default()
            };
            colored_vertices::write(path, (&map.mesh, map.header.origin), vertices)?;
            written.push(path.to_path_buf());
        }
        if let Some(path) = &self.levels_out {
            write_levels(path, finished, map)?;
            written.push(path.clone());
        }
        Ok(written)
    }
}
