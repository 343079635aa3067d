//! What a file's extensions mean for its geometry.

use gltf::accessor::Accessor;
use gltf::mesh::Primitive;
use serde_json::Value;

use crate::error::{Error, Result};
use crate::format::gltf::description::list;

/// Extensions that are read.
const READ: [&str; 2] = ["KHR_mesh_quantization", "EXT_mesh_gpu_instancing"];
/// Extensions that pack geometry.
const PACKED: [&str; 4] = [
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "MESHOPT_compression",
];
/// Parts of the names of extensions that concern anything but geometry.
const UNNEEDED: [&str; 13] = [
    "_materials_",
    "_texture_",
    "_lights_",
    "_animation_",
    "_audio",
    "_xmp",
    "_metadata",
    "_mesh_features",
    "_physics",
    "_interactivity",
    "_ngon_encoding",
    "_lod",
    "VRM",
];

/// Refuses a file whose geometry asks for an extension that is not read. Others are crossed out of the
/// list of what is required, which the `gltf` crate would refuse; says which.
pub(super) fn settle(description: &mut Value) -> Result<Vec<String>> {
    let required: Vec<String> = list(description, "extensionsRequired")
        .iter()
        .filter_map(|name| Some(name.as_str()?.to_owned()))
        .collect();
    if let Some(name) = required.iter().find(|name| PACKED.contains(&name.as_str())) {
        return Err(packed(name));
    }
    let is_read = |name: &&String| READ.contains(&name.as_str());
    let is_unneeded = |name: &&String| UNNEEDED.iter().any(|part| name.contains(part));
    let unknown = required
        .iter()
        .find(|name| !is_read(name) && !is_unneeded(name));
    if let Some(name) = unknown {
        return Err(
            Error::data("extensionsRequired", format!("extension {name}"))
                .expected("none that may change the geometry in a way not known here")
                .advice("export the mesh without it"),
        );
    }
    if let Some(description) = description.as_object_mut() {
        description.remove("extensionsRequired");
    }
    let unneeded = required.iter().filter(|name| !is_read(name));
    Ok(unneeded
        .map(|name| format!("extension {name}: it does not concern the geometry"))
        .collect())
}

fn packed(name: &str) -> Error {
    Error::data("glTF", format!("geometry packed by {name}"))
        .expected("plain geometry")
        .advice("unpack it: gltf-transform copy packed.glb plain.glb (npm: @gltf-transform/cli)")
}

/// Refuses positions that only a packed copy holds.
pub(super) fn refuse_draco(primitive: &Primitive<'_>, positions: &Accessor<'_>) -> Result<()> {
    let packing = primitive.extension_value(PACKED[0]);
    match packing {
        Some(_) if positions.view().is_none() => Err(packed(PACKED[0])),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn extensions_are_read_passed_over_or_refused_by_name() {
        let settled = |name: &str| settle(&mut json!({ "extensionsRequired": [name] }));
        for name in READ {
            assert!(settled(name).unwrap().is_empty());
        }
        for name in [
            "KHR_materials_unlit",
            "KHR_texture_basisu",
            "EXT_texture_webp",
            "KHR_lights_punctual",
            "VRMC_vrm",
        ] {
            assert!(settled(name).unwrap()[0].contains(name));
        }
        for name in PACKED {
            let error = settled(name).unwrap_err().to_string();
            assert!(
                error.contains(name) && error.contains("gltf-transform"),
                "{error}"
            );
        }
        let error = settled("EXT_bent_space").unwrap_err().to_string();
        assert!(error.contains("EXT_bent_space"), "{error}");
    }
}
