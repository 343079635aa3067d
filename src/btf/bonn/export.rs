//! A sample becomes a `.btf` file, which other programs read.
//!
//! The file has the cosine in its values (the cosine flag is set) and reflectance, not radiance: white facing the light
//! is 1, so a sample's values are multiplied by π.
//!
//! | format | from a factored sample | from any other |
//! | --- | --- | --- |
//! | DFMF | its factors, or the first K of them | factored to rank K first |
//! | FMF | its factors as one pair, or the best K of that | factored to rank K per channel first |
//! | PVF | the images of each view, K components | the same |
//! | BDI | every image | the same |

use std::f64::consts::{FRAC_1_PI, PI};
use std::path::Path;
use std::sync::atomic::AtomicU64;

use rayon::prelude::*;
use serde::Serialize;

use crate::btf::bonn::bdi::{BdiContent, Compression};
use crate::btf::bonn::color::{Color, ColorModel};
use crate::btf::bonn::dfmf::DfmfContent;
use crate::btf::bonn::encode::{Written, encode};
use crate::btf::bonn::file::BonnFile;
use crate::btf::bonn::fmf::{ExtraHeader, FmfContent};
use crate::btf::bonn::header::{Header, Meta};
use crate::btf::bonn::images::BonnImages;
use crate::btf::bonn::pvf::PvfContent;
use crate::btf::bonn::sample_factors::{channels, color_step};
use crate::btf::bonn::sampling::Sampling;
use crate::btf::bonn::scalar::Scalar;
use crate::btf::bonn::signature::{Format, SIGNATURES, Signature};
use crate::btf::bonn::{one_pair, view_components};
use crate::btf::description::Description;
use crate::btf::factored::factorize::{Accuracy, FactorOptions, factorize};
use crate::btf::factored::factors::Factors;
use crate::btf::sample::{DType, Pixels, Sample};
use crate::error::{Error, Result};
use crate::format::atomic::folder::FolderInProgress;
use crate::format::atomic::parent;
use crate::format::ours::BTF_MARK;
use crate::progress::Progress;

/// Images that are read together for a run of texels.
const IMAGES: usize = 32;
/// Scan lines of a BDI chunk, as btflib has it.
const LINES: u32 = 4;

/// How a sample becomes a `.btf` file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Options of dfmf, fmf and pvf")]
pub struct BonnExportOptions {
    /// Components: per channel (dfmf), of all channels together (fmf), per view (pvf). Required unless the sample is
    /// factored. [default: those of a factored sample]
    #[arg(long, value_name = "K")]
    pub rank: Option<u32>,
    /// Number type of the file's matrices. Published files have f2. [default: f2]
    #[arg(long, value_enum)]
    pub scalar: Option<Scalar>,
}

impl BonnExportOptions {
    /// Refuses options that a format has no use for; `None` for formats of others.
    pub fn validate(&self, format: Option<Format>) -> Result<()> {
        let given = [
            ("rank", self.rank.is_some()),
            ("scalar", self.scalar.is_some()),
        ];
        let has_factors = format.is_some_and(|format| format != Format::Bdi);
        let given = given.iter().find(|(_, given)| *given && !has_factors);
        if let Some((option, _)) = given {
            let found = "given for a format that holds every image";
            return Err(Error::option(*option, found, "--to dfmf, fmf or pvf"));
        }
        match self.rank {
            Some(0) => Err(Error::option("rank", "0", "at least 1")),
            _ => Ok(()),
        }
    }
}

/// What was written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exported {
    /// Components of the file; `None` where it has every number.
    pub rank: Option<usize>,
    /// ‖sample − file‖ / ‖sample‖ of the file as it is read, where components were left out.
    pub error: Option<f64>,
}

/// Writes the sample in `folder` as a file of a format; `seed` is that of a factorization, where one is made.
pub fn export(
    folder: &Path,
    format: Format,
    options: &BonnExportOptions,
    path: &Path,
    seed: u64,
    progress: Progress<'_>,
) -> Result<Exported> {
    options.validate(Some(format))?;
    let sample = Sample::open(folder)?;
    let header = header_of(sample.description()).map_err(|error| error.in_file(folder))?;
    let scalar = options.scalar.unwrap_or_default();
    let job = Job {
        sample: &sample,
        header: &header,
        rank: options.rank.map(|rank| rank as usize),
        scalar,
        path,
        progress,
    };
    match format {
        Format::Bdi => job.write_bdi(),
        Format::Pvf => job.write_pvf(),
        Format::Dfmf | Format::Fmf => job.write_factors(format, seed),
    }
}

/// One export.
struct Job<'a> {
    sample: &'a Sample,
    header: &'a Header,
    rank: Option<usize>,
    scalar: Scalar,
    path: &'a Path,
    progress: Progress<'a>,
}

impl Job<'_> {
    fn signature(&self, format: Format, has_extra_header: bool) -> Signature {
        let wanted = |signature: &&Signature| {
            signature.format == format
                && signature.has_rotations
                && signature.has_extra_header == has_extra_header
        };
        SIGNATURES
            .iter()
            .find(wanted)
            .copied()
            .unwrap_or(SIGNATURES[0])
    }

    /// The rank that was asked for, or that of a factored sample.
    fn stated_rank(&self) -> Result<usize> {
        let own = self.sample.factors().map(|factors| factors.rank());
        self.rank.or(own).ok_or_else(|| {
            Error::option(
                "rank",
                "not given, and the sample is not factored",
                "how many components the file is to have, as --rank 32",
            )
        })
    }

    /// Writes the sample's factors, or those it is given first.
    fn write_factors(&self, format: Format, seed: u64) -> Result<Exported> {
        if let Some(factors) = self.sample.factors() {
            return self.write_factors_of(factors, format);
        }
        let options = FactorOptions {
            accuracy: Accuracy::Rank(self.stated_rank()? as u32),
            dtype: DType::F4,
            seed,
        };
        // Never put in place: it is removed in the end, or by the next run.
        let name = self.path.file_name().unwrap_or_default();
        let name = format!("{}.factors", name.to_string_lossy());
        let scratch = FolderInProgress::create(&self.path.with_file_name(name), |_| Ok(None))?;
        let folder = scratch.member("factored.sample");
        let origin = self.sample.description().source.clone();
        factorize(self.sample, &options, origin, &folder, self.progress)?;
        let factored = Sample::open(&folder)?;
        match factored.factors() {
            Some(factors) => self.write_factors_of(factors, format),
            None => Err(Error::data("layout", "not factored").expected("factors")),
        }
    }

    fn write_factors_of(&self, factors: &Factors, format: Format) -> Result<Exported> {
        let (rank, whole) = match format {
            Format::Fmf => self.write_fmf(factors)?,
            _ => self.write_dfmf(factors)?,
        };
        let is_whole = rank == whole && self.sample.factors().is_some();
        Ok(Exported {
            rank: Some(rank),
            error: if is_whole { None } else { Some(self.error()?) },
        })
    }

    /// Writes the file; its components, and how many the factors have.
    fn write_dfmf(&self, factors: &Factors) -> Result<(usize, usize)> {
        let own = factors.rank();
        let rank = self.rank.unwrap_or(own);
        if rank > own {
            return Err(Error::option(
                "rank",
                rank.to_string(),
                format!("at most {own}, the rank of the sample"),
            ));
        }
        let (transform, mean) = color_step(factors);
        let (color, scale) = color_of(transform * PI, mean * PI);
        let content = DfmfContent {
            header: self.header,
            color,
            channels: &channels(factors, rank, scale),
            scalar: self.scalar,
            transposed: false,
        };
        let signature = self.signature(Format::Dfmf, false);
        encode(self.path, &signature, Written::Dfmf(content))?;
        Ok((rank, own))
    }

    /// Writes the file; its components, and how many the factors have.
    fn write_fmf(&self, factors: &Factors) -> Result<(usize, usize)> {
        let pair = one_pair::whole(factors, PI)?;
        let whole = pair.rank();
        let pair = match self.rank {
            Some(rank) => pair.best(rank)?,
            None => pair,
        };
        let extra = ExtraHeader {
            height_map: self.height_map()?,
            ..ExtraHeader::default()
        };
        let content = FmfContent {
            header: self.header,
            extra: Some((2, &extra)),
            left: &pair.left,
            right: &pair.right,
            scalar: self.scalar,
        };
        let signature = self.signature(Format::Fmf, true);
        encode(self.path, &signature, Written::Fmf(content))?;
        Ok((pair.rank(), whole))
    }

    /// The sample's heights in millimetres, and the number of columns; none where a texel's size is not known.
    fn height_map(&self) -> Result<Option<(Vec<f32>, u32)>> {
        let description = self.sample.description();
        let (Some(heights), Some(mm)) = (self.sample.heights()?, description.texel_mm) else {
            return Ok(None);
        };
        let in_mm = |&height: &f32| (f64::from(height) * mm) as f32;
        let heights = heights.heights().iter().map(in_mm).collect();
        Ok(Some((heights, description.width)))
    }

    fn write_pvf(&self) -> Result<Exported> {
        let sampling = &self.header.sampling;
        let most = (sampling.lights.len() * 3).min(self.header.texels());
        let rank = self.stated_rank()?.min(most);
        self.progress
            .begin("components of views", sampling.views.len() as u64);
        let mut view = |view| {
            self.progress.advance(1)?;
            view_components::of(self.sample, view, rank, PI as f32)
        };
        let content = PvfContent {
            header: self.header,
            rank,
            view: &mut view,
            scalar: self.scalar,
            legacy: false,
        };
        let signature = self.signature(Format::Pvf, false);
        encode(self.path, &signature, Written::Pvf(content))?;
        self.progress.end();
        Ok(Exported {
            rank: Some(rank),
            error: Some(self.error()?),
        })
    }

    /// The relative error of the file that was written, read as `import` reads it.
    fn error(&self) -> Result<f64> {
        let file = BonnFile::open(self.path, parent(self.path))?;
        let description = self.sample.description().clone().with_whole_images();
        let images = BonnImages {
            scales: vec![FRAC_1_PI as f32; description.lights.len()],
            body: file.into_body()?,
            heights: None,
            negative: AtomicU64::new(0),
            description,
        };
        images.relative_error(self.sample, self.progress)
    }

    fn write_bdi(&self) -> Result<Exported> {
        let mask = vec![true; self.header.texels()];
        self.progress.begin("texels", mask.len() as u64);
        let texels = |texels: &[u32], out: &mut [f32]| {
            self.read_texels(texels, out)?;
            self.progress.advance(texels.len() as u64)
        };
        let content = BdiContent {
            header: self.header,
            compression: Compression::Sparse,
            lines: LINES,
            mask: &mask,
            texels: &texels,
        };
        let signature = self.signature(Format::Bdi, false);
        encode(self.path, &signature, Written::Bdi(content))?;
        self.progress.end();
        Ok(Exported::default())
    }

    /// A run of texels, \[texel\]\[image\]\[RGB\].
    fn read_texels(&self, texels: &[u32], out: &mut [f32]) -> Result<()> {
        let first = texels[0] as usize;
        let range = first..first + texels.len();
        let images: Vec<u32> = (0..self.sample.image_count() as u32).collect();
        self.sample.announce_texels_of(&images, range.clone());
        let mut by_image = vec![0.0; out.len()];
        by_image
            .par_chunks_mut(IMAGES * texels.len() * 3)
            .zip(images.par_chunks(IMAGES))
            .try_for_each(|(numbers, images)| {
                let mut pixels = vec![Pixels::of_type(DType::F4); images.len()];
                self.sample
                    .read_texels_of(images, range.clone(), &mut pixels)?;
                let pairs = numbers.chunks_mut(texels.len() * 3).zip(&pixels);
                pairs.for_each(|(numbers, pixels)| pixels.copy_to(numbers));
                Ok::<_, Error>(())
            })?;
        let (by_image, _) = by_image.as_chunks::<3>();
        let per_texel = out.par_chunks_mut(images.len() * 3).enumerate();
        per_texel.for_each(|(texel, out)| {
            let (out, _) = out.as_chunks_mut::<3>();
            for (image, out) in out.iter_mut().enumerate() {
                *out = by_image[image * texels.len() + texel].map(|v| v * PI as f32);
            }
        });
        Ok(())
    }
}

/// The colour model of a colour step, and what factors are to be multiplied by.
fn color_of(transform: glam::DMat3, mean: glam::DVec3) -> (Color, f32) {
    let scale = transform.x_axis.x;
    let is_plain = |v: f64| v.abs() < 1e-12;
    let rest = transform - glam::DMat3::from_diagonal(glam::DVec3::splat(scale));
    if rest.to_cols_array().iter().all(|&v| is_plain(v)) && mean == glam::DVec3::ZERO {
        // π · (1/π) may be off by a rounding.
        let scale = if is_plain(scale - 1.0) { 1.0 } else { scale };
        return (Color::of(ColorModel::Rgb), scale as f32);
    }
    let color = Color {
        model: ColorModel::Pca,
        mean: mean.as_vec3().to_array(),
        // The columns of T are the rows of M.
        transform: transform.to_cols_array().map(|v| v as f32),
    };
    (color, 1.0)
}

fn header_of(description: &Description) -> Result<Header> {
    if description.pairs.is_some() {
        return Err(Error::data("layout", "a list of (view, light) pairs")
            .expected("every view with every light, as .btf files have it"));
    }
    let stated = |field: &str| {
        let text = description
            .source
            .get(field)
            .and_then(|value| value.as_str());
        text.unwrap_or_default().to_owned()
    };
    Ok(Header {
        meta: Meta {
            measurement_setup: stated("measurement_setup"),
            image_sensor: stated("image_sensor"),
            light_source: stated("light_source"),
            pixels_per_mm: description.texel_mm.map_or(0.0, |mm| 1.0 / mm) as f32,
            xml: BTF_MARK.as_bytes().to_vec(),
            ..Meta::default()
        },
        sampling: Sampling {
            views: description.views.clone(),
            lights: description.lights.clone(),
        },
        width: description.width,
        height: description.height,
        rotations: Vec::new(),
    })
}
