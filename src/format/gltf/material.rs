//! How a GLB looks: textures, transparency, roughness.

use serde_json::{Value, json};

/// What becomes of a base colour's alpha.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AlphaMode {
    /// There is none.
    #[default]
    Opaque,
    /// Less than a half is not there.
    Mask,
    /// The surface is mixed with what lies behind.
    Blend,
}

/// The material of a GLB; textures are whole PNG files.
#[derive(Clone, Copy, Debug)]
pub struct GltfMaterial<'a> {
    /// The base colour, by the sRGB curve, with alpha unless [`alpha`](Self::alpha) is opaque.
    pub base_color: Option<&'a [u8]>,
    /// Normals in the space of the mesh's tangents.
    pub normal_map: Option<&'a [u8]>,
    /// What becomes of alpha.
    pub alpha: AlphaMode,
    /// 0 (a mirror) to 1; nothing is metal.
    pub roughness: f32,
    /// Whether the base colour is what is seen, light and shade included.
    pub is_unlit: bool,
}

const UNLIT: &str = "KHR_materials_unlit";

impl<'a> GltfMaterial<'a> {
    /// The textures, in the order of their numbers.
    pub(super) fn textures(&self) -> impl Iterator<Item = &'a [u8]> {
        self.base_color.into_iter().chain(self.normal_map)
    }

    /// Adds the material to a file's description; `views` are the buffer views of its textures.
    pub(super) fn describe(&self, file: &mut Value, views: &[usize]) {
        let mut surface = json!({ "metallicFactor": 0.0, "roughnessFactor": self.roughness });
        let mut next = 0;
        let mut texture = |there: bool| {
            let index = next;
            next += usize::from(there);
            there.then(|| json!({ "index": index }))
        };
        if let Some(texture) = texture(self.base_color.is_some()) {
            surface["baseColorTexture"] = texture;
        }
        let mut material = json!({ "pbrMetallicRoughness": surface });
        if let Some(texture) = texture(self.normal_map.is_some()) {
            material["normalTexture"] = texture;
        }
        match self.alpha {
            AlphaMode::Opaque => {}
            AlphaMode::Mask => {
                material["alphaMode"] = json!("MASK");
                material["alphaCutoff"] = json!(0.5);
            }
            AlphaMode::Blend => material["alphaMode"] = json!("BLEND"),
        }
        if self.alpha != AlphaMode::Opaque {
            // Through holes the far side is seen from within.
            material["doubleSided"] = json!(true);
        }
        if self.is_unlit {
            material["extensions"] = json!({ UNLIT: {} });
            file["extensionsUsed"] = json!([UNLIT]);
        }
        file["materials"] = json!([material]);
        if views.is_empty() {
            return;
        }
        let textures = 0..views.len();
        file["textures"] = textures
            .map(|at| json!({ "sampler": 0, "source": at }))
            .collect();
        let image = |view: &usize| json!({ "bufferView": view, "mimeType": "image/png" });
        file["images"] = views.iter().map(image).collect();
        // Mixed between texels and levels; beyond the border of an atlas there is nothing.
        file["samplers"] = json!([
            { "magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071 }
        ]);
    }
}
