//! A decorated atlas as a surface texton map, to be rendered like any: the surface is cut to a vertex per texel,
//! each of which takes the coordinate of its texel, continued to the vertex in the texel's (s, t) plane.
//!
//! Where there are heights the surface can be moved along its normals, and where there is alpha the holes are cut
//! out, so that shadows and occlusion follow both.

use std::path::Path;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::exemplar::channels::ChannelKind;
use crate::grid::{TexCoord, TexelGrid};
use crate::index::TextonLabel;
use crate::maps::atlas_map::{AtlasMap, Description};
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::frame::Frame;
use crate::mesh::tessellation::{TexturedMesh, affordable_edge, tessellate};
use crate::progress::Progress;
use crate::textures::folder::{surface_of, texel_of};
use crate::textures::texture::Texture;
use crate::textures::{holes, image_file, relief};

/// The most triangles: as many as a displaced model has.
const MOST_TRIANGLES: usize = relief::MOST_TRIANGLES;
/// How far from a vertex, in texels of the atlas, a texel of its chart is looked for.
const REACH: i64 = 3;

/// Reads the folder of a decorated atlas as a surface texton map.
///
/// `displace` moves the surface along its normals, in mesh units per unit of the height channel. Errors: a folder
/// that is no atlas or is damaged, and displacement without heights.
pub fn read_decorated(
    folder: &Path,
    displace: Option<f64>,
    progress: Progress<'_>,
) -> Result<SurfaceTextonMap> {
    let map = AtlasMap::read(folder)?;
    let description = Description::read(folder)?;
    let texture = |kind: ChannelKind| {
        let file = description
            .channels
            .iter()
            .find(|channel| channel.kind == kind.name());
        file.map(|file| image_file::read(folder, file, [map.width, map.height]))
            .transpose()
    };
    let alpha = texture(ChannelKind::Alpha)?;
    let heights = match displace {
        None => None,
        Some(amount) => match texture(ChannelKind::Height)? {
            Some(heights) => Some((heights, amount)),
            None => {
                let found = format!("{amount}, but {} has no heights", folder.display());
                return Err(Error::option(
                    "displace",
                    found,
                    "an atlas with a channel of kind height",
                ));
            }
        },
    };
    decorated(
        &map,
        alpha.as_ref(),
        heights.as_ref().map(|(h, x)| (h, *x)),
        progress,
    )
}

/// A decorated atlas as a surface texton map; `heights` come with the mesh units that their unit stands for.
pub fn decorated(
    map: &AtlasMap,
    alpha: Option<&Texture>,
    heights: Option<(&Texture, f64)>,
    progress: Progress<'_>,
) -> Result<SurfaceTextonMap> {
    let smooth = surface_of(map);
    let edge = affordable_edge(&smooth.mesh, texel_of(map), MOST_TRIANGLES);
    let mut surface = tessellate(smooth, edge, MOST_TRIANGLES, progress)?;
    progress.check()?;
    if let Some(alpha) = alpha {
        let means = relief::vertex_means(&surface, alpha);
        surface = holes::cut(surface, &means);
        if surface.mesh.triangles.is_empty() {
            return Err(Error::data("alpha", "below one half everywhere")
                .expected("an atlas that is opaque somewhere"));
        }
    }
    let vertices = Vertices::of(map, &surface);
    progress.check()?;
    if let Some((heights, amount)) = heights {
        relief::moved(&mut surface, heights, amount);
        relief::own_normals(&mut surface);
    }
    Ok(vertices.into_map(map, surface))
}

/// What the vertices hold.
struct Vertices {
    coords: Vec<TexCoord>,
    textons: Vec<TextonLabel>,
    /// The orientation of the texel that each takes after.
    orientations: Vec<Vec3>,
}

impl Vertices {
    /// Each vertex after the nearest texel; those in no triangle hold nothing.
    fn of(map: &AtlasMap, surface: &TexturedMesh) -> Self {
        let count = surface.mesh.positions.len();
        let mut uvs = vec![None; count];
        let corners = surface.mesh.triangles.iter().zip(&surface.corner_uvs);
        for (&vertex, &uv) in corners.flat_map(|(corners, uvs)| corners.iter().zip(uvs)) {
            uvs[vertex as usize].get_or_insert(uv);
        }
        let held: Vec<_> = surface
            .mesh
            .positions
            .par_iter()
            .zip(&uvs)
            .map(|(&position, uv)| {
                let texel = uv.and_then(|uv| nearest_texel(map, uv, position));
                texel.map_or(NOTHING, |texel| continued(map, texel, position))
            })
            .collect();
        Self {
            coords: held.iter().map(|held| held.0).collect(),
            textons: held.iter().map(|held| held.1).collect(),
            orientations: held.iter().map(|held| held.2).collect(),
        }
    }

    fn into_map(self, map: &AtlasMap, surface: TexturedMesh) -> SurfaceTextonMap {
        let frame = |(&normal, &s): (&Vec3, &Vec3)| {
            Frame::new(normal, s).or_else(|| Frame::new(normal, normal.any_orthonormal_vector()))
        };
        let pairs = surface.normals.iter().zip(&self.orientations);
        let orientations = pairs.map(|pair| frame(pair).map_or(Vec3::X, |frame| frame.s));
        SurfaceTextonMap {
            orientations: orientations.collect(),
            mesh: surface.mesh,
            normals: surface.normals,
            scale: None,
            coords: self.coords,
            textons: self.textons,
            exemplar: map.exemplar,
            texel: map.texel,
            origin: map.origin,
            seed: map.seed,
            method: map.method.clone(),
            sample: map.sample.clone(),
            space: map.space.clone(),
        }
    }
}

/// What a vertex in no triangle holds.
const NOTHING: (TexCoord, TextonLabel, Vec3) =
    (TexCoord { s: 0.5, t: 0.5 }, TextonLabel::NONE, Vec3::X);

/// The texel inside a chart that lies nearest on the surface, of those round a place in the atlas.
fn nearest_texel(map: &AtlasMap, uv: Vec2, position: Vec3) -> Option<usize> {
    let (width, height) = (i64::from(map.width), i64::from(map.height));
    let column = (uv.x * map.width as f32).floor() as i64;
    let row = ((1.0 - uv.y) * map.height as f32).floor() as i64;
    let texels = (row - REACH..=row + REACH)
        .flat_map(|row| (column - REACH..=column + REACH).map(move |column| (row, column)))
        .filter(|(row, column)| (0..height).contains(row) && (0..width).contains(column))
        .map(|(row, column)| (row * width + column) as usize)
        .filter(|&texel| map.coords[texel].is_some());
    texels.min_by(|&a, &b| {
        let distance = |texel: usize| map.position[texel].distance_squared(position);
        distance(a).total_cmp(&distance(b)).then(a.cmp(&b))
    })
}

/// What a vertex near a texel holds: the texel's coordinate, continued in its (s, t) plane.
fn continued(map: &AtlasMap, texel: usize, position: Vec3) -> (TexCoord, TextonLabel, Vec3) {
    let s = map.orientation[texel];
    let along = (position - map.position[texel]) / map.texel as f32;
    let t = map.normal[texel].cross(s);
    let held = map.coords[texel].unwrap_or(NOTHING.0);
    let at = TexCoord {
        s: held.s + along.dot(s),
        t: held.t + along.dot(t),
    };
    (on_grid(map.grid(), at), map.textons[texel], s)
}

/// A coordinate wrapped or clamped to the sample.
fn on_grid(grid: TexelGrid, at: TexCoord) -> TexCoord {
    let (width, height) = (grid.width as f32, grid.height as f32);
    let down = height - at.t;
    let held = |value: f32, side: f32| {
        let value = if grid.tileable {
            value.rem_euclid(side)
        } else {
            value
        };
        value.clamp(0.0, side.next_down())
    };
    TexCoord {
        s: held(at.s, width),
        t: height - held(down, height),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::Precision;
    use crate::maps::atlas_map::tests::square;

    /// A number per texel of the square's atlas.
    fn texture(kind: ChannelKind, number: impl Fn(usize) -> f32) -> Texture {
        Texture {
            name: kind.name().into(),
            kind,
            count: 1,
            low: 0.0,
            high: 1.0,
            precision: Precision::Float,
            width: 4,
            height: 4,
            numbers: (0..16).map(number).collect(),
        }
    }

    #[test]
    fn coordinates_continue_between_texels() {
        let shown = decorated(&square(), None, None, Progress::silent()).unwrap();
        assert!(shown.mesh.positions.len() > 9);
        let apart = |a: f32, b: f32, side: f32| (a - b + 0.5 * side).rem_euclid(side) - 0.5 * side;
        for (p, at) in shown.mesh.positions.iter().zip(&shown.coords) {
            // The sample lies on the square as it is, three texels along each side.
            assert!(apart(at.s, 3.0 * p.x, 8.0).abs() < 1e-4, "{p}: {at:?}");
            assert!(apart(at.t, 3.0 * p.y, 4.0).abs() < 1e-4, "{p}: {at:?}");
            assert!((0.0..8.0).contains(&at.s) && at.t > 0.0 && at.t <= 4.0);
        }
        assert!(shown.orientations.iter().all(|s| *s == Vec3::X));
    }

    #[test]
    fn heights_move_vertices_but_not_what_they_hold() {
        let map = square();
        let heights = texture(ChannelKind::Height, |_| 0.5);
        let level = decorated(&map, None, None, Progress::silent()).unwrap();
        let moved = decorated(&map, None, Some((&heights, 0.4)), Progress::silent()).unwrap();
        assert!(
            moved
                .mesh
                .positions
                .iter()
                .all(|p| (p.z - 0.2).abs() < 1e-6)
        );
        assert_eq!(moved.coords, level.coords);
    }

    #[test]
    fn what_is_transparent_is_cut_out() {
        let map = square();
        // The left column of three is transparent: alpha passes one half between the first two.
        let alpha = texture(ChannelKind::Alpha, |texel| {
            f32::from(u8::from(texel % 4 > 0))
        });
        let shown = decorated(&map, Some(&alpha), None, Progress::silent()).unwrap();
        let least = shown.mesh.triangles.iter().flatten();
        let least = least.map(|&v| shown.mesh.positions[v as usize].x);
        let least = least.fold(f32::INFINITY, f32::min);
        assert!((least - 1.0 / 3.0).abs() < 0.1, "{least}");
        let none = texture(ChannelKind::Alpha, |_| 0.2);
        let refused = decorated(&map, Some(&none), None, Progress::silent());
        assert!(refused.unwrap_err().to_string().contains("alpha"));
    }
}
