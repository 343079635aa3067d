//! Wavefront OBJ: polygons with texture coordinates and normals. Vertices keep the file's order
//! and number, used or not.
//!
//! Groups, objects, materials, lines, points and free-form surfaces are skipped. A fault in texture coordinates or
//! normals is noted and costs the surface nothing.

use std::io::{self, Write};
use std::path::Path;

use crate::error::{Error, Result};
use crate::format::atomic;
use crate::format::mesh_format::MeshFormat;
use crate::format::ours::MESH_MARK;
use crate::format::polygon_mesh::{PolygonMesh, from_origin};
use crate::format::text;

/// The format.
pub(crate) const FORMAT: MeshFormat = MeshFormat {
    name: "OBJ",
    extensions: &["obj"],
    parse: |bytes, _| parse(bytes),
    splits_vertices: false,
    companions: None,
};

/// The lists a face's indices point into, and the faces so far.
#[derive(Default)]
struct Parsed {
    mesh: PolygonMesh,
    /// NaN where the file has no number.
    uvs: Vec<[f32; 2]>,
    /// Zeros where the file has no numbers.
    normals: Vec<[f32; 3]>,
    /// Position, texture coordinate and normal of every corner.
    corners: Vec<[Option<usize>; 3]>,
    /// Vertices named before they came: line and index.
    expected: Vec<(usize, usize)>,
    small_faces: usize,
    faults: Faults,
}

/// What cannot be used beside the positions and faces.
#[derive(Default)]
struct Faults {
    uvs: usize,
    normals: usize,
}

/// Parses an OBJ file's bytes.
pub fn parse(bytes: &[u8]) -> Result<PolygonMesh> {
    let text = text::decode(bytes)?.text;
    let mut parsed = Parsed::default();
    let mut joined = String::new();
    for (number, line) in text::lines(&text) {
        if let Some(begun) = continued(line, !joined.is_empty()) {
            joined.push_str(begun);
            joined.push(' ');
            continue;
        }
        if joined.is_empty() {
            parsed.take_line(line, number)?;
        } else {
            joined.push_str(line);
            parsed.take_line(&joined, number)?;
            joined.clear();
        }
    }
    if !joined.is_empty() {
        parsed.take_line(&joined, text::lines(&text).count())?;
    }
    parsed.finish()
}

/// A line without the backslash that continues it; numbers and indices may be continued, comments and
/// names may not.
fn continued(line: &str, inside: bool) -> Option<&str> {
    let begun = line.trim_end().strip_suffix('\\')?;
    let word = begun.split_ascii_whitespace().next().unwrap_or_default();
    let has_numbers = inside || matches!(word, "v" | "vt" | "vn" | "vp" | "f" | "fo" | "l" | "p");
    (has_numbers && !begun.contains('#')).then_some(begun)
}

impl Parsed {
    fn take_line(&mut self, line: &str, number: usize) -> Result<()> {
        let content = line.split('#').next().unwrap_or("");
        let mut words = content.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let position = position(&mut words).map_err(|error| at_line(error, number))?;
                self.mesh.positions.push(position);
            }
            Some("vt") => self
                .uvs
                .push(texture_coordinate(&mut words).unwrap_or([f32::NAN; 2])),
            Some("vn") => self.normals.push(normal(&mut words).unwrap_or([0.0; 3])),
            Some("f" | "fo") => self
                .take_face(words, number)
                .map_err(|error| at_line(error, number))?,
            _ => {}
        }
        Ok(())
    }

    fn take_face<'a>(&mut self, words: impl Iterator<Item = &'a str>, number: usize) -> Result<()> {
        let begin = self.corners.len();
        for word in words {
            let corner = self.corner(word, number)?;
            self.corners.push(corner);
        }
        let size = self.corners.len() - begin;
        if size < 3 {
            self.corners.truncate(begin);
            self.small_faces += 1;
            return Ok(());
        }
        self.mesh.faces.sizes.push(size as u32);
        Ok(())
    }

    /// A corner `v`, `v/vt`, `v//vn` or `v/vt/vn`; indices count from 1, negative ones from the end of
    /// the list so far. Vertices may come later in the file.
    fn corner(&mut self, word: &str, number: usize) -> Result<[Option<usize>; 3]> {
        let mut parts = word.split('/');
        let mut part = || parts.next().filter(|part| !part.is_empty());
        let Some(vertex) = part() else {
            return Err(Error::data("", format!("face corner `{word}`")).expected("a vertex index"));
        };
        let count = self.mesh.positions.len();
        let position = match resolve(vertex, count) {
            // A vertex is recognised by 32 bits.
            Some(index) if index < u32::MAX as usize => index,
            _ => return Err(no_vertex(vertex, count)),
        };
        if position >= count {
            self.expected.push((number, position));
        }
        let attribute = |part: Option<&str>, count: usize, faults: &mut usize| {
            let index = part.and_then(|part| resolve(part, count));
            *faults += usize::from(part.is_some() && index.is_none());
            index
        };
        let uv = attribute(part(), self.uvs.len(), &mut self.faults.uvs);
        let normal = attribute(part(), self.normals.len(), &mut self.faults.normals);
        Ok([Some(position), uv, normal])
    }

    fn finish(mut self) -> Result<PolygonMesh> {
        let count = self.mesh.positions.len();
        if let Some(&(line, index)) = self.expected.iter().find(|(_, index)| *index >= count) {
            let word = (index + 1).to_string();
            return Err(at_line(no_vertex(&word, count), line));
        }
        let vertices = self.corners.iter().flat_map(|corner| corner[0]);
        self.mesh.faces.corners = vertices.map(|vertex| vertex as u32).collect();
        self.mesh.note_small_faces(self.small_faces);
        self.drop_unusable();
        if self.corners.iter().any(|corner| corner[1].is_some()) {
            let uv = |c: &[Option<usize>; 3]| c[1].map_or([f32::NAN; 2], |index| self.uvs[index]);
            self.mesh.corner_uvs = Some(self.corners.iter().map(uv).collect());
        }
        if self.corners.iter().any(|corner| corner[2].is_some()) {
            self.mesh.normals = Some(self.vertex_normals());
        }
        self.note_faults();
        Ok(self.mesh)
    }

    /// Forgets indices of texture coordinates and normals that the file does not have, or not as numbers.
    fn drop_unusable(&mut self) {
        for [_, uv, normal] in &mut self.corners {
            let is_uv = |index: &usize| {
                let found = self.uvs.get(*index);
                found.is_some_and(|uv| uv.iter().all(|value| value.is_finite()))
            };
            let is_normal = |index: &usize| {
                let found = self.normals.get(*index);
                found.is_some_and(|normal| normal.iter().all(|value| value.is_finite()))
            };
            self.faults.uvs += usize::from(uv.is_some_and(|index| !is_uv(&index)));
            self.faults.normals += usize::from(normal.is_some_and(|index| !is_normal(&index)));
            *uv = uv.filter(is_uv);
            *normal = normal.filter(is_normal);
        }
    }

    fn note_faults(&mut self) {
        let kinds = [
            (self.faults.uvs, "texture coordinates", self.uvs.len()),
            (self.faults.normals, "normals", self.normals.len()),
        ];
        for (count, what, listed) in kinds.into_iter().filter(|(count, ..)| *count > 0) {
            self.mesh.unused.push(format!(
                "{count} corners name {what} that cannot be used (the file lists {listed})"
            ));
        }
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

fn at_line(error: Error, line: usize) -> Error {
    match error {
        Error::Data(mut fault) => {
            fault.place = format!("line {line}");
            Error::Data(fault)
        }
        other => other,
    }
}

fn no_vertex(word: &str, count: usize) -> Error {
    Error::data("", format!("`{word}`")).expected(format!("an index of {count} vertices, from 1"))
}

/// The place in a list that an index says: from 1, or negative from the end of `count` so far.
fn resolve(word: &str, count: usize) -> Option<usize> {
    match word.parse::<i64>().ok()? {
        index @ 1.. => usize::try_from(index - 1).ok(),
        0 => None,
        index => usize::try_from(count as i64 + index).ok(),
    }
}

fn position<'a>(words: &mut impl Iterator<Item = &'a str>) -> Result<[f64; 3]> {
    let mut position = [0.0; 3];
    for value in &mut position {
        let Some(word) = words.next() else {
            return Err(Error::data("", "the line ends early").expected("three numbers"));
        };
        *value = word
            .parse()
            .map_err(|_| Error::data("", format!("`{word}`")).expected("a number"))?;
    }
    Ok(position)
}

fn normal<'a>(words: &mut impl Iterator<Item = &'a str>) -> Option<[f32; 3]> {
    let mut number = || words.next()?.parse().ok();
    Some([number()?, number()?, number()?])
}

/// `u` and, unless the texture has one axis, `v`.
fn texture_coordinate<'a>(words: &mut impl Iterator<Item = &'a str>) -> Option<[f32; 2]> {
    let u = words.next()?.parse().ok()?;
    let v = words.next().map_or(Some(0.0), |word| word.parse().ok())?;
    Some([u, v])
}

/// What an OBJ file is written from; lists are per vertex, or per triangle corner for `uvs`.
#[derive(Clone, Copy, Debug)]
pub struct ObjMesh<'a> {
    /// Where the positions count from.
    pub origin: [f64; 3],
    /// Vertex positions.
    pub positions: &'a [[f32; 3]],
    /// Unit vertex normals, none if empty.
    pub normals: &'a [[f32; 3]],
    /// Texture coordinates of the corners of each triangle; NaN where there is none.
    pub uvs: Option<&'a [[[f32; 2]; 3]]>,
    /// Vertex indices.
    pub triangles: &'a [[u32; 3]],
}

/// Writes an OBJ file.
pub fn write(path: &Path, mesh: &ObjMesh<'_>) -> Result<()> {
    atomic::write_file(path, |sink| {
        writeln!(sink, "# {MESH_MARK}")?;
        write_positions(sink, mesh)?;
        for [x, y, z] in mesh.normals {
            writeln!(sink, "vn {x} {y} {z}")?;
        }
        let listed = |uv: &[f32; 2]| uv.iter().all(|value| value.is_finite());
        for [u, v] in mesh.uvs.into_iter().flatten().flatten() {
            if listed(&[*u, *v]) {
                writeln!(sink, "vt {u} {v}")?;
            }
        }
        let mut coordinates = 0;
        for (index, triangle) in mesh.triangles.iter().enumerate() {
            write!(sink, "f")?;
            for (corner, vertex) in triangle.iter().enumerate() {
                let v = vertex + 1;
                let uv = mesh.uvs.map(|uvs| uvs[index][corner]).filter(listed);
                coordinates += usize::from(uv.is_some());
                match (uv.is_some(), mesh.normals.is_empty()) {
                    (true, true) => write!(sink, " {v}/{coordinates}")?,
                    (true, false) => write!(sink, " {v}/{coordinates}/{v}")?,
                    (false, true) => write!(sink, " {v}")?,
                    (false, false) => write!(sink, " {v}//{v}")?,
                }
            }
            writeln!(sink)?;
        }
        Ok(())
    })
}

/// As many digits as tell the numbers apart: of doubles, where an origin was subtracted.
fn write_positions(sink: &mut impl Write, mesh: &ObjMesh<'_>) -> io::Result<()> {
    for &position in mesh.positions {
        if mesh.origin == [0.0; 3] {
            let [x, y, z] = position;
            writeln!(sink, "v {x} {y} {z}")?;
        } else {
            let [x, y, z] = from_origin(mesh.origin, position);
            writeln!(sink, "v {x} {y} {z}")?;
        }
    }
    Ok(())
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
    fn faces_may_come_before_their_vertices() {
        let mesh = parse_text(&format!("f 1 2 3\n{SQUARE}f -1 -2 -3\n")).unwrap();
        assert_eq!(mesh.faces.corners, [0, 1, 2, 3, 2, 1]);
        let error = parse_text(&format!("f 1 2 5\n{SQUARE}")).unwrap_err();
        assert!(error.to_string().contains("line 1"), "{error}");
    }

    #[test]
    fn a_backslash_continues_numbers_and_nothing_else() {
        let names = "# from C:\\models\\\ng C:\\group\\\nusemtl a\\\n";
        let mesh = parse_text(&format!(
            "{names}{SQUARE}f 1 2 \\\n 3 # corner \\\nf 1 3 4\\"
        ))
        .unwrap();
        assert_eq!(mesh.positions.len(), 4);
        assert_eq!(mesh.faces.corners, [0, 1, 2, 0, 2, 3]);
    }

    #[test]
    fn marks_and_line_ends_of_other_systems_are_read() {
        let plain = parse_text(&format!("{SQUARE}f 1 2 3\n")).unwrap();
        let text = format!("{SQUARE}f 1 2 3\n").replace('\n', "\r");
        assert_eq!(parse_text(&text).unwrap(), plain);
        assert_eq!(parse_text(&format!("\u{feff}{text}")).unwrap(), plain);
        let units = text.encode_utf16().flat_map(u16::to_le_bytes);
        let wide: Vec<u8> = [0xFF, 0xFE].into_iter().chain(units).collect();
        assert_eq!(parse(&wide).unwrap(), plain);
    }

    #[test]
    fn faults_beside_the_surface_are_noted() {
        for lists in ["", "vt 0 0\nvt 1 x\nvn 0 0 nan\n"] {
            let mesh = parse_text(&format!("{SQUARE}{lists}f 1/9/1 2/2/1 3/x/-7\n")).unwrap();
            assert_eq!(mesh.faces.corners, [0, 1, 2]);
            assert_eq!((mesh.corner_uvs, mesh.normals), (None, None));
            assert!(mesh.unused[0].contains("3 corners name texture coordinates"));
            assert!(mesh.unused[1].contains("3 corners name normals"));
            assert!(mesh.notes.is_empty());
        }
    }

    #[test]
    fn large_coordinates_keep_their_digits() {
        let mesh = parse_text("v 701362.6 4485513.7 182.332211\n").unwrap();
        assert_eq!(mesh.positions, [[701362.6, 4485513.7, 182.332211]]);
        assert!(!mesh.single_precision);
    }

    #[test]
    fn written_files_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        let positions = [[0.5, 0.25, 0.75], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let uvs = [[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]];
        let normals = [[0.0, 0.0, 1.0]; 3];
        let mut mesh = ObjMesh {
            origin: [0.0; 3],
            positions: &positions,
            normals: &normals,
            uvs: Some(&uvs),
            triangles: &[[0, 1, 2]],
        };
        write(&path, &mesh).unwrap();
        let back = parse(&std::fs::read(&path).unwrap()).unwrap();
        let doubles = positions.map(|p: [f32; 3]| p.map(f64::from));
        assert_eq!(back.positions, doubles);
        assert_eq!(
            back.corner_uvs.unwrap(),
            [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
        );
        assert_eq!(back.normals.unwrap(), normals);
        mesh.origin = [701_362.0, 4_485_513.5, -7.0];
        write(&path, &mesh).unwrap();
        let back = parse(&std::fs::read(&path).unwrap()).unwrap();
        assert_eq!(back.positions[0], [701_362.5, 4_485_513.75, -6.25]);
    }

    #[test]
    fn corners_without_a_texture_coordinate_stay_without() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        let mesh = ObjMesh {
            origin: [0.0; 3],
            positions: &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            normals: &[],
            uvs: Some(&[[[0.5, 0.5], [f32::NAN; 2], [1.0, 0.0]]]),
            triangles: &[[0, 1, 2]],
        };
        write(&path, &mesh).unwrap();
        let back = parse(&std::fs::read(&path).unwrap()).unwrap();
        let uvs = back.corner_uvs.unwrap();
        assert_eq!([uvs[0], uvs[2]], [[0.5, 0.5], [1.0, 0.0]]);
        assert!(uvs[1][0].is_nan());
    }
}
