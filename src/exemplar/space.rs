//! The surface texton space (Tong 2002 §4): per level the texton map and the Gram matrix Φ; or,
//! for plain images, one feature vector per texel. In: a vocabulary, or a file. Out: the file
//! `NAME.space.npz`. Appearance vectors are not used beyond this stage: everything later needs only their dot products.
//! What the numbers of a feature vector are is in [`channels`], what else is known of
//! texels in [`controls`](super::controls).

use std::path::Path;

use ndarray::{Array2, ArrayView2, Ix2, Ix3, s};
use serde::{Deserialize, Serialize};
use serde_json::Value;

pub use crate::exemplar::space_level::{Features, SpaceLevel};

use crate::btf::texel_size::check_texel_mm;
use crate::error::{Error, Result};
use crate::exemplar::channels::{self, Channel, Channels};
use crate::exemplar::controls::Controls;
use crate::exemplar::space_level::{LARGEST, is_sound};
use crate::format::id::ContentId;
use crate::format::json::as_map;
use crate::format::npz;
use crate::grid::TexelGrid;
use crate::texton::gram::{RowVectors, gram_matrix};
use crate::texton::vocabulary::{Vocabulary, VocabularyLevel, label_image};

/// `format` in the file's `meta.json`.
pub const FORMAT: &str = "mesotex-space";
/// The version written, and the only one read.
pub const VERSION: u32 = 1;

/// All levels of an exemplar, finest first, and where it comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Space {
    /// Level 0 is the finest.
    pub levels: Vec<SpaceLevel>,
    /// What the numbers of feature vectors are; none for textons.
    pub channels: Channels,
    /// What else is known of the texels of each level; empty where there are no controls.
    pub controls: Vec<Controls>,
    /// This space's own id.
    pub id: ContentId,
    /// Side of a texel of level 0 in millimetres, where the sample says it.
    pub texel_mm: Option<f64>,
    /// The id of the sample it describes.
    pub sample: ContentId,
}

/// What the texels of a space carry, as `meta.json` says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SpaceKind {
    /// Texton labels and Gram matrices.
    Textons,
    /// Feature vectors.
    Features,
}

/// `meta.json`.
#[derive(Debug, Serialize, Deserialize)]
struct Meta {
    format: String,
    version: u32,
    kind: SpaceKind,
    tileable: bool,
    levels: usize,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    texel_mm: Option<f64>,
    sample: ContentId,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    textons: Option<ContentId>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    channels: Option<Value>,
    #[serde(skip_serializing)]
    id: Option<ContentId>,
}

/// The space of a vocabulary: the textons' dot products in place of their appearance vectors.
/// It has no id of its own until it is [written](Space::write).
pub fn space_of_vocabulary<C: RowVectors>(vocabulary: &Vocabulary<C>) -> Result<Space> {
    let levels = vocabulary.levels.iter().enumerate();
    Ok(Space {
        levels: levels.map(space_level).collect::<Result<_>>()?,
        channels: Channels::default(),
        controls: Vec::new(),
        id: ContentId::of_bytes(&[]),
        texel_mm: vocabulary.texel_mm,
        sample: vocabulary.sample.clone(),
    })
}

fn space_level<C: RowVectors>((at, level): (usize, &VocabularyLevel<C>)) -> Result<SpaceLevel> {
    let gram = with_default_texton(&gram_matrix(&level.centroids)?);
    match gram.iter().find(|value| !is_sound(**value)) {
        None => Ok(SpaceLevel {
            grid: level.grid,
            features: Features::Textons {
                labels: level.labels.clone(),
                gram,
            },
        }),
        Some(value) => Err(Error::data(
            format!("L{at}/centroids"),
            format!("a dot product of {value}"),
        )
        .expected(format!("at most {LARGEST:e}"))),
    }
}

/// Φ with one more row and column: the default texton, the plain mean of the textons.
fn with_default_texton(products: &Array2<f64>) -> Array2<f32> {
    let textons = products.nrows();
    let mut gram = Array2::zeros((textons + 1, textons + 1));
    let with_default: Vec<f64> = products
        .outer_iter()
        .map(|row| row.sum() / textons as f64)
        .collect();
    let default_squared = with_default.iter().sum::<f64>() / textons as f64;
    gram.slice_mut(s![..textons, ..textons])
        .assign(&products.mapv(|v| v as f32));
    for (texton, &v) in with_default.iter().enumerate() {
        gram[[texton, textons]] = v as f32;
        gram[[textons, texton]] = v as f32;
    }
    gram[[textons, textons]] = default_squared as f32;
    gram
}

impl Space {
    /// A space of plain images without an id: `levels` have the numbers as stored, unweighted.
    pub(super) fn of_channels(
        mut levels: Vec<SpaceLevel>,
        list: Vec<Channel>,
        controls: Vec<Controls>,
        sample: ContentId,
    ) -> Result<Self> {
        Ok(Self {
            channels: Channels::weigh(list, &mut levels)?,
            levels,
            controls,
            id: ContentId::of_bytes(&[]),
            texel_mm: None,
            sample,
        })
    }

    /// What the texels carry.
    pub fn kind(&self) -> SpaceKind {
        match self.levels.first().map(|level| &level.features) {
            Some(Features::Plain(_)) => SpaceKind::Features,
            _ => SpaceKind::Textons,
        }
    }

    /// Whether borders wrap.
    pub fn tileable(&self) -> bool {
        self.levels.first().is_some_and(|level| level.grid.tileable)
    }

    /// Writes the file; `textons` is the id of the vocabulary it came from, if any. The space
    /// takes the id of what was written.
    pub fn write(&mut self, path: &Path, textons: Option<&ContentId>) -> Result<()> {
        // Describe it.
        let meta = Meta {
            format: FORMAT.into(),
            version: VERSION,
            kind: self.kind(),
            tileable: self.tileable(),
            levels: self.levels.len(),
            texel_mm: self.texel_mm,
            sample: self.sample.clone(),
            textons: textons.cloned(),
            channels: self.stated_channels()?,
            id: None,
        };
        // Write the features and controls of each level.
        self.id = npz::write(path, as_map(&meta)?, |file| {
            for (at, level) in self.levels.iter().enumerate() {
                match &level.features {
                    Features::Textons { labels, gram } => {
                        file.array(&format!("L{at}/labels"), label_image(labels, level.grid)?)?;
                        file.array(&format!("L{at}/gram"), gram.view())?;
                    }
                    Features::Plain(features) => {
                        let features = self.channels.stored(at, features);
                        file.array(&format!("L{at}/features"), features.view())?;
                    }
                }
                if let Some(controls) = self.controls.get(at) {
                    controls.write(file, at)?;
                }
            }
            Ok(())
        })?;
        Ok(())
    }

    /// The field `channels` of `meta.json`.
    fn stated_channels(&self) -> Result<Option<Value>> {
        match self.channels.list() {
            [] => Ok(None),
            list => serde_json::to_value(list)
                .map(Some)
                .map_err(|error| Error::data("channels", error.to_string())),
        }
    }

    /// Reads a file and checks that its parts belong together.
    pub fn read(path: &Path) -> Result<Self> {
        let mut file = npz::Reader::open(path)?;
        let meta = read_meta(&mut file)?;
        let (mut levels, mut controls) = (Vec::new(), Vec::new());
        for at in 0..meta.levels {
            let level = match meta.kind {
                SpaceKind::Textons => read_textons(&mut file, at, meta.tileable)?,
                SpaceKind::Features => read_features(&mut file, at, meta.tileable)?,
            };
            check_pyramid(&file, levels.last(), &level, at)?;
            controls.push(Controls::read(&mut file, at, level.grid)?);
            levels.push(level);
        }
        if controls.iter().all(|level| *level == Controls::default()) {
            controls.clear();
        }
        let Some(id) = meta.id else {
            return Err(file.fault("meta.json: id", "missing"));
        };
        Ok(Self {
            channels: read_channels(&file, meta.kind, meta.channels.as_ref(), &mut levels)?,
            levels,
            controls,
            id,
            texel_mm: meta.texel_mm,
            sample: meta.sample,
        })
    }
}

fn read_meta(file: &mut npz::Reader) -> Result<Meta> {
    let head: Value = file.meta()?;
    let format = head.get("format").and_then(Value::as_str).unwrap_or("none");
    if format != FORMAT {
        return Err(file
            .fault("meta.json: format", format!("`{format}`"))
            .expected(format!("{FORMAT}, as `mesotex gram` writes it")));
    }
    let meta: Meta = file.meta()?;
    if meta.version != VERSION {
        return Err(file
            .fault("meta.json: version", meta.version.to_string())
            .expected(VERSION.to_string()));
    }
    check_texel_mm(file, meta.texel_mm)?;
    if !(1..=32).contains(&meta.levels) {
        return Err(file
            .fault("meta.json: levels", meta.levels.to_string())
            .expected("1 to 32"));
    }
    Ok(meta)
}

fn grid_of(height: usize, width: usize, tileable: bool) -> TexelGrid {
    TexelGrid {
        width: width as u32,
        height: height as u32,
        tileable,
    }
}

fn read_textons(file: &mut npz::Reader, at: usize, tileable: bool) -> Result<SpaceLevel> {
    let (labels_name, gram_name) = (format!("L{at}/labels"), format!("L{at}/gram"));
    let labels = file.array::<u16, Ix2>(&labels_name)?;
    let gram = file.array::<f32, Ix2>(&gram_name)?;
    let textons = gram.nrows().saturating_sub(1);
    if gram.nrows() != gram.ncols() || textons == 0 {
        return Err(file
            .fault(&gram_name, format!("shape {:?}", gram.shape()))
            .expected("a square: the textons and the default texton"));
    }
    check_gram(file, &gram_name, gram.view())?;
    if let Some(label) = labels.iter().find(|&&label| usize::from(label) >= textons) {
        return Err(file
            .fault(&labels_name, format!("label {label}"))
            .expected(format!(
                "labels below {textons}, the textons of {gram_name}"
            )));
    }
    Ok(SpaceLevel {
        grid: grid_of(labels.nrows(), labels.ncols(), tileable),
        features: Features::Textons {
            labels: labels.iter().copied().collect(),
            gram,
        },
    })
}

/// Dot products are finite and symmetric.
fn check_gram(file: &npz::Reader, name: &str, gram: ArrayView2<'_, f32>) -> Result<()> {
    let scale = gram
        .diag()
        .iter()
        .fold(0.0_f32, |largest, v| largest.max(v.abs()));
    for ((row, col), &value) in gram.indexed_iter() {
        let negative = row == col && value < 0.0;
        if !is_sound(value) || negative || (value - gram[[col, row]]).abs() > 1e-3 * scale {
            return Err(file
                .fault(name, format!("{value} at [{row}, {col}]"))
                .expected(format!(
                    "numbers up to {LARGEST:e}, the same at [i, j] and [j, i], none on the diagonal \
                     negative"
                )));
        }
    }
    Ok(())
}

fn read_features(file: &mut npz::Reader, at: usize, tileable: bool) -> Result<SpaceLevel> {
    let name = format!("L{at}/features");
    let features = file.array::<f32, Ix3>(&name)?;
    let (height, width, depth) = features.dim();
    if features.is_empty() {
        return Err(file
            .fault(&name, format!("shape [{height}, {width}, {depth}]"))
            .expected("at least one texel and one number per texel"));
    }
    let sound = |value: &&f32| is_sound(**value * **value);
    if let Some(value) = features.iter().find(|value| !sound(value)) {
        return Err(file
            .fault(&name, value.to_string())
            .expected(format!("numbers whose squares are at most {LARGEST:e}")));
    }
    Ok(SpaceLevel {
        grid: grid_of(height, width, tileable),
        features: Features::Plain(features),
    })
}

/// The channels that a file states, or those that one without such a statement is taken to have. The
/// levels come out weighted.
fn read_channels(
    file: &npz::Reader,
    kind: SpaceKind,
    stated: Option<&Value>,
    levels: &mut [SpaceLevel],
) -> Result<Channels> {
    let in_meta = |error| file.at("meta.json", error);
    let list = match (kind, stated) {
        (SpaceKind::Textons, None) => return Ok(Channels::default()),
        (SpaceKind::Textons, Some(_)) => {
            return Err(file
                .fault("meta.json: channels", "there")
                .expected("none in a space of textons"));
        }
        (SpaceKind::Features, Some(stated)) => {
            let depth = channels::depth_of(levels).map_err(in_meta)?;
            channels::parsing::parse(stated, depth).map_err(in_meta)?
        }
        (SpaceKind::Features, None) => channels::implied(levels),
    };
    match list.is_empty() {
        true => Ok(Channels::default()),
        false => Channels::weigh(list, levels).map_err(in_meta),
    }
}

/// Each level is half the one before, rounded up.
fn check_pyramid(
    file: &npz::Reader,
    finer: Option<&SpaceLevel>,
    level: &SpaceLevel,
    at: usize,
) -> Result<()> {
    let grid = level.grid;
    let expected = finer.map_or(grid, |finer| finer.grid.coarser());
    if grid == expected && !grid.is_empty() && u32::try_from(grid.len()).is_ok() {
        return Ok(());
    }
    Err(file
        .fault(
            &format!("L{at}"),
            format!("{} × {} texels", grid.height, grid.width),
        )
        .expected(format!("{} × {}", expected.height, expected.width)))
}

impl SpaceLevel {
    /// The feature of a sample that lies nowhere (plain images): the mean of all texels.
    pub fn default_feature(&self) -> Vec<f32> {
        let Features::Plain(features) = &self.features else {
            return Vec::new();
        };
        let depth = features.dim().2;
        let mut sums = vec![0.0_f64; depth];
        for texel in features.rows() {
            sums.iter_mut()
                .zip(texel)
                .for_each(|(sum, &v)| *sum += f64::from(v));
        }
        sums.iter()
            .map(|sum| (sum / self.grid.len() as f64) as f32)
            .collect()
    }
}

#[cfg(test)]
mod tests;
