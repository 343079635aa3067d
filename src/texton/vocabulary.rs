//! The texton vocabulary, `NAME.textons.npz`: per level the texton map and the textons' appearance
//! vectors; the images they were seen in and the filters they were seen through.

use std::path::Path;

use ndarray::{Array2, Array3, ArrayView2, Ix1, Ix2, Ix3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::btf::texel_size::check_texel_mm;
use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::json::as_map;
use crate::format::npz;
use crate::format::stored_array::StoredArray;
use crate::grid::TexelGrid;
use crate::texton::row_blocks::RowBlocks;

/// `format` in the file's `meta.json`.
pub const FORMAT: &str = "mesotex-textons";
/// The version written, and the only one read.
pub const VERSION: u32 = 1;

/// Numbers that one task checks.
const CHECKED: usize = 1 << 16;
/// The largest number of an appearance vector: dot products of a million of them stay far below the
/// largest `f32`. Measured ones are below 10⁵.
const LARGEST: f32 = 1e12;

/// The vocabulary of one level.
#[derive(Clone, Debug, PartialEq)]
pub struct VocabularyLevel<Centroids = Array2<f32>> {
    /// The texel grid.
    pub grid: TexelGrid,
    /// Label of each texel: the nearest centroid. Flat index row · width + column.
    pub labels: Vec<u16>,
    /// Appearance vectors [textons, D]: means of their members.
    pub centroids: Centroids,
    /// Members of each texton, none 0.
    pub counts: Vec<u32>,
    /// Sum of squared distances of all texels to their centroid.
    pub inertia: f64,
    /// Lloyd steps taken.
    pub iterations: u32,
}

/// The vocabulary of a sample; its centroids in memory, or [left in the file](StoredVocabulary).
#[derive(Clone, Debug, PartialEq)]
pub struct Vocabulary<Centroids = Array2<f32>> {
    /// Finest first.
    pub levels: Vec<VocabularyLevel<Centroids>>,
    /// Images the appearance vectors are made of, ascending.
    pub representatives: Vec<u32>,
    /// The filter bank's taps, [48, 49, 49].
    pub filters: Array3<f32>,
    /// Colour channels of an appearance vector: 3, or 1 for luminance.
    pub channels: u32,
    /// Of a factored sample's centroids, the basis they are stored in.
    pub factor_basis: Option<FactorBasis>,
    /// Whether borders wrap.
    pub tileable: bool,
    /// The options it was made with, without those that change no number.
    pub options: Value,
    /// The seed it was made with.
    pub seed: u64,
    /// Side of a texel in millimetres, where the sample says it.
    pub texel_mm: Option<f64>,
    /// The id of the sample.
    pub sample: ContentId,
    /// This vocabulary's own id.
    pub id: ContentId,
}

/// The basis of centroids that are stored in few numbers: [textons, sets · rank · 48], component
/// (set · rank + factor) · 48 + filter. Their dot products are those of the appearance vectors. These are
/// A B times a centroid, filter by filter, with A the numbers of the representative images' planes in the
/// sample's eigentextures, and B this matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct FactorBasis {
    /// Eigentextures of a set.
    pub rank: u32,
    /// Sets of eigentextures: 3, one per channel, or 1.
    pub sets: u32,
    /// B = (AᵀA)^−½ [sets · rank, sets · rank].
    pub matrix: Array2<f32>,
}

/// A vocabulary just found, whose centroids give their memory back as they are written.
pub type FoundVocabulary = Vocabulary<RowBlocks>;

/// A vocabulary whose centroids stay in the file.
pub type StoredVocabulary = Vocabulary<StoredArray<f32>>;

/// `meta.json`.
#[derive(Debug, Serialize, Deserialize)]
struct Meta {
    format: String,
    version: u32,
    tileable: bool,
    channels: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    factor_basis: Option<BasisSides>,
    options: Value,
    seed: u64,
    inertia: Vec<f64>,
    iterations: Vec<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    texel_mm: Option<f64>,
    sample: ContentId,
    #[serde(skip_serializing)]
    id: Option<ContentId>,
}

/// What `meta.json` says of a factor basis.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct BasisSides {
    rank: u32,
    sets: u32,
}

impl FoundVocabulary {
    /// Writes the file. Returns the id of what was written.
    pub fn write(self, path: &Path) -> Result<ContentId> {
        let meta = Meta {
            format: FORMAT.into(),
            version: VERSION,
            tileable: self.tileable,
            channels: self.channels,
            factor_basis: self.factor_basis.as_ref().map(|basis| BasisSides {
                rank: basis.rank,
                sets: basis.sets,
            }),
            options: self.options.clone(),
            seed: self.seed,
            inertia: self.levels.iter().map(|level| level.inertia).collect(),
            iterations: self.levels.iter().map(|level| level.iterations).collect(),
            texel_mm: self.texel_mm,
            sample: self.sample.clone(),
            id: None,
        };
        npz::write(path, as_map(&meta)?, |file| {
            for (at, level) in self.levels.into_iter().enumerate() {
                let labels = label_image(&level.labels, level.grid)?;
                file.array(&format!("L{at}/labels"), labels)?;
                let sides = level.centroids.sides();
                let blocks = level.centroids.into_blocks();
                file.blocks(&format!("L{at}/centroids"), &sides, blocks)?;
                file.array(&format!("L{at}/counts"), ndarray::aview1(&level.counts))?;
            }
            file.array("representatives", ndarray::aview1(&self.representatives))?;
            if let Some(basis) = &self.factor_basis {
                file.array("factor_basis", basis.matrix.view())?;
            }
            file.array("filters", self.filters.view())
        })
    }
}

impl Vocabulary {
    /// Reads a file and checks that its parts belong together.
    pub fn read(path: &Path) -> Result<Self> {
        let stored = StoredVocabulary::open(path)?;
        let held = |level: VocabularyLevel<StoredArray<f32>>| {
            let array = level.centroids.to_array()?;
            let centroids = array.into_dimensionality();
            Ok(VocabularyLevel {
                centroids: centroids
                    .map_err(|error| Error::data("centroids", error.to_string()))?,
                grid: level.grid,
                labels: level.labels,
                counts: level.counts,
                inertia: level.inertia,
                iterations: level.iterations,
            })
        };
        Ok(Self {
            levels: stored.levels.into_iter().map(held).collect::<Result<_>>()?,
            representatives: stored.representatives,
            filters: stored.filters,
            channels: stored.channels,
            factor_basis: stored.factor_basis,
            tileable: stored.tileable,
            options: stored.options,
            seed: stored.seed,
            texel_mm: stored.texel_mm,
            sample: stored.sample,
            id: stored.id,
        })
    }
}

impl StoredVocabulary {
    /// Opens a file and checks that its parts belong together; centroids stay in it.
    pub fn open(path: &Path) -> Result<Self> {
        // Read what the file says of itself.
        let mut file = npz::Reader::open(path)?;
        let meta: Meta = file.meta()?;
        check_format(&file, &meta.format, meta.version)?;
        let Some(id) = meta.id.clone() else {
            return Err(file.fault("meta.json: id", "missing"));
        };
        // Read what all levels share.
        let representatives = file.array::<u32, Ix1>("representatives")?.to_vec();
        let filters = file.array::<f32, Ix3>("filters")?;
        check_meta(&file, &meta)?;
        let factor_basis = factor_basis(&mut file, &meta)?;
        let planes = match &factor_basis {
            Some(basis) => Some(basis.matrix.nrows()),
            None => representatives.len().checked_mul(meta.channels as usize),
        };
        let components = components(&file, planes, &representatives, &filters)?;
        // Read the levels, each half the one before.
        let mut levels: Vec<VocabularyLevel<StoredArray<f32>>> = Vec::new();
        for (&inertia, &iterations) in meta.inertia.iter().zip(&meta.iterations) {
            let at = levels.len();
            let level = VocabularyLevel {
                inertia,
                iterations,
                ..read_level(&mut file, at, meta.tileable, components)?
            };
            let expected = levels
                .last()
                .map_or(level.grid, |finer| finer.grid.coarser());
            if level.grid != expected {
                return Err(file
                    .fault(&format!("L{at}/labels"), sides(level.grid))
                    .expected(format!(
                        "{}: each level is half the one before",
                        sides(expected)
                    )));
            }
            levels.push(level);
        }
        Ok(Self {
            levels,
            representatives,
            filters,
            channels: meta.channels,
            factor_basis,
            tileable: meta.tileable,
            options: meta.options,
            seed: meta.seed,
            texel_mm: meta.texel_mm,
            sample: meta.sample,
            id,
        })
    }
}

fn check_format(file: &npz::Reader, format: &str, version: u32) -> Result<()> {
    if format != FORMAT {
        return Err(file
            .fault("meta.json: format", format!("`{format}`"))
            .expected(format!("{FORMAT}, as `mesotex textons` writes it")));
    }
    if version != VERSION {
        return Err(file
            .fault("meta.json: version", version.to_string())
            .expected(VERSION.to_string()));
    }
    Ok(())
}

fn sides(grid: TexelGrid) -> String {
    format!("{} × {} texels", grid.height, grid.width)
}

/// Levels that any sample can have: beyond these, each is a single texel.
const MOST_LEVELS: usize = 32;

/// Checks the numbers of `meta.json`.
fn check_meta(file: &npz::Reader, meta: &Meta) -> Result<()> {
    let levels = meta.inertia.len();
    if !(1..=MOST_LEVELS).contains(&levels) || levels != meta.iterations.len() {
        return Err(file
            .fault(
                "meta.json: inertia, iterations",
                format!("{levels} and {} levels", meta.iterations.len()),
            )
            .expected(format!("1 to {MOST_LEVELS}, as many of each")));
    }
    check_texel_mm(file, meta.texel_mm)?;
    let sound = |inertia: &f64| *inertia >= 0.0 && inertia.is_finite();
    if let Some(inertia) = meta.inertia.iter().find(|inertia| !sound(inertia)) {
        return Err(file
            .fault("meta.json: inertia", inertia.to_string())
            .expected("finite and not negative"));
    }
    if !matches!(meta.channels, 1 | 3) {
        return Err(file
            .fault("meta.json: channels", meta.channels.to_string())
            .expected("1 or 3"));
    }
    Ok(())
}

/// The basis of the centroids, where they are not stored image by image.
fn factor_basis(file: &mut npz::Reader, meta: &Meta) -> Result<Option<FactorBasis>> {
    let Some(BasisSides { rank, sets }) = meta.factor_basis else {
        return Ok(None);
    };
    let matrix = file.array::<f32, Ix2>("factor_basis")?;
    let planes = u64::from(rank) * u64::from(sets);
    if !matches!(sets, 1 | 3) || planes == 0 || matrix.shape().iter().any(|&s| s as u64 != planes) {
        return Err(file
            .fault("factor_basis", format!("shape {:?}", matrix.shape()))
            .expected(format!("[{planes}, {planes}], as meta.json states")));
    }
    match matrix.iter().find(|number| !number.is_finite()) {
        Some(number) => Err(file
            .fault("factor_basis", number.to_string())
            .expected("finite numbers")),
        None => Ok(Some(FactorBasis { rank, sets, matrix })),
    }
}

/// Numbers of a centroid.
fn components(
    file: &npz::Reader,
    planes: Option<usize>,
    representatives: &[u32],
    filters: &Array3<f32>,
) -> Result<usize> {
    if filters.is_empty() || filters.iter().any(|tap| !tap.is_finite()) {
        return Err(file
            .fault("filters", format!("shape {:?}", filters.shape()))
            .expected("filters of one finite tap or more"));
    }
    let components = planes.and_then(|planes| planes.checked_mul(filters.dim().0));
    components.filter(|&count| count > 0).ok_or_else(|| {
        file.fault(
            "representatives",
            format!("{} images", representatives.len()),
        )
        .expected("at least 1")
    })
}

/// Checks that no texton is empty and that the members are the level's texels, none twice.
fn check_counts(file: &npz::Reader, name: &str, counts: &[u32], texels: usize) -> Result<()> {
    let members: u64 = counts.iter().map(|&count| u64::from(count)).sum();
    if members == texels as u64 && !counts.contains(&0) {
        return Ok(());
    }
    Err(file
        .fault(
            name,
            format!("{members} members of {} textons", counts.len()),
        )
        .expected(format!(
            "{texels}, one per texel, and no texton without members"
        )))
}

fn read_level(
    file: &mut npz::Reader,
    at: usize,
    tileable: bool,
    components: usize,
) -> Result<VocabularyLevel<StoredArray<f32>>> {
    // Read the lists.
    let name = |part: &str| format!("L{at}/{part}");
    let labels = file.array::<u16, Ix2>(&name("labels"))?;
    let centroids = file.stored::<f32>(&name("centroids"))?;
    let counts = file.array::<u32, Ix1>(&name("counts"))?.to_vec();
    // Check them against each other.
    if centroids.shape() != [counts.len(), components] {
        return Err(file
            .fault(&name("centroids"), format!("{:?}", centroids.shape()))
            .expected(format!(
                "[{}, {components}], as counts, representatives and filters require",
                counts.len()
            )));
    }
    if let Some(label) = labels
        .iter()
        .find(|&&label| usize::from(label) >= counts.len())
    {
        return Err(file
            .fault(&name("labels"), format!("label {label}"))
            .expected(format!("labels below {}", counts.len())));
    }
    check_counts(file, &name("counts"), &counts, labels.len())?;
    // Check their numbers.
    if u32::try_from(labels.len()).is_err() {
        return Err(file
            .fault(&name("labels"), format!("{:?} texels", labels.dim()))
            .expected("fewer than 2^32"));
    }
    if let Some(value) = first_unsound(&centroids)? {
        return Err(file
            .fault(&name("centroids"), value.to_string())
            .expected(format!("numbers from −{LARGEST:e} to {LARGEST:e}")));
    }
    Ok(VocabularyLevel {
        grid: TexelGrid {
            width: labels.ncols() as u32,
            height: labels.nrows() as u32,
            tileable,
        },
        labels: labels.iter().copied().collect(),
        centroids,
        counts,
        inertia: 0.0,
        iterations: 0,
    })
}

/// The first number that is not finite or too large.
fn first_unsound(numbers: &StoredArray<f32>) -> Result<Option<f32>> {
    let sound = |value: &f32| (-LARGEST..=LARGEST).contains(value);
    let unsound = |held: &mut Vec<f32>, part: usize| {
        let first = part * CHECKED;
        held.resize(CHECKED.min(numbers.len() - first), 0.0);
        numbers.read(first, held)?;
        Ok(held.iter().copied().find(|value| !sound(value)))
    };
    let parts = numbers.len().div_ceil(CHECKED);
    let found: Vec<Option<f32>> = (0..parts)
        .into_par_iter()
        .map_init(Vec::new, unsound)
        .collect::<Result<_>>()?;
    Ok(found.into_iter().flatten().next())
}

/// Labels as an image [height, width].
pub fn label_image(labels: &[u16], grid: TexelGrid) -> std::io::Result<ArrayView2<'_, u16>> {
    ArrayView2::from_shape((grid.height as usize, grid.width as usize), labels)
        .map_err(std::io::Error::other)
}
