//! What is baked, in memory: heights and reflection of every texel, from maps or from a preset.

use glam::{DVec2, Vec3};

use crate::btf::bake::brdf::{Coat, Diffuse, Reflection};
use crate::btf::bake::height_field::{HeightField, ReliefPoint, texel};
use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::grid::TexelGrid;

/// A flat piece of material on a texel grid; arrays are row-major, row 0 at the top.
#[derive(Clone, Debug)]
pub struct Material {
    /// What it is called.
    pub name: String,
    /// Its texels, and whether opposite borders continue each other.
    pub grid: TexelGrid,
    /// Side of a texel in millimetres, where known.
    pub texel_mm: Option<f64>,
    /// Height of the surface at each texel's centre, in texels; any level.
    pub heights: Vec<f32>,
    /// Base colour, linear Rec. 709, 0 to 1.
    pub albedo: Vec<Vec3>,
    /// Roughness of the coat, 0 to 1; `None`: matte, no coat at all.
    pub roughness: Option<Vec<f32>>,
    /// 0 dielectric, 1 metal; `None`: no metal anywhere.
    pub metallic: Option<Vec<f32>>,
    /// Reflectance of the coat at normal incidence where it is no metal.
    pub reflectance: f32,
    /// The diffuse base.
    pub diffuse: Diffuse,
}

impl Material {
    /// Refuses arrays of the wrong length and numbers no material has.
    pub fn check(&self) -> Result<()> {
        let unit = |v: f32| (0.0..=1.0).contains(&v);
        self.check_map("height", self.heights.len(), |i| {
            self.heights[i].is_finite()
        })?;
        self.check_map("albedo", self.albedo.len(), |i| {
            self.albedo[i].to_array().into_iter().all(unit)
        })?;
        for (name, map) in [("roughness", &self.roughness), ("metallic", &self.metallic)] {
            if let Some(map) = map {
                self.check_map(name, map.len(), |i| unit(map[i]))?;
            }
        }
        if !unit(self.reflectance) {
            return Err(Error::data("reflectance", self.reflectance.to_string()).expected("0 to 1"));
        }
        Ok(())
    }

    fn check_map(&self, name: &str, length: usize, sound: impl Fn(usize) -> bool) -> Result<()> {
        if length != self.grid.len() || length == 0 {
            return Err(Error::data(name, format!("{length} texels"))
                .expected(format!("{}", self.grid.len())));
        }
        let Some(at) = (0..length).find(|&index| !sound(index)) else {
            return Ok(());
        };
        let width = self.grid.width as usize;
        Err(Error::data(
            format!("{name}, row {}, column {}", at / width, at % width),
            "a value out of range",
        )
        .expected("finite heights; albedo, roughness and metallic in 0 to 1"))
    }

    /// The surface to trace. A material that is not tileable is continued by mirroring, so its surface
    /// has twice the rows and columns.
    pub fn surface(&self) -> HeightField {
        HeightField::of_grid(self.grid, &self.heights)
    }

    /// The texel at a column and an upward row of the surface.
    fn texel(&self, x: usize, y: usize) -> usize {
        texel(self.grid, x, y)
    }

    /// The reflection at a point of the surface: the maps, linear between texel centres.
    pub fn reflection(&self, point: ReliefPoint) -> Reflection {
        let texels =
            [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| self.texel(point.x + dx, point.y + dy));
        let weights = bilinear(point.within);
        let number = |map: &[f32]| (0..4).map(|i| weights[i] * map[texels[i]]).sum::<f32>();
        Reflection {
            albedo: (0..4).map(|i| weights[i] * self.albedo[texels[i]]).sum(),
            metallic: self.metallic.as_deref().map_or(0.0, number),
            diffuse: self.diffuse,
            coat: self.roughness.as_deref().map(|map| Coat {
                roughness: number(map),
                reflectance: self.reflectance,
            }),
        }
    }

    /// The id of all numbers that decide the look.
    pub fn id(&self) -> ContentId {
        let mut hasher = blake3::Hasher::new();
        let shape = [
            self.grid.width,
            self.grid.height,
            u32::from(self.grid.tileable),
        ];
        hasher.update(bytemuck::cast_slice(&shape));
        hasher.update(bytemuck::cast_slice(&self.heights));
        hasher.update(bytemuck::cast_slice(&self.albedo));
        for map in [&self.roughness, &self.metallic] {
            hasher.update(&[u8::from(map.is_some())]);
            hasher.update(bytemuck::cast_slice(map.as_deref().unwrap_or_default()));
        }
        let sigma = match self.diffuse {
            Diffuse::Lambert => -1.0,
            Diffuse::OrenNayar(sigma) => sigma,
        };
        hasher.update(bytemuck::cast_slice(&[self.reflectance, sigma]));
        ContentId::of_hash(&hasher.finalize())
    }
}

/// Weights of a patch's corners (0,0), (1,0), (0,1), (1,1).
fn bilinear(at: DVec2) -> [f32; 4] {
    let (u, v) = (at.x as f32, at.y as f32);
    [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(tileable: bool) -> Material {
        let grid = TexelGrid {
            width: 3,
            height: 2,
            tileable,
        };
        Material {
            name: "ramp".into(),
            grid,
            texel_mm: None,
            heights: vec![0.0, 1.0, 2.0, 10.0, 11.0, 12.0],
            albedo: (0..6).map(|i| Vec3::splat(i as f32 / 10.0)).collect(),
            roughness: None,
            metallic: None,
            reflectance: 0.04,
            diffuse: Diffuse::Lambert,
        }
    }

    fn point(x: usize, y: usize, u: f64, v: f64) -> ReliefPoint {
        ReliefPoint {
            x,
            y,
            within: DVec2::new(u, v),
        }
    }

    #[test]
    fn maps_are_linear_between_texel_centres_and_wrap() {
        let material = ramp(true);
        // Patch (0, 0) has row 1 (the last) below and row 0 above.
        let middle = material.reflection(point(0, 0, 0.5, 0.5)).albedo.x;
        assert!((middle - 0.2).abs() < 1e-6, "{middle}");
        let wrapped = material.reflection(point(2, 0, 1.0, 0.0)).albedo.x;
        assert!((wrapped - 0.3).abs() < 1e-6, "{wrapped}");
    }

    #[test]
    fn what_does_not_tile_is_mirrored() {
        let material = ramp(false);
        let surface = material.surface();
        assert_eq!((surface.width(), surface.height()), (6, 4));
        let height = |x, y| surface.position(point(x, y, 0.0, 0.0)).z;
        assert_eq!(height(2, 0), height(3, 0));
        assert_eq!(height(0, 0), height(5, 0));
        assert_eq!(height(1, 1), height(1, 2));
        assert_eq!(height(1, 0) - height(1, 1), 10.0);
        let beyond = material.reflection(point(4, 0, 0.0, 0.0)).albedo.x;
        assert!((beyond - 0.4).abs() < 1e-6);
    }

    #[test]
    fn unsound_maps_are_refused_by_place() {
        let mut material = ramp(true);
        material.albedo[4].y = 1.5;
        let error = material.check().unwrap_err().to_string();
        assert!(error.contains("albedo, row 1, column 1"), "{error}");
        material.albedo.pop();
        assert!(material.check().is_err());
        let mut material = ramp(true);
        material.heights[0] = f32::NAN;
        assert!(
            material
                .check()
                .unwrap_err()
                .to_string()
                .contains("height, row 0")
        );
    }

    #[test]
    fn the_id_changes_with_every_map() {
        let base = ramp(true);
        let mut other = base.clone();
        other.roughness = Some(vec![0.0; 6]);
        assert_ne!(base.id(), other.id());
        let mut other = base.clone();
        other.diffuse = Diffuse::OrenNayar(0.0);
        assert_ne!(base.id(), other.id());
        assert_eq!(base.id(), base.clone().id());
    }
}
