//! What all `.btf` files begin with behind their signature: the measurement, the directions, the size, rotations.

use crate::btf::bonn::fields::Fields;
use crate::btf::bonn::output::Output;
use crate::btf::bonn::sampling::Sampling;
use crate::error::{Error, Result};

/// Bytes of each of the three fixed texts.
const TEXT: usize = 80;
/// Versions of the header that are read.
const VERSIONS: std::ops::RangeInclusive<u32> = 1..=4;
/// The version written.
pub const VERSION: u32 = 4;

/// What a file states about its measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Meta {
    /// Version of the header, 1 to 4: later ones say more.
    pub version: u32,
    /// What it was measured with.
    pub measurement_setup: String,
    /// The camera's sensor.
    pub image_sensor: String,
    /// The lamp.
    pub light_source: String,
    /// Texels per millimetre; 0 where unknown.
    pub pixels_per_mm: f32,
    /// Stated factors of R, G and B; no public reader applies them, nor does this one.
    pub rgb_scale: [f32; 3],
    /// Whether values have the cosine of the light's polar angle in them (version 2 on).
    pub has_cosine: bool,
    /// A description of the measurement in XML (version 3 on).
    pub xml: Vec<u8>,
    /// Names of the colour channels (version 4 on; R, G, B before).
    pub channels: Vec<String>,
}

impl Default for Meta {
    fn default() -> Self {
        Self {
            version: VERSION,
            measurement_setup: String::new(),
            image_sensor: String::new(),
            light_source: String::new(),
            pixels_per_mm: 0.0,
            rgb_scale: [1.0; 3],
            has_cosine: true,
            xml: Vec::new(),
            channels: rgb(),
        }
    }
}

fn rgb() -> Vec<String> {
    ["R", "G", "B"].map(str::to_owned).to_vec()
}

impl Meta {
    pub(super) fn read(fields: &mut Fields) -> Result<Self> {
        let start = fields.at();
        // Read what every version has.
        let size = fields.u32("header size")?;
        let version = fields.u32("header version")?;
        check_version(version)?;
        let mut meta = Self {
            version,
            measurement_setup: text(fields, "measurement setup")?,
            image_sensor: text(fields, "image sensor")?,
            light_source: text(fields, "light source")?,
            pixels_per_mm: fields.float_array::<1>("pixels per mm")?[0],
            rgb_scale: fields.float_array("rgb scale factor")?,
            has_cosine: false,
            ..Self::default()
        };
        // Read what later versions add.
        if version > 1 {
            meta.has_cosine = fields.u32("cosine flag")? != 0;
        }
        if version > 2 {
            let length = fields.u32("length of the XML")?;
            meta.xml = fields.bytes("XML", length.into())?;
        }
        if version > 3 {
            meta.channels = channel_names(fields)?;
        }
        // Check the stated size against what was read.
        match fields.at() - start {
            read if read == u64::from(size) => Ok(meta),
            read => Err(Error::data("header size", format!("{size} bytes"))
                .expected(format!("{read}, which its fields take"))),
        }
    }

    pub(super) fn write(&self, output: &mut Output<'_>) -> Result<()> {
        let mut bytes = Vec::new();
        for text in [
            &self.measurement_setup,
            &self.image_sensor,
            &self.light_source,
        ] {
            let mut fixed = text.as_bytes().to_vec();
            fixed.resize(TEXT, 0);
            bytes.extend(fixed);
        }
        let floats = [&[self.pixels_per_mm][..], &self.rgb_scale].concat();
        bytes.extend(floats.iter().flat_map(|float| float.to_le_bytes()));
        if self.version > 1 {
            bytes.extend(u32::from(self.has_cosine).to_le_bytes());
        }
        if self.version > 2 {
            add_counted(&mut bytes, &self.xml);
        }
        if self.version > 3 {
            bytes.extend((self.channels.len() as u32).to_le_bytes());
            for name in &self.channels {
                add_counted(&mut bytes, name.as_bytes());
            }
        }
        output.u32(bytes.len() + 8)?;
        output.u32(self.version as usize)?;
        output.bytes(&bytes)
    }

    /// Where red, green and blue are found among the channels.
    pub(super) fn rgb_channels(&self) -> Result<[usize; 3]> {
        let names: Vec<String> = self.channels.iter().map(|n| n.to_uppercase()).collect();
        let fault = |expected: &str| {
            let shown: Vec<&str> = self.channels.iter().take(8).map(String::as_str).collect();
            let more = if self.channels.len() > shown.len() {
                ", …"
            } else {
                ""
            };
            Error::data(
                "channels",
                format!("{} ({}{more})", self.channels.len(), shown.join(", ")),
            )
            .expected(expected)
        };
        match names.len() {
            1 => Ok([0; 3]),
            3 => {
                let mut sorted: Vec<&str> = names.iter().map(String::as_str).collect();
                sorted.sort_unstable();
                let in_order = names == ["R", "G", "B"];
                match sorted == ["B", "G", "R"] && !in_order {
                    true => Err(fault("R, G, B in this order")),
                    false => Ok([0, 1, 2]),
                }
            }
            _ => Err(fault(
                "3 channels, red, green and blue, or 1; spectral channels are not turned to RGB",
            )),
        }
    }
}

fn check_version(version: u32) -> Result<()> {
    if VERSIONS.contains(&version) {
        return Ok(());
    }
    Err(match VERSIONS.contains(&version.swap_bytes()) {
        true => big_endian("header version", version),
        false => Error::data("header version", version.to_string()).expected("1 to 4"),
    })
}

/// Says that a number makes sense in the other byte order alone.
pub(super) fn big_endian(field: &str, number: u32) -> Error {
    Error::data(field, number.to_string())
        .expected("little-endian numbers")
        .advice("the file has big-endian numbers, which no known program writes; convert it")
}

/// A text of fixed length, ended by a zero.
fn text(fields: &mut Fields, field: &str) -> Result<String> {
    let bytes = fields.bytes(field, TEXT as u64)?;
    let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(TEXT);
    Ok(String::from_utf8_lossy(&bytes[..end]).trim().to_owned())
}

fn channel_names(fields: &mut Fields) -> Result<Vec<String>> {
    let count = fields.u32("number of channels")?;
    if count == 0 || u64::from(count) > fields.left() / 4 {
        return Err(Error::data("number of channels", count.to_string())
            .expected(format!("1 to {}", fields.left() / 4)));
    }
    let name = |channel| {
        let field = format!("name of channel {channel}");
        let length = fields.u32(&field)?;
        let bytes = fields.bytes(&field, length.into())?;
        let name = String::from_utf8_lossy(&bytes);
        Ok(name.trim_matches(['\0', ' ']).to_owned())
    };
    (0..count).map(name).collect()
}

fn add_counted(bytes: &mut Vec<u8>, text: &[u8]) {
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(text);
}

/// All that precedes the body.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// The measurement.
    pub meta: Meta,
    /// The directions.
    pub sampling: Sampling,
    /// Columns of the texel grid.
    pub width: u32,
    /// Rows of the texel grid.
    pub height: u32,
    /// Rotations into local frames, row-major; empty where there are none.
    pub rotations: Vec<[f32; 9]>,
}

impl Header {
    /// Reads the header of all formats but BDI, whose fields have another order.
    pub(super) fn read(
        fields: &mut Fields,
        has_rotations: bool,
        notes: &mut Vec<String>,
    ) -> Result<Self> {
        let meta = Meta::read(fields)?;
        let sampling = Sampling::read(fields, notes)?;
        let [width, height] = read_size(fields)?;
        let rotations = match has_rotations {
            true => read_rotations(fields)?,
            false => Vec::new(),
        };
        Ok(Self {
            meta,
            sampling,
            width,
            height,
            rotations,
        })
    }

    pub(super) fn write(&self, output: &mut Output<'_>, has_rotations: bool) -> Result<()> {
        self.meta.write(output)?;
        self.sampling.write(output)?;
        output.u32(self.width as usize)?;
        output.u32(self.height as usize)?;
        match has_rotations {
            true => self.write_rotations(output),
            false => Ok(()),
        }
    }

    pub(super) fn write_rotations(&self, output: &mut Output<'_>) -> Result<()> {
        output.u32(self.rotations.len())?;
        output.floats(self.rotations.as_flattened())
    }

    /// Texels of an image.
    pub fn texels(&self) -> usize {
        self.width as usize * self.height as usize
    }
}

/// Columns and rows.
pub(super) fn read_size(fields: &mut Fields) -> Result<[u32; 2]> {
    let size = [fields.u32("width")?, fields.u32("height")?];
    let [width, height] = size.map(u64::from);
    match width * height {
        0 => Err(Error::data("size", format!("{width} × {height}")).expected("at least one texel")),
        texels if texels > u64::from(u32::MAX) => {
            Err(Error::data("size", format!("{width} × {height}"))
                .expected("fewer than 2^32 texels"))
        }
        _ => Ok(size),
    }
}

pub(super) fn read_rotations(fields: &mut Fields) -> Result<Vec<[f32; 9]>> {
    let count = fields.u32("number of rotations")?;
    let numbers = fields.floats("rotations", u64::from(count) * 9)?;
    Ok(numbers.as_chunks::<9>().0.to_vec())
}
