//! Small `.btf` files of every kind, made by code.
#![allow(dead_code, reason = "every test program uses its own part")]

use std::fs;
use std::path::Path;
use std::sync::Arc;

use mesotex::btf::DirectionSet;
use mesotex::btf::bonn::{
    BdiContent, Channel, Color, ColorModel, Compression, DfmfContent, ExtraHeader, FmfContent,
    Header, Meta, PvfContent, SIGNATURES, Sampling, Scalar, Signature, View, Written, encode,
};
use ndarray::Array2;

pub const VIEWS: usize = 3;
pub const LIGHTS: usize = 4;
pub const IMAGES: usize = VIEWS * LIGHTS;
pub const WIDTH: usize = 5;
pub const HEIGHT: usize = 3;
pub const TEXELS: usize = WIDTH * HEIGHT;
pub const RANK: usize = 3;

pub fn signature(text: &str) -> Signature {
    let found = SIGNATURES.iter().find(|signature| signature.text == text);
    *found.unwrap()
}

pub fn directions(set: &str) -> Vec<mesotex::btf::Direction> {
    set.parse::<DirectionSet>().unwrap().directions().unwrap()
}

/// A header with the cosine in the values.
pub fn header() -> Header {
    Header {
        meta: Meta {
            measurement_setup: "dome".into(),
            image_sensor: "camera".into(),
            light_source: "lamps".into(),
            pixels_per_mm: 4.0,
            ..Meta::default()
        },
        sampling: Sampling {
            views: directions("rings:0:1,40:2"),
            lights: directions("rings:20:4"),
        },
        width: WIDTH as u32,
        height: HEIGHT as u32,
        rotations: Vec::new(),
    }
}

/// Numbers from 0 to 1 that every type holds exactly.
pub fn numbers(rows: usize, columns: usize, seed: usize) -> Array2<f32> {
    Array2::from_shape_fn((rows, columns), |(r, c)| {
        ((r * 37 + c * 11 + r * c * 5 + seed * 23) % 64) as f32 / 64.0
    })
}

/// The factors of three channels; the last two have fewer components.
pub fn channels() -> Vec<Channel> {
    let channel = |at: usize| Channel {
        directions: Arc::new(numbers(IMAGES, RANK - at / 2, at)),
        eigentextures: Arc::new(numbers(TEXELS, RANK - at / 2, at + 7)),
    };
    (0..3).map(channel).collect()
}

/// The value of a channel from its factors.
pub fn product(channel: &Channel, image: usize, texel: usize) -> f64 {
    let rank = channel.rank();
    let (mut u, mut e) = (vec![0.0; rank], vec![0.0; rank]);
    channel.directions.read(image..image + 1, &mut u).unwrap();
    channel
        .eigentextures
        .read(texel..texel + 1, &mut e)
        .unwrap();
    u.iter().zip(&e).map(|(u, e)| f64::from(u * e)).sum()
}

pub fn bytes_of(signature: &Signature, content: Written<'_>) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.btf");
    encode(&path, signature, content).unwrap();
    fs::read(path).unwrap()
}

pub struct Dfmf {
    pub signature: &'static str,
    pub header: Header,
    pub color: Color,
    pub scalar: Scalar,
    pub transposed: bool,
}

impl Default for Dfmf {
    fn default() -> Self {
        Self {
            signature: "!DFMF08FCR",
            header: header(),
            color: Color::of(ColorModel::Rgb),
            scalar: Scalar::Half,
            transposed: false,
        }
    }
}

impl Dfmf {
    pub fn bytes(&self) -> Vec<u8> {
        let channels = channels();
        let content = DfmfContent {
            header: &self.header,
            color: self.color,
            channels: &channels,
            scalar: self.scalar,
            transposed: self.transposed,
        };
        bytes_of(&signature(self.signature), Written::Dfmf(content))
    }
}

/// The pair of factors of an FMF file: rows (image, channel) and texels, or (texel, channel) and images.
pub fn pair(transposed: bool) -> [Array2<f32>; 2] {
    match transposed {
        false => [numbers(IMAGES * 3, RANK, 1), numbers(TEXELS, RANK, 2)],
        true => [numbers(TEXELS * 3, RANK, 3), numbers(IMAGES, RANK, 4)],
    }
}

pub fn fmf(
    text: &str,
    header: &Header,
    extra: Option<(u8, &ExtraHeader)>,
    scalar: Scalar,
    transposed: bool,
) -> Vec<u8> {
    let [left, right] = pair(transposed);
    let content = FmfContent {
        header,
        extra,
        left: &left,
        right: &right,
        scalar,
    };
    bytes_of(&signature(text), Written::Fmf(content))
}

/// The numbers of a view of a PVF file, with weights per light instead of per texel.
pub fn view(at: usize, per_light: bool) -> View {
    let (dimension, rows) = match per_light {
        false => (LIGHTS * 3, TEXELS),
        true => (TEXELS * 3, LIGHTS),
    };
    View {
        mean: numbers(dimension, 1, at).into_raw_vec_and_offset().0,
        components: numbers(dimension, RANK, at + 1),
        weights: numbers(rows, RANK, at + 5),
    }
}

pub fn pvf(text: &str, header: &Header, scalar: Scalar, per_light: bool, legacy: bool) -> Vec<u8> {
    let mut view = |at| Ok(view(at, per_light));
    let content = PvfContent {
        header,
        rank: RANK,
        view: &mut view,
        scalar,
        legacy,
    };
    bytes_of(&signature(text), Written::Pvf(content))
}

/// The number of a BDI file.
pub fn number(texel: usize, image: usize, channel: usize) -> f32 {
    (texel * IMAGES * 3 + image * 3 + channel) as f32 / 1024.0
}

pub fn bdi(header: &Header, compression: Compression, lines: u32, mask: &[bool]) -> Vec<u8> {
    let texels = |texels: &[u32], out: &mut [f32]| {
        let numbers = texels.iter().flat_map(|&texel| {
            let of_texel = (0..IMAGES).flat_map(move |image| (0..3).map(move |c| (image, c)));
            of_texel.map(move |(image, channel)| number(texel as usize, image, channel))
        });
        out.iter_mut().zip(numbers).for_each(|(out, v)| *out = v);
        Ok(())
    };
    let content = BdiContent {
        header,
        compression,
        lines,
        mask,
        texels: &texels,
    };
    bytes_of(&signature("!BDIF06R2!"), Written::Bdi(content))
}

/// A file of each kind.
pub fn all() -> Vec<Vec<u8>> {
    let header = header();
    let mut old = header.clone();
    (old.meta.version, old.meta.has_cosine) = (1, false);
    let mut turned = header.clone();
    turned.rotations = vec![[0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0]; TEXELS];
    let extra = ExtraHeader {
        dynamic_range_reduction: 1,
        height_map: Some((vec![0.5; TEXELS], WIDTH as u32)),
    };
    let log = Dfmf {
        color: Color::of(ColorModel::LogYRatios),
        ..Dfmf::default()
    };
    let mut mask = vec![true; TEXELS];
    mask[7] = false;
    vec![
        Dfmf::default().bytes(),
        log.bytes(),
        fmf("!FMF06FC", &old, None, Scalar::Double, true),
        fmf(
            "!FMF12FCER",
            &header,
            Some((2, &extra)),
            Scalar::Half,
            false,
        ),
        pvf("!PVF06FCR", &turned, Scalar::Single, false, false),
        pvf("!PVF06FC", &old, Scalar::Half, true, true),
        bdi(&header, Compression::Sparse, 2, &mask),
        bdi(&header, Compression::Bzip, 4, &mask),
        bdi(&header, Compression::Full, 1, &mask),
    ]
}

/// Imports a file beside itself.
pub fn import(path: &Path) -> mesotex::error::Result<()> {
    use mesotex::btf::bonn::{BonnImport, BonnOptions};
    let target = path.with_extension("sample");
    let import = BonnImport {
        path,
        options: &mesotex::btf::import::ImportOptions::default(),
        bonn: &BonnOptions::default(),
        handedness: mesotex::btf::import::Handedness::Right,
        seed: 0,
        destination: target.as_path().into(),
        progress: mesotex::progress::Progress::silent(),
    };
    import.run().map(drop)
}

/// Bytes of the channels of a DFMF file of halves.
pub fn channels_length() -> usize {
    let of = |channel: &Channel| 13 + 2 * channel.rank() * (1 + IMAGES + TEXELS);
    channels().iter().map(of).sum()
}
