//! `mesotex export`: a sample, or a surface texton map → a format that other programs read.

mod bonn;
mod fit;
mod image_set;
mod model;

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::btf::bonn::BonnExportOptions;
use crate::btf::bonn::signature::Format as BonnFormat;
use crate::btf::image_sets::ImageSet;
use crate::btf::sample::{Sample, files_of};
use crate::cli::export::fit::FitOptions;
use crate::cli::export::model::ColorOptions;
use crate::cli::info::kind::Kind as Input;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::Result;
use crate::format::ours::Format;
use crate::textures::vertex_model::ModelFormat;

/// Write a sample or a surface texton map in a format that other programs read.
///
/// OUT is the exact name of the file or folder that is written; an existing folder must be empty. Values of samples
/// become reflectance times the light's cosine: a white plane facing the light has 1. Maps become meshes with texture
/// coordinates, labels and orientation per vertex, and with colours if a sample is given.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  mesotex export weave.sample --to folder -o weave-images
  mesotex export impalla.sample --to ubo2003 -o impalla-images
  mesotex export coin.sample --to ptm -o coin.ptm
  mesotex export weave.sample --to bdi -o weave.btf
  mesotex export weave.sample --to dfmf --rank 32 -o weave.btf
  mesotex export bunny.map.ply --to glb -o bunny.glb
  mesotex export bunny.map.ply --to obj -o bunny-lit.obj --sample weave.sample --light 45,120")]
pub struct Arguments {
    /// The sample, or for glb, obj, usda and ply the surface texton map.
    pub input: PathBuf,
    /// The format to write.
    #[arg(long, value_enum)]
    pub to: ExportFormat,
    /// The file or the folder to write.
    #[arg(short, long)]
    pub output: PathBuf,
    #[command(flatten)]
    pub bonn: BonnExportOptions,
    #[command(flatten)]
    pub fit: FitOptions,
    #[command(flatten)]
    pub colors: ColorOptions,
    #[command(flatten)]
    pub common: Common,
}

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExportFormat {
    /// A folder as UBO2003: 8-bit JPEG in sRGB, directions at whole degrees.
    Ubo2003,
    /// A folder as UTIA: 8-bit PNG in sRGB, directions at whole degrees.
    Utia,
    /// A folder as UTIA: OpenEXR in XYZ (D65), half floats, directions at whole degrees.
    UtiaExr,
    /// A folder of OpenEXR images with a table of angles, any directions; nothing is lost.
    Folder,
    /// Bonn's .btf: factors of each colour channel (decorrelated full matrix factorization).
    Dfmf,
    /// Bonn's .btf: one pair of factors (full matrix factorization).
    Fmf,
    /// Bonn's .btf: principal components of each view (per-view factorization).
    Pvf,
    /// Bonn's .btf: every number, as halves.
    Bdi,
    /// A polynomial texture map: a sample of one view, fitted over its lights.
    Ptm,
    /// A map as glTF 2.0 in one file: TEXCOORD_0, TANGENT, _TEXTON, COLOR_0 (linear).
    Glb,
    /// A map as Wavefront OBJ: vt, vn, and colours behind positions (sRGB, 0 to 1).
    Obj,
    /// A map as USD text: primvars st, texton, orientation, displayColor (linear).
    Usda,
    /// A map as PLY: s t over the sample's size, texton, sx sy sz, red green blue (sRGB bytes).
    Ply,
}

/// The families of formats.
enum Kind {
    ImageSet(ImageSet),
    Bonn(BonnFormat),
    Ptm,
    Model(ModelFormat),
}

impl ExportFormat {
    /// Whether it is a mesh.
    pub fn is_mesh(self) -> bool {
        matches!(self.kind(), Kind::Model(_))
    }

    fn kind(self) -> Kind {
        match self {
            Self::Ubo2003 => Kind::ImageSet(ImageSet::Ubo2003),
            Self::Utia => Kind::ImageSet(ImageSet::Utia),
            Self::UtiaExr => Kind::ImageSet(ImageSet::UtiaExr),
            Self::Folder => Kind::ImageSet(ImageSet::Folder),
            Self::Dfmf => Kind::Bonn(BonnFormat::Dfmf),
            Self::Fmf => Kind::Bonn(BonnFormat::Fmf),
            Self::Pvf => Kind::Bonn(BonnFormat::Pvf),
            Self::Bdi => Kind::Bonn(BonnFormat::Bdi),
            Self::Ptm => Kind::Ptm,
            Self::Glb => Kind::Model(ModelFormat::Glb),
            Self::Obj => Kind::Model(ModelFormat::Obj),
            Self::Usda => Kind::Model(ModelFormat::Usda),
            Self::Ply => Kind::Model(ModelFormat::Ply),
        }
    }
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn check(&self) -> Result<()> {
        match self.to.kind() {
            Kind::Bonn(format) => self.bonn.validate(Some(format))?,
            Kind::ImageSet(_) | Kind::Ptm | Kind::Model(_) => self.bonn.validate(None)?,
        }
        self.fit.validate(matches!(self.to, ExportFormat::Ptm))
    }

    fn files(&self) -> Result<Files> {
        let product = match self.to.kind() {
            Kind::Bonn(_) => Product::File(Format::Btf),
            Kind::Ptm => Product::File(Format::Ptm),
            Kind::ImageSet(_) => Product::NewFolder,
            Kind::Model(ModelFormat::Glb) => Product::File(Format::Model),
            Kind::Model(ModelFormat::Usda) => Product::File(Format::Usda),
            Kind::Model(ModelFormat::Obj) => Product::File(Format::Obj),
            Kind::Model(ModelFormat::Ply) => Product::File(Format::Ply),
        };
        let files = match self.to.kind() {
            Kind::Model(_) => Files::default().read_as(&[Input::Map], &self.input),
            _ => Files::default().read_as(&[Input::Sample], &self.input),
        };
        let sample = self.colors.sample.iter();
        Ok(files
            .read(&files_of(&self.input))
            .read(
                sample
                    .flat_map(|sample| files_of(sample))
                    .collect::<Vec<_>>()
                    .iter(),
            )
            .write("output", [&self.output], product))
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        let (input, output) = (&self.input, &self.output);
        let outcome = match self.to.kind() {
            Kind::ImageSet(set) => image_set::run(input, set, output, session)?,
            Kind::Bonn(format) => bonn::run(input, format, &self.bonn, output, session)?,
            Kind::Ptm => fit::run(input, &self.fit, output, session)?,
            Kind::Model(format) => return model::run(input, format, &self.colors, output),
        };
        Ok(match self.heights_left_out()? {
            Some(reason) => outcome.line(format!("the sample's heights are left out: {reason}")),
            None => outcome,
        })
    }
}

impl Arguments {
    /// Why a sample's heights are not in the file; `None` where they are, or where it has none.
    fn heights_left_out(&self) -> Result<Option<&'static str>> {
        let sample = Sample::open(&self.input)?;
        if sample.heights()?.is_none() {
            return Ok(None);
        }
        let is_sized = sample.description().texel_mm.is_some();
        Ok(match (self.to, is_sized) {
            (ExportFormat::Fmf, true) => None,
            (ExportFormat::Fmf, false) => Some(
                "the file holds millimetres, and the sample does not state the size of a texel",
            ),
            _ => Some("the format has no place for them (fmf has)"),
        })
    }
}
