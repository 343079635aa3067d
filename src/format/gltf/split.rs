//! Vertices repeated so that each has one texture coordinate and one tangent, as glTF requires.

use std::collections::HashMap;

/// A triangle's corners: texture coordinates, v upwards, and tangents.
pub(super) struct Corners<'a> {
    pub(super) uvs: &'a [[[f32; 2]; 3]],
    pub(super) tangents: Option<&'a [[[f32; 4]; 3]]>,
}

/// The repeated vertices.
pub(super) struct Split {
    /// The vertex that each is a copy of; the first ones are the mesh's own.
    sources: Vec<u32>,
    /// Texture coordinates, v downwards.
    pub(super) uvs: Vec<[f32; 2]>,
    /// Tangents; empty where the corners have none.
    pub(super) tangents: Vec<[f32; 4]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// The tangent of a vertex in no triangle.
const ANY_TANGENT: [f32; 4] = [1.0, 0.0, 0.0, 1.0];

impl Split {
    pub(super) fn new(vertices: usize, triangles: &[[u32; 3]], corners: &Corners<'_>) -> Self {
        let mut split = Self {
            sources: (0..vertices as u32).collect(),
            uvs: vec![[0.0; 2]; vertices],
            tangents: match corners.tangents {
                Some(_) => vec![ANY_TANGENT; vertices],
                None => Vec::new(),
            },
            triangles: triangles.to_vec(),
        };
        let mut is_taken = vec![false; vertices];
        let mut known: HashMap<(u32, [u32; 6]), u32> = HashMap::new();
        // Give each corner a vertex: the source, or a copy where other corners took it with other
        // values.
        for at in 0..triangles.len() {
            for corner in 0..3 {
                let uv = match corners.uvs[at][corner] {
                    [u, v] if u.is_finite() && v.is_finite() => [u, 1.0 - v],
                    _ => [0.0; 2],
                };
                let tangent = corners.tangents.map(|tangents| tangents[at][corner]);
                let source = triangles[at][corner];
                let key = (source, bits(uv, tangent));
                let vertex = *known.entry(key).or_insert_with(|| {
                    let is_free = !std::mem::replace(&mut is_taken[source as usize], true);
                    let vertex = if is_free {
                        source
                    } else {
                        split.repeat(source)
                    };
                    split.uvs[vertex as usize] = uv;
                    if let Some(tangent) = tangent {
                        split.tangents[vertex as usize] = tangent;
                    }
                    vertex
                });
                split.triangles[at][corner] = vertex;
            }
        }
        split
    }

    /// Adds a copy of a vertex, to be filled in.
    fn repeat(&mut self, source: u32) -> u32 {
        self.sources.push(source);
        self.uvs.push([0.0; 2]);
        if !self.tangents.is_empty() {
            self.tangents.push(ANY_TANGENT);
        }
        self.sources.len() as u32 - 1
    }

    /// A list per vertex of the mesh for the vertices here.
    pub(super) fn copied(&self, list: &[[f32; 3]]) -> Vec<[f32; 3]> {
        self.sources.iter().map(|&v| list[v as usize]).collect()
    }
}

fn bits([u, v]: [f32; 2], tangent: Option<[f32; 4]>) -> [u32; 6] {
    let [x, y, z, w] = tangent.unwrap_or_default();
    [u, v, x, y, z, w].map(f32::to_bits)
}
