//! Moving previews as video, by the `ffmpeg` of the machine.
//!
//! Pictures are handed over as bytes, 8-bit sRGB, and encoded with the matrix of Rec. 709 and one thread, without marks
//! of time or version: one version of `ffmpeg` writes the same bytes every time.

use std::fs::File;
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use crate::error::{Error, Result};
use crate::format::rgb_image::RgbImage;
use crate::report::animation::{Pictures, write_pictures};

/// Files of video.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Container {
    /// MPEG-4: H.264 where the machine has an encoder of it.
    Mp4,
    /// WebM: VP9 where the machine has an encoder of it.
    Webm,
}

/// An encoder by the name that `ffmpeg` gives it, and what asks it for a high quality.
type Codec = (&'static str, &'static [&'static str]);

impl Container {
    /// What a message, and `ffmpeg`, calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mp4 => "mp4",
            Self::Webm => "webm",
        }
    }

    /// Encoders, the best first.
    fn codecs(self) -> &'static [Codec] {
        match self {
            Self::Mp4 => &[
                ("libx264", &["-crf", "18"]),
                ("libopenh264", &["-b:v", "12M"]),
                ("mpeg4", &["-q:v", "2"]),
            ],
            Self::Webm => &[
                ("libvpx-vp9", &["-crf", "24", "-b:v", "0"]),
                ("libvpx", &["-crf", "8", "-b:v", "12M"]),
            ],
        }
    }
}

/// Even sides, for colour at half the resolution, and colours by the matrix of Rec. 709 and the curve of sRGB, said to
/// players.
const FILTERS: &str = "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,\
    setparams=range=tv:colorspace=bt709:color_primaries=bt709:color_trc=iec61966-2-1";

/// An `ffmpeg` that writes one kind of video.
#[derive(Clone, Debug)]
pub struct VideoEncoder {
    program: PathBuf,
    container: Container,
    codec: Codec,
}

impl VideoEncoder {
    /// Asks `program` whether it has an encoder for a container.
    pub fn find(program: &Path, container: Container) -> Result<Self> {
        let refused = |found: String| {
            Error::option(
                "animation",
                format!("{}: {found}", container.name()),
                "gif or apng, which need no other program, or an ffmpeg on the PATH with an encoder of it \
                 (Debian: apt-get install ffmpeg)",
            )
        };
        let mut asked = Command::new(program);
        let asked = asked
            .args(["-hide_banner", "-encoders"])
            .stdin(Stdio::null());
        let told = match asked.output() {
            Ok(told) if told.status.success() => told.stdout,
            Ok(told) => {
                return Err(refused(format!(
                    "{} fails: {}",
                    program.display(),
                    told.status
                )));
            }
            Err(error) => {
                return Err(refused(format!(
                    "{} does not run: {error}",
                    program.display()
                )));
            }
        };
        let told = String::from_utf8_lossy(&told);
        // Lines as " V....D libx264              H.264 / AVC".
        let known: Vec<&str> = told
            .lines()
            .filter_map(|line| line.split_whitespace().nth(1))
            .collect();
        let codecs = container.codecs();
        let codec = codecs.iter().find(|(name, _)| known.contains(name));
        match codec {
            Some(&codec) => Ok(Self {
                program: program.to_path_buf(),
                container,
                codec,
            }),
            None => {
                let names: Vec<&str> = codecs.iter().map(|(name, _)| *name).collect();
                let none = format!("{} has none of {}", program.display(), names.join(", "));
                Err(refused(none))
            }
        }
    }

    /// Writes pictures of equal size as a video, `rate` of them per second.
    pub fn write(
        &self,
        path: &Path,
        pictures: impl Iterator<Item = Result<RgbImage>>,
        rate: u32,
    ) -> Result<()> {
        write_pictures(path, pictures, |sink, pictures| {
            self.fill(sink.get_ref().path(), pictures, rate)
        })
    }

    fn fill(&self, path: &Path, pictures: &mut Pictures<'_>, rate: u32) -> io::Result<()> {
        let Some(first) = pictures.next().transpose()? else {
            return Err(io::Error::other("no image to show"));
        };
        let mut complaints = tempfile::tempfile()?;
        let mut command = self.command(&first, rate);
        let mut running = command
            .arg(path)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(complaints.try_clone()?)
            .spawn()?;
        let sent = send(&mut running, first, pictures);
        // A broken pipe is what an encoder leaves that gave up: it says why itself.
        let is_own = |error: &io::Error| error.kind() != io::ErrorKind::BrokenPipe;
        if sent.as_ref().is_err_and(is_own) {
            running.kill()?;
        }
        let ended = running.wait()?;
        match sent {
            Err(error) if is_own(&error) => Err(error),
            Ok(()) if ended.success() => Ok(()),
            _ => Err(io::Error::other(format!(
                "{} fails: {}",
                self.program.display(),
                last_line(&mut complaints)?
            ))),
        }
    }

    /// The program and what it is told, but for the file to write.
    fn command(&self, picture: &RgbImage, rate: u32) -> Command {
        let (codec, quality) = self.codec;
        let [size, rate] = [
            format!("{}x{}", picture.width, picture.height),
            rate.to_string(),
        ];
        let mut command = Command::new(&self.program);
        command
            .args(["-hide_banner", "-loglevel", "error", "-y"])
            .args(["-f", "rawvideo", "-pixel_format", "rgb24"])
            .args(["-video_size", &size, "-framerate", &rate, "-i", "pipe:0"])
            .args(["-vf", FILTERS, "-pix_fmt", "yuv420p"])
            .args(["-c:v", codec])
            .args(quality)
            .args([
                "-threads",
                "1",
                "-fflags",
                "+bitexact",
                "-flags:v",
                "+bitexact",
            ]);
        if self.container == Container::Mp4 {
            // What a player needs first stands first.
            command.args(["-movflags", "+faststart"]);
        }
        command.args(["-f", self.container.name()]);
        command
    }
}

/// Hands all pictures over, and says that these are all.
fn send(running: &mut Child, first: RgbImage, pictures: &mut Pictures<'_>) -> io::Result<()> {
    let Some(mut pipe) = running.stdin.take() else {
        return Err(io::ErrorKind::BrokenPipe.into());
    };
    let [width, height] = [first.width, first.height];
    for picture in [Ok(first)].into_iter().chain(pictures) {
        let picture = picture?;
        if [picture.width, picture.height] != [width, height] {
            return Err(io::Error::other("images of different sizes"));
        }
        pipe.write_all(&picture.pixels)?;
    }
    Ok(())
}

fn last_line(file: &mut File) -> io::Result<String> {
    let mut bytes = Vec::new();
    file.rewind()?;
    file.read_to_end(&mut bytes)?;
    let text = String::from_utf8_lossy(&bytes);
    let said = text.lines().rev().find(|line| !line.trim().is_empty());
    Ok(said.unwrap_or("no reason given").trim().to_owned())
}
