//! Wavefront OBJ: polygons with texture coordinates and normals. Vertices keep the file's order
//! and number, used or not.
//!
//! Groups, objects, materials, lines, points and free-form surfaces are passed over.

use std::io::Write;
use std::path::Path;

use crate::error::{Error, Result};
use crate::format::atomic;
use crate::format::ours::MESH_MARK;
use crate::format::polygon_mesh::PolygonMesh;

/// The lists a face's indices point into, and the faces so far.
#[derive(Default)]
struct Parsed {
    mesh: PolygonMesh,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// Position, texture coordinate and normal of every corner.
    corners: Vec<[Option<usize>; 3]>,
    small_faces: usize,
}

/// Parses an OBJ file's bytes.
pub fn parse(bytes: &[u8]) -> Result<PolygonMesh> {
    let text = String::from_utf8_lossy(bytes);
    let mut parsed = Parsed::default();
    let mut joined = String::new();
    for (number, line) in text.lines().enumerate() {
        if let Some(begun) = line.trim_end().strip_suffix('\\') {
            joined.push_str(begun);
            joined.push(' ');
            continue;
        }
        let at_line = |error: Error| place_at_line(error, number + 1);
        if joined.is_empty() {
            parsed.take_line(line).map_err(at_line)?;
        } else {
            joined.push_str(line);
            parsed.take_line(&joined).map_err(at_line)?;
            joined.clear();
        }
    }
    Ok(parsed.finish())
}

fn place_at_line(error: Error, line: usize) -> Error {
    match error {
        Error::Data(mut fault) => {
            fault.place = format!("line {line}");
            Error::Data(fault)
        }
        other => other,
    }
}

impl Parsed {
    fn take_line(&mut self, line: &str) -> Result<()> {
        let content = line.split('#').next().unwrap_or("");
        let mut words = content.split_ascii_whitespace();
        match words.next() {
            Some("v") => self.mesh.positions.push(numbers(&mut words)?),
            Some("vt") => self.uvs.push(texture_coordinate(&mut words)?),
            Some("vn") => self.normals.push(numbers(&mut words)?),
            Some("f") => self.take_face(words)?,
            _ => {}
        }
        Ok(())
    }

    fn take_face<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<()> {
        let begin = self.corners.len();
        for word in words {
            let corner = self.corner(word)?;
            self.corners.push(corner);
        }
        let size = self.corners.len() - begin;
        if size < 3 {
            self.corners.truncate(begin);
            self.small_faces += 1;
            return Ok(());
        }
        self.mesh.faces.sizes.push(size as u32);
        for corner in &self.corners[begin..] {
            self.mesh
                .faces
                .corners
                .push(corner[0].unwrap_or_default() as u32);
        }
        Ok(())
    }

    /// A corner `v`, `v/vt`, `v//vn` or `v/vt/vn`; indices count from 1, negative ones from the end.
    fn corner(&self, word: &str) -> Result<[Option<usize>; 3]> {
        let mut parts = word.split('/');
        let mut index = |count: usize, what: &str| -> Result<Option<usize>> {
            match parts.next() {
                None | Some("") => Ok(None),
                Some(part) => resolve(part, count, what).map(Some),
            }
        };
        let position = index(self.mesh.positions.len(), "vertices")?;
        let uv = index(self.uvs.len(), "texture coordinates")?;
        let normal = index(self.normals.len(), "normals")?;
        if position.is_none() {
            return Err(Error::data("", format!("face corner `{word}`")).expected("a vertex index"));
        }
        Ok([position, uv, normal])
    }

    fn finish(mut self) -> PolygonMesh {
        if self.corners.iter().any(|corner| corner[1].is_some()) {
            let uv = |c: &[Option<usize>; 3]| c[1].map_or([f32::NAN; 2], |index| self.uvs[index]);
            self.mesh.corner_uvs = Some(self.corners.iter().map(uv).collect());
        }
        if self.corners.iter().any(|corner| corner[2].is_some()) {
            self.mesh.normals = Some(self.vertex_normals());
        }
        if self.small_faces > 0 {
            let note = format!(
                "{} faces of fewer than 3 corners left out",
                self.small_faces
            );
            self.mesh.notes.push(note);
        }
        self.mesh
    }

    /// The sum of the normals at each vertex's corners.
    fn vertex_normals(&self) -> Vec<[f32; 3]> {
        let mut sums = vec![[0.0; 3]; self.mesh.positions.len()];
        for corner in &self.corners {
            if let [Some(vertex), _, Some(normal)] = *corner {
                for (sum, value) in sums[vertex].iter_mut().zip(self.normals[normal]) {
                    *sum += value;
                }
            }
        }
        sums
    }
}

fn resolve(part: &str, count: usize, what: &str) -> Result<usize> {
    let fault = || {
        Error::data("", format!("index `{part}`")).expected(format!(
            "1 to {count} or −{count} to −1, for the {count} {what} so far"
        ))
    };
    let index: i64 = part.parse().map_err(|_| fault())?;
    let from_zero = if index < 0 {
        count as i64 + index
    } else {
        index - 1
    };
    if (0..count as i64).contains(&from_zero) {
        Ok(from_zero as usize)
    } else {
        Err(fault())
    }
}

fn numbers<'a>(words: &mut impl Iterator<Item = &'a str>) -> Result<[f32; 3]> {
    let mut numbers = [0.0; 3];
    for number in &mut numbers {
        *number = parse_number(words.next())?;
    }
    Ok(numbers)
}

/// u and, if it is there, v.
fn texture_coordinate<'a>(words: &mut impl Iterator<Item = &'a str>) -> Result<[f32; 2]> {
    let u = parse_number(words.next())?;
    let v = words
        .next()
        .map_or(Ok(0.0), |word| parse_number(Some(word)))?;
    Ok([u, v])
}

/// A number in a mesh text file.
pub(crate) fn parse_number(word: Option<&str>) -> Result<f32> {
    let Some(word) = word else {
        return Err(Error::data("", "the line ends early").expected("a number"));
    };
    word.parse()
        .map_err(|_| Error::data("", format!("`{word}`")).expected("a number"))
}

/// What an OBJ file is written from; lists are per vertex, or per triangle corner for `uvs`.
#[derive(Clone, Copy, Debug)]
pub struct ObjMesh<'a> {
    /// Vertex positions.
    pub positions: &'a [[f32; 3]],
    /// Unit vertex normals, none if empty.
    pub normals: &'a [[f32; 3]],
    /// Texture coordinates of the corners of each triangle.
    pub uvs: Option<&'a [[[f32; 2]; 3]]>,
    /// Vertex indices.
    pub triangles: &'a [[u32; 3]],
}

/// Writes an OBJ file.
pub fn write(path: &Path, mesh: &ObjMesh<'_>) -> Result<()> {
    atomic::write_file(path, |sink| {
        writeln!(sink, "# {MESH_MARK}")?;
        for [x, y, z] in mesh.positions {
            writeln!(sink, "v {x} {y} {z}")?;
        }
        for [x, y, z] in mesh.normals {
            writeln!(sink, "vn {x} {y} {z}")?;
        }
        for [u, v] in mesh.uvs.into_iter().flatten().flatten() {
            writeln!(sink, "vt {u} {v}")?;
        }
        for (index, triangle) in mesh.triangles.iter().enumerate() {
            write!(sink, "f")?;
            for (corner, vertex) in triangle.iter().enumerate() {
                let (v, vt) = (vertex + 1, index * 3 + corner + 1);
                match (mesh.uvs.is_some(), mesh.normals.is_empty()) {
                    (true, true) => write!(sink, " {v}/{vt}")?,
                    (true, false) => write!(sink, " {v}/{vt}/{v}")?,
                    (false, true) => write!(sink, " {v}")?,
                    (false, false) => write!(sink, " {v}//{v}")?,
                }
            }
            writeln!(sink)?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_text(text: &str) -> Result<PolygonMesh> {
        parse(text.as_bytes())
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0 0.5 nan 1\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn polygons_keep_order_and_corners() {
        let text = format!("{SQUARE}vt 0 0\nvt 1 0\nvn 0 0 1\nf 1/1/1 2/2/1 -2 \\\n 4//1\n");
        let mesh = parse_text(&text).unwrap();
        assert_eq!(mesh.faces.iter().collect::<Vec<_>>(), [[0, 1, 2, 3]]);
        let uvs = mesh.corner_uvs.unwrap();
        assert_eq!(uvs[1], [1.0, 0.0]);
        assert!(uvs[2][0].is_nan());
        assert_eq!(mesh.normals.unwrap()[2], [0.0; 3]);
    }

    #[test]
    fn small_faces_are_noted_and_bad_indices_refused() {
        let mesh = parse_text(&format!("{SQUARE}f 1// 2//\nf 1// 2// 3//\n")).unwrap();
        assert_eq!(mesh.faces.sizes, [3]);
        assert!(mesh.notes[0].contains("fewer than 3"));
        for (face, found) in [
            ("f 1 2 5", "`5`"),
            ("f 0 1 2", "`0`"),
            ("f 1 2 -5", "`-5`"),
            ("f a 1 2", "`a`"),
        ] {
            let error = parse_text(&format!("{SQUARE}{face}\n"))
                .unwrap_err()
                .to_string();
            assert!(error.contains("line 5") && error.contains(found), "{error}");
        }
        assert!(
            parse_text("v 1 2\n")
                .unwrap_err()
                .to_string()
                .contains("line 1")
        );
    }

    #[test]
    fn written_files_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        let positions = [[0.1, 0.2, 0.3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let uvs = [[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]];
        let normals = [[0.0, 0.0, 1.0]; 3];
        let mesh = ObjMesh {
            positions: &positions,
            normals: &normals,
            uvs: Some(&uvs),
            triangles: &[[0, 1, 2]],
        };
        write(&path, &mesh).unwrap();
        let back = parse(&std::fs::read(&path).unwrap()).unwrap();
        assert_eq!(back.positions, positions);
        assert_eq!(back.corner_uvs.unwrap(), uvs[0]);
        assert_eq!(back.normals.unwrap(), normals);
    }
}
