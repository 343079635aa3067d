//! The images of an exemplar as channels: what each one is, by options, by its name, by its numbers.
//!
//! The first image is the colour that is rendered. Of the others `--kinds` says what they are; where it
//! does not, an encoding of light of their own says colour, then the words of file names count, as for
//! `bake`, then grey images are heights.

use std::path::Path;

use crate::btf::bake::maps::{Shown, shown_by_names};
use crate::cli::exemplar::arguments::Arguments;
use crate::cli::exemplar::option_values::ImageEncoding;
use crate::cli::exemplar::reading::{ImageReader, check_size};
use crate::cli::exemplar::weights;
use crate::error::{Error, Result};
use crate::exemplar::channels::ChannelKind;
use crate::exemplar::plain_images::ChannelImage;
use crate::format::image::{Encoding, FloatImage, ReadImage};

/// Red, green and blue nearer to each other than this are grey: two steps of 8 bits.
const GREY: f32 = 2.5 / 255.0;

impl Arguments {
    /// Refuses kinds and encodings that do not fit the images or each other.
    pub(super) fn check_kinds(&self) -> Result<()> {
        let images = self.images.len();
        let given = self.encoding.len();
        if given != 1 && given != images {
            return Err(Error::option(
                "encoding",
                format!("{given} for {images} images"),
                "one for all, or one for each image",
            ));
        }
        if self.encoding[0] == ImageEncoding::Data {
            return Err(Error::option(
                "encoding",
                "data for the first image",
                "auto, srgb or linear: the first image is the colour that is rendered",
            ));
        }
        if !self.kinds.is_empty() && self.kinds.len() != images {
            return Err(Error::option(
                "kinds",
                format!("{} for {images} images", self.kinds.len()),
                "one for each image",
            ));
        }
        if self.kind(0).is_some_and(|kind| kind != ChannelKind::Color) {
            return Err(Error::option(
                "kinds",
                "the first image is not a colour",
                "auto or color: the first image is the colour that is rendered",
            ));
        }
        (1..images).try_for_each(|image| self.check_encoding(image))
    }

    /// An encoding of its own must fit the image's kind.
    fn check_encoding(&self, image: usize) -> Result<()> {
        match self.kind(image) {
            Some(kind) if self.own_light(image) && kind != ChannelKind::Color => {
                Err(Error::option(
                    "encoding",
                    format!("light for image {}, of kind {}", image + 1, kind.name()),
                    "auto or data: only colours are light",
                ))
            }
            _ => Ok(()),
        }
    }

    /// Whether `--encoding` says of this image alone that it is light. One for all speaks of colours.
    fn own_light(&self, image: usize) -> bool {
        let encoding = self.encoding.get(image);
        let is_light = matches!(encoding, Some(ImageEncoding::Srgb | ImageEncoding::Linear));
        is_light && self.encoding.len() > 1
    }

    /// The kind that `--kinds` states for an image.
    fn kind(&self, image: usize) -> Option<ChannelKind> {
        self.kinds.get(image).and_then(|kind| kind.stated())
    }
}

/// Reads the images, each as one channel, and their alpha where it is kept.
pub(super) fn read(arguments: &Arguments, reader: &mut ImageReader) -> Result<Vec<ChannelImage>> {
    let shown = shown_by_names(&arguments.images);
    let mut channels: Vec<ChannelImage> = Vec::new();
    for (index, path) in arguments.images.iter().enumerate() {
        let encoding = arguments.encoding[index % arguments.encoding.len()];
        let stated = match index {
            0 => Some(ChannelKind::Color),
            _ if arguments.own_light(index) => Some(ChannelKind::Color),
            _ => arguments.kind(index),
        };
        let (kind, ReadImage { image, alpha, .. }) =
            read_one(path, (stated, shown[index]), encoding, reader)?;
        if let Some(first) = channels.first().map(|channel| &channel.image) {
            check_size(&image, [first.width, first.height], path)?;
        }
        let weight = weights::of_image(&arguments.weights, index);
        let alpha = alpha_image(&image, alpha, path)?;
        add(&mut channels, kind, weight, shaped(image, kind, path)?);
        if let Some(alpha) = alpha {
            add(&mut channels, ChannelKind::Alpha, weight, alpha);
        }
    }
    weights::give_named(&arguments.weights, &mut channels)?;
    Ok(channels)
}

/// Adds a channel named after its kind, numbered from the second of a kind on.
fn add(channels: &mut Vec<ChannelImage>, kind: ChannelKind, weight: f64, image: FloatImage) {
    let before = channels
        .iter()
        .filter(|channel| channel.kind == kind)
        .count();
    let mut channel = ChannelImage::new(kind, image);
    channel.weight = weight;
    if before > 0 {
        channel.name = format!("{}-{}", kind.name(), before + 1);
    }
    channels.push(channel);
}

/// An image of the kind that is stated, or else of the one told by what its name says it shows.
pub(in crate::cli) fn read_one(
    path: &Path,
    (stated, shown): (Option<ChannelKind>, Option<Shown>),
    encoding: ImageEncoding,
    reader: &mut ImageReader,
) -> Result<(ChannelKind, ReadImage)> {
    match stated {
        Some(kind) => Ok((kind, read_stated(path, kind, encoding, reader)?)),
        None => read_told(path, shown, encoding, reader),
    }
}

/// An image whose kind is known.
fn read_stated(
    path: &Path,
    kind: ChannelKind,
    encoding: ImageEncoding,
    reader: &mut ImageReader,
) -> Result<ReadImage> {
    match encoding.of_light() {
        Some(light) if kind == ChannelKind::Color => reader.color(path, light),
        _ => reader.data(path).map(|read| reader.taken(path, read)),
    }
}

/// An image whose kind is to be told.
fn read_told(
    path: &Path,
    shown: Option<Shown>,
    encoding: ImageEncoding,
    reader: &mut ImageReader,
) -> Result<(ChannelKind, ReadImage)> {
    let read = reader.data(path)?;
    match told(shown, &read.image) {
        ChannelKind::Color if encoding != ImageEncoding::Data => {
            let kind = ChannelKind::Color;
            Ok((kind, read_stated(path, kind, encoding, reader)?))
        }
        kind => Ok((kind, reader.taken(path, read))),
    }
}

/// What an image is, by what its name says it shows, where its numbers allow it.
fn told(shown: Option<Shown>, image: &FloatImage) -> ChannelKind {
    let is_grey = first_coloured(image).is_none();
    match shown {
        Some(Shown::Normal) if !is_grey => ChannelKind::Normal,
        Some(Shown::Color) => ChannelKind::Color,
        Some(Shown::Height) if is_grey => ChannelKind::Height,
        Some(Shown::Opacity) if is_grey => ChannelKind::Alpha,
        Some(Shown::Other) if is_grey => ChannelKind::Mask,
        _ if image.channels == 1 => ChannelKind::Height,
        _ => ChannelKind::Color,
    }
}

/// The first texel whose red, green and blue differ.
fn first_coloured(image: &FloatImage) -> Option<usize> {
    let texels = image.data.chunks_exact(image.channels as usize);
    texels.into_iter().position(|texel| {
        let least = texel.iter().copied().fold(f32::INFINITY, f32::min);
        let most = texel.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        most - least > GREY
    })
}

/// The image with as many numbers per texel as its kind has.
pub(in crate::cli) fn shaped(
    image: FloatImage,
    kind: ChannelKind,
    path: &Path,
) -> Result<FloatImage> {
    if kind.counts().contains(&image.channels) {
        return Ok(image);
    }
    if kind == ChannelKind::Normal {
        return Err(Error::data("channels", "grey")
            .expected("red, green and blue of a normal map")
            .in_file(path));
    }
    grey(image, path)
}

/// A grey image with 1 number per texel; refused where it has colour.
pub(super) fn grey(image: FloatImage, path: &Path) -> Result<FloatImage> {
    let Some(texel) = first_coloured(&image) else {
        return Ok(image.into_gray());
    };
    let (row, col) = (texel / image.width as usize, texel % image.width as usize);
    let rgb = &image.data[3 * texel..][..3];
    Err(Error::data(
        format!("row {row}, column {col}"),
        format!("red {}, green {}, blue {}", rgb[0], rgb[1], rgb[2]),
    )
    .expected("a grey image")
    .advice("save the intended channel as a grey image, or name it with --layer (OpenEXR)")
    .in_file(path))
}

/// The alpha of an image that was read, as an image of its own.
pub(in crate::cli) fn alpha_image(
    image: &FloatImage,
    alpha: Option<Vec<f32>>,
    path: &Path,
) -> Result<Option<FloatImage>> {
    let Some(data) = alpha else {
        return Ok(None);
    };
    let alpha = FloatImage {
        channels: 1,
        data,
        encoding: Encoding::Data,
        ..*image
    };
    alpha.check_finite().map_err(|error| error.in_file(path))?;
    Ok(Some(alpha))
}
