//! Reading the images of an exemplar: as colour or as plain numbers, all finite, notes gathered.

use std::path::Path;

use clap::Args;

use crate::cli::exemplar::option_values::AlphaOption;
use crate::error::{Error, Result};
use crate::format::image::{
    self, Alpha, Flags, FloatImage, Notes, Orientation, Purpose, ReadImage, ReadOptions,
    SourceEncoding,
};
use crate::progress::Progress;

/// How the images of a command are read.
#[derive(Clone, Debug, Args)]
pub struct ReadingOptions {
    /// Whether the orientation tag of images is applied
    #[arg(long, value_enum, default_value = "upright")]
    pub orientation: Orientation,
    /// What to do with texels that are not opaque
    #[arg(long, value_enum, default_value = "refuse")]
    pub alpha: AlphaOption,
    /// The layer, part, view or channel to read from an OpenEXR file that has several; `mesotex info IMAGE` lists them
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
}

impl ReadingOptions {
    /// A reader that does so.
    pub(in crate::cli) fn reader(&self) -> ImageReader {
        ImageReader::new(self.orientation, self.alpha, self.layer.clone())
    }
}

/// Reads images as the command's options say.
pub(in crate::cli) struct ImageReader {
    options: ReadOptions,
    notes: Notes,
    layer_taken: bool,
    /// Whether alpha is wanted and none was found yet.
    lacks_alpha: bool,
}

impl ImageReader {
    /// Options as the flags of the same names have them.
    pub(in crate::cli) fn new(
        orientation: Orientation,
        alpha: AlphaOption,
        layer: Option<String>,
    ) -> Self {
        Self {
            options: ReadOptions {
                orientation,
                alpha: match alpha {
                    AlphaOption::Refuse => Alpha::Refuse,
                    AlphaOption::Ignore => Alpha::Ignore,
                    AlphaOption::Keep => Alpha::Keep,
                },
                layer,
                flags: Flags::USUAL,
                ..ReadOptions::default()
            },
            notes: Notes::default(),
            layer_taken: false,
            lacks_alpha: alpha == AlphaOption::Keep,
        }
    }

    /// An image as light, and its alpha where that is kept.
    pub(in crate::cli) fn color(
        &mut self,
        path: &Path,
        encoding: SourceEncoding,
    ) -> Result<ReadImage> {
        let options = ReadOptions {
            encoding,
            ..self.options.clone()
        };
        let read = self.read(path, &options)?;
        Ok(self.taken(path, read))
    }

    /// An image's numbers as they stand, whose notes do not count until it is [`taken`](Self::taken).
    pub(super) fn data(&self, path: &Path) -> Result<ReadImage> {
        let options = ReadOptions {
            purpose: Purpose::Data,
            ..self.options.clone()
        };
        self.read(path, &options)
    }

    /// The numbers of a control as they stand.
    pub(in crate::cli) fn control(&mut self, path: &Path) -> Result<FloatImage> {
        let options = ReadOptions {
            purpose: Purpose::Data,
            alpha: Alpha::Ignore,
            ..self.options.clone()
        };
        let read = self.read(path, &options)?;
        Ok(self.taken(path, read).image)
    }

    /// Counts an image among those that are used.
    pub(super) fn taken(&mut self, path: &Path, mut read: ReadImage) -> ReadImage {
        self.notes.add(path, std::mem::take(&mut read.notes));
        self.layer_taken |= read.layer_taken;
        self.lacks_alpha &= read.alpha.is_none();
        read
    }

    /// Tells the notes, and refuses options that no image was touched by.
    pub(in crate::cli) fn finish(self, progress: Progress<'_>) -> Result<()> {
        self.notes.warn(progress);
        if self.lacks_alpha {
            return Err(Error::option(
                "alpha",
                "keep, but every texel of every image is opaque",
                "an image with transparent texels, or no --alpha",
            ));
        }
        self.options.check_layer_taken(self.layer_taken)
    }

    fn read(&self, path: &Path, options: &ReadOptions) -> Result<ReadImage> {
        let read = image::read_with(path, options)?;
        let finite = read.image.check_finite();
        finite.map_err(|error| error.in_file(path))?;
        Ok(read)
    }
}

/// Refuses an image of another size than the first, [width, height].
pub(in crate::cli) fn check_size(image: &FloatImage, first: [u32; 2], path: &Path) -> Result<()> {
    if [image.width, image.height] == first {
        return Ok(());
    }
    Err(
        Error::data("size", format!("{}×{}", image.width, image.height))
            .expected(format!("{}×{}, as the first image", first[0], first[1]))
            .in_file(path),
    )
}
