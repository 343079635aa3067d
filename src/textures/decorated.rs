//! An atlas map as a surface texton map, as `render` draws it: the mesh cut to about a vertex per texel, moved
//! along its normals by the heights, its holes cut out.
//!
//! A vertex takes the texture coordinate of the texel that lies nearest to it in space, continued to it along s
//! and t. Deviation: Ying 2001 draws texture maps; here colours depend on view and light, and are shaded at
//! vertices or between them as those of any other map.

use glam::Vec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::grid::TexCoord;
use crate::index::TextonLabel;
use crate::maps::atlas_map::AtlasMap;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::tessellation::TexturedMesh;
use crate::progress::Progress;
use crate::textures::atlas_surface::{surface_of, texel_of};
use crate::textures::fine_texels::continued;
use crate::textures::holes;
use crate::textures::relief::{cut, displace, own_normals, vertex_means};
use crate::textures::texture::Texture;

/// Rings of texels round a vertex's place in the image in which its texel is looked for.
const RINGS: i64 = 8;
/// A texel farther than this from a vertex, in sides of a texel, belongs to another chart.
const NEAR: f32 = 3.0;

/// The images that change a surface's shape.
#[derive(Clone, Copy, Default)]
pub struct Shape<'a> {
    /// Heights, and the mesh units that one stands for.
    pub relief: Option<(&'a Texture, f64)>,
    /// How opaque the surface is.
    pub alpha: Option<&'a Texture>,
    /// Whether something else shows where the surface is transparent, so that it has no holes.
    pub is_covered: bool,
}

/// A surface ready to be rendered.
pub struct Decorated {
    /// The map on a mesh of about a vertex per texel.
    pub map: SurfaceTextonMap,
    /// How opaque each vertex is, from 0 to 1, where the surface is covered and has an alpha.
    pub alpha: Option<Vec<f32>>,
}

/// The map on a mesh of about a vertex per texel.
pub fn decorated(map: &AtlasMap, shape: Shape<'_>, progress: Progress<'_>) -> Result<Decorated> {
    // Cut the surface finely enough.
    let texel = texel_of(map);
    let mut surface = cut(surface_of(map), texel, progress)?.surface;
    // Leave out, or cover, what is transparent.
    let mut below = None;
    if let Some(alpha) = shape.alpha {
        let means = vertex_means(&surface, alpha);
        match shape.is_covered {
            true => below = Some(means.iter().map(|share| share.clamp(0.0, 1.0)).collect()),
            false => surface = without_holes(surface, &means)?,
        }
    }
    // Find the texel nearest to each vertex, and what it holds.
    let texels = nearest_texels(map, &surface, texel as f32);
    progress.check()?;
    let coords = texels
        .iter()
        .zip(&surface.mesh.positions)
        .map(|(texel, position)| {
            let coord = texel.and_then(|texel| continued(map, texel, *position));
            coord.map_or(TexCoord { s: 0.5, t: 0.5 }, |coord| on_grid(map, coord))
        });
    let coords = coords.collect();
    let scale = map.scale.as_ref().map(|scale| {
        let at = |texel: &Option<usize>| texel.map_or(1.0, |texel| scale[texel]);
        texels.iter().map(at).collect()
    });
    let label = |texel: &Option<usize>| texel.map_or(TextonLabel::NONE, |texel| map.textons[texel]);
    let textons = texels.iter().map(label).collect();
    // Displace the surface.
    if let Some((heights, amount)) = shape.relief {
        displace(&mut surface, heights, amount);
        own_normals(&mut surface);
    }
    // Project the orientations onto it.
    let orientation = |(texel, normal): (&Option<usize>, &Vec3)| {
        let s = texel.map_or(Vec3::X, |texel| map.orientation[texel]);
        let flat = s - *normal * s.dot(*normal);
        flat.try_normalize()
            .unwrap_or_else(|| normal.any_orthonormal_vector())
    };
    let on_mesh = SurfaceTextonMap {
        orientations: texels
            .iter()
            .zip(&surface.normals)
            .map(orientation)
            .collect(),
        normals: surface.normals,
        mesh: surface.mesh,
        scale,
        coords,
        textons,
        transition: None,
        mask: None,
        header: map.header.clone(),
    };
    Ok(Decorated {
        map: on_mesh,
        alpha: below,
    })
}

/// Per vertex the texel that lies nearest to it in space, of those near its place in the image; none for a
/// vertex in no triangle.
fn nearest_texels(map: &AtlasMap, surface: &TexturedMesh, side: f32) -> Vec<Option<usize>> {
    let mut uvs = vec![None; surface.mesh.positions.len()];
    let triangles = surface.mesh.triangles.iter().zip(&surface.corner_uvs);
    for (&vertex, &uv) in triangles.flat_map(|(corners, uvs)| corners.iter().zip(uvs)) {
        uvs[vertex as usize].get_or_insert(uv);
    }
    let vertices = uvs.into_par_iter().zip(&surface.mesh.positions);
    let texel = |(uv, position): (Option<glam::Vec2>, &Vec3)| {
        let uv = uv?;
        let (row, col) = ((1.0 - uv.y) * map.height as f32, uv.x * map.width as f32);
        nearest_texel(map, [row as i64, col as i64], *position, NEAR * side)
    };
    vertices.map(texel).collect()
}

/// The texel inside a chart nearest to a point, ring after ring round a place until one is near.
fn nearest_texel(map: &AtlasMap, [row, col]: [i64; 2], point: Vec3, near: f32) -> Option<usize> {
    let (width, height) = (i64::from(map.width), i64::from(map.height));
    let mut best: Option<(f32, usize)> = None;
    for ring in 0..=RINGS {
        let around = -ring..=ring;
        for (down, right) in around
            .clone()
            .flat_map(|down| around.clone().map(move |right| (down, right)))
        {
            let (row, col) = (row + down, col + right);
            if down.abs().max(right.abs()) < ring
                || !(0..height).contains(&row)
                || !(0..width).contains(&col)
            {
                continue;
            }
            let texel = (row * width + col) as usize;
            if map.chart[texel] < 0 {
                continue;
            }
            let distance = map.position[texel].distance(point);
            if best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, texel));
            }
        }
        // One ring more than the first that holds one: corners of a ring are farther than its sides.
        if ring > 0 && best.is_some_and(|(distance, _)| distance <= near) {
            break;
        }
    }
    best.map(|(_, texel)| texel)
}

/// A coordinate on the sample's grid: wrapped where that is tileable, else moved to its border.
fn on_grid(map: &AtlasMap, coord: TexCoord) -> TexCoord {
    let [width, height] = map.header.exemplar.map(|side| side as f32);
    let side = |at: f32, side: f32| match map.tileable {
        true => at.rem_euclid(side),
        false => at,
    };
    TexCoord {
        s: side(coord.s, width).clamp(0.0, width.next_down()),
        t: side(coord.t, height).clamp(f32::MIN_POSITIVE, height),
    }
}

/// The surface where alpha is one half or more.
fn without_holes(surface: TexturedMesh, alpha: &[f32]) -> Result<TexturedMesh> {
    let kept = holes::cut(surface, alpha);
    match kept.mesh.triangles.is_empty() {
        true => Err(Error::data("alpha", "below one half at every texel")
            .expected("texels that are not holes")),
        false => Ok(kept),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exemplar::channels::ChannelKind;
    use crate::maps::atlas_map::tests::square;
    use crate::textures::texture::tests::texture;

    #[test]
    fn vertices_go_on_from_their_texels() {
        let map = square();
        let on_mesh = decorated(&map, Shape::default(), Progress::silent())
            .unwrap()
            .map;
        assert!(on_mesh.mesh.positions.len() >= 9);
        assert!((on_mesh.mesh.area() - 1.0).abs() < 1e-6);
        for (position, coord) in on_mesh.mesh.positions.iter().zip(&on_mesh.coords) {
            // A texel of the sample covers a third; texels of the atlas begin at s = 0, t = 0 there.
            let wanted = (3.0 * position.x, 3.0 * position.y);
            let near = |a: f32, b: f32, side: f32| {
                let off = (a - b).rem_euclid(side);
                off.min(side - off) < 1e-4
            };
            assert!(
                near(coord.s, wanted.0, 8.0) && near(coord.t, wanted.1, 4.0),
                "{position} {coord:?}"
            );
        }
        assert!(
            on_mesh
                .textons
                .iter()
                .all(|label| *label != TextonLabel::NONE)
        );
        assert!(
            on_mesh
                .orientations
                .iter()
                .all(|s| s.distance(Vec3::X) < 1e-6)
        );
    }

    #[test]
    fn the_surface_is_moved_and_has_holes() {
        let map = square();
        let up = texture(ChannelKind::Height, 1, vec![0.5; 4]);
        let left = texture(ChannelKind::Alpha, 1, vec![1.0, 0.0, 1.0, 0.0]);
        let shape = Shape {
            relief: Some((&up, 0.4)),
            alpha: Some(&left),
            is_covered: false,
        };
        let made = decorated(&map, shape, Progress::silent()).unwrap().map;
        let used = made.mesh.triangles.iter().flatten();
        let mut used = used.map(|&vertex| made.mesh.positions[vertex as usize]);
        assert!(used.all(|p| (p.z - 0.2).abs() < 1e-6));
        let area = made.mesh.area();
        assert!((0.5..0.85).contains(&area), "{area}");
        // Over something else the whole surface is there, each vertex as opaque as its texel.
        let covered = Shape {
            alpha: Some(&left),
            is_covered: true,
            ..Shape::default()
        };
        let covered = decorated(&map, covered, Progress::silent()).unwrap();
        assert!((covered.map.mesh.area() - 1.0).abs() < 1e-6);
        let alpha = covered.alpha.unwrap();
        for (p, alpha) in covered.map.mesh.positions.iter().zip(alpha) {
            // The image's two columns are mixed from u = 1/4 to 3/4, the surface ends at 3/4.
            let wanted = 1.0 - (2.0 * (0.75 * p.x - 0.25)).clamp(0.0, 1.0);
            assert!((alpha - wanted).abs() < 1e-5, "{p}: {alpha}");
        }
        let none = texture(ChannelKind::Alpha, 1, vec![0.4; 4]);
        let shape = Shape {
            alpha: Some(&none),
            ..Shape::default()
        };
        assert!(decorated(&map, shape, Progress::silent()).is_err());
    }
}
