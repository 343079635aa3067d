//! Pictures of a finished map: PNG of the grid itself, or of the mesh seen by the project's renderer.

use std::f64::consts::FRAC_1_SQRT_2;
use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec3;
use rayon::prelude::*;

use crate::btf::sample::{self, Sample};
use crate::cli::outputs::{Files, Product};
use crate::error::{Error, Result};
use crate::exemplar::space::Space;
use crate::false_color::{coordinate_colors, energy_colors, label_colors};
use crate::format::image::{Encoding, FloatImage, Precision, encode_srgb8, write_png};
use crate::format::ours::Format;
use crate::grid::{TexCoord, TexelGrid};
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::colored_vertices::{self, ColoredVertices};
use crate::progress::Progress;
use crate::render::preview;
use crate::sites::level::Sites;
use crate::sites::target::Target;
use crate::synthesis::inputs::Inputs;
use crate::synthesis::quality::energy;

/// Pixels of a picture of a mesh.
const SIZE: [u32; 2] = [1024, 768];

/// Which pictures are wanted.
#[derive(Debug, Args)]
#[command(next_help_heading = "Pictures")]
pub struct PictureArguments {
    /// Write NAME.coordinate.png (copied patches are smooth), NAME.label.png and NAME.energy.png; with --sample also
    /// NAME.color.png
    #[arg(long, value_name = "NAME")]
    pub pictures: Option<PathBuf>,
    /// The sample, for pictures in its colours: seen from above, lit from the upper left
    #[arg(long, value_name = "X.sample")]
    pub sample: Option<PathBuf>,
    /// Write the mesh with a colour (red, green, blue) at each vertex, from --sample; with --onto faces from the
    /// surrounding faces
    #[arg(long, value_name = "FILE.ply")]
    pub vertex_colors: Option<PathBuf>,
}

impl PictureArguments {
    /// Checks that the sample is the space's, before any work is done.
    pub fn check(&self, space: &Space) -> Result<()> {
        if self.sample.is_none() && self.vertex_colors.is_some() {
            let expected = "--sample X.sample as well";
            return Err(Error::option("vertex-colors", "no colours", expected));
        }
        self.check_size(space)
    }

    /// Checks that the sample has the space's size.
    pub fn check_size(&self, space: &Space) -> Result<()> {
        let Some(path) = &self.sample else {
            return Ok(());
        };
        let (sample, grid) = (Sample::open(path)?, space.levels[0].grid);
        if (sample.grid().width, sample.grid().height) == (grid.width, grid.height) {
            return Ok(());
        }
        let size = |grid: TexelGrid| format!("{}×{} texels", grid.width, grid.height);
        Err(Error::data("size", size(sample.grid()))
            .expected(format!("{}, as the space has", size(grid)))
            .in_file(path))
    }

    /// Adds what is read and written for the pictures.
    pub fn files(&self, files: Files) -> Files {
        let mut pictures = Vec::new();
        if let Some(name) = &self.pictures {
            pictures.extend(self.kinds().map(|kind| with_kind(name, kind.name())));
        }
        let sample = self.sample.as_deref().map(sample::files_of);
        files
            .read(sample.iter().flatten())
            .write("pictures", &pictures, Product::File(Format::Picture))
            .write(
                "vertex-colors",
                &self.vertex_colors,
                Product::File(Format::Ply),
            )
    }

    /// The pictures that are drawn; one in the sample's colours where there is one.
    fn kinds(&self) -> impl Iterator<Item = Kind> {
        let color = self.sample.as_ref().map(|_| Kind::Color);
        [Kind::Coordinate, Kind::Label, Kind::Energy]
            .into_iter()
            .chain(color)
    }

    /// The distance of every site's neighbourhood, where a picture shows it; else none.
    pub fn energies<const N: usize, S: Sites<N>>(
        &self,
        inputs: Inputs<'_, S>,
        coords: &[TexCoord],
        progress: Progress<'_>,
    ) -> Result<Vec<f64>> {
        match self.pictures {
            Some(_) => energy::of_every_site(inputs, coords, progress),
            None => Ok(Vec::new()),
        }
    }

    /// Draws what was asked, of [`energies`](Self::energies); returns the files written.
    pub fn draw(
        &self,
        plane: &Plane,
        map: &SurfaceTextonMap,
        energies: &[f64],
    ) -> Result<Vec<PathBuf>> {
        let mut written = Vec::new();
        let colors = self.sample.as_deref().map(|path| sample_colors(path, map));
        let colors = colors.transpose()?;
        if let Some(name) = &self.pictures {
            let kinds: Vec<Kind> = self.kinds().collect();
            let draw = |&kind: &Kind| {
                let path = with_kind(name, kind.name());
                let colors = match kind {
                    Kind::Coordinate => &coordinate_colors(map.grid(false), &map.coords),
                    Kind::Label => &label_colors(&map.textons),
                    Kind::Energy => &energy_colors(energies),
                    Kind::Color => colors.as_deref().unwrap_or_default(),
                };
                plane.draw(map, colors, &path).map(|()| path)
            };
            written = kinds.par_iter().map(draw).collect::<Result<_>>()?;
        }
        if let (Some(path), Some(colors)) = (&self.vertex_colors, &colors) {
            let vertices = ColoredVertices {
                normals: Some(&map.normals),
                srgb: colors,
                linear: None,
            };
            colored_vertices::write(path, (&map.mesh, map.header.origin), vertices)?;
            written.push(path.clone());
        }
        Ok(written)
    }
}

/// The pictures of a map.
#[derive(Clone, Copy)]
enum Kind {
    Coordinate,
    Label,
    Energy,
    Color,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Coordinate => "coordinate",
            Self::Label => "label",
            Self::Energy => "energy",
            Self::Color => "color",
        }
    }
}

/// What a picture shows: the flat grid itself, one pixel per site, or the mesh.
pub enum Plane {
    /// Columns and rows.
    Grid(u32, u32),
    /// The mesh of the map.
    Surface,
}

impl Plane {
    /// What pictures of a target show.
    pub fn of(target: &Target) -> Self {
        match target.surface.grid {
            Some(grid) => Self::Grid(grid.width, grid.height),
            None => Self::Surface,
        }
    }

    fn draw(&self, map: &SurfaceTextonMap, colors: &[[u8; 3]], path: &Path) -> Result<()> {
        match *self {
            Self::Grid(width, height) => write_png(path, width, height, colors.as_flattened()),
            Self::Surface => {
                let pixels = preview::vertex_colors(&map.mesh, colors, SIZE)?;
                write_png(path, SIZE[0], SIZE[1], &pixels)
            }
        }
    }
}

/// `NAME.KIND.png`.
fn with_kind(name: &Path, kind: &str) -> PathBuf {
    let mut path = name.as_os_str().to_owned();
    path.push(format!(".{kind}.png"));
    PathBuf::from(path)
}

/// The sample's colours in linear light, white for a white plane facing the light.
pub(super) fn shown_colors(sample: &Sample) -> Result<FloatImage> {
    let grid = sample.grid();
    let image = shown_image(sample);
    let mut data = vec![0.0; grid.len() * 3];
    sample.image(image)?.copy_to(&mut data);
    let (_, light) = sample.description().view_and_light(image);
    let cosine = sample.description().lights[light].cos_theta().max(0.1);
    let white = cosine as f32 / std::f32::consts::PI;
    data.iter_mut().for_each(|value| *value /= white);
    Ok(FloatImage {
        width: grid.width,
        height: grid.height,
        channels: 3,
        data,
        encoding: Encoding::Linear,
        precision: Precision::Float,
    })
}

/// The sample's colour at every site.
fn sample_colors(path: &Path, map: &SurfaceTextonMap) -> Result<Vec<[u8; 3]>> {
    let sample = Sample::open(path)?;
    let grid = sample.grid();
    let image = shown_colors(&sample)?;
    let (texels, _) = image.data.as_chunks::<3>();
    let colors: Vec<[u8; 3]> = texels.iter().map(|rgb| rgb.map(encode_srgb8)).collect();
    let color = |&at: &TexCoord| colors[grid.texel_nearest(at).index()];
    Ok(map.coords.iter().map(color).collect())
}

/// The image seen most nearly from above, lit most nearly from the upper left at 45°.
fn shown_image(sample: &Sample) -> usize {
    let description = sample.description();
    let lit_from = DVec3::new(-0.5, 0.5, FRAC_1_SQRT_2);
    let score = |image: usize| {
        let (view, light) = description.view_and_light(image);
        4.0 * description.views[view].cos_theta() + description.lights[light].0.dot(lit_from)
    };
    let best =
        (0..sample.image_count()).max_by(|&a, &b| score(a).total_cmp(&score(b)).then(b.cmp(&a)));
    best.unwrap_or(0)
}
