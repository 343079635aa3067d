//! Visibility by rasterization: which point of which triangle each sample of the image sees.
//!
//! In: a view, a mesh, a sample pattern. Out: a [`SurfaceBuffer`]. Tiles are drawn in parallel,
//! each by one task and its triangles in order, so the result does not depend on the thread count.
//! Both sides of every triangle are drawn; those that face the camera first, so that of the others
//! most are found hidden before they are drawn.

mod bins;
mod coverage;
mod pattern;
mod screen;

use macro_rules_attribute::apply;
use rayon::prelude::*;

pub use bins::TILE;
pub use coverage::NOTHING;
use pattern::SUBPIXEL;
pub use pattern::Samples;

use crate::lanes::vectorized;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;
use crate::render::camera::View;
use bins::{Bins, Side, tile_counts};
use coverage::{TileSamples, barycentric};
use screen::Screen;

/// What one sample sees: a point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The mesh triangle, or [`NOTHING`].
    pub triangle: u32,
    /// Barycentric weights of the triangle's first and second corner; the third has the rest.
    pub weights: [f32; 2],
}

impl Hit {
    /// A sample that sees nothing.
    pub const MISS: Self = Self {
        triangle: NOTHING,
        weights: [0.0; 2],
    };

    /// Whether a surface is seen.
    #[inline]
    pub fn is_surface(&self) -> bool {
        self.triangle != NOTHING
    }

    /// The weights of all three corners; they sum to 1.
    #[inline]
    pub fn barycentric(&self) -> [f32; 3] {
        let [a, b] = self.weights;
        [a, b, 1.0 - a - b]
    }

    /// The corner with the largest weight, the first of equal ones.
    #[inline]
    pub fn nearest_corner(&self) -> usize {
        let [a, b, c] = self.barycentric();
        if a >= b && a >= c {
            0
        } else if b >= c {
            1
        } else {
            2
        }
    }
}

/// What every sample of an image sees, tile by tile.
#[derive(Clone, Debug)]
pub struct SurfaceBuffer {
    /// Columns and rows of the image.
    pub size: [u32; 2],
    /// The pattern of samples.
    pub samples: Samples,
    by_distance: Vec<usize>,
    /// Per tile, row by row: the hits of its TILE × TILE pixels, [`Samples::stored`] each; empty
    /// where nothing is seen.
    tiles: Vec<Vec<Hit>>,
}

impl SurfaceBuffer {
    /// Draws a mesh as `view` sees it; nothing nearer than `nearest` (in depth) is drawn. Once
    /// interrupted, the remaining tiles stay empty.
    pub fn draw(
        view: &View,
        mesh: &TriangleMesh,
        samples: Samples,
        nearest: f64,
        progress: Progress<'_>,
    ) -> Self {
        // Project the vertices, and sort the triangles into tiles.
        let screen = Screen::project(view, &mesh.positions, &mesh.triangles, nearest);
        let bins = Bins::sort(&screen, &mesh.triangles, view.size);
        let drawing = Drawing {
            view,
            screen: &screen,
            bins: &bins,
            triangles: &mesh.triangles,
            samples,
        };
        // Draw the tiles in parallel.
        let [across, down] = tile_counts(view.size);
        let tiles = (0..(across * down) as usize)
            .into_par_iter()
            .map(|tile| match samples {
                _ if progress.is_interrupted() => Vec::new(),
                Samples::One => draw_tile::<1, 1>(&drawing, tile),
                Samples::Four => draw_tile::<5, 8>(&drawing, tile),
                Samples::Eight => draw_tile::<9, 16>(&drawing, tile),
                Samples::Sixteen => draw_tile::<17, 24>(&drawing, tile),
            })
            .collect();
        Self {
            size: view.size,
            samples,
            by_distance: samples.by_distance(),
            tiles,
        }
    }

    /// The stored hits of a pixel, those of colour first, the centre last; empty in a tile that
    /// sees nothing.
    #[inline]
    pub fn pixel(&self, column: u32, row: u32) -> &[Hit] {
        let across = self.size[0].div_ceil(TILE);
        let tile = &self.tiles[(row / TILE * across + column / TILE) as usize];
        if tile.is_empty() {
            return &[];
        }
        let stored = self.samples.stored();
        let pixel = (row % TILE * TILE + column % TILE) as usize;
        &tile[pixel * stored..][..stored]
    }

    /// The stored hits of a pixel of a band, given its place there.
    pub fn band_pixel(&self, band: usize, place: usize) -> &[Hit] {
        let width = self.size[0] as usize;
        let (column, row) = (place % width, band * BAND + place / width);
        self.pixel(column as u32, row as u32)
    }

    /// Those of a pixel's hits that colour and coverage are the mean of.
    #[inline]
    pub fn color_hits<'a>(&self, pixel: &'a [Hit]) -> &'a [Hit] {
        &pixel[..self.samples.count().min(pixel.len())]
    }

    /// What the other layers of a pixel show: the centre, or the covered sample nearest to it;
    /// nothing where no sample of colour is covered.
    #[inline]
    pub fn layer_hit(&self, pixel: &[Hit]) -> Hit {
        let Some(centre) = pixel.last() else {
            return Hit::MISS;
        };
        let mut covered = self.by_distance.iter().filter(|&&s| pixel[s].is_surface());
        match covered.next() {
            None => Hit::MISS,
            Some(_) if centre.is_surface() => *centre,
            Some(&nearest) => pixel[nearest],
        }
    }

    /// The colour samples of a pixel, nearest to its centre first.
    pub fn by_distance(&self) -> &[usize] {
        &self.by_distance
    }

    /// An image of what `value` makes of each pixel's hits, row by row; `nothing` where a whole
    /// tile sees nothing.
    pub fn map_pixels<R: Copy + Send + Sync, W>(
        &self,
        nothing: R,
        init: impl Fn() -> W + Sync + Send,
        value: impl Fn(&mut W, &[Hit]) -> R + Sync + Send,
    ) -> Vec<R> {
        self.map_bands(nothing, init, |work, band, pixels| {
            self.visit_band(band, |pixel, hits| pixels[pixel] = value(work, hits));
        })
    }

    /// An image, band by band: `fill` is given a band's number and its pixels, `nothing` so far.
    /// Bands run in parallel, with working memory from `init`.
    pub fn map_bands<R: Copy + Send + Sync, W>(
        &self,
        nothing: R,
        init: impl Fn() -> W + Sync + Send,
        fill: impl Fn(&mut W, usize, &mut [R]) + Sync + Send,
    ) -> Vec<R> {
        let [width, height] = self.size.map(|side| side as usize);
        let mut image = vec![nothing; width * height];
        image
            .par_chunks_mut(BAND * width)
            .enumerate()
            .for_each_init(init, |work, (band, pixels)| fill(work, band, pixels));
        image
    }

    /// Bands of rows in the image.
    pub fn bands(&self) -> usize {
        (self.size[1] as usize).div_ceil(BAND)
    }

    /// Hands out the pixels of a band that lie in tiles that see something: the place of each in
    /// the band, and its hits. Neighbours follow each other, across and down, so that what they
    /// share is still near.
    pub fn visit_band(&self, band: usize, mut visit: impl FnMut(usize, &[Hit])) {
        let ([width, height], side) = (self.size.map(|side| side as usize), TILE as usize);
        let across = width.div_ceil(side);
        let rows = band * BAND..height.min((band + 1) * BAND);
        let tiles = &self.tiles[rows.start / side * across..][..across];
        for (column, tile) in tiles.iter().enumerate() {
            let columns = column * side..width.min((column + 1) * side);
            for (below, row) in rows.clone().enumerate() {
                let hits = self.pixels_of_row(tile, row % side);
                for (at, hits) in columns.clone().zip(hits) {
                    visit(below * width + at, hits);
                }
            }
        }
    }

    /// Pixels that see a surface.
    pub fn covered_pixels(&self) -> usize {
        let stored = self.samples.stored();
        let is_covered = |hits: &&[Hit]| hits.iter().any(Hit::is_surface);
        let of_tile = |tile: &Vec<Hit>| tile.chunks_exact(stored).filter(is_covered).count();
        self.tiles.par_iter().map(of_tile).sum()
    }

    /// The pixels' hits in one row of a tile; none where it sees nothing.
    #[inline]
    fn pixels_of_row<'a>(&self, tile: &'a [Hit], row: usize) -> impl Iterator<Item = &'a [Hit]> {
        let stored = self.samples.stored();
        let first = (row * TILE as usize * stored).min(tile.len());
        tile[first..].chunks_exact(stored)
    }

    /// All hits on surfaces, in tiles that run in parallel.
    pub fn for_each_surface(&self, visit: impl Fn(&Hit) + Sync) {
        self.tiles
            .par_iter()
            .for_each(|tile| tile.iter().filter(|hit| hit.is_surface()).for_each(&visit));
    }
}

/// Rows of pixels that are one task; tiles have a multiple of it.
const BAND: usize = 8;

struct Drawing<'a> {
    view: &'a View,
    screen: &'a Screen,
    bins: &'a Bins,
    triangles: &'a [[u32; 3]],
    samples: Samples,
}

/// What the `STORED` samples of one tile's pixels see. They are drawn as `LANES`, a multiple of the
/// processor's, of which the last are idle.
#[apply(vectorized!)]
fn draw_tile<const STORED: usize, const LANES: usize>(drawing: &Drawing, tile: usize) -> Vec<Hit> {
    let (view, samples, bins) = (drawing.view, drawing.samples, drawing.bins);
    let across = tile_counts(view.size)[0] as usize;
    let corner = [tile % across, tile / across].map(|index| index as u32 * TILE);
    let [mut fronts, mut backs] =
        [Side::Front, Side::Back].map(|side| bins.of_tile(tile, side).peekable());
    if fronts.peek().is_none() && backs.peek().is_none() {
        return Vec::new();
    }
    let mut seen = TileSamples::<LANES>::new(corner, view.size, samples);
    for number in fronts {
        seen.draw(drawing.corners(number), number);
    }
    let farthest = seen.farthest();
    for number in backs {
        seen.draw_behind(drawing.corners(number), number, &farthest);
    }
    drawing.hits::<STORED, LANES>(corner, &seen.triangles)
}

impl Drawing<'_> {
    #[inline(always)]
    fn corners(&self, number: u32) -> [&screen::ScreenVertex; 3] {
        let corners = match self.triangles.get(number as usize) {
            Some(&corners) => corners,
            None => self.screen.pieces[number as usize - self.triangles.len()].corners,
        };
        let [a, b, c] = corners;
        let vertex = |v: u32| &self.screen.vertices[v as usize];
        [vertex(a), vertex(b), vertex(c)]
    }

    /// The points of the triangles that a tile's samples see; empty when they see none.
    #[inline(always)]
    fn hits<const STORED: usize, const LANES: usize>(
        &self,
        corner: [u32; 2],
        seen: &[[u32; LANES]],
    ) -> Vec<Hit> {
        if seen.iter().flatten().all(|&number| number == NOTHING) {
            return Vec::new();
        }
        let positions = self.samples.positions::<STORED>();
        let mut hits = Vec::with_capacity(seen.len() * STORED);
        for (pixel, numbers) in seen.iter().enumerate() {
            let column = corner[0] + pixel as u32 % TILE;
            let row = corner[1] + pixel as u32 / TILE;
            let at = [column as i32 * SUBPIXEL, row as i32 * SUBPIXEL];
            for (&number, position) in numbers.iter().zip(positions) {
                hits.push(if number == NOTHING {
                    Hit::MISS
                } else {
                    self.hit(number, [at[0] + position[0], at[1] + position[1]])
                });
            }
        }
        hits
    }

    #[inline(always)]
    fn hit(&self, number: u32, sample: [i32; 2]) -> Hit {
        let weights = barycentric(self.corners(number), sample, self.view.is_perspective());
        let piece = (number as usize).checked_sub(self.triangles.len());
        let Some(piece) = piece.map(|index| &self.screen.pieces[index]) else {
            let [a, b, _] = weights;
            return Hit {
                triangle: number,
                weights: [a, b],
            };
        };
        let of_source =
            |corner: usize| -> f32 { (0..3).map(|k| weights[k] * piece.weights[k][corner]).sum() };
        Hit {
            triangle: piece.source,
            weights: [of_source(0), of_source(1)],
        }
    }
}

#[cfg(test)]
mod tests;
