//! New texture coordinates for a mesh: cut into charts, flattened and packed by the library `uvunwrap`
//! (region growing within a cone of normals, least-squares conformal maps refined to keep areas).

use glam::Vec2;
use uvunwrap::{Density, MeshInput, Options, Stage, generate_with_progress};

use super::charts::Atlas;
use crate::error::{Error, Result};
use crate::mesh::topology::NONE;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;

/// Texels between a chart and the border of the image; twice as many lie between two charts.
const PADDING: u32 = 2;
/// The most triangles that are unwrapped: a million take minutes.
const MOST_TRIANGLES: usize = 1 << 20;
/// The smallest image that charts are packed into, in texels.
const LEAST_RESOLUTION: u32 = 16;

impl Atlas {
    /// Cuts a mesh into charts and lays them out in a square image of `resolution` texels per side, with room
    /// between them. Refuses more than 2²⁰ triangles, and a resolution at which the charts do not fit.
    ///
    /// A triangle too thin to be flattened has no area in the texture and lies on a corner of its
    /// neighbour's chart.
    pub fn unwrapped(mesh: &TriangleMesh, resolution: u32, progress: Progress<'_>) -> Result<Self> {
        if resolution < LEAST_RESOLUTION {
            return Err(too_small(resolution, "to unwrap the mesh"));
        }
        let triangles = mesh.triangles.len();
        if triangles > MOST_TRIANGLES {
            return Err(
                Error::data("mesh", format!("{triangles} triangles to unwrap"))
                    .expected(format!("at most {MOST_TRIANGLES}"))
                    .advice(
                        "retile it with mesotex mesh --vertices, or give it texture coordinates",
                    ),
            );
        }
        let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|p| p.to_array()).collect();
        let input = MeshInput::new(&positions, mesh.triangles.as_flattened());
        let options = Options {
            density: Density::Auto {
                page_size: resolution,
            },
            padding: PADDING,
            ..Options::default()
        };
        progress.begin("unwrapping", mesh.triangles.len() as u64);
        let flattened = std::sync::atomic::AtomicUsize::new(0);
        let listen = |report: uvunwrap::Progress| {
            if report.stage == Stage::Parameterizing {
                let before = flattened.swap(report.done, std::sync::atomic::Ordering::Relaxed);
                // An interruption is seen again below.
                let _ = progress.advance(report.done.saturating_sub(before) as u64);
            }
            !progress.is_interrupted()
        };
        let found = generate_with_progress(&[input], &options, listen);
        progress.check()?;
        progress.end();
        let found = found.map_err(|error| {
            Error::data("mesh", format!("cannot be unwrapped: {error}"))
                .advice("clean or retile it with mesotex mesh")
        })?;
        if found.page_count > 1 {
            let asked = format!("for the {} charts of this mesh", found.chart_count);
            return Err(too_small(resolution, &asked));
        }
        Self::of_unwrapped(mesh, &found, resolution)
    }

    fn of_unwrapped(mesh: &TriangleMesh, found: &uvunwrap::Atlas, resolution: u32) -> Result<Self> {
        let Some(output) = found.meshes.first() else {
            return Err(Error::data("mesh", "was not unwrapped"));
        };
        // The library crops the image to what is used; texels keep their size and place here.
        let used = Vec2::new(found.width as f32, found.height as f32) / resolution as f32;
        let corner = |index: &u32| Vec2::from_array(output.vertices[*index as usize].uv) * used;
        let (triangles, _) = output.indices.as_chunks::<3>();
        let corner_uvs = triangles
            .iter()
            .map(|corners| corners.each_ref().map(corner))
            .collect();
        let charts: Vec<u32> = triangles
            .iter()
            .map(|corners| output.vertices[corners[0] as usize].chart.unwrap_or(NONE))
            .collect();
        if let Some(triangle) = charts.iter().position(|&chart| chart == NONE) {
            let [a, b, c] = mesh.triangles[triangle];
            return Err(Error::data(
                format!("triangle {triangle}"),
                format!("too thin to be unwrapped (vertices {a}, {b}, {c})"),
            )
            .expected("a neighbour with an area")
            .advice("mesotex mesh --specks drops small pieces"));
        }
        Ok(Self::of_labels(corner_uvs, &charts))
    }
}

fn too_small(resolution: u32, what: &str) -> Error {
    let found = format!("{resolution} is too small {what}");
    Error::option("resolution", found, "more texels")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::atlas::{TexelPoints, overlap};
    use crate::mesh::shapes;

    fn unwrapped(mesh: &TriangleMesh, threads: usize) -> Atlas {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| Atlas::unwrapped(mesh, 128, Progress::silent()).unwrap())
    }

    #[test]
    fn unwrapped_shapes_are_atlases_at_any_number_of_threads() {
        for mesh in [
            shapes::torus(24, 12, 1.0, 0.4),
            shapes::icosphere(3),
            shapes::cylinder(16, 8, 1.0, 0.3),
        ] {
            let atlas = unwrapped(&mesh, 1);
            assert_eq!(atlas, unwrapped(&mesh, 4));
            assert_eq!(atlas.corner_uvs.len(), mesh.triangles.len());
            assert_eq!(overlap::first_overlap(&atlas.corner_uvs), None);
            let own = Atlas::of_uvs(&mesh, &atlas.corner_uvs).unwrap();
            assert_eq!(own.charts, atlas.charts);
            TexelPoints::new(&mesh, &atlas, 128, 128).unwrap();
        }
    }

    #[test]
    fn texels_cover_about_the_same_area_everywhere() {
        let mesh = shapes::torus(48, 24, 1.0, 0.4);
        let atlas = unwrapped(&mesh, 2);
        let areas = |t: usize| {
            let [a, b, c] = atlas.corners(t);
            let flat = (b - a).perp_dot(c - a);
            mesh.area_normal_f64(t).length() / flat
        };
        let all: Vec<f64> = (0..mesh.triangles.len()).map(areas).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        assert!(all.iter().all(|area| (0.5..2.0).contains(&(area / mean))));
    }

    #[test]
    fn a_mesh_too_large_to_unwrap_is_refused_with_its_size() {
        let mesh = shapes::grid(1024, 513, 1.0);
        let refused = Atlas::unwrapped(&mesh, 1024, Progress::silent());
        let text = refused.unwrap_err().to_string();
        assert!(
            text.contains("1050624") && text.contains("at most 1048576"),
            "{text}"
        );
    }

    #[test]
    fn a_resolution_for_nothing_is_refused() {
        let mesh = shapes::icosphere(1);
        let refused = Atlas::unwrapped(&mesh, 3, Progress::silent());
        assert!(refused.unwrap_err().to_string().contains("--resolution"));
    }
}
