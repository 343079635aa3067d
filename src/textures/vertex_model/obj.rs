//! A decorated mesh as an OBJ file.

use std::io::Write;
use std::path::Path;

use crate::error::Result;
use crate::format::atomic;
use crate::format::image::encode_srgb8;
use crate::format::ours::MESH_MARK;
use crate::textures::vertex_model::VertexModel;

pub(super) fn write(path: &Path, model: &VertexModel<'_>) -> Result<()> {
    let map = model.map;
    let origin = map.header.origin;
    atomic::write_file(path, |sink| {
        writeln!(sink, "# {MESH_MARK}")?;
        for (vertex, position) in map.mesh.positions.iter().enumerate() {
            let [x, y, z] = (position.as_dvec3() + origin).to_array();
            write!(sink, "v {x} {y} {z}")?;
            if let Some(colors) = model.colors {
                let [r, g, b] = colors[vertex].map(|value| f32::from(encode_srgb8(value)) / 255.0);
                write!(sink, " {r} {g} {b}")?;
            }
            writeln!(sink)?;
        }
        for [u, v] in model.uvs() {
            writeln!(sink, "vt {u} {v}")?;
        }
        for normal in &map.normals {
            writeln!(sink, "vn {} {} {}", normal.x, normal.y, normal.z)?;
        }
        for triangle in &map.mesh.triangles {
            let [a, b, c] = triangle.map(|vertex| vertex + 1);
            writeln!(sink, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")?;
        }
        Ok(())
    })
}
