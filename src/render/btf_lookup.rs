//! The sample evaluated at one texture coordinate, view and lights (Tong 2002 §6): the nearest
//! images' values at a texel, blended.
//!
//! In: directions in the vertex's frame, texel positions. Out: linear radiance, light by light
//! times the light's irradiance.

use glam::{DVec3, Vec3, Vec4};
use serde::Serialize;

use crate::btf::HeightMap;
use crate::btf::sample::Sample;
use crate::error::Result;
use crate::grid::{TexCoord, TexelGrid};
use crate::index::TexelIndex;
use crate::progress::Progress;
use crate::render::even_light;
use crate::render::nearest::{DirectionSet, PairSet, Scratch, Weight, Weighting, lifted};
use crate::render::parallax::{Place, ReadList, Relief};
use crate::render::texel_table::{AnyTable, MemoryBudget, RowLayout, Stored, TexelTable};

/// How values between texel centres are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Texels {
    /// The texel that holds the coordinate.
    Nearest,
    /// The four texels round it, by distance; wrapped when the sample is tileable, else the
    /// border is repeated.
    Bilinear,
}

/// A sample ready for shading.
#[derive(Debug)]
pub struct BtfLookup {
    directions: Directions,
    /// The sample, texel by texel.
    pub table: AnyTable,
    texels: Texels,
    /// Sums of a view's images that lie beside them.
    sums: usize,
    grid: TexelGrid,
    relief: Option<Relief>,
}

#[derive(Debug)]
enum Directions {
    /// Rows of a texel's numbers are views, columns lights.
    Product {
        views: DirectionSet,
        lights: DirectionSet,
    },
    /// One row, columns are pairs.
    Pairs(PairSet),
}

impl BtfLookup {
    /// Lays out a sample for shading; with `filled` so that a [`Fill`](crate::render::fill::Fill) can be added.
    /// Scattered samples have none.
    pub fn new(
        sample: &Sample,
        weighting: Weighting,
        texels: Texels,
        mip: bool,
        filled: bool,
        budget: &MemoryBudget,
        progress: Progress<'_>,
    ) -> Result<Self> {
        // Choose the directions that are kept, and their images.
        let description = sample.description();
        let (views, lights) = (&description.views, &description.lights);
        let (directions, images) = match &description.pairs {
            None => {
                let (views, lights) = (
                    DirectionSet::new(views, weighting),
                    DirectionSet::new(lights, weighting),
                );
                let stride = description.lights.len() as u32;
                let of_view = |&view: &u32| lights.kept().iter().map(move |l| view * stride + l);
                let images: Vec<u32> = views.kept().iter().flat_map(of_view).collect();
                (Directions::Product { views, lights }, images)
            }
            Some(pairs) => {
                let pairs = PairSet::new(views, lights, pairs, weighting)?;
                let images = pairs.kept().to_vec();
                (Directions::Pairs(pairs), images)
            }
        };
        // Lay out the rows, with sums where fill light needs them.
        let layout = match &directions {
            Directions::Product { lights, .. } if filled => RowLayout {
                images: lights.len(),
                sums: even_light::sums(lights).to_vec(),
            },
            _ => RowLayout::plain(images.len()),
        };
        let sums = layout.sums.len();
        Ok(Self {
            directions,
            table: AnyTable::build(sample, (&images, &layout), mip, budget, progress)?,
            texels,
            sums,
            grid: sample.grid(),
            relief: None,
        })
    }

    /// Blends views with their parallax over the heights of a sample; plainly where there are `None`. A scattered
    /// sample has no views to blend.
    #[must_use]
    pub fn with_heights(mut self, heights: Option<&HeightMap>) -> Self {
        let levels = self.levels();
        self.relief = match (&self.directions, heights) {
            (Directions::Product { views, .. }, Some(heights)) => {
                Some(Relief::new(heights, views.directions(), levels))
            }
            _ => None,
        };
        self
    }

    /// Whether views are blended with their parallax.
    pub fn has_parallax(&self) -> bool {
        self.relief.is_some()
    }

    fn levels(&self) -> usize {
        match &self.table {
            AnyTable::Half(table) => table.levels.len(),
            AnyTable::Single(table) => table.levels.len(),
        }
    }

    /// The sample's texels.
    pub fn grid(&self) -> TexelGrid {
        self.grid
    }

    /// Whether one texel holds all that a coordinate needs, whatever its footprint.
    pub fn reads_one_texel(&self) -> bool {
        self.texels == Texels::Nearest && self.levels() == 1 && self.relief.is_none()
    }

    /// Distinct views and lights; distinct pairs, twice, for a scattered sample.
    pub fn counts(&self) -> (usize, usize) {
        match &self.directions {
            Directions::Product { views, lights } => (views.len(), lights.len()),
            Directions::Pairs(pairs) => (pairs.len(), pairs.len()),
        }
    }

    /// Whether the images are scattered pairs.
    pub fn is_scattered(&self) -> bool {
        matches!(self.directions, Directions::Pairs(_))
    }
}

/// One image column of a blend.
#[derive(Clone, Copy, Debug, Default)]
struct Column {
    /// Where its red lies in a row.
    offset: u32,
    /// Share times irradiance, red to blue, times the table's first [`Stored::UNDO`]; the next
    /// image's red weighs nothing.
    weight: Vec4,
}

/// A blend of images under construction, and its working memory; one per task.
#[derive(Debug, Default)]
pub struct Blend {
    view: DVec3,
    /// Row and share.
    rows: Vec<Weight>,
    columns: Vec<Column>,
    found: Vec<Weight>,
    scratch: Scratch,
    /// Luminance of the irradiance of lights above the horizon, and the part of it whose view or
    /// light lies lower than any sampled one.
    lit: f32,
    beyond: f32,
    /// How far from a coordinate images may be read, in texels; of no use without heights.
    reach: f32,
    list: ReadList,
}

impl Blend {
    #[inline(always)]
    fn begin(&mut self, view: DVec3) {
        self.view = view;
        self.columns.clear();
        (self.lit, self.beyond) = (0.0, 0.0);
    }

    /// Says how far from a coordinate images may be read, in texels, where views are blended with their parallax.
    #[inline(always)]
    pub fn set_reach(&mut self, reach: f32) {
        self.reach = reach;
    }

    /// Whether no light falls on the point.
    #[inline(always)]
    pub fn is_dark(&self) -> bool {
        self.columns.is_empty()
    }

    /// The share of the weight that came from beyond the sampled range.
    pub fn beyond(&self) -> f32 {
        if self.lit > 0.0 {
            self.beyond / self.lit
        } else {
            0.0
        }
    }
}

impl BtfLookup {
    /// Begins the blend for a view direction in the vertex's frame.
    #[inline(always)]
    pub fn begin(&self, blend: &mut Blend, view: DVec3) {
        blend.begin(lifted(view));
        self.view_weights(blend.view, &mut blend.scratch, &mut blend.rows);
    }

    /// Begins the blend for a view direction above the horizon whose weights are known.
    #[inline(always)]
    pub fn begin_known(&self, blend: &mut Blend, view: Vec3, weights: &[Weight]) {
        blend.begin(view.as_dvec3());
        blend.rows.clear();
        blend.rows.extend_from_slice(weights);
    }

    /// The weights of a view above the horizon.
    #[inline(always)]
    pub fn view_weights(&self, view: DVec3, scratch: &mut Scratch, out: &mut Vec<Weight>) {
        match &self.directions {
            Directions::Product { views, .. } => views.weigh::<false>(view, scratch, out),
            Directions::Pairs(_) => {
                let (index, weight) = (0, 1.0);
                out.clear();
                out.push(Weight { index, weight });
            }
        }
    }

    /// Adds a light: its direction in the vertex's frame and its irradiance, already dimmed by
    /// what hides it. Below the horizon it adds nothing.
    #[inline(always)]
    pub fn add_light<T: Stored>(&self, blend: &mut Blend, light: DVec3, irradiance: [f32; 3]) {
        if light.z <= 0.0 {
            return;
        }
        let mut found = std::mem::take(&mut blend.found);
        match &self.directions {
            Directions::Product { .. } => {
                self.light_weights(light, &mut blend.scratch, &mut found);
            }
            Directions::Pairs(pairs) => {
                pairs.weigh(blend.view, light, &mut blend.scratch, &mut found);
            }
        }
        self.add_weighted::<T>(blend, light, &found, irradiance);
        blend.found = found;
    }

    /// The weights of a light above the horizon of a product sample, whatever the view.
    #[inline(always)]
    pub fn light_weights(&self, light: DVec3, scratch: &mut Scratch, out: &mut Vec<Weight>) {
        match &self.directions {
            Directions::Product { lights, .. } => lights.weigh::<true>(light, scratch, out),
            Directions::Pairs(_) => out.clear(),
        }
    }

    /// Adds a light above the horizon whose images' weights are known.
    #[inline(always)]
    pub fn add_weighted<T: Stored>(
        &self,
        blend: &mut Blend,
        light: DVec3,
        weights: &[Weight],
        irradiance: [f32; 3],
    ) {
        let (view_cosine, light_cosine) = (blend.view.z as f32, light.z as f32);
        let is_beyond = match &self.directions {
            Directions::Product { views, lights } => {
                views.is_below_all(view_cosine) || lights.is_below_all(light_cosine)
            }
            Directions::Pairs(pairs) => pairs.is_below_all(view_cosine, light_cosine),
        };
        let [r, g, b] = irradiance;
        let whole = Vec4::new(r, g, b, 0.0) * T::UNDO[0];
        blend.columns.extend(weights.iter().map(|found| Column {
            offset: 3 * found.index,
            weight: whole * found.weight,
        }));
        let luminance = super::light::luminance(irradiance);
        blend.lit += luminance;
        blend.beyond += if is_beyond { luminance } else { 0.0 };
    }

    /// Adds light from all around, by its [shares](crate::render::fill::Fill::shares) of the four sums; after the
    /// lights.
    #[inline(always)]
    pub fn add_fill<T: Stored>(&self, blend: &mut Blend, shares: [f32; 4]) {
        let Directions::Product { lights, .. } = &self.directions else {
            return;
        };
        let first = lights.len() as u32;
        let columns = (first..).zip(shares).take(self.sums);
        blend.columns.extend(columns.map(|(sum, share)| Column {
            offset: 3 * sum,
            weight: Vec4::new(share, share, share, 0.0) * T::UNDO[0],
        }));
    }

    /// Joins columns that several lights added, so that each image is read once.
    #[inline(always)]
    pub fn merge_lights(&self, blend: &mut Blend) {
        let columns = &mut blend.columns;
        columns.sort_by_key(|column| column.offset);
        columns.dedup_by(|next, kept| {
            let same = next.offset == kept.offset;
            if same {
                kept.weight += next.weight;
            }
            same
        });
    }

    /// The blended value at a coordinate, `detail` levels up the pyramid (0: the finest; between
    /// two levels, both are mixed).
    #[inline(always)]
    pub fn at<T: Stored>(
        &self,
        table: &TexelTable<T>,
        coord: TexCoord,
        detail: f32,
        blend: &mut Blend,
    ) -> Vec4 {
        let last = (table.levels.len() - 1) as f32;
        let detail = detail.clamp(0.0, last);
        let (level, mix) = (detail as usize, detail.fract());
        let finer = self.of_level(table, level, coord, blend);
        if mix > 0.0 {
            let coarser = self.of_level(table, level + 1, coord, blend);
            finer + (coarser - finer) * mix
        } else {
            finer
        }
    }

    #[inline(always)]
    fn of_level<T: Stored>(
        &self,
        table: &TexelTable<T>,
        level: usize,
        coord: TexCoord,
        blend: &mut Blend,
    ) -> Vec4 {
        match &self.relief {
            Some(relief) => self.with_parallax(relief, table, level, coord, blend),
            None => self.on_level(table, level, coord, &blend.rows, &blend.columns),
        }
    }

    /// The blended value where each view's images are read at the texels that show what the view sees.
    #[inline(always)]
    fn with_parallax<T: Stored>(
        &self,
        relief: &Relief,
        table: &TexelTable<T>,
        level: usize,
        coord: TexCoord,
        blend: &mut Blend,
    ) -> Vec4 {
        // Find the texels that each view shows there.
        let place = Place {
            coord: match self.texels {
                Texels::Nearest => self.grid.centre(self.grid.texel_nearest(coord)),
                Texels::Bilinear => coord,
            },
            level,
            view: blend.view.as_vec3(),
            reach: blend.reach,
        };
        // Blend them.
        let Blend {
            rows,
            columns,
            list,
            ..
        } = blend;
        list.find(relief, &place, rows);
        let (numbers, row_length) = (&table.levels[level], self.row_length());
        let mut sum = Vec4::ZERO;
        for read in list.reads() {
            let line = &numbers.texel(read.texel)[read.view as usize * row_length..];
            sum += blend_row(line, columns) * (read.share * T::UNDO[1]);
        }
        // Add what is read without parallax.
        let sum = match list.plain() {
            [] => sum,
            plain => sum + self.on_level(table, level, coord, plain, columns),
        };
        sum.max(Vec4::ZERO)
    }

    #[inline(always)]
    fn on_level<T: Stored>(
        &self,
        table: &TexelTable<T>,
        level: usize,
        coord: TexCoord,
        rows: &[Weight],
        columns: &[Column],
    ) -> Vec4 {
        // Find the texel on this level.
        let shrink = 1.0 / (1u32 << level.min(31)) as f32;
        let finest = self.grid;
        let (mut column, mut row) = (coord.s, finest.height as f32 - coord.t);
        if finest.tileable {
            column = column.rem_euclid(finest.width as f32);
            row = row.rem_euclid(finest.height as f32);
        }
        (column, row) = (column * shrink, row * shrink);
        let level = &table.levels[level];
        if self.texels == Texels::Nearest {
            let texel = nearest_texel(level.grid, row.floor(), column.floor());
            return self.blend_rows(level.texel(texel), rows, columns);
        }
        // Blend the four texels round the place.
        let (top, left) = ((row - 0.5).floor(), (column - 0.5).floor());
        let (down, right) = (row - 0.5 - top, column - 0.5 - left);
        let mut sum = Vec4::ZERO;
        for (i, j) in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)] {
            let share = (1.0 - down - i + 2.0 * i * down) * (1.0 - right - j + 2.0 * j * right);
            if share > 0.0 {
                let texel = nearest_texel(level.grid, top + i, left + j);
                sum += share * self.blend_rows(level.texel(texel), rows, columns);
            }
        }
        sum
    }

    /// Sums the rows' and columns' images at one texel, given its numbers; red to blue, the fourth
    /// means nothing. Weights may be negative; the sum is clamped at 0.
    #[inline(always)]
    pub fn blend_texel<T: Stored>(&self, numbers: &[T], blend: &Blend) -> Vec4 {
        self.blend_rows(numbers, &blend.rows, &blend.columns)
    }

    #[inline(always)]
    fn blend_rows<T: Stored>(&self, numbers: &[T], rows: &[Weight], columns: &[Column]) -> Vec4 {
        let row_length = self.row_length();
        let mut total = Vec4::ZERO;
        for row in rows {
            let line = &numbers[row.index as usize * row_length..];
            total += blend_row(line, columns) * (row.weight * T::UNDO[1]);
        }
        total.max(Vec4::ZERO)
    }

    /// Numbers of a row of a texel: RGB per light of a view and per sum of them, or none where all pairs are one row.
    #[inline(always)]
    fn row_length(&self) -> usize {
        match &self.directions {
            Directions::Product { lights, .. } => 3 * (lights.len() + self.sums),
            Directions::Pairs(_) => 0,
        }
    }
}

/// Sums the columns' images of one row of a texel's numbers.
#[inline(always)]
fn blend_row<T: Stored>(line: &[T], columns: &[Column]) -> Vec4 {
    let mut sum = Vec4::ZERO;
    for column in columns {
        if let Some(&four) = line[column.offset as usize..].first_chunk::<4>() {
            sum += column.weight * T::widen(four);
        }
    }
    sum
}

/// The texel at a row and column: wrapped when tileable, else clamped to the border.
#[inline(always)]
fn nearest_texel(grid: TexelGrid, row: f32, column: f32) -> TexelIndex {
    let wrap = |at: f32, side: u32| {
        let (at, last) = (at as i32, side as i32 - 1);
        let inside = if !grid.tileable {
            at.clamp(0, last)
        } else if at < 0 {
            (at + side as i32).max(0)
        } else if at > last {
            (at - side as i32).min(last)
        } else {
            at
        };
        inside as u32
    };
    grid.texel(wrap(row, grid.height), wrap(column, grid.width))
}
