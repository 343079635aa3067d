//! Colours and masks of a texture, level by level: 2×2 means of what exists. A mask becomes numbers that can be
//! averaged: which share of a pixel each label has.

use ndarray::{Array2, Array3};

use crate::exemplar::controls::MASK_LABELS;
use crate::grid::TexelGrid;
use crate::index::TexelIndex;

/// Textures that are mixed at most.
pub const MOST_SOURCES: usize = 2;

/// A texture and its mask.
#[derive(Clone, Copy, Debug)]
pub struct Texture<'a> {
    /// Its pixels.
    pub grid: TexelGrid,
    /// What is compared of each, about 0 to 1, [H, W, depth].
    pub numbers: &'a Array3<f32>,
    /// Labels 0 to 3, [H, W].
    pub mask: &'a Array2<u8>,
}

/// How labels become numbers: with two labels the share of the greater, with more the share of each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaskCode {
    labels: Vec<u8>,
}

impl MaskCode {
    /// That of all labels of some masks; no numbers without masks, or with one label.
    pub fn of<'a>(masks: impl Iterator<Item = &'a Array2<u8>>) -> Self {
        let mut there = [false; MASK_LABELS as usize];
        masks
            .flatten()
            .for_each(|&label| there[usize::from(label)] = true);
        let labels: Vec<u8> = (0..MASK_LABELS)
            .filter(|&label| there[usize::from(label)])
            .collect();
        Self {
            labels: match labels[..] {
                [] | [_] => Vec::new(),
                [_, greater] => vec![greater],
                _ => labels,
            },
        }
    }

    fn count(&self) -> usize {
        self.labels.len()
    }

    /// What a squared difference weighs, so that two labels are 1 apart.
    fn weight(&self) -> f32 {
        if self.count() > 1 { 0.5 } else { 1.0 }
    }

    fn shares(&self, mask: &Array2<u8>) -> Vec<f32> {
        let of_pixel = |label: &u8| {
            let label = *label;
            self.labels
                .iter()
                .map(move |&other| f32::from(u8::from(label == other)))
        };
        mask.iter().flat_map(of_pixel).collect()
    }
}

/// One level of a texture, or of the output, which has no colours of its own.
#[derive(Clone, Debug)]
pub struct TextureLevel {
    /// Its pixels.
    pub grid: TexelGrid,
    /// Colour numbers, `depth` per pixel.
    pub colors: Vec<f32>,
    /// Colour numbers per pixel.
    pub depth: usize,
    /// Shares of labels, `labels` per pixel.
    pub shares: Vec<f32>,
    /// Shares per pixel.
    pub labels: usize,
    /// What a squared difference of shares weighs.
    label_weight: f32,
}

/// Numbers per pixel that are compared.
#[derive(Clone, Copy, Debug)]
pub struct Depths {
    /// Of colours.
    pub color: usize,
    /// Of masks.
    pub mask: usize,
    /// What a squared difference in the mask's weighs.
    pub mask_weight: f32,
}

impl TextureLevel {
    /// So many levels of a texture, finest first.
    pub fn pyramid(texture: &Texture<'_>, code: &MaskCode, count: usize) -> Vec<Self> {
        let finest = Self {
            grid: texture.grid,
            colors: texture.numbers.iter().copied().collect(),
            depth: texture.numbers.dim().2,
            shares: code.shares(texture.mask),
            labels: code.count(),
            label_weight: code.weight(),
        };
        finest.with_coarser(count)
    }

    /// So many levels of an output of (rows, columns), finest first.
    pub fn of_output(
        (rows, cols): (usize, usize),
        mask: Option<&Array2<u8>>,
        code: &MaskCode,
        count: usize,
    ) -> Vec<Self> {
        let finest = Self {
            grid: TexelGrid {
                width: cols as u32,
                height: rows as u32,
                tileable: false,
            },
            colors: Vec::new(),
            depth: 0,
            shares: mask.map_or(Vec::new(), |mask| code.shares(mask)),
            labels: mask.map_or(0, |_| code.count()),
            label_weight: code.weight(),
        };
        finest.with_coarser(count)
    }

    /// What is compared of this level of an output with a source's.
    pub fn depths(&self, source: &Self) -> Depths {
        Depths {
            color: source.depth,
            mask: self.labels,
            mask_weight: self.label_weight,
        }
    }

    fn with_coarser(self, count: usize) -> Vec<Self> {
        let mut all = vec![self];
        while all.len() < count {
            let next = all[all.len() - 1].coarser();
            all.push(next);
        }
        all
    }

    fn coarser(&self) -> Self {
        Self {
            grid: self.grid.coarser(),
            colors: means(self.grid, &self.colors, self.depth),
            shares: means(self.grid, &self.shares, self.labels),
            depth: self.depth,
            labels: self.labels,
            label_weight: self.label_weight,
        }
    }
}

/// The means of the children of every pixel of the coarser grid.
fn means(grid: TexelGrid, numbers: &[f32], depth: usize) -> Vec<f32> {
    let coarser = grid.coarser();
    let mut all = Vec::with_capacity(coarser.len() * depth);
    for parent in (0..coarser.len() as u32).map(TexelIndex) {
        let count = grid.children(parent).count() as f32;
        for at in 0..depth {
            let children = grid.children(parent);
            let sum: f32 = children
                .map(|child| numbers[child.index() * depth + at])
                .sum();
            all.push(sum / count);
        }
    }
    all
}

/// One number per pixel, on the next coarser level.
pub fn coarser_values(values: &Array2<f32>) -> Array2<f32> {
    let (rows, cols) = values.dim();
    Array2::from_shape_fn((rows.div_ceil(2), cols.div_ceil(2)), |(row, col)| {
        let children = (2 * row..(2 * row + 2).min(rows))
            .flat_map(|row| (2 * col..(2 * col + 2).min(cols)).map(move |col| values[[row, col]]));
        let (sum, count) =
            children.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
        sum / count
    })
}
