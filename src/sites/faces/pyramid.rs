//! All levels of a surface whose triangles have two colours.

use crate::error::{Error, Result};
use crate::mesh::face_colors::ColoredMesh;
use crate::mesh::subdivision::butterfly::{CHILDREN, butterfly, inherited_colors};
use crate::progress::Progress;
use crate::sites::faces::level::FaceLevel;

/// Levels of faces, each cut in four on the next.
#[derive(Clone, Debug, PartialEq)]
pub struct FacePyramid {
    /// The coarsest first. The children of face f are 4·f … 4·f + 3 on the next level, the centre last; child k has
    /// corner k of its parent as its own corner k.
    pub levels: Vec<FaceLevel>,
}

impl FacePyramid {
    /// A base mesh and its butterfly subdivisions.
    ///
    /// Errors: `subdivisions` that make more than 2³² half-edges.
    pub fn subdivided(
        base: &ColoredMesh,
        subdivisions: u32,
        progress: Progress<'_>,
    ) -> Result<Self> {
        check_count(base.mesh.triangles.len(), subdivisions)?;
        progress.begin("subdivision", u64::from(subdivisions));
        let mut levels = vec![FaceLevel::new(base.mesh.clone(), base.white.clone())];
        for number in 0..subdivisions as usize {
            let coarser = &levels[number];
            let finer = butterfly(&coarser.mesh, &coarser.topology);
            let white = inherited_colors(&coarser.white);
            levels.push(FaceLevel::new(finer, white));
            progress.advance(1)?;
        }
        progress.end();
        Ok(Self { levels })
    }
}

/// Refuses numbers of faces whose half-edges cannot be numbered.
pub(crate) fn check_count(faces: usize, subdivisions: u32) -> Result<()> {
    let children = u64::from(CHILDREN).checked_pow(subdivisions);
    let half_edges = children
        .and_then(|children| children.checked_mul(faces as u64))
        .and_then(|faces| faces.checked_mul(3));
    match half_edges {
        Some(half_edges) if half_edges < u64::from(u32::MAX) => Ok(()),
        _ => Err(Error::option(
            "subdivisions",
            format!("{subdivisions} of {faces} faces"),
            "at most 1.4 billion faces on the finest level",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::face_colors::colored_base;
    use crate::mesh::shapes;

    #[test]
    fn levels_are_nested_in_fours_and_properly_colored() {
        let torus = shapes::torus(12, 8, 1.0, 0.4);
        let quiet = Progress::silent();
        let base = colored_base(&torus, 192, 0.7, quiet).unwrap();
        let pyramid = FacePyramid::subdivided(&base, 2, quiet).unwrap();
        let counts: Vec<usize> = pyramid.levels.iter().map(FaceLevel::count).collect();
        assert_eq!(counts, [192, 768, 3072]);
        for level in &pyramid.levels {
            for (half_edge, &twin) in level.topology.opposite.iter().enumerate() {
                assert_ne!(level.white[half_edge / 3], level.white[twin as usize / 3]);
            }
        }
        for (coarser, finer) in pyramid.levels.iter().zip(&pyramid.levels[1..]) {
            for parent in 0..coarser.count() {
                let away = coarser.centers[parent].distance(finer.centers[4 * parent + 3]);
                let near = coarser.adjacent_distances().mean as f32;
                assert!(away < 0.3 * near);
            }
        }
    }

    #[test]
    fn too_many_subdivisions_are_refused() {
        assert!(check_count(8, 13).is_ok());
        for (faces, subdivisions) in [(8, 14), (1, 40), (2_000_000_000, 0)] {
            let error = check_count(faces, subdivisions).unwrap_err().to_string();
            assert!(error.contains("--subdivisions"), "{error}");
        }
    }
}
