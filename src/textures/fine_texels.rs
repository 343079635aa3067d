//! The texels of a texture map, and the texture coordinates they take from an atlas of the same or a coarser size.
//!
//! A texel finer than those of the atlas lies between up to four of them. Each of these has its own texture
//! coordinate, continued to the finer texel's point along the surface's s and t, as pixels continue those of
//! vertices. What they show is mixed by nearness, so that patches of the sample meet without a step.

use glam::Vec3;

use crate::error::{Error, Result};
use crate::grid::TexCoord;
use crate::maps::atlas_map::AtlasMap;
use crate::mesh::atlas::{Atlas, TexelPoints};

/// Rings of texels in which one of the same chart is looked for where none lies beside a finer texel.
const RINGS: i64 = 3;

/// The texels of a texture map on an atlas.
pub(super) struct FineTexels<'a> {
    map: &'a AtlasMap,
    /// How many texels stand for the side of one of the atlas.
    finer: u32,
    /// Where they lie.
    pub(super) points: TexelPoints,
    /// A texel of the atlas in each chart.
    first: Vec<usize>,
}

/// A texel of the atlas, seen from a finer one.
#[derive(Clone, Copy)]
pub(super) struct Source {
    /// The texel.
    pub(super) texel: usize,
    /// Its texture coordinate, continued.
    pub(super) coord: TexCoord,
    /// Its share; shares of a texel's sources sum to 1.
    pub(super) share: f32,
}

impl<'a> FineTexels<'a> {
    /// Finds the texels on the mesh again; refuses an atlas whose charts do not fit its mesh.
    pub(super) fn new(map: &'a AtlasMap, atlas: &Atlas, finer: u32) -> Result<Self> {
        let on_mesh =
            |finer| TexelPoints::new(&map.mesh, atlas, finer * map.width, finer * map.height);
        let coarse = on_mesh(1)?;
        let mut first = vec![usize::MAX; atlas.charts];
        for (texel, &chart) in map.chart.iter().enumerate().rev() {
            let wanted = coarse.chart(atlas, texel).map_or(-1, |chart| chart as i32);
            if chart != wanted {
                let width = map.width as usize;
                let place = format!("chart, row {}, column {}", texel / width, texel % width);
                return Err(Error::data(place, chart.to_string())
                    .expected(format!("{wanted}, by the mesh's texture coordinates")));
            }
            if let Ok(chart) = usize::try_from(chart) {
                first[chart] = texel;
            }
        }
        Ok(Self {
            map,
            finer,
            points: if finer == 1 { coarse } else { on_mesh(finer)? },
            first,
        })
    }

    /// What a texel inside a chart takes its value from.
    pub(super) fn sources(&self, texel: usize) -> impl Iterator<Item = Source> {
        let mut shares = [(texel, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];
        if self.finer > 1 {
            shares = self.beside(texel);
        }
        let point = match self.finer {
            1 => self.map.position[texel],
            _ => self.points.surface_point(&self.map.mesh, texel).position,
        };
        let seen = shares.into_iter().filter(|(_, share)| *share > 0.0);
        seen.filter_map(move |(texel, share)| {
            let coord = continued(self.map, texel, point)?;
            Some(Source {
                texel,
                coord,
                share,
            })
        })
    }

    /// The texels of the atlas round a finer one that lie in its chart, with their shares.
    fn beside(&self, texel: usize) -> [(usize, f32); 4] {
        let chart = self.map.chart_of[self.points.triangle[texel] as usize];
        let columns = self.points.width as usize;
        let place = |at: usize| (at as f32 + 0.5) / self.finer as f32 - 0.5;
        let (y, x) = (place(texel / columns), place(texel % columns));
        let (top, left) = (y.floor(), x.floor());
        let (down, right) = (y - top, x - left);
        let mut found = [(0, 0.0); 4];
        for (slot, (i, j)) in found.iter_mut().zip([(0, 0), (0, 1), (1, 0), (1, 1)]) {
            let rows = if i == 0 { 1.0 - down } else { down };
            let share = rows * if j == 0 { 1.0 - right } else { right };
            if let Some(texel) = self.in_chart(chart, top as i64 + i, left as i64 + j) {
                *slot = (texel, share);
            }
        }
        let sum: f32 = found.iter().map(|(_, share)| share).sum();
        if sum > 0.0 {
            return found.map(|(texel, share)| (texel, share / sum));
        }
        let nearest = self.nearest(chart, y.round() as i64, x.round() as i64);
        [(nearest, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)]
    }

    /// The texel of the atlas at a row and column, where it lies in a chart.
    fn in_chart(&self, chart: u32, row: i64, col: i64) -> Option<usize> {
        let (width, height) = (i64::from(self.map.width), i64::from(self.map.height));
        let is_there = (0..height).contains(&row) && (0..width).contains(&col);
        let texel = is_there.then_some((row * width + col) as usize)?;
        (i64::from(self.map.chart[texel]) == i64::from(chart)).then_some(texel)
    }

    /// The texel of a chart nearest to a place, of those near it; else its first.
    fn nearest(&self, chart: u32, row: i64, col: i64) -> usize {
        let around = -RINGS..=RINGS;
        let steps = around
            .clone()
            .flat_map(|down| around.clone().map(move |right| (down, right)));
        let near = steps.filter_map(|(down, right)| {
            let texel = self.in_chart(chart, row + down, col + right)?;
            Some((down * down + right * right, texel))
        });
        near.min()
            .map_or(self.first[chart as usize], |(_, texel)| texel)
    }
}

/// The texture coordinate of a texel of an atlas, continued to a point of the surface.
pub(super) fn continued(map: &AtlasMap, texel: usize, point: Vec3) -> Option<TexCoord> {
    let coord = map.coords[texel]?;
    let (s, n) = (map.orientation[texel], map.normal[texel]);
    let offset = (point - map.position[texel]).as_dvec3();
    let along = |axis: Vec3| (offset.dot(axis.as_dvec3()) / map.texel_at(texel)) as f32;
    Some(TexCoord {
        s: coord.s + along(s),
        t: coord.t + along(n.cross(s)),
    })
}
