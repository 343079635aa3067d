//! A `.btf` file open for reading: header, kind and matrices, all sizes checked against its length.

use std::path::Path;

use serde_json::{Value, json};

use crate::btf::bonn::bdi::{self, Bdi};
use crate::btf::bonn::body::Body;
use crate::btf::bonn::crop::{Cropped, factors_of};
use crate::btf::bonn::factors::Factors;
use crate::btf::bonn::fields::Fields;
use crate::btf::bonn::header::Header;
use crate::btf::bonn::pvf::{self, Pvf};
use crate::btf::bonn::signature::{Format, LONGEST, Signature};
use crate::btf::bonn::{dfmf, fmf};
use crate::btf::import::Region;
use crate::error::Result;
use crate::format::guard::guarded;

/// What follows the header.
pub(super) enum Content {
    /// DFMF and FMF.
    Factors(Factors),
    /// PVF.
    Pvf(Pvf),
    /// PVF, a region of its images.
    PartOfPvf(Cropped<Pvf>),
    /// BDI.
    Bdi(Bdi),
}

/// An open file.
pub struct BonnFile {
    signature: Signature,
    header: Header,
    pub(super) content: Content,
    /// Millimetres above any plane, one number per texel.
    heights: Option<Vec<f32>>,
    notes: Vec<String>,
}

impl BonnFile {
    /// Reads header and sizes; packed texels are unpacked on the disk of `scratch`.
    pub fn open(path: &Path, scratch: &Path) -> Result<Self> {
        guarded(path, || Self::read(&mut Fields::open(path)?, scratch))
    }

    fn read(fields: &mut Fields, scratch: &Path) -> Result<Self> {
        let start = fields.bytes("signature", fields.left().min(LONGEST as u64))?;
        let signatures = Signature::all_of(&start)?;
        match (
            Self::read_as(signatures[0], fields, scratch),
            signatures.get(1),
        ) {
            // The fault of the longest match is told where no other fits.
            (Err(fault), Some(&shorter)) => {
                Self::read_as(shorter, fields, scratch).map_err(|_| fault)
            }
            (read, _) => read,
        }
    }

    fn read_as(signature: Signature, fields: &mut Fields, scratch: &Path) -> Result<Self> {
        fields.go_to(signature.text.len() as u64);
        let (mut notes, mut heights) = (Vec::new(), None);
        // Read the header and the content of the format that the signature names.
        let (header, content) = match signature.format {
            Format::Bdi => {
                let (header, texels) = bdi::read(fields, scratch, &mut notes)?;
                (header, Content::Bdi(texels))
            }
            Format::Pvf => {
                let (header, slots) =
                    pvf::read_header(fields, signature.has_rotations, &mut notes)?;
                let views = pvf::read(fields, &header, slots)?;
                (header, Content::Pvf(views))
            }
            Format::Dfmf => {
                let header = Header::read(fields, signature.has_rotations, &mut notes)?;
                let factors = dfmf::read(fields, &header)?;
                (header, Content::Factors(factors))
            }
            Format::Fmf => {
                let header = Header::read(fields, signature.has_rotations, &mut notes)?;
                let (factors, extra) = fmf::read(fields, &header, signature.has_extra_header)?;
                match extra.height_map {
                    Some((map, width)) if width == header.width && map.len() == header.texels() => {
                        heights = Some(map);
                    }
                    Some((map, width)) => notes.push(format!(
                        "its height map of {width} × {} is not that of its {} × {} texels, and is left out",
                        map.len() / width as usize,
                        header.width,
                        header.height
                    )),
                    None => {}
                }
                (header, Content::Factors(factors))
            }
        };
        // Tell what is read but not applied.
        if header.meta.rgb_scale != [1.0; 3] && header.meta.rgb_scale != [0.0; 3] {
            let [r, g, b] = header.meta.rgb_scale;
            notes.push(format!(
                "its rgb_scale_factor ({r}, {g}, {b}) is not applied"
            ));
        }
        Ok(Self {
            signature,
            header,
            content,
            heights,
            notes,
        })
    }

    /// How the images are kept.
    pub fn format(&self) -> Format {
        self.signature.format
    }

    /// All that precedes the body.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// What the user should know.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// How high each texel lies over any plane, in millimetres.
    pub fn heights(&self) -> Option<&[f32]> {
        self.heights.as_deref()
    }

    /// The colour model and the largest number of components, where images are factors of all views.
    pub fn factors(&self) -> Option<(&'static str, usize)> {
        match &self.content {
            Content::Factors(factors) => Some((model_name(factors), factors.rank())),
            Content::Pvf(_) | Content::PartOfPvf(_) | Content::Bdi(_) => None,
        }
    }

    /// What the file says of itself, for `btf.json` and reports.
    pub fn facts(&self) -> Value {
        let meta = &self.header.meta;
        let mut facts = json!({
            "kind": format!("UBO2014 {}", self.format().name()),
            "measurement_setup": meta.measurement_setup,
            "image_sensor": meta.image_sensor,
            "light_source": meta.light_source,
            "pixels_per_mm": meta.pixels_per_mm,
            "rgb_scale_factor": meta.rgb_scale,
            "cosine": meta.has_cosine,
            "channels": meta.channels,
            "rotations": self.header.rotations.len(),
        });
        if let (Some((model, rank)), Some(facts)) = (self.factors(), facts.as_object_mut()) {
            facts.insert("color_model".into(), model.into());
            facts.insert("components".into(), rank.into());
        }
        facts
    }

    /// The same with the texels of a region alone, as `--crop` asks for.
    pub(super) fn cropped(mut self, region: Region) -> Result<Self> {
        let (width, height) = (self.header.width, self.header.height);
        region.check_inside("crop", (width, height))?;
        self.content = match self.content {
            Content::Factors(factors) => Content::Factors(factors_of(factors, region, width)),
            Content::Pvf(views) => Content::PartOfPvf(Cropped {
                body: views,
                region,
                size: [width, height],
            }),
            Content::Bdi(texels) => Content::Bdi(texels.cropped(region)),
            part @ Content::PartOfPvf(_) => part,
        };
        if let Some(heights) = &mut self.heights {
            let kept = region.rows(width).flat_map(|row| heights[row].to_vec());
            *heights = kept.collect();
        }
        if self.header.rotations.len() > 1 {
            let rotations = &self.header.rotations;
            let kept = region.rows(width).flat_map(|row| rotations[row].to_vec());
            self.header.rotations = kept.collect();
        }
        (self.header.width, self.header.height) = (region.width, region.height);
        Ok(self)
    }

    /// The images, with all matrices in memory where there are factors.
    pub(super) fn into_body(self) -> Result<Box<dyn Body>> {
        Ok(match self.content {
            Content::Factors(factors) => Box::new(factors.load()?),
            Content::Pvf(views) => Box::new(views),
            Content::PartOfPvf(views) => Box::new(views),
            Content::Bdi(texels) => Box::new(texels),
        })
    }
}

fn model_name(factors: &Factors) -> &'static str {
    match factors.logarithmic {
        true => "RGB, dynamic range reduced",
        false => factors.color.model.name(),
    }
}
