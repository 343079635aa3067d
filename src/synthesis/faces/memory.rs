//! How much memory choosy sampling takes, before any work is done.

use crate::maps::face_map::FaceMap;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::sites::faces::neighborhood::NEIGHBORS;
use crate::sites::faces::plan::FacePlan;
use crate::sites::vertices::memory::bytes_to_retile;

/// Bytes of a face on all levels of a surface: its mesh, neighbours across edges, centre, source.
const FACE: u64 = 190;
/// Numbers of a channel that are held per face on all levels: both pyramids, and a level while it is projected.
const NUMBERS: u64 = 4;
/// Bytes of a triangle of the sample's grids on all levels: its mesh, its neighbourhood, its place in the tree.
const SAMPLE_FACE: u64 = 700;
/// Matrices of products of a neighbourhood's numbers that are held at once.
const MATRICES: u64 = 12;
/// Bytes of a face of a GLB: three vertices of its own, in lists and in the file's.
const MODEL_FACE: u64 = 300;
/// Bytes of a face that is written: the columns of its file.
const WRITTEN_FACE: u64 = 60;
/// The program, and working memory of its threads.
const PROGRAM: u64 = 16 << 20;

/// Bytes that a texture on a mesh takes, of this many numbers per texel of which `dimensions` are compared;
/// `has_model` says whether a GLB is written.
pub fn bytes_to_synthesize(
    mesh: &TriangleMesh,
    plan: &FacePlan,
    (channels, dimensions): (usize, usize),
    has_model: bool,
) -> u64 {
    let numbers = 4 * NUMBERS * channels as u64;
    let of_face = FACE + numbers + WRITTEN_FACE + if has_model { MODEL_FACE } else { 0 };
    let surface = plan.faces().saturating_mul(of_face);
    let of_sample_face = SAMPLE_FACE + 2 * numbers + 16 * dimensions as u64;
    let sample = plan.sample_faces().saturating_mul(of_sample_face);
    let pattern = (NEIGHBORS * channels) as u64;
    let retiled = bytes_to_retile(mesh.positions.len().max(plan.base_faces));
    let all = [
        surface,
        sample,
        8 * MATRICES * pattern * pattern,
        retiled,
        PROGRAM,
    ];
    all.into_iter().fold(0, u64::saturating_add)
}

/// Bytes of a face that is drawn: three vertices with place, frame and texture coordinate.
const DRAWN_FACE: u64 = 240;
/// Bytes of a triangle of the sample's grid on all levels.
const GRID_FACE: u64 = 130;

/// Bytes that a face map takes when it is drawn: its faces, and the grid that their sources are of.
pub fn bytes_to_decorate(map: &FaceMap) -> u64 {
    let side = u64::from(map.square.side);
    let grid = 2 * side * side;
    DRAWN_FACE * map.sources.len() as u64 + GRID_FACE * grid
}
