//! BDI: all numbers as halves, texel by texel.
//!
//! Behind measurement and directions: u32 width, u32 height, u32 scan lines per chunk, u8 compression (0 all texels,
//! 1 all texels with bzip2, 2 the texels of the mask), u8 mask \[width\]\[height\], u32 rotations and their numbers.
//! Then chunks of this many scan lines' texels: u32 bytes, and per texel \[view\]\[light\]\[channel\]. Texels are
//! stored row by row. The last chunk may be short, or filled up.
//!
//! btflib reads the mask column by column, and writes it row by row; the two agree where no texel is missing. Here it
//! is read and written column by column, since only the reader has met files of others.

use std::io::{Read, Write};
use std::ops::Range;
use std::path::Path;

use bzip2::read::BzDecoder;
use bzip2::write::BzEncoder;
use half::f16;
use rayon::prelude::*;

use crate::btf::bonn::body::Body;
use crate::btf::bonn::fields::Fields;
use crate::btf::bonn::header::{Header, Meta, read_rotations, read_size};
use crate::btf::bonn::output::Output;
use crate::btf::bonn::sampling::Sampling;
use crate::btf::bonn::scalar::Scalar;
use crate::btf::import::Region;
use crate::error::{Error, Result};
use crate::format::nameless::{Nameless, NamelessWriter};
use crate::format::positioned::PositionedFile;

/// What chunks packed with bzip2 may expand to, in bytes per byte of the file, and besides.
const EXPANSION: (u64, u64) = (256, 32 << 20);
/// A mask may leave out all but one of this many texels.
const MOST_MISSING: usize = 256;

/// Which texels a file has, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    /// 0: all texels.
    Full,
    /// 1: all texels, each chunk packed with bzip2.
    Bzip,
    /// 2: the texels of the mask.
    Sparse,
}

impl Compression {
    fn of_number(number: u8) -> Result<Self> {
        match number {
            0 => Ok(Self::Full),
            1 => Ok(Self::Bzip),
            2 => Ok(Self::Sparse),
            other => Err(Error::data("compression", other.to_string())
                .expected("0 (full), 1 (bzip2) or 2 (sparse)")),
        }
    }

    fn number(self) -> u8 {
        match self {
            Self::Full => 0,
            Self::Bzip => 1,
            Self::Sparse => 2,
        }
    }
}

/// The texels of a file.
pub(super) struct Bdi {
    store: Store,
    /// Texels per chunk.
    per_chunk: usize,
    /// The stored texels that are read, in order.
    stored: Vec<StoredTexel>,
    width: usize,
    images: usize,
    texels: usize,
    lights: usize,
    channels: usize,
    rgb: [usize; 3],
}

/// A texel that is read.
#[derive(Clone, Copy)]
struct StoredTexel {
    /// Its place among those of the file.
    place: usize,
    /// Where it lies in an image.
    texel: usize,
}

/// Where the halves are.
enum Store {
    /// In the file, each chunk from a place on.
    InFile(PositionedFile, Vec<u64>),
    /// Unpacked, chunk after chunk.
    Unpacked(Nameless<f16>),
}

/// Reads everything behind the signature; the texels stay in the file, or are unpacked in `folder`.
pub(super) fn read(
    fields: &mut Fields,
    folder: &Path,
    notes: &mut Vec<String>,
) -> Result<(Header, Bdi)> {
    // Read the header.
    let meta = Meta::read(fields)?;
    let rgb = meta.rgb_channels()?;
    let sampling = Sampling::read(fields, notes)?;
    let [width, height] = read_size(fields)?;
    let lines = fields.u32("scan lines per chunk")?;
    let compression = Compression::of_number(fields.u8("compression")?)?;
    let mask = fields.bytes("mask", u64::from(width) * u64::from(height))?;
    let header = Header {
        meta,
        sampling,
        width,
        height,
        rotations: read_rotations(fields)?,
    };
    // Find which texels are stored, and where their chunks lie.
    let stored = stored_texels(&mask, &header, compression, notes)?;
    let chunks = Chunks::of(&header, lines, stored.len())?;
    // Unpack compressed chunks once; others stay in the file.
    let store = match compression {
        Compression::Bzip => Store::Unpacked(chunks.unpack(fields, folder)?),
        Compression::Full | Compression::Sparse => {
            Store::InFile(fields.file().clone(), chunks.find(fields)?)
        }
    };
    fields.end()?;
    let places = stored.iter().enumerate();
    let bdi = Bdi {
        store,
        per_chunk: chunks.per_chunk,
        stored: places
            .map(|(place, &texel)| StoredTexel {
                place,
                texel: texel as usize,
            })
            .collect(),
        width: width as usize,
        images: header.sampling.images(),
        texels: header.texels(),
        lights: header.sampling.lights.len(),
        channels: header.meta.channels.len(),
        rgb,
    };
    Ok((header, bdi))
}

/// The texels that a file has, row by row.
fn stored_texels(
    mask: &[u8],
    header: &Header,
    compression: Compression,
    notes: &mut Vec<String>,
) -> Result<Vec<u32>> {
    let all = header.texels();
    if compression != Compression::Sparse {
        return Ok((0..all as u32).collect());
    }
    let is_stored = |texel: &u32| {
        let (row, column) = (texel / header.width, texel % header.width);
        mask[(column * header.height + row) as usize] != 0
    };
    let stored: Vec<u32> = (0..all as u32).filter(is_stored).collect();
    if stored.len() < all.div_ceil(MOST_MISSING) {
        return Err(
            Error::data("mask", format!("{} of {all} texels", stored.len()))
                .expected(format!("at least one of {MOST_MISSING}")),
        );
    }
    if stored.len() < all {
        notes.push(format!(
            "{} of {all} texels are missing in the file and are black; its mask is read column by column",
            all - stored.len()
        ));
    }
    Ok(stored)
}

/// What the chunks of a file must be.
struct Chunks {
    texel_bytes: u64,
    per_chunk: usize,
    /// Texels of a chunk that is filled up.
    full: u64,
    stored: usize,
}

impl Chunks {
    fn of(header: &Header, lines: u32, stored: usize) -> Result<Self> {
        let full = u64::from(lines) * u64::from(header.width);
        if full == 0 {
            return Err(Error::data("scan lines per chunk", "0").expected("at least 1"));
        }
        let numbers = header.sampling.images() as u64 * 2;
        let texel_bytes = numbers.checked_mul(header.meta.channels.len() as u64);
        let texel_bytes = texel_bytes.ok_or_else(|| {
            Error::data("numbers of a texel", "2^63 or more").expected("fewer than the file has")
        })?;
        Ok(Self {
            texel_bytes,
            per_chunk: full.min(stored as u64) as usize,
            full,
            stored,
        })
    }

    /// The texels of each chunk.
    fn texels(&self) -> impl Iterator<Item = u64> {
        let (stored, each) = (self.stored, self.per_chunk);
        (0..stored.div_ceil(each)).map(move |chunk| each.min(stored - chunk * each) as u64)
    }

    /// Where each chunk begins.
    fn find(&self, fields: &mut Fields) -> Result<Vec<u64>> {
        let mut places = Vec::new();
        for (chunk, texels) in self.texels().enumerate() {
            let place = format!("chunk {chunk}");
            let bytes = u64::from(fields.u32(&format!("{place}: size"))?);
            let least = texels.checked_mul(self.texel_bytes);
            let most = self.full.saturating_mul(self.texel_bytes);
            if least.is_none_or(|least| bytes < least) || bytes > most {
                return Err(
                    Error::data(format!("{place}: size"), format!("{bytes} bytes")).expected(
                        format!(
                            "{} bytes for {texels} texels, or at most {most} filled up",
                            least.unwrap_or(u64::MAX)
                        ),
                    ),
                );
            }
            places.push(fields.pass(&place, Some(bytes), 1)?);
        }
        Ok(places)
    }

    /// Unpacks all chunks into a file without a name.
    fn unpack(&self, fields: &mut Fields, folder: &Path) -> Result<Nameless<f16>> {
        let io = |action| Error::io(folder, action);
        // Refuse chunks that would expand beyond all reason.
        let most = fields
            .file()
            .length()
            .saturating_mul(EXPANSION.0)
            .saturating_add(EXPANSION.1);
        let needed = (self.stored as u64).checked_mul(self.texel_bytes);
        if needed.is_none_or(|needed| needed > most) {
            return Err(Error::data("bzip2", "chunks that expand too far")
                .expected(format!("at most {most} bytes for a file of this length")));
        }
        // Unpack chunk after chunk, a texel at a time.
        let mut writer = NamelessWriter::create_in(folder).map_err(io("write"))?;
        for (chunk, texels) in self.texels().enumerate() {
            let place = format!("chunk {chunk}");
            let length = fields.u32(&format!("{place}: size"))?;
            let packed = fields.bytes(&place, length.into())?;
            let mut decoder = BzDecoder::new(&packed[..]);
            let mut texel = vec![0; self.texel_bytes as usize];
            for _ in 0..texels {
                decoder.read_exact(&mut texel).map_err(|error| {
                    Error::data(format!("{place}: bzip2"), error.to_string())
                        .expected(format!("{texels} texels of {} bytes", self.texel_bytes))
                        .advice("the file is truncated or damaged")
                })?;
                let (words, _) = texel.as_chunks::<2>();
                let halves: Vec<f16> = words.iter().map(|w| f16::from_le_bytes(*w)).collect();
                writer.write(&halves).map_err(io("write"))?;
            }
        }
        writer.finish().map_err(io("read"))
    }
}

impl Bdi {
    /// The same with the texels of a region alone.
    pub(super) fn cropped(self, region: Region) -> Self {
        let (left, top) = (region.left as usize, region.top as usize);
        let (width, height) = (region.width as usize, region.height as usize);
        let inside = |stored: &StoredTexel| {
            let (row, column) = (stored.texel / self.width, stored.texel % self.width);
            let (row, column) = (row.checked_sub(top)?, column.checked_sub(left)?);
            (row < height && column < width).then_some(StoredTexel {
                place: stored.place,
                texel: row * width + column,
            })
        };
        Self {
            stored: self.stored.iter().filter_map(inside).collect(),
            width,
            texels: width * height,
            ..self
        }
    }

    /// Fills `halves` with the numbers of a stored texel for a run of images.
    fn texel(&self, place: usize, images: &Range<usize>, halves: &mut [f16]) -> Result<()> {
        let numbers = self.images * self.channels;
        let first = images.start * self.channels;
        match &self.store {
            Store::Unpacked(all) => {
                let start = place * numbers + first;
                halves.copy_from_slice(&all.as_slice()[start..start + halves.len()]);
                Ok(())
            }
            Store::InFile(file, chunks) => {
                let (chunk, inside) = (place / self.per_chunk, place % self.per_chunk);
                let at = chunks[chunk] + 2 * (inside * numbers + first) as u64;
                let mut bytes = vec![0; halves.len() * 2];
                file.read_at(at, &mut bytes)?;
                let (words, _) = bytes.as_chunks::<2>();
                let pairs = halves.iter_mut().zip(words);
                pairs.for_each(|(half, word)| *half = f16::from_le_bytes(*word));
                Ok(())
            }
        }
    }

    fn check(&self, texel: usize, first_image: usize, halves: &[f16]) -> Result<()> {
        let Some(at) = halves.iter().position(|half| !half.is_finite()) else {
            return Ok(());
        };
        let image = first_image + at / self.channels;
        Err(Error::data(
            format!(
                "view {}, light {}, row {}, column {}",
                image / self.lights,
                image % self.lights,
                texel / self.width,
                texel % self.width
            ),
            halves[at].to_string(),
        )
        .expected("a finite number"))
    }
}

impl Body for Bdi {
    /// Texels are far apart in the file: the fewer runs, the less is read.
    fn run_bytes(&self) -> usize {
        256 << 20
    }

    fn read(&self, images: Range<usize>, out: &mut [f32]) -> Result<()> {
        let numbers = images.len() * self.channels;
        let mut halves = vec![f16::ZERO; self.stored.len() * numbers];
        halves
            .par_chunks_mut(numbers)
            .zip(&self.stored)
            .try_for_each(|(halves, stored)| {
                self.texel(stored.place, &images, halves)?;
                self.check(stored.texel, images.start, halves)
            })?;
        let per_image = out.par_chunks_mut(self.texels * 3).enumerate();
        per_image.for_each(|(image, out)| {
            out.fill(0.0);
            for (at, stored) in self.stored.iter().enumerate() {
                let from = at * numbers + image * self.channels;
                for (out, channel) in out[stored.texel * 3..].iter_mut().zip(self.rgb) {
                    *out = halves[from + channel].to_f32();
                }
            }
        });
        Ok(())
    }
}

/// Fills numbers with those of a run of texels.
type ReadTexels<'a> = dyn Fn(&[u32], &mut [f32]) -> Result<()> + 'a;

/// What a BDI file is written from.
pub struct BdiContent<'a> {
    /// All that precedes the body.
    pub header: &'a Header,
    /// Which texels are written, and how.
    pub compression: Compression,
    /// Scan lines of a chunk; btflib writes 4.
    pub lines: u32,
    /// Whether each texel is there, row by row.
    pub mask: &'a [bool],
    /// Fills numbers with a run of stored texels, \[texel\]\[image\]\[channel\].
    pub texels: &'a ReadTexels<'a>,
}

impl BdiContent<'_> {
    /// Writes everything behind the signature.
    pub(super) fn write(&self, output: &mut Output<'_>) -> Result<()> {
        let header = self.header;
        header.meta.write(output)?;
        header.sampling.write(output)?;
        output.u32(header.width as usize)?;
        output.u32(header.height as usize)?;
        output.u32(self.lines as usize)?;
        output.u8(self.compression.number())?;
        let (width, height) = (header.width as usize, header.height as usize);
        for column in 0..width {
            let bytes: Vec<u8> = (0..height)
                .map(|row| u8::from(self.mask[row * width + column]))
                .collect();
            output.bytes(&bytes)?;
        }
        header.write_rotations(output)?;
        let is_stored =
            |texel: &u32| self.compression != Compression::Sparse || self.mask[*texel as usize];
        let stored: Vec<u32> = (0..header.texels() as u32).filter(is_stored).collect();
        let per_chunk = self.lines as usize * width;
        stored
            .chunks(per_chunk)
            .try_for_each(|texels| self.write_chunk(output, texels))
    }

    /// Writes a chunk, its texels a scan line at a time.
    fn write_chunk(&self, output: &mut Output<'_>, texels: &[u32]) -> Result<()> {
        let header = self.header;
        let numbers = header.sampling.images() * header.meta.channels.len();
        let is_packed = self.compression == Compression::Bzip;
        if !is_packed {
            output.u32(texels.len() * numbers * 2)?;
        }
        let mut packed = BzEncoder::new(Vec::new(), bzip2::Compression::default());
        for run in texels.chunks(header.width as usize) {
            let mut values = vec![0.0; run.len() * numbers];
            (self.texels)(run, &mut values)?;
            let mut bytes = Vec::with_capacity(values.len() * 2);
            Scalar::Half.encode("values", &values, &mut bytes)?;
            match is_packed {
                true => packed.write_all(&bytes).map_err(pack_error)?,
                false => output.bytes(&bytes)?,
            }
        }
        if is_packed {
            let bytes = packed.finish().map_err(pack_error)?;
            output.u32(bytes.len())?;
            output.bytes(&bytes)?;
        }
        Ok(())
    }
}

fn pack_error(source: std::io::Error) -> Error {
    Error::io(Path::new("bzip2"), "pack")(source)
}
