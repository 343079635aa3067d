//! An image of a list as linear Rec. 709: its bytes, from wherever they are, and what its family knows.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::btf::import::family::Family;
use crate::btf::import::image_list::{ImageList, MeasuredImage};
use crate::btf::import::options::ImportOptions;
use crate::btf::import::size_line::{self, SizeLine};
use crate::btf::import::spectrum;
use crate::error::{Error, Result};
use crate::format::image::{
    self, ExrContent, FloatImage, Note, ReadImage, ReadOptions, SourceEncoding,
};

/// Reads the images of a list, on any thread.
#[derive(Debug)]
pub(super) struct ImageReader<'a> {
    list: &'a ImageList,
    options: &'a ImportOptions,
    reading: ReadOptions,
    /// Whether any image had the layer that was asked for, and whether any was spectral.
    layer_taken: AtomicBool,
    is_spectral: AtomicBool,
}

impl<'a> ImageReader<'a> {
    pub(super) fn new(list: &'a ImageList, options: &'a ImportOptions) -> Self {
        Self {
            list,
            options,
            reading: options.reading(),
            layer_taken: AtomicBool::new(false),
            is_spectral: AtomicBool::new(false),
        }
    }

    /// An image in linear Rec. 709, three channels, and what its reader had to say.
    pub(super) fn read(&self, measured: &MeasuredImage) -> Result<(FloatImage, Vec<Note>)> {
        let mut bytes = self.list.place.read(&measured.path)?;
        let mut notes = Vec::new();
        if self.list.family == Family::Bonn
            && self.options.size_line == SizeLine::Auto
            && let Some(sound) = size_line::corrected(&bytes)
        {
            bytes = sound;
            let text = "its size line `+X … -Y …` is read as rows from the bottom, as ATRIUM's are \
                (--size-line stated reads it as stated)";
            notes.push(Note::new("size line", text));
        }
        let content = image::exr_content(&measured.path, &bytes)?;
        let read = match &content {
            Some(content) if self.is_spectrum(content) => self.spectral(measured, &bytes)?,
            _ => self.picture(measured, &bytes, content.as_ref(), &mut notes)?,
        };
        notes.extend(read.notes);
        Ok((read.image.into_linear().into_rgb(), notes))
    }

    /// Refuses options that no image had use for.
    pub(super) fn check_options_used(&self) -> Result<()> {
        self.reading
            .check_layer_taken(self.layer_taken.load(Ordering::Relaxed))?;
        match self.options.illuminant {
            Some(_) if !self.is_spectral.load(Ordering::Relaxed) => Err(Error::option(
                "illuminant",
                "no image is spectral",
                "OpenEXR with a channel per wavelength, or no illuminant",
            )),
            _ => Ok(()),
        }
    }

    fn is_spectrum(&self, content: &ExrContent) -> bool {
        self.options.layer.is_none() && spectrum::is_spectrum(&content.channels)
    }

    fn spectral(&self, measured: &MeasuredImage, bytes: &[u8]) -> Result<ReadImage> {
        self.is_spectral.store(true, Ordering::Relaxed);
        let is_wanted = |channel: &str| spectrum::wavelength(channel).is_some();
        let planes = image::read_planes(&measured.path, bytes, is_wanted)?;
        let illuminant = self.options.illuminant.unwrap_or_default();
        let (image, negative) =
            spectrum::to_rgb(&planes, illuminant).map_err(|error| error.in_file(&measured.path))?;
        let note = || {
            let text = format!(
                "{negative} texels have colours outside Rec. 709; their negative numbers are set to 0"
            );
            Note::new("gamut", text)
        };
        Ok(ReadImage {
            image,
            alpha: None,
            notes: (negative > 0).then(note).into_iter().collect(),
            layer_taken: false,
        })
    }

    /// Any image but a spectral one. UTIA's OpenEXR files are XYZ, whatever their channels are called.
    fn picture(
        &self,
        measured: &MeasuredImage,
        bytes: &[u8],
        content: Option<&ExrContent>,
        notes: &mut Vec<Note>,
    ) -> Result<ReadImage> {
        let mut reading = self.reading.clone();
        if let Some(content) = content.filter(|_| reading.encoding == SourceEncoding::Auto) {
            let has = |name: &str| content.channels.iter().any(|channel| channel == name);
            let is_named_so = has("X") && has("Y") && has("Z") && !has("R");
            let is_utia = self.list.family == Family::Utia && !content.states_color;
            if is_named_so || is_utia {
                reading.encoding = SourceEncoding::Xyz;
                let text =
                    "its numbers are taken as XYZ under D65 (--encoding linear takes them as RGB)";
                notes.push(Note::new("xyz", text));
            }
        }
        let read = image::read_bytes(&measured.path, bytes, &reading)?;
        self.layer_taken
            .fetch_or(read.layer_taken, Ordering::Relaxed);
        Ok(read)
    }
}
