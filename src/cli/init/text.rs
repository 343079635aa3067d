//! The text of the scene, with a comment at every number.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use toml::Value;

use crate::cli::init::fitted_mesh::FittedMesh;
use crate::cli::init::material::{Depth, Maps, Material, Tiling};
use crate::synthesis::Method;

/// What a scene is written of.
pub(super) struct Fitted<'a> {
    /// Its name.
    pub(super) name: String,
    /// The material, as the scene names it.
    pub(super) material_path: PathBuf,
    /// The mesh, alike.
    pub(super) mesh_path: PathBuf,
    /// What the material is.
    pub(super) material: &'a Material,
    /// How the mesh is textured.
    pub(super) surface: &'a FittedMesh,
}

/// A path or a text as TOML writes it.
fn quoted(text: impl AsRef<Path>) -> String {
    Value::String(text.as_ref().to_string_lossy().into_owned()).to_string()
}

/// The whole scene.
pub(super) fn scene_text(fitted: &Fitted<'_>) -> String {
    let mut text = head(fitted);
    text += &appearance(fitted);
    text += &surface(fitted);
    text += RENDER;
    text
}

fn head(fitted: &Fitted<'_>) -> String {
    let sample = match fitted.material {
        Material::Sample { .. } => format!(
            "sample = {}  # an existing sample; no stage makes it\n",
            quoted(&fitted.material_path)
        ),
        _ => String::new(),
    };
    format!(
        "\
# A scene of `mesotex run`: a section is a stage, a key is an option of its command (mesotex STAGE --help).
# Paths are relative to this file. Change a value and run it again: only what depends on it is made again.
#   mesotex run FILE --plan             what would run, how long it takes, how much memory
#   mesotex run FILE --quality draft    a quick look, in files of its own
#   mesotex run FILE --until synth      stop after a stage
name = {}  # what the outputs are called
output = \"out\"  # their folder
seed = 0
{sample}",
        quoted(&fitted.name)
    )
}

/// The stages from the material to the neighbour table.
fn appearance(fitted: &Fitted<'_>) -> String {
    let path = quoted(&fitted.material_path);
    match fitted.material {
        Material::Maps(maps) => bake(&path, maps) + &textons(Some(maps.tiling)) + KNN,
        Material::Sample { tiling, .. } => textons(Some(*tiling)) + KNN,
        Material::Capture => {
            format!("\n[import]\npath = {path}  # `mesotex info` describes it\n")
                + &textons(None)
                + KNN
        }
        Material::Image { .. } => format!(
            "\n[exemplar]\n\
             images = [{path}]  # height and other maps may follow; they guide synthesis\n\
             # tile = true       # the borders continue each other\n\
             levels = 4\n\
             k = 11             # neighbours per texel\n"
        ),
    }
}

fn bake(path: &str, maps: &Maps) -> String {
    let [columns, rows] = maps.sides;
    // State material and size.
    let mut text =
        format!("\n[bake]\nmaterial = {path}  # `mesotex info` lists what each file is used for\n");
    let _ = writeln!(
        text,
        "size = {}         # texels along the longer side: {columns} × {rows}; the time of all stages grows with it",
        maps.size
    );
    // State the depth of the heights and where it comes from.
    let slopes = maps.slope_deg;
    let _ = match maps.depth {
        Depth::None => writeln!(text, "# no height map: normals or a plane give the relief"),
        Depth::OfMaterial(depth) => writeln!(
            text,
            "# depth = {depth}    # height of white over black, as a share of the width, as the material states"
        ),
        Depth::Chosen(depth) => writeln!(
            text,
            "depth = {depth}      # height of white over black, as a share of the width: 95 % of the slopes are below {slopes:.0}°"
        ),
    };
    // State the physical width.
    let _ = match maps.texel_mm {
        Some(mm) => writeln!(text, "# a texel is {mm:.3} mm wide, as the material states"),
        None => writeln!(text, "# width-mm = 200   # of the maps, where it is known"),
    };
    text + "\
views = \"12x5\"      # 60 directions; bonn81 has 81
lights = \"12x5\"
samples = 4         # rays per texel, view and light
"
}

fn textons(tiling: Option<Tiling>) -> String {
    let levels = tiling.map_or(4, |tiling| tiling.levels);
    let tiles = match tiling {
        Some(Tiling {
            is_given_up: true, ..
        }) => "no-tile = true      # the sides cannot be halved for every level\n",
        _ => "",
    };
    format!(
        "\n[textons]\n\
         textons = 200       # 3D textons of the finest level\n\
         levels = {levels}          # of the pyramid; the sample is halved for each\n{tiles}"
    )
}

const KNN: &str = "
[knn]
k = 11              # neighbours per texel
";

/// The methods beside the default that any scene can take.
fn other_methods() -> Vec<&'static str> {
    let is_other = |method: &Method| method.is_ordinary() && *method != Method::default();
    let others = Method::ALL.iter().copied().filter(is_other);
    others.map(Method::name).collect()
}

fn surface(fitted: &Fitted<'_>) -> String {
    let FittedMesh {
        vertices,
        texel,
        repeats,
        extent: [x, y, z],
        ..
    } = fitted.surface;
    let path = quoted(&fitted.mesh_path);
    let count = match fitted.surface.keeps_own {
        true => {
            format!(
                "# vertices = {vertices}  # the mesh keeps its own vertices; with this line it is retiled\n"
            )
        }
        false => {
            format!("vertices = {vertices}   # spread evenly; about one per texel of the texture\n")
        }
    };
    format!(
        "\n[mesh]\n\
         input = {path}  # {x:.4} × {y:.4} × {z:.4} mesh units\n\
         {count}\n\
         [synth]\n\
         texel = {texel}      # mesh units that a texel covers: the sample repeats {repeats:.1} times across the surface\n\
         # method = \"{method}\"  # or {others}\n",
        method = Method::default().name(),
        others = other_methods().join(", ")
    )
}

const RENDER: &str = "
[[render]]          # one per sequence of frames
name = \"frames\"
sweep = \"light-azimuth\"
frames = 24
size = \"960x720\"
# up = \"z\"          # if the mesh lies on its side
# shading = \"pixel\"  # sharper, slower
";
