//! The origin that a mesh's coordinates are relative to.
//!
//! Georeferenced meshes (UTM, ECEF) lie millions of units from zero, where single precision has steps of
//! half a unit. An origin near the mesh is subtracted in double precision on reading and added again on
//! writing; everything between works with small numbers.

use glam::DVec3;

use crate::format::polygon_mesh::PolygonMesh;
use crate::progress::Progress;

/// Distance from zero, in diagonals of the mesh's box, from which an origin is subtracted.
const FAR: f64 = 8.0;
/// A step beyond this share of the median edge is coarse.
const COARSE: f64 = 0.01;
/// Edges that are looked at for their median.
const EDGES: usize = 1 << 16;

/// The box round the corners of all faces.
struct Extent {
    low: DVec3,
    high: DVec3,
}

impl Extent {
    fn of(file: &PolygonMesh) -> Option<Self> {
        let corners = file.faces.corners.iter();
        let mut points = corners.map(|&v| DVec3::from_array(file.positions[v as usize]));
        let first = points.next()?;
        let (low, high) = points.fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
        Some(Self { low, high })
    }

    fn diagonal(&self) -> f64 {
        (self.high - self.low).length()
    }

    /// The largest coordinate.
    fn farthest(&self) -> f64 {
        self.low.abs().max(self.high.abs()).max_element()
    }
}

/// The origin that suits a file: zero for a mesh near zero, else a round number near its middle.
pub fn origin_of(file: &PolygonMesh) -> DVec3 {
    let Some(extent) = Extent::of(file) else {
        return DVec3::ZERO;
    };
    let diagonal = extent.diagonal();
    if diagonal == 0.0 || extent.farthest() <= FAR * diagonal {
        return DVec3::ZERO;
    }
    // A power of two: multiples have few digits, and their sums with positions are exact.
    let step = diagonal.log2().floor().exp2();
    let middle = 0.5 * (extent.low + extent.high);
    (middle / step).round() * step
}

/// An origin as `comment origin` and frames have it; `None` for zero.
pub fn origin_text(origin: DVec3) -> Option<String> {
    let DVec3 { x, y, z } = origin;
    (origin != DVec3::ZERO).then(|| format!("{x} {y} {z}"))
}

/// The comment of a PLY whose positions count from an origin.
pub fn origin_comment(origin: DVec3) -> Option<String> {
    origin_text(origin).map(|text| format!("origin {text}"))
}

/// Says so when single precision, the file's or ours, is coarse against the edges.
pub fn warn_of_precision(file: &PolygonMesh, progress: Progress<'_>) {
    let Some(extent) = Extent::of(file) else {
        return;
    };
    let edge = median_edge(file);
    let (farthest, advice) = match file.single_precision {
        true => (
            extent.farthest(),
            "export it nearer to zero, or with double precision",
        ),
        false => (extent.diagonal(), "split it into smaller parts"),
    };
    let step = single_step(farthest);
    if edge > 0.0 && step > COARSE * edge {
        progress.warn(format!(
            "single precision has steps of {step:.3e} at coordinates of {farthest:.3e}, coarse against edges of \
             {edge:.3e}: the shape is rounded; {advice}"
        ));
    }
}

/// The distance between neighbouring numbers of single precision at `value`.
fn single_step(value: f64) -> f64 {
    let value = value as f32;
    f64::from(value.next_up()) - f64::from(value)
}

fn median_edge(file: &PolygonMesh) -> f64 {
    let every = file.faces.sizes.len().div_ceil(EDGES).max(1);
    let mut lengths: Vec<f64> = file
        .faces
        .iter()
        .step_by(every)
        .map(|polygon| {
            let [a, b] =
                [polygon[0], polygon[1]].map(|v| DVec3::from_array(file.positions[v as usize]));
            a.distance(b)
        })
        .filter(|length| *length > 0.0)
        .collect();
    lengths.sort_by(f64::total_cmp);
    lengths.get(lengths.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Event;
    use std::sync::Mutex;

    /// A triangle with legs of 0.1, moved.
    fn triangle(moved: [f64; 3], single_precision: bool) -> PolygonMesh {
        let corner = |x: f64, y: f64| [moved[0] + x, moved[1] + y, moved[2]];
        let mut mesh = PolygonMesh {
            positions: vec![
                corner(0.0, 0.0),
                corner(0.1, 0.0),
                corner(0.0, 0.1),
                [0.0; 3],
            ],
            single_precision,
            ..PolygonMesh::default()
        };
        mesh.faces.push(&[0, 1, 2]);
        mesh
    }

    #[test]
    fn only_far_meshes_have_an_origin_and_a_round_one() {
        assert_eq!(origin_of(&triangle([1.0, 0.5, 0.0], false)), DVec3::ZERO);
        let origin = origin_of(&triangle([701_362.5, 4_485_513.7, 182.3], false));
        assert!((origin - DVec3::new(701_362.5, 4_485_513.7, 182.3)).length() < 0.2);
        assert_eq!(origin * 16.0, (origin * 16.0).round());
        assert_eq!(origin_of(&PolygonMesh::default()), DVec3::ZERO);
    }

    #[test]
    fn coarse_numbers_are_told() {
        let warnings = |mesh: &PolygonMesh| {
            let told = Mutex::new(0);
            let listener = |event| {
                if let Event::Warn(_) = event {
                    *told.lock().unwrap() += 1;
                }
            };
            warn_of_precision(mesh, Progress::new(&listener, None));
            told.into_inner().unwrap()
        };
        assert_eq!(warnings(&triangle([4_485_513.7; 3], true)), 1);
        assert_eq!(warnings(&triangle([4_485_513.7; 3], false)), 0);
        assert_eq!(warnings(&triangle([1.0; 3], true)), 0);
    }
}
