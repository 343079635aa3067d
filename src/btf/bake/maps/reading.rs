//! Reading the image files of a material: the albedo as colour, all else as plain numbers.

use std::cell::Cell;
use std::path::Path;

use crate::btf::bake::maps::recipe::ColorEncoding;
use crate::error::Result;
use crate::format::image::{
    self, Alpha, FloatImage, Notes, Purpose, ReadImage, ReadOptions, SourceEncoding,
};
use crate::progress::Progress;

/// Reads maps as a command's options say, and passes on what their readers note.
pub(super) struct MapReader<'a> {
    options: ReadOptions,
    albedo_encoding: Option<SourceEncoding>,
    pub(super) progress: Progress<'a>,
    layer_taken: Cell<bool>,
}

impl<'a> MapReader<'a> {
    pub(super) fn new(
        options: ReadOptions,
        albedo_encoding: Option<SourceEncoding>,
        progress: Progress<'a>,
    ) -> Self {
        Self {
            options,
            albedo_encoding,
            progress,
            layer_taken: Cell::new(false),
        }
    }

    /// A colour map in linear Rec. 709, three channels. The command's encoding is before the material's,
    /// and that before the file's.
    pub(super) fn color(&self, path: &Path, stated: Option<ColorEncoding>) -> Result<FloatImage> {
        let stated = stated.map(|encoding| match encoding {
            ColorEncoding::Srgb => SourceEncoding::Srgb,
            ColorEncoding::Linear => SourceEncoding::Linear,
        });
        let encoding = self.albedo_encoding.or(stated).unwrap_or_default();
        let options = ReadOptions {
            encoding,
            ..self.options.clone()
        };
        Ok(self.read(path, &options)?.into_linear().into_rgb())
    }

    /// A map of heights, normals or shares: the numbers as stored, all finite.
    pub(super) fn data(&self, path: &Path) -> Result<FloatImage> {
        let options = ReadOptions {
            purpose: Purpose::Data,
            ..self.options.clone()
        };
        let image = self.read(path, &options)?;
        image.check_finite().map_err(|error| error.in_file(path))?;
        Ok(image)
    }

    /// A normal map as stored, all finite, with its alpha where that may hold a vector's part.
    pub(super) fn normals(&self, path: &Path) -> Result<(FloatImage, Option<Vec<f32>>)> {
        let options = ReadOptions {
            purpose: Purpose::Data,
            alpha: Alpha::Keep,
            ..self.options.clone()
        };
        let read = self.read_with(path, &options)?;
        read.image
            .check_finite()
            .map_err(|error| error.in_file(path))?;
        Ok((read.image, read.alpha))
    }

    fn read(&self, path: &Path, options: &ReadOptions) -> Result<FloatImage> {
        Ok(self.read_with(path, options)?.image)
    }

    fn read_with(&self, path: &Path, options: &ReadOptions) -> Result<ReadImage> {
        let mut read = image::read_with(path, options)?;
        let mut notes = Notes::default();
        notes.add(path, std::mem::take(&mut read.notes));
        notes.warn(self.progress);
        self.layer_taken
            .set(self.layer_taken.get() || read.layer_taken);
        Ok(read)
    }

    /// Refuses a layer's name that no map had layers for.
    pub(super) fn check_layer(&self) -> Result<()> {
        self.options.check_layer_taken(self.layer_taken.get())
    }
}
