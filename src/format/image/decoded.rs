//! An image as its decoder returns it, and the steps from there to what the caller asked for.
//!
//! The steps are the same for every format: square pixels, alpha, orientation, colour.

use crate::error::{Error, Result};
use crate::format::image::color::{Curve, Statement, decode};
use crate::format::image::facts::{Channel, Facts, Part, Transparency};
use crate::format::image::float_image::{Encoding, FloatImage, Precision, ReadImage};
use crate::format::image::notes::Note;
use crate::format::image::options::{
    Alpha, Flags, Gamut, Orientation, Purpose, ReadOptions, SourceEncoding,
};
use crate::format::image::orientation::turned;

/// Floats this near to 1 are opaque; integers must be at their greatest.
const OPAQUE_FLOAT: f32 = 0.999;
/// Pixels this near to square are square.
const SQUARE: f64 = 0.005;

/// A decoded image: row 0 at the top as stored, channels interleaved, numbers as stored.
pub(super) struct Decoded {
    pub(super) width: u32,
    pub(super) height: u32,
    /// Colour channels: 1 or 3.
    pub(super) channels: u32,
    pub(super) data: Vec<f32>,
    /// One number per texel, and whether colours are multiplied by it.
    pub(super) alpha: Option<(Vec<f32>, bool)>,
    pub(super) precision: Precision,
    pub(super) statement: Statement,
    /// Orientation as EXIF counts it.
    pub(super) orientation: u8,
    /// Width of a pixel over its height.
    pub(super) pixel_aspect: f64,
    /// Whether the layer that was asked for was chosen.
    pub(super) layer_taken: bool,
    pub(super) notes: Vec<Note>,
    /// Format, stored numbers, compression and the like; the rest is filled in by [`Decoded::facts`].
    pub(super) facts: Facts,
}

/// Colour numbers and alpha of interleaved `numbers`, `stored` to a texel: grey or RGB first, then alpha
/// where there is one.
pub(super) fn split_alpha<T: Copy>(
    stored: usize,
    numbers: &[T],
    number: impl Fn(T) -> f32,
) -> (u32, Vec<f32>, Option<Vec<f32>>) {
    let kept = if stored < 3 { 1 } else { 3 };
    let texels = numbers.chunks_exact(stored);
    let mut data = Vec::with_capacity(texels.len() * kept);
    data.extend(
        texels
            .clone()
            .flat_map(|texel| texel[..kept].iter().map(|&value| number(value))),
    );
    let alpha = (stored > kept).then(|| texels.map(|texel| number(texel[kept])).collect());
    (kept as u32, data, alpha)
}

impl Decoded {
    /// Counts what is not opaque.
    fn transparency(&self) -> Option<Transparency> {
        let (alpha, premultiplied) = self.alpha.as_ref()?;
        let opaque = match self.precision {
            Precision::Float => OPAQUE_FLOAT,
            Precision::Bits8 | Precision::Bits16 => 1.0,
        };
        let count = |is: &dyn Fn(f32) -> bool| alpha.iter().filter(|&&a| is(a)).count() as u64;
        Some(Transparency {
            // Written so that NaN counts as transparent.
            transparent: alpha.len() as u64 - count(&|a| a >= opaque),
            invisible: count(&|a| a <= 0.0),
            premultiplied: *premultiplied,
        })
    }

    /// What the file says, in one place.
    pub(super) fn facts(&self) -> Facts {
        let mut facts = self.facts.clone();
        facts.size = [self.width.into(), self.height.into()];
        facts.pixel_aspect = self.pixel_aspect;
        facts.color.clone_from(&self.statement.text);
        facts.reading = self.statement.reading(self.precision);
        facts.orientation = self.orientation;
        facts.alpha = self.transparency();
        facts
    }

    /// The image as the caller asked for it, notes added.
    pub(super) fn finished(mut self, options: &ReadOptions) -> Result<ReadImage> {
        check_square(self.pixel_aspect)?;
        self.check_alpha(options)?;
        self.turn(options);
        let kept = self.alpha.take_if(|_| options.alpha == Alpha::Keep);
        let encoding = match options.purpose {
            Purpose::Data => Encoding::Data,
            Purpose::Color => self.color(options)?,
        };
        let image = FloatImage {
            width: self.width,
            height: self.height,
            channels: self.channels,
            data: self.data,
            encoding,
            precision: self.precision,
        };
        Ok(ReadImage {
            image,
            alpha: kept.map(|(alpha, _)| alpha),
            notes: self.notes,
            layer_taken: self.layer_taken,
        })
    }

    fn check_alpha(&mut self, options: &ReadOptions) -> Result<()> {
        let Some(found) = self.transparency().filter(|found| found.transparent > 0) else {
            self.alpha = None;
            return Ok(());
        };
        let texels = u64::from(self.width) * u64::from(self.height);
        let count = format!("{} of {texels} texels are not opaque", found.transparent);
        match (options.purpose, options.alpha) {
            (_, Alpha::Keep) => return Ok(()),
            (Purpose::Data, _) => {
                let text = format!("{count}; the alpha channel is not used");
                self.notes.push(Note::new("alpha", text));
            }
            (_, Alpha::Refuse) => return Err(transparent(count, &found, options.flags)),
            (_, Alpha::Ignore) => {
                let text = format!("{count}; their colours are taken as stored");
                self.notes.push(Note::new("alpha", text));
            }
            (_, Alpha::OverBlack) => return Ok(()),
        }
        self.alpha = None;
        Ok(())
    }

    fn turn(&mut self, options: &ReadOptions) {
        if self.orientation == 1 {
            return;
        }
        if options.orientation == Orientation::Stored {
            let flag = match options.flags.orientation {
                "" => String::new(),
                flag => format!(" ({flag} upright turns it)"),
            };
            let text = format!(
                "its orientation tag ({}) is not followed: rows are read as stored{flag}",
                self.orientation
            );
            self.notes.push(Note::new("orientation", text));
            return;
        }
        let size = (self.width as usize, self.height as usize);
        let channels = self.channels as usize;
        self.data = turned(&self.data, size, channels, self.orientation);
        if let Some((alpha, _)) = &mut self.alpha {
            *alpha = turned(alpha, size, 1, self.orientation);
        }
        if self.orientation > 4 {
            (self.width, self.height) = (self.height, self.width);
        }
    }

    /// Brings colours to linear Rec. 709, or leaves them in plain sRGB.
    fn color(&mut self, options: &ReadOptions) -> Result<Encoding> {
        let said = |curve| Statement::of(Some(curve), None, "");
        let mut encoding = match options.encoding {
            SourceEncoding::Srgb => Encoding::Srgb,
            SourceEncoding::Linear => Encoding::Linear,
            SourceEncoding::Gamma22 => self.follow(&said(Curve::Power(2.2)), options)?,
            SourceEncoding::Xyz => self.follow(&Statement::tristimulus("XYZ"), options)?,
            SourceEncoding::Auto => self.follow(&self.statement.clone(), options)?,
        };
        if let Some((alpha, premultiplied)) = &self.alpha {
            let channels = self.channels as usize;
            if encoding == Encoding::Srgb {
                decode(&mut self.data, channels, &Curve::Srgb, None, Gamut::Keep);
                encoding = Encoding::Linear;
            }
            if !premultiplied {
                let texels = self.data.chunks_exact_mut(channels);
                for (texel, &alpha) in texels.zip(alpha) {
                    texel.iter_mut().for_each(|value| *value *= alpha);
                }
            }
        }
        Ok(encoding)
    }

    fn follow(&mut self, statement: &Statement, options: &ReadOptions) -> Result<Encoding> {
        if let Some(why) = &statement.unusable {
            let advice = match options.flags.encoding {
                "" => "convert it to sRGB".to_string(),
                flag => {
                    format!("convert it to sRGB, or state how to read it: {flag} srgb or linear")
                }
            };
            return Err(Error::data("colour space", why.clone())
                .expected("an RGB or grey profile of matrix and curves, or none")
                .advice(advice));
        }
        let curve = statement.followed_curve(self.precision);
        let matrix = statement.matrix.filter(|_| self.channels == 3);
        match (&curve, matrix) {
            (Curve::Srgb, None) => return Ok(Encoding::Srgb),
            (Curve::Linear, None) => return Ok(Encoding::Linear),
            _ => {}
        }
        let channels = self.channels as usize;
        let outside = decode(&mut self.data, channels, &curve, matrix, options.gamut);
        if outside.texels > 0 && options.gamut == Gamut::Clip {
            let text = format!(
                "{} texels have colours outside Rec. 709 (down to {}); their negative numbers are set to 0",
                outside.texels, outside.least
            );
            self.notes.push(Note::new("gamut", text));
        }
        Ok(Encoding::Linear)
    }
}

fn check_square(aspect: f64) -> Result<()> {
    if (aspect - 1.0).abs() <= SQUARE {
        return Ok(());
    }
    Err(Error::data("pixel aspect ratio", aspect.to_string())
        .expected("1: square pixels")
        .advice("resample the image to square pixels, or correct its header if they are square"))
}

fn transparent(count: String, found: &Transparency, flags: Flags) -> Error {
    let advice = match flags.alpha {
        "" => "composite the image over a background, or leave its alpha channel out".to_string(),
        flag => format!(
            "composite the image over a background and leave its alpha channel out, or take colours as \
             stored: {flag} ignore"
        ),
    };
    let hidden = match found.invisible {
        0 => String::new(),
        invisible => format!(", {invisible} of them not visible at all"),
    };
    Error::data("alpha", format!("{count}{hidden}"))
        .expected("every texel opaque")
        .advice(advice)
}

/// The one part of a format without parts.
pub(super) fn only_part(channels: &[&str], numbers: &str, compression: &str) -> Part {
    Part {
        channels: channels
            .iter()
            .map(|name| Channel {
                name: (*name).into(),
                numbers: numbers.into(),
                sampling: [1, 1],
            })
            .collect(),
        compression: compression.into(),
        ..Part::default()
    }
}

/// The names of interleaved channels, alpha last.
pub(super) fn channel_names(color: u32, alpha: bool) -> &'static [&'static str] {
    match (color, alpha) {
        (1, false) => &["Y"],
        (1, true) => &["Y", "A"],
        (_, false) => &["R", "G", "B"],
        (_, true) => &["R", "G", "B", "A"],
    }
}
