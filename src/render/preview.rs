//! False-colour pictures of a mesh with a colour at each vertex, for looking at fields, labels and
//! levels: fitted camera, antialiased, shaded softly by the facets so that the shape is seen.

use glam::{DVec3, Vec3};

use crate::error::{Error, Result};
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;
use crate::render::azimuth::{Axis, AzimuthFrame};
use crate::render::bounds::{Bounds, used_points};
use crate::render::camera::View;
use crate::render::framing::{Aim, FittedProjection};
use crate::render::raster::{Hit, Samples, SurfaceBuffer};

/// Draws a mesh in the colours of its vertices (8-bit sRGB values, interpolated as they stand)
/// from a camera fitted at azimuth 25° and elevation 20° of the +y axis; returns row-major
/// (height, width, RGB) bytes, as [`write_png`](crate::format::image::write_png) takes them.
pub fn vertex_colors(mesh: &TriangleMesh, colors: &[[u8; 3]], size: [u32; 2]) -> Result<Vec<u8>> {
    // Check the colours.
    if colors.len() != mesh.positions.len() {
        return Err(Error::data("colors", colors.len().to_string())
            .expected(format!("{}, one per vertex", mesh.positions.len())));
    }
    // Fit the camera.
    let bounds = Bounds::of(mesh)?;
    let azimuths = AzimuthFrame::facing(Axis::Y, Axis::Z);
    let towards = azimuths.direction(25f64.to_radians(), 20f64.to_radians());
    let aim = Aim {
        target: bounds.centre,
        towards,
        up: DVec3::Y,
        projection: FittedProjection::Perspective {
            vertical_fov: 30f64.to_radians(),
        },
        aspect: f64::from(size[0]) / f64::from(size[1]),
    };
    let framed = aim.still(used_points(mesh), bounds.radius, true);
    let view = View::new(aim.camera(&framed), size)?;
    // Draw.
    let surface = SurfaceBuffer::draw(
        &view,
        mesh,
        Samples::Four,
        bounds.nearest(),
        Progress::silent(),
    );
    let light = towards.as_vec3();
    let pixels = surface.map_pixels(
        BACKGROUND.map(|v| v as u8),
        || (),
        |(), hits| pixel(mesh, colors, light, surface.color_hits(hits)),
    );
    Ok(pixels.into_iter().flatten().collect())
}

const BACKGROUND: [f32; 3] = [255.0; 3];

fn pixel(mesh: &TriangleMesh, colors: &[[u8; 3]], light: Vec3, hits: &[Hit]) -> [u8; 3] {
    let seen = |hit: &Hit| {
        if !hit.is_surface() {
            return Vec3::from_array(BACKGROUND);
        }
        let triangle = hit.triangle as usize;
        let normal = mesh.area_normal(triangle).normalize_or_zero();
        let shade = 0.35 + 0.65 * normal.dot(light).abs();
        let corners = mesh.triangles[triangle];
        let color: Vec3 = corners
            .iter()
            .zip(hit.barycentric())
            .map(|(&v, weight)| Vec3::from_array(colors[v as usize].map(f32::from)) * weight)
            .sum();
        color * shade
    };
    let mean = hits.iter().map(seen).sum::<Vec3>() / hits.len() as f32;
    mean.to_array().map(|value| (value + 0.5) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_red_triangle_is_red_on_white() {
        let mesh = TriangleMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
        };
        let picture = vertex_colors(&mesh, &[[200, 0, 0]; 3], [40, 30]).unwrap();
        assert_eq!(picture.len(), 40 * 30 * 3);
        assert_eq!(picture[..3], [255, 255, 255]);
        let red = picture
            .chunks(3)
            .filter(|p| p[0] > 100 && p[1] == 0)
            .count();
        assert!(red > 50, "{red}");
        assert!(vertex_colors(&mesh, &[[0; 3]; 2], [40, 30]).is_err());
    }
}
