//! A decorated mesh as USD text.

use std::fmt::Display;
use std::io::{self, Write};
use std::path::Path;

use crate::error::Result;
use crate::format::atomic;
use crate::format::ours::MESH_MARK;
use crate::textures::vertex_model::VertexModel;

/// Numbers on a line.
const ON_LINE: usize = 16;

pub(super) fn write(path: &Path, model: &VertexModel<'_>) -> Result<()> {
    let map = model.map;
    // Format the columns.
    let colors = model.clamped_colors();
    let per_vertex = " (interpolation = \"vertex\")";
    let counts = map.mesh.triangles.iter().map(|_| 3);
    let indices = map.mesh.triangles.as_flattened().iter();
    let vectors = |list: &'_ [glam::Vec3]| -> Vec<String> {
        list.iter().map(|v| tuple(&v.to_array())).collect()
    };
    let labels = map.textons.iter().map(|label| label.0);
    let [x, y, z] = map.header.origin.to_array();
    // Write them.
    atomic::write_file(path, |sink| {
        writeln!(
            sink,
            "#usda 1.0\n# {MESH_MARK}\n(\n    defaultPrim = \"Surface\"\n    upAxis = \"Y\"\n)\n"
        )?;
        writeln!(sink, "def Mesh \"Surface\"\n{{")?;
        writeln!(sink, "    uniform token subdivisionScheme = \"none\"")?;
        list(sink, "int[] faceVertexCounts", counts, "")?;
        list(sink, "int[] faceVertexIndices", indices, "")?;
        list(sink, "point3f[] points", vectors(&map.mesh.positions), "")?;
        list(
            sink,
            "normal3f[] normals",
            vectors(&map.normals),
            per_vertex,
        )?;
        let uvs = model.uvs();
        let uvs = uvs.iter().map(|uv| tuple(uv));
        list(sink, "texCoord2f[] primvars:st", uvs, per_vertex)?;
        list(sink, "int[] primvars:texton", labels, per_vertex)?;
        let orientations = vectors(&map.orientations);
        list(
            sink,
            "vector3f[] primvars:orientation",
            orientations,
            per_vertex,
        )?;
        if let Some(colors) = &colors {
            let colors = colors.iter().map(|color| tuple(color));
            list(sink, "color3f[] primvars:displayColor", colors, per_vertex)?;
        }
        writeln!(sink, "    double3 xformOp:translate = ({x}, {y}, {z})")?;
        writeln!(
            sink,
            "    uniform token[] xformOpOrder = [\"xformOp:translate\"]\n}}"
        )
    })
}

fn tuple(numbers: &[f32]) -> String {
    let texts: Vec<String> = numbers.iter().map(f32::to_string).collect();
    format!("({})", texts.join(", "))
}

/// One attribute: its declaration, its values, what stands behind them.
fn list<T: Display>(
    sink: &mut impl Write,
    name: &str,
    values: impl IntoIterator<Item = T>,
    behind: &str,
) -> io::Result<()> {
    write!(sink, "    {name} = [")?;
    for (place, value) in values.into_iter().enumerate() {
        match place {
            0 => {}
            _ if place % ON_LINE == 0 => write!(sink, ",\n        ")?,
            _ => write!(sink, ", ")?,
        }
        write!(sink, "{value}")?;
    }
    writeln!(sink, "]{behind}")
}
