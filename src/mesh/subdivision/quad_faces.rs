//! The quadrilateral faces of a user's mesh, put together again from the triangles that they were cut into.

use super::quad_mesh::QuadMesh;
use crate::error::{Error, Result};
use crate::mesh::reading::UserMesh;

/// The control mesh that a user's faces make; its vertices are the mesh's.
///
/// Refuses a mesh with a face of other than 4 corners, and a face whose halves mesh repair has separated.
pub fn control_mesh(user: &UserMesh) -> Result<QuadMesh> {
    let (triangles, faces) = (&user.mesh.triangles, &user.face_of);
    let mut quads = Vec::with_capacity(triangles.len() / 2);
    let mut begin = 0;
    while begin < triangles.len() {
        let face = faces.get(begin).copied();
        let count = match face {
            Some(face) => faces[begin..].iter().take_while(|&&of| of == face).count(),
            None => 1,
        };
        let place = format!("face {}", face.unwrap_or(begin as u32));
        let &[first, second] = &triangles[begin..begin + count] else {
            return Err(not_quadrilateral(place, format!("{} corners", count + 2)));
        };
        let Some(quad) = joined(first, second) else {
            let found = "its halves were separated when the mesh was repaired".into();
            return Err(not_quadrilateral(place, found));
        };
        quads.push(quad);
        begin += count;
    }
    Ok(QuadMesh::new(user.mesh.positions.len(), quads))
}

fn not_quadrilateral(place: String, found: String) -> Error {
    Error::data(place, found)
        .expected("4 corners at every face, for --charts faces")
        .advice("--unwrap makes charts of any mesh")
}

/// The corners of two triangles on either side of an edge.
fn joined(first: [u32; 3], second: [u32; 3]) -> Option<[u32; 4]> {
    (0..3).find_map(|k| {
        let [from, to, apex] = [0, 1, 2].map(|step| first[(k + step) % 3]);
        let back = (0..3).find(|&j| second[j] == to && second[(j + 1) % 3] == from)?;
        Some([to, apex, from, second[(back + 2) % 3]])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::reading::{CleaningOptions, clean, parse};
    use crate::progress::Progress;
    use std::path::Path;

    fn read(text: &str) -> UserMesh {
        let file = parse(text.as_bytes(), Path::new("a.obj")).unwrap();
        clean(file, &CleaningOptions::default(), Progress::silent()).unwrap()
    }

    #[test]
    fn faces_come_back_as_they_were() {
        let vertices = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n";
        let user = read(&format!("{vertices}f 1 2 5 4\nf 2 3 6 5\n"));
        let control = control_mesh(&user).unwrap();
        assert_eq!((control.quads.len(), control.edges()), (2, 7));
        for (quad, wanted) in control.quads.iter().zip([[0, 1, 4, 3], [1, 2, 5, 4]]) {
            let turned = (0..4).any(|k| (0..4).all(|j| quad[(k + j) % 4] == wanted[j]));
            assert!(turned, "{quad:?}");
        }
    }

    #[test]
    fn other_faces_are_refused_by_their_number() {
        let vertices = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 1 2 0\nv 0 2 0\n";
        for (last, corners) in [("5 6 7", "3 corners"), ("5 6 7 8 4", "5 corners")] {
            let user = read(&format!("{vertices}f 1 2 5 4\nf 2 3 6 5\nf {last}\n"));
            let error = control_mesh(&user).unwrap_err().to_string();
            assert!(
                error.contains("face 2") && error.contains(corners),
                "{error}"
            );
            assert!(error.contains("--unwrap"), "{error}");
        }
        let triangles = UserMesh::from(crate::mesh::shapes::grid(2, 2, 1.0));
        let error = control_mesh(&triangles).unwrap_err().to_string();
        assert!(error.contains("face 0: 3 corners"), "{error}");
    }
}
