//! A decorated surface small enough for a page: positions, frames and texture coordinates in whole numbers of 16 bits.
//! `web/surface.js` reads them.

use glam::{DVec3, Vec3};
use serde::Serialize;

use crate::error::Result;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::render::bounds::Bounds;
use crate::render::sides::has_border;
use crate::report::numbers::{append_column, append_indices};

/// The largest number of a column.
const MOST: f64 = 65535.0;

/// What the numbers stand for.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SurfaceDescription {
    vertices: usize,
    triangles: usize,
    /// The box of the positions.
    low: [f64; 3],
    high: [f64; 3],
    /// Columns and rows of the sample that coordinates count in.
    grid: [u32; 2],
    /// Mesh units that a texel covers where the scale is 1.
    texel: f64,
    is_scaled: bool,
    /// Logarithms of the smallest and the largest scale.
    scale_low: f64,
    scale_high: f64,
    /// Whether insides are seen too.
    has_border: bool,
}

/// The description of a surface, and its columns.
pub fn surface_columns(
    map: &SurfaceTextonMap,
    bounds: &Bounds,
) -> Result<(SurfaceDescription, Vec<u8>)> {
    let mut bytes = Vec::new();
    // Write positions within their bounds.
    let within = |value: f64, low: f64, high: f64| {
        let share = if high > low {
            (value - low) / (high - low)
        } else {
            0.0
        };
        (share.clamp(0.0, 1.0) * MOST).round() as u16
    };
    for axis in 0..3 {
        let (low, high) = (bounds.low[axis], bounds.high[axis]);
        let positions = map.mesh.positions.iter();
        append_column(
            &mut bytes,
            positions.map(|p| within(f64::from(p[axis]), low, high)),
        );
    }
    // Write unit vectors on an octahedron.
    for vectors in [&map.normals, &map.orientations] {
        for place in 0..2 {
            append_column(&mut bytes, vectors.iter().map(|&v| on_octahedron(v)[place]));
        }
    }
    // Write texture coordinates.
    let [width, height] = map.header.exemplar;
    let coordinate = |value: f32, side: u32| {
        (f64::from(value) / f64::from(side) * (MOST + 1.0)).min(MOST) as u16
    };
    append_column(
        &mut bytes,
        map.coords.iter().map(|at| coordinate(at.s, width)),
    );
    append_column(
        &mut bytes,
        map.coords.iter().map(|at| coordinate(at.t, height)),
    );
    // Write the logarithm of the scale.
    let (mut scale_low, mut scale_high) = (0.0, 0.0);
    if let Some(scale) = &map.scale {
        let logarithms = || scale.iter().map(|&value| f64::from(value).ln());
        scale_low = logarithms().fold(f64::INFINITY, f64::min);
        scale_high = logarithms().fold(f64::NEG_INFINITY, f64::max);
        append_column(
            &mut bytes,
            logarithms().map(|value| within(value, scale_low, scale_high)),
        );
    }
    // Write the triangles.
    append_indices(&mut bytes, map.mesh.triangles.iter().flatten().copied());
    // Describe the columns.
    let description = SurfaceDescription {
        vertices: map.mesh.positions.len(),
        triangles: map.mesh.triangles.len(),
        low: DVec3::to_array(&bounds.low),
        high: DVec3::to_array(&bounds.high),
        grid: map.header.exemplar,
        texel: map.header.texel,
        is_scaled: map.scale.is_some(),
        scale_low,
        scale_high,
        has_border: has_border(&map.mesh),
    };
    Ok((description, bytes))
}

/// A unit vector as its place on the unfolded octahedron.
fn on_octahedron(vector: Vec3) -> [u16; 2] {
    let flat = vector / (vector.x.abs() + vector.y.abs() + vector.z.abs());
    let (mut x, mut y) = (flat.x, flat.y);
    if flat.z < 0.0 {
        (x, y) = (
            (1.0 - flat.y.abs()) * flat.x.signum(),
            (1.0 - flat.x.abs()) * flat.y.signum(),
        );
    }
    [x, y].map(|value| (f64::from(0.5 + 0.5 * value).clamp(0.0, 1.0) * MOST).round() as u16)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What `web/surface.js` does.
    fn of_octahedron([a, b]: [u16; 2]) -> Vec3 {
        let (x, y) = (f32::from(a) / 32767.5 - 1.0, f32::from(b) / 32767.5 - 1.0);
        let z = 1.0 - x.abs() - y.abs();
        let fold = (-z).max(0.0);
        Vec3::new(x - x.signum() * fold, y - y.signum() * fold, z).normalize()
    }

    #[test]
    fn directions_survive_the_octahedron() {
        for k in 0..200 {
            let (a, b) = (k as f32 * 0.7, k as f32 * 0.031 - 1.5);
            let v = Vec3::new(a.cos() * b.cos(), a.sin() * b.cos(), b.sin());
            assert!(v.distance(of_octahedron(on_octahedron(v))) < 1e-4, "{v}");
        }
        for v in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z] {
            assert!(v.distance(of_octahedron(on_octahedron(v))) < 1e-4, "{v}");
        }
    }
}
