//! The quality of a run: the scene as it stands, or a draft of it.
//!
//! A draft is the scene without its finest level. A baked sample has half as many texels per side and a level less,
//! the mesh a quarter of the vertices, a texel is twice as wide, so that the texture lies as it will. Frames are half
//! as large and a quarter as many. Outputs are called NAME-draft, reports and pictures too: neither quality writes
//! over the other.

use clap::ValueEnum;
use toml::Value;

use crate::cli::bake;
use crate::cli::run::scene::Scene;
use crate::cli::run::side_outputs::mark_side_outputs;
use crate::render::options::RenderOptions;
use crate::texton::TextonOptions;

/// How finely a scene is run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Quality {
    /// A quick preview, half as fine, in files of its own: NAME-draft
    Draft,
    /// As the scene states
    #[default]
    Final,
}

/// What a draft adds to names.
const MARK: &str = "-draft";
/// Texels a side that a draft leaves at least.
const LEAST_SIZE: i64 = 16;
/// Vertices that a draft leaves at least.
const LEAST_VERTICES: i64 = 1000;

impl Quality {
    /// The scene at this quality. Values that are no numbers are left for the checks of their stages.
    pub fn apply(self, scene: &mut Scene) {
        if self == Self::Final || scene.name.is_empty() {
            return;
        }
        scene.name.push_str(MARK);
        let sections = scene.document.sections.iter_mut();
        sections.for_each(|section| mark_side_outputs(section, MARK));
        thin_surface(scene);
        thin_frames(scene);
    }
}

/// Halves the sample where the mesh can follow it, and quarters the vertices where the texture stays as large.
fn thin_surface(scene: &mut Scene) {
    let vertices = integer(scene, "mesh", "vertices");
    let texel = number(scene, "synth", "texel");
    let is_baked = scene.has("bake");
    if is_baked {
        scene.set("bake", "samples", Value::Integer(1));
        scene.unset("bake", "error");
    }
    // A mesh that keeps its vertices and has no texel stated is textured by its own edges.
    let halves = is_baked && (vertices.is_some() || texel.is_some());
    if halves {
        let size = integer(scene, "bake", "size").unwrap_or(i64::from(bake::SIZE));
        scene.set("bake", "size", Value::Integer((size / 2).max(LEAST_SIZE)));
        let levels = integer(scene, "textons", "levels");
        let levels = levels.unwrap_or(i64::from(TextonOptions::default().levels));
        scene.set("textons", "levels", Value::Integer((levels - 1).max(1)));
        if let Some(levels) = integer(scene, "synth", "levels") {
            scene.set("synth", "levels", Value::Integer((levels - 1).max(1)));
        }
        if let Some(texel) = texel {
            scene.set("synth", "texel", Value::Float(2.0 * texel));
        }
    }
    if let Some(vertices) = vertices.filter(|_| halves || texel.is_some()) {
        let fewer = (vertices / 4).max(LEAST_VERTICES.min(vertices));
        scene.set("mesh", "vertices", Value::Integer(fewer));
    }
}

/// Halves the sides of frames, and makes every fourth.
fn thin_frames(scene: &mut Scene) {
    for section in scene.renderings() {
        let size = match section.key("size").map(|key| &key.value) {
            None => Some(RenderOptions::default().image.size.0),
            Some(Value::String(text)) => {
                let sides = text.split_once('x');
                sides.and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]))
            }
            Some(_) => None,
        };
        if let Some([width, height]) = size {
            let half = |side: u32| (side / 2).max(1);
            let size = format!("{}x{}", half(width), half(height));
            section.set("size", Value::String(size));
        }
        let frames = section.key("frames").and_then(|key| key.value.as_integer());
        if let Some(frames) = frames.filter(|_| section.key("sweep-length").is_none()) {
            section.set("frames", Value::Integer((frames + 3) / 4));
        }
    }
}

fn integer(scene: &Scene, section: &str, key: &str) -> Option<i64> {
    scene.value(section, key)?.as_integer()
}

fn number(scene: &Scene, section: &str, key: &str) -> Option<f64> {
    let value = scene.value(section, key)?;
    value
        .as_float()
        .or_else(|| value.as_integer().map(|whole| whole as f64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    use crate::cli::run::faults::Faults;

    fn drafted(text: &str) -> Vec<String> {
        let mut faults = Faults::default();
        let mut scene = Scene::all(text, &mut faults).remove(0);
        Quality::Draft.apply(&mut scene);
        let drafts = scene.drafts(&mut faults);
        faults.into_result(Path::new("scene.toml")).unwrap();
        drafts
            .iter()
            .map(|draft| draft.words(&[]).join(" "))
            .collect()
    }

    #[test]
    fn a_draft_is_the_scene_without_its_finest_level() {
        let commands = drafted(
            "name = \"a\"\n[bake]\npreset = \"weave\"\nsamples = \"auto\"\nerror = 0.1\n\
             preview = \"out/p.png\"\n[textons]\nlevels = 3\n\
             [mesh]\ninput = \"b.obj\"\nvertices = 60000\n[synth]\ntexel = 0.5\nlevels = 4\n\
             [[render]]\nsweep = \"view-orbit\"\nframes = 10\nsize = \"641x480\"\n[[render]]\nname = \"still\"\n",
        );
        assert_eq!(
            commands,
            [
                "bake -o a-draft.sample --preset=weave --preview=out/p-draft.png --samples=1 --size=64",
                "textons a-draft.sample -o a-draft.textons.npz --levels=2",
                "gram a-draft.textons.npz -o a-draft.space.npz",
                "knn a-draft.space.npz -o a-draft.knn.npz",
                "mesh b.obj -o a-draft.mesh.ply --vertices=15000",
                "synth a-draft.space.npz a-draft.knn.npz a-draft.mesh.ply -o a-draft.map.ply --levels=3 --texel=1.0",
                "render a-draft.sample a-draft.map.ply -o a-draft.frames --frames=3 --size=320x240 --sweep=view-orbit",
                "render a-draft.sample a-draft.map.ply -o a-draft.still --size=480x360",
            ]
        );
    }

    #[test]
    fn the_texture_stays_as_large() {
        // An imported sample keeps its texels: vertices may be fewer only where the texel is stated.
        let of = |synth: &str| {
            drafted(&format!(
                "name = \"a\"\nsample = \"s.sample\"\n[mesh]\ninput = \"b.obj\"\nvertices = 8000\n[synth]\n{synth}"
            ))
        };
        assert_eq!(of("")[3], "mesh b.obj -o a-draft.mesh.ply --vertices=8000");
        let stated = of("texel = 0.5\n");
        assert_eq!(stated[3], "mesh b.obj -o a-draft.mesh.ply --vertices=2000");
        assert!(stated[4].ends_with("--texel=0.5"));
        // A mesh that keeps its vertices keeps its texel, and the sample all of its texels.
        let kept =
            drafted("name = \"a\"\nsurface = \"m.ply\"\n[bake]\npreset = \"weave\"\nsize = 64\n");
        assert_eq!(
            kept[0],
            "bake -o a-draft.sample --preset=weave --samples=1 --size=64"
        );
    }
}
