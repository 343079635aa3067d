//! How much memory an atlas takes while it is prepared, before any work is done.

use super::options::{AtlasOptions, ChartSource};
use crate::mesh::atlas::FaceSquares;
use crate::mesh::reading::UserMesh;

/// Bytes of a packed sample and of a packed neighbour.
const ENTRY: f64 = 8.0;
/// Bytes per site of a level beside samples and neighbours: place, frame, cells, parent, edges.
const SITE: f64 = 200.0;
/// Bytes per texel of the image: its triangle, weights and site.
const TEXEL: f64 = 24.0;
/// Bytes per triangle of the mesh: topology, rings, field, charts.
const TRIANGLE: f64 = 700.0;
/// The share of the image that new charts fill at the most.
const FILLED: f64 = 0.85;
/// The program, and working memory of its threads.
const PROGRAM: f64 = (16_u64 << 20) as f64;

/// Bytes that preparing an atlas takes: per level the samples and neighbours, which are held twice at the
/// finest level while they are joined.
pub fn bytes_to_prepare(user: &UserMesh, options: &AtlasOptions) -> u64 {
    let texels = f64::from(options.resolution).powi(2);
    let sites = texels * filled(user, options);
    let square = |width: u32| f64::from(width).powi(2);
    let (fine, coarse) = (
        square(options.neighborhood),
        square(options.coarse_neighborhood),
    );
    let window = ENTRY * (2.0 * fine - 1.0);
    let levels: f64 = (0..options.levels)
        .map(|level| 0.25_f64.powi(level as i32))
        .sum();
    let kept = (window + SITE + ENTRY * coarse / 4.0) * levels;
    let bytes = sites * (kept + window)
        + texels * TEXEL * levels
        + triangles(user, options) * TRIANGLE
        + PROGRAM;
    bytes as u64
}

/// Triangles of the surface: the mesh's own, or those of its subdivision.
fn triangles(user: &UserMesh, options: &AtlasOptions) -> f64 {
    let own = user.mesh.triangles.len() as f64;
    let steps = squares(user, options).map_or(0, |squares| squares.steps());
    own * 4.0_f64.powi(steps as i32)
}

/// The squares of a control mesh's faces, where these are charts and have room.
fn squares(user: &UserMesh, options: &AtlasOptions) -> Option<FaceSquares> {
    let faces = user.mesh.triangles.len() / 2;
    match options.charts {
        ChartSource::Faces => FaceSquares::new(faces, options.resolution).ok(),
        ChartSource::Uv => None,
    }
}

/// The share of the image that charts fill: as much as the mesh's own cover, or as new ones do.
fn filled(user: &UserMesh, options: &AtlasOptions) -> f64 {
    if let Some(squares) = squares(user, options) {
        return squares.filled();
    }
    let Some(uvs) = user.corner_uvs.as_ref().filter(|_| !options.unwrap) else {
        return FILLED;
    };
    let area = |[a, b, c]: &[glam::Vec2; 3]| f64::from((b - a).perp_dot(c - a).abs()) / 2.0;
    let sum: f64 = uvs.iter().map(area).filter(|area| area.is_finite()).sum();
    sum.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn memory_grows_with_what_charts_fill() {
        let mesh = shapes::grid(4, 4, 0.25);
        let half = |mesh: &crate::mesh::triangle_mesh::TriangleMesh, scale: f32| {
            let uvs = (0..mesh.triangles.len())
                .map(|t| mesh.corners(t).map(|corner| corner.truncate() * scale));
            UserMesh {
                corner_uvs: Some(uvs.collect()),
                ..UserMesh::from(mesh.clone())
            }
        };
        let bytes = |scale| bytes_to_prepare(&half(&mesh, scale), &AtlasOptions::default());
        let (whole, quarter) = (bytes(1.0), bytes(0.5));
        // Samples and neighbours of 7 × 7, kept and joined.
        let least = 1024 * 1024 * 2 * 8 * 97;
        assert!((least..2 * least).contains(&whole), "{whole}");
        assert!(quarter < whole / 3);
    }
}
