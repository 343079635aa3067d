//! OFF, the Object File Format of Geomview, in text: positions and polygons.
//!
//! Normals, colours and texture coordinates that stand between (NOFF, COFF, STOFF) are passed over;
//! binary, 4D and n-dimensional files are refused.

use crate::error::{Error, Result};
use crate::format::polygon_mesh::PolygonMesh;

/// The lines of a file without comments and empty ones, each with its number.
struct Lines<'a> {
    rest: Box<dyn Iterator<Item = (usize, &'a str)> + 'a>,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str) -> Self {
        let content = |(number, line): (usize, &'a str)| {
            (number + 1, line.split('#').next().unwrap_or("").trim())
        };
        let rest = text
            .lines()
            .enumerate()
            .map(content)
            .filter(|(_, line)| !line.is_empty());
        Self {
            rest: Box::new(rest),
        }
    }

    fn next(&mut self, expected: impl FnOnce() -> String) -> Result<(usize, &'a str)> {
        self.rest
            .next()
            .ok_or_else(|| Error::data("end of file", "the file is cut off").expected(expected()))
    }
}

/// Parses an OFF file's bytes.
pub fn parse(bytes: &[u8]) -> Result<PolygonMesh> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = Lines::new(&text);
    let (vertices, faces) = header(&mut lines)?;
    let mut mesh = PolygonMesh::default();
    for vertex in 0..vertices {
        let (line, content) = lines.next(|| format!("vertex {vertex} of {vertices}"))?;
        let mut words = content.split_ascii_whitespace();
        let mut position = [0.0; 3];
        for value in &mut position {
            *value = number(words.next(), line)?;
        }
        mesh.positions.push(position);
    }
    let mut small_faces = 0;
    for face in 0..faces {
        let (line, content) = lines.next(|| format!("face {face} of {faces}"))?;
        small_faces += usize::from(!take_face(&mut mesh, content, line)?);
    }
    if small_faces > 0 {
        mesh.notes.push(format!(
            "{small_faces} faces of fewer than 3 corners left out"
        ));
    }
    Ok(mesh)
}

/// The counts of vertices and faces; they may follow the keyword on its line, even without space.
fn header(lines: &mut Lines<'_>) -> Result<(usize, usize)> {
    let (line, first) = lines.next(|| "an OFF file".into())?;
    let refuse = |found: &str| {
        Err(Error::data(format!("line {line}"), format!("`{found}`"))
            .expected("a text file that begins with OFF (or NOFF, COFF, STOFF)"))
    };
    let Some((kind, rest)) = first.split_once("OFF") else {
        return refuse(first);
    };
    if !matches!(kind, "" | "N" | "C" | "CN" | "ST" | "STN" | "STC" | "STCN")
        || rest.trim_start().starts_with("BINARY")
    {
        return refuse(first);
    }
    let counts = if rest.trim().is_empty() {
        lines.next(|| "the counts of vertices and faces".into())?
    } else {
        (line, rest)
    };
    let mut words = counts.1.split_ascii_whitespace();
    let vertices = number(words.next(), counts.0)?;
    let faces = number(words.next(), counts.0)?;
    Ok((vertices, faces))
}

fn take_face(mesh: &mut PolygonMesh, content: &str, line: usize) -> Result<bool> {
    let mut words = content.split_ascii_whitespace();
    let size: usize = number(words.next(), line)?;
    let begin = mesh.faces.corners.len();
    for _ in 0..size {
        let index: u32 = number(words.next(), line)?;
        if index as usize >= mesh.positions.len() {
            return Err(
                Error::data(format!("line {line}"), format!("vertex index {index}"))
                    .expected(format!("below {} vertices", mesh.positions.len())),
            );
        }
        mesh.faces.corners.push(index);
    }
    if size < 3 {
        mesh.faces.corners.truncate(begin);
        return Ok(false);
    }
    mesh.faces.sizes.push(size as u32);
    Ok(true)
}

fn number<T: std::str::FromStr>(word: Option<&str>, line: usize) -> Result<T> {
    let place = format!("line {line}");
    let Some(word) = word else {
        return Err(Error::data(place, "the line ends early").expected("a number"));
    };
    word.parse()
        .map_err(|_| Error::data(place, format!("`{word}`")).expected("a number"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_headers_comments_and_colours_are_read() {
        for head in [
            "OFF\n4 2 0",
            "  OFF4 2 0 # or nah",
            "COFF # colours\n\n4 2 5",
        ] {
            let text =
                format!("{head}\n0 0 0 255\n1 0 0 # x\n\n1 1 0\n0 1 0\n4 0 1 2 3 0.5 0.5\n2 0 1\n");
            let mesh = parse(text.as_bytes()).unwrap();
            assert_eq!(mesh.positions.len(), 4);
            assert_eq!(mesh.faces.iter().collect::<Vec<_>>(), [[0, 1, 2, 3]]);
            assert_eq!(mesh.notes.len(), 1);
        }
    }

    #[test]
    fn broken_files_say_where() {
        let error = |text: &str| parse(text.as_bytes()).unwrap_err().to_string();
        assert!(error("OFF\n2 1 0\n0 0 0\n1 0 0\n3 0 1 2\n").contains("vertex index 2"));
        assert!(error("OFF\n3000000000 1 0\n0 0 0\n").contains("vertex 1 of 3000000000"));
        assert!(error("4OFF\n1 0 0\n").contains("`4OFF`"));
        assert!(error("OFF BINARY\n").contains("BINARY"));
        assert!(error("OFF\n1 1 0\n0 zero 0\n").contains("line 3"));
        assert!(error("").contains("OFF"));
    }
}
