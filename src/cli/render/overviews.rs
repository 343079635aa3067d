//! What shows a sweep at a glance, beside its frames: the contact sheet and the moving preview.

use std::path::{Path, PathBuf};

use crate::cli::outcome::Outcome;
use crate::error::Result;
use crate::format::ours::{Format, check_replaceable};
use crate::format::rgb_image::RgbImage;
use crate::progress::Progress;
use crate::render::option_values::Animation;
use crate::render::sweep::FrameFile;
use crate::report::animation::{write_apng, write_gif};
use crate::report::contact_sheet::{contact_sheet, reduced};
use crate::report::video::{Container, VideoEncoder};

/// The contact sheet, the most pictures on it, and their columns.
const SHEET: &str = "contact.png";
const MOST_PICTURES: usize = 64;
const THUMBNAIL: u32 = 320;
/// What the angles on a contact sheet are.
const LEGEND: &str = "angles: azimuth and elevation";
/// Pictures per second of a moving preview, and the most columns of one that is no video.
const RATE: u16 = 24;
const WIDEST: u32 = 480;

/// The overviews of a folder of frames.
pub(super) struct Overviews<'a> {
    folder: &'a Path,
    animation: Animation,
    /// What makes a moving preview that this program does not write itself.
    encoder: Option<VideoEncoder>,
}

impl<'a> Overviews<'a> {
    /// Refuses to write over files of the user, and video where the machine has no encoder of it.
    pub(super) fn new(folder: &'a Path, animation: Animation) -> Result<Self> {
        let sheet = folder.join(SHEET);
        check_replaceable(&sheet, Format::Picture)?;
        // Most moving previews have no mark of their own: they are ours where the contact sheet is.
        if let Some(name) = animation.file_name().filter(|_| !sheet.exists()) {
            check_replaceable(&folder.join(name), Format::Picture)?;
        }
        let container = match animation {
            Animation::None | Animation::Gif | Animation::Apng => None,
            Animation::Mp4 => Some(Container::Mp4),
            Animation::Webm => Some(Container::Webm),
        };
        let find = |container| VideoEncoder::find(Path::new("ffmpeg"), container);
        Ok(Self {
            folder,
            animation,
            encoder: container.map(find).transpose()?,
        })
    }

    /// Adds the contact sheet and the moving preview, once all frames are there.
    pub(super) fn add(
        &self,
        outcome: Outcome,
        frames: &[FrameFile],
        progress: Progress<'_>,
    ) -> Result<Outcome> {
        let missing = frames.iter().filter(|frame| !frame.is_there).count();
        if missing > 0 {
            return Ok(outcome.line(format!(
                "{missing} frames are for other shards; the last to finish draws the contact sheet"
            )));
        }
        let sheet = self.folder.join(SHEET);
        contact_sheet(&thumbnails(frames, progress)?, LEGEND).write(&sheet)?;
        let outcome = outcome.wrote(&sheet).put_inside([sheet]);
        match self.write_animation(frames, progress)? {
            None => Ok(outcome),
            Some(moving) => Ok(outcome.wrote(&moving).put_inside([moving])),
        }
    }

    fn write_animation(
        &self,
        frames: &[FrameFile],
        progress: Progress<'_>,
    ) -> Result<Option<PathBuf>> {
        let Some(name) = self.animation.file_name() else {
            return Ok(None);
        };
        let path = self.folder.join(name);
        progress.begin("moving preview", frames.len() as u64);
        let pictures = frames.iter().map(|frame| {
            let picture = RgbImage::read(&frame.preview)?;
            progress.advance(1)?;
            Ok(match self.encoder {
                Some(_) => picture,
                None => reduced(picture, WIDEST),
            })
        });
        match (&self.encoder, self.animation) {
            (Some(encoder), _) => encoder.write(&path, pictures, u32::from(RATE))?,
            (None, Animation::Gif) => write_gif(&path, pictures, u32::from(RATE))?,
            (None, _) => write_apng(&path, pictures, RATE)?,
        }
        progress.end();
        Ok(Some(path))
    }
}

/// Evenly spaced frames, small.
fn thumbnails(frames: &[FrameFile], progress: Progress<'_>) -> Result<Vec<(RgbImage, String)>> {
    let shown = frames.len().min(MOST_PICTURES);
    (0..shown)
        .map(|index| &frames[index * frames.len() / shown])
        .map(|frame| {
            progress.check()?;
            let picture = reduced(RgbImage::read(&frame.preview)?, THUMBNAIL);
            Ok((picture, format!("{}  {}", frame.number, frame.label)))
        })
        .collect()
}
