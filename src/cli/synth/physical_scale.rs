//! The texel that the size of a sample makes on a mesh whose unit is known.

use std::fmt;

use clap::ValueEnum;

use crate::cli::machine::available_memory;
use crate::error::{Error, Result};
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::sites::vertices::memory::vertices_retiled_in;

/// The unit of a mesh's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MeshUnit {
    /// Millimetres
    Mm,
    /// Centimetres
    Cm,
    /// Metres, as in glTF
    M,
    /// Inches
    In,
}

impl fmt::Display for MeshUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mm => "mm",
            Self::Cm => "cm",
            Self::M => "m",
            Self::In => "in",
        })
    }
}

impl MeshUnit {
    fn millimetres(self) -> f64 {
        match self {
            Self::Mm => 1.0,
            Self::Cm => 10.0,
            Self::M => 1000.0,
            Self::In => 25.4,
        }
    }
}

/// The side of a sample's texels on a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhysicalTexel {
    unit: MeshUnit,
    millimetres: f64,
}

impl PhysicalTexel {
    /// Of texels with this side; refused where it is not known.
    pub fn new(unit: MeshUnit, texel_mm: Option<f64>) -> Result<Self> {
        let Some(millimetres) = texel_mm else {
            return Err(Error::option(
                "mesh-unit",
                format!("{unit}, but the space does not state the size of a texel"),
                "--texel X, in mesh units; or a sample that states it (--texel-mm of import or exemplar, \
                 texel-mm or width-mm in a recipe of bake), and make its textons and space again",
            ));
        };
        Ok(Self { unit, millimetres })
    }

    /// Mesh units per texel.
    pub fn mesh_units(self) -> f64 {
        self.millimetres / self.unit.millimetres()
    }

    /// What the user reads.
    pub fn describe(self) -> String {
        let (mm, unit, texel) = (self.millimetres, self.unit, self.mesh_units());
        format!("a texel of {mm} mm covers {texel} mesh units ({unit})")
    }

    /// An error about the texel names what the user typed.
    pub fn name_in(self, error: Error) -> Error {
        match error {
            Error::Option {
                option,
                found,
                expected,
            } if option == "texel" => {
                let Self { unit, millimetres } = self;
                let found = format!("{unit}, in which a texel of {millimetres} mm is {found}");
                Error::option("mesh-unit", found, expected)
            }
            other => other,
        }
    }
}

/// Refuses a texel for which a vertex per texel would not fit the memory there is.
pub fn check_texel_count(mesh: &TriangleMesh, texel: f64) -> Result<()> {
    match available_memory() {
        Some(available) => check_texels(mesh, texel, vertices_retiled_in(available.0)),
        None => Ok(()),
    }
}

fn check_texels(mesh: &TriangleMesh, texel: f64, most: u64) -> Result<()> {
    let (area, texels) = (mesh.area(), mesh.area() / texel.powi(2));
    let most = most.max(mesh.positions.len() as u64);
    if texels <= most as f64 {
        return Ok(());
    }
    Err(Error::option(
        "texel",
        format!("{texel}: the mesh holds {texels:.3e} texels, which need as many vertices"),
        format!(
            "at most {most}, for which there is memory: --texel {:.3e} or more",
            (area / most as f64).sqrt()
        ),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn a_texel_has_its_size_in_the_unit_of_the_mesh() {
        for (unit, expected) in [
            (MeshUnit::Mm, 0.5),
            (MeshUnit::Cm, 0.05),
            (MeshUnit::M, 0.0005),
            (MeshUnit::In, 0.5 / 25.4),
        ] {
            let texel = PhysicalTexel::new(unit, Some(0.5)).unwrap();
            assert!((texel.mesh_units() - expected).abs() < 1e-15, "{unit}");
        }
        let refused = PhysicalTexel::new(MeshUnit::Cm, None).unwrap_err();
        assert!(refused.to_string().starts_with("--mesh-unit: cm, but"));
    }

    #[test]
    fn errors_name_the_option_that_was_typed() {
        let texel = PhysicalTexel::new(MeshUnit::M, Some(2.0)).unwrap();
        let named = texel.name_in(Error::option("texel", "0.002: too small", "more"));
        let expected =
            "--mesh-unit: m, in which a texel of 2 mm is 0.002: too small; expected more";
        assert_eq!(named.to_string(), expected);
        let other = texel.name_in(Error::option("k", "3", "4"));
        assert_eq!(other.to_string(), "--k: 3; expected 4");
    }

    #[test]
    fn texels_beyond_memory_are_refused_with_the_smallest_that_fits() {
        // 10 × 10 units.
        let mesh = shapes::grid(10, 10, 1.0);
        assert!(check_texels(&mesh, 0.1, 10_000).is_ok());
        let refused = check_texels(&mesh, 0.01, 10_000).unwrap_err().to_string();
        assert!(refused.contains("1.000e6 texels"), "{refused}");
        assert!(refused.contains("--texel 1.000e-1 or more"), "{refused}");
        // A mesh that is there already fits.
        assert!(check_texels(&mesh, 1.0, 3).is_ok());
    }
}
