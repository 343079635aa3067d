//! The surface as it is baked, for other programs: `SURFACE.npz`.
//!
//! Members, row-major with row 0 at the top: `heights` f32 [H, W] in texels, mean 0 · `albedo` f32
//! [H, W, 3] linear · `roughness`, `metallic` f32 [H, W] · `meta.json` with `name`, `tileable`,
//! `matte` (no coat: roughness means nothing), `reflectance`, `oren_nayar_sigma` (radians, or null),
//! `material` (the id that `btf.json` names).

use std::path::Path;

use ndarray::{Array2, Array3, ArrayD};
use serde_json::{Map, json};

use crate::btf::bake::brdf::Diffuse;
use crate::btf::bake::material::Material;
use crate::error::{Error, Result};
use crate::format::npz;

/// Writes the surface of a material.
pub fn write_surface(material: &Material, path: &Path) -> Result<()> {
    material.check()?;
    let shape = (material.grid.height as usize, material.grid.width as usize);
    let map = |numbers: Vec<f32>| -> Result<ArrayD<f32>> {
        Array2::from_shape_vec(shape, numbers)
            .map(Array2::into_dyn)
            .map_err(|error| Error::data("surface", error.to_string()))
    };
    let texels = material.grid.len();
    let mean = material.heights.iter().map(|&h| f64::from(h)).sum::<f64>() / texels as f64;
    let level = |h: &f32| (f64::from(*h) - mean) as f32;
    let heights = map(material.heights.iter().map(level).collect())?;
    let or_zero = |numbers: &Option<Vec<f32>>| numbers.clone().unwrap_or_else(|| vec![0.0; texels]);
    let roughness = map(or_zero(&material.roughness))?;
    let metallic = map(or_zero(&material.metallic))?;
    let colors: Vec<f32> = bytemuck::cast_slice(&material.albedo).to_vec();
    let albedo = Array3::from_shape_vec((shape.0, shape.1, 3), colors)
        .map_err(|error| Error::data("surface", error.to_string()))?;
    let sigma = match material.diffuse {
        Diffuse::Lambert => None,
        Diffuse::OrenNayar(sigma) => Some(sigma),
    };
    let meta = Map::from_iter([
        ("name".to_owned(), json!(material.name)),
        ("tileable".to_owned(), json!(material.grid.tileable)),
        ("matte".to_owned(), json!(material.roughness.is_none())),
        ("reflectance".to_owned(), json!(material.reflectance)),
        ("oren_nayar_sigma".to_owned(), json!(sigma)),
        ("material".to_owned(), json!(material.id())),
    ]);
    npz::write(path, meta, |archive| {
        archive.array("heights", heights.view())?;
        archive.array("albedo", albedo.view())?;
        archive.array("roughness", roughness.view())?;
        archive.array("metallic", metallic.view())
    })
    .map(|_| ())
}
