//! How many faces the base mesh has, how often it is subdivided, and how much of the sample is used.
//!
//! A triangle of the sample's grid is a texel high, so it covers 1/√3 square texels. On the finest level a face of the
//! surface stands for as much: a surface of area A whose texels have side `texel` has √3·A/texel² faces.

use serde::Serialize;

use crate::error::{Error, Result};
use crate::mesh::subdivision::butterfly::CHILDREN;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::sites::faces::triangular_grid::triangles_per_row;
use crate::sites::vertices::surface_options::texel_on;

/// Rows of triangles that the coarsest level needs: fewer leave no whole neighbourhood.
const FEWEST_ROWS: u32 = 5;
/// Rows of triangles that the coarsest level keeps where nothing else is asked for (Castellanos and Williams, Fig. 8).
const ROWS: u32 = 8;
/// How many times the surface holds the sample, at least, where nothing else is asked for.
const COPIES: usize = 4;
/// The most triangles of a base mesh.
const MOST_BASE_FACES: f64 = (1 << 24) as f64;

/// What can be asked of the faces of a surface.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Faces")]
pub struct FaceOptions {
    /// Approximate number of triangles of the base mesh [default: from --texel and --subdivisions]
    #[arg(long, value_name = "N")]
    pub base_faces: Option<usize>,
    /// How often the base mesh is subdivided, each time into four times as many faces [default: one less than the
    /// levels of the space, or as often as leaves the sample 8 rows of triangles]
    #[arg(long, value_name = "N")]
    pub subdivisions: Option<u32>,
}

/// The sizes of a surface and its sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FacePlan {
    /// Rows and columns of the sample that are used.
    pub side: u32,
    /// How often base mesh and grid are subdivided.
    pub subdivisions: u32,
    /// Triangles that the base mesh is asked for.
    pub base_faces: usize,
}

impl FacePlan {
    /// Plans a surface on a mesh, for a sample of `[width, height]` texels in a space of this many levels. `texel` is
    /// what is asked for, in mesh units.
    ///
    /// Errors: options that exclude each other, a sample too small for the levels, a surface smaller than the sample.
    pub fn new(
        mesh: &TriangleMesh,
        ([width, height], levels): ([u32; 2], usize),
        options: &FaceOptions,
        texel: Option<f64>,
    ) -> Result<Self> {
        // Find how often the sample is subdivided.
        let shortest = width.min(height);
        let subdivisions = subdivisions_of(shortest, levels, options.subdivisions)?;
        let rows = shortest >> subdivisions;
        let of_sample = rows as usize * triangles_per_row(rows) as usize;
        // Find how many faces the base mesh needs.
        let base_faces = match (options.base_faces, texel) {
            (Some(faces), Some(texel)) => {
                let found = format!("{texel} beside --base-faces {faces}");
                let expected = "one of the two: both set the size of a face";
                return Err(Error::option("texel", found, expected));
            }
            (Some(faces), None) if faces < of_sample => {
                let expected = format!(
                    "at least the {of_sample} triangles of the sample at the coarsest level; more --subdivisions make \
                     them fewer"
                );
                return Err(Error::option("base-faces", faces.to_string(), expected));
            }
            (Some(faces), None) => faces,
            (None, asked) => faces_of_texel(mesh, asked, (of_sample, subdivisions))?,
        };
        Ok(Self {
            side: rows << subdivisions,
            subdivisions,
            base_faces,
        })
    }

    /// Faces of the finest level, about.
    pub fn faces(&self) -> u64 {
        u64::from(CHILDREN)
            .saturating_pow(self.subdivisions)
            .saturating_mul(self.base_faces as u64)
    }

    /// Triangles of the sample's finest grid.
    pub fn sample_faces(&self) -> u64 {
        let rows = self.side >> self.subdivisions;
        (u64::from(rows) * u64::from(triangles_per_row(rows))) << (2 * self.subdivisions)
    }
}

/// How often the base mesh is subdivided: as asked, or as the sample allows.
fn subdivisions_of(shortest: u32, levels: usize, asked: Option<u32>) -> Result<u32> {
    let rows = |subdivisions: u32| shortest.checked_shr(subdivisions).unwrap_or(0);
    if rows(0) < FEWEST_ROWS {
        let found = format!("{shortest} texels along its shorter side");
        return Err(Error::data("sample", found).expected(format!("at least {FEWEST_ROWS}")));
    }
    let largest = |fewest: u32| (0..32).take_while(|&count| rows(count) >= fewest).count() as u32;
    match asked {
        Some(asked) if rows(asked) < FEWEST_ROWS => Err(Error::option(
            "subdivisions",
            format!("{asked} with a sample of {shortest} texels along its shorter side"),
            format!(
                "at most {}: its coarsest level needs {FEWEST_ROWS} rows of triangles",
                largest(FEWEST_ROWS) - 1
            ),
        )),
        Some(asked) => Ok(asked),
        None => Ok(largest(ROWS).min(levels as u32).saturating_sub(1)),
    }
}

/// The triangles of a base mesh whose faces stand for a texel on the finest level.
fn faces_of_texel(
    mesh: &TriangleMesh,
    asked: Option<f64>,
    (of_sample, subdivisions): (usize, u32),
) -> Result<usize> {
    let texel = texel_on(mesh, asked)?;
    let parts = f64::from(CHILDREN).powi(subdivisions as i32);
    let weight = 3f64.sqrt() * mesh.area() / parts;
    let faces = (weight / (texel * texel)).round();
    let largest = (weight / of_sample as f64).sqrt();
    let refused = |expected: String| Err(Error::option("texel", texel.to_string(), expected));
    if faces > MOST_BASE_FACES {
        let least = (weight / MOST_BASE_FACES).sqrt();
        return refused(format!(
            "at least {least}: the base mesh has too many faces"
        ));
    }
    match asked {
        None => Ok((faces as usize).max(COPIES * of_sample)),
        Some(_) if (faces as usize) < of_sample => refused(format!(
            "at most {largest}: the surface would be smaller than the sample"
        )),
        Some(_) => Ok(faces as usize),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::sites::faces::triangular_grid::TriangularGrid;

    fn planned(
        size: [u32; 2],
        levels: usize,
        (base_faces, subdivisions): (Option<usize>, Option<u32>),
        texel: Option<f64>,
    ) -> Result<FacePlan> {
        let options = FaceOptions {
            base_faces,
            subdivisions,
        };
        FacePlan::new(&shapes::grid(40, 30, 1.0), (size, levels), &options, texel)
    }

    #[test]
    fn texels_make_faces_and_samples_are_cropped() {
        let plan = planned([70, 67], 4, (None, None), Some(0.1)).unwrap();
        // √3 · 1200 / 0.01 faces.
        assert_eq!((plan.side, plan.subdivisions), (64, 3));
        assert_eq!(
            plan.base_faces,
            (3f64.sqrt() * 120_000.0 / 64.0).round() as usize
        );
        assert_eq!(plan.faces(), 64 * plan.base_faces as u64);
        let grid = TriangularGrid::new(plan.side, plan.subdivisions + 1).unwrap();
        assert_eq!(plan.sample_faces(), grid.pyramid.levels[3].count() as u64);
        // A sample of few rows has fewer levels than the space.
        let few = planned([20, 24], 4, (None, None), None).unwrap();
        assert_eq!((few.side, few.subdivisions), (20, 1));
        // Without a texel the surface holds the sample four times at least.
        assert_eq!(few.base_faces, 4 * 10 * 17);
        let asked = planned([64, 64], 4, (Some(500), Some(2)), None).unwrap();
        assert_eq!(
            (asked.base_faces, asked.subdivisions, asked.side),
            (500, 2, 64)
        );
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let refused = |size, asked, texel| {
            let planned = planned(size, 4, asked, texel);
            planned.unwrap_err().to_string()
        };
        let none = (None, None);
        assert!(refused([4, 90], none, None).contains("4 texels along its shorter side"));
        let many = refused([64, 64], (None, Some(4)), None);
        assert!(
            many.contains("--subdivisions: 4") && many.contains("at most 3"),
            "{many}"
        );
        assert!(refused([64, 64], (None, Some(99)), None).contains("at most 3"));
        let both = refused([64, 64], (Some(500), None), Some(0.1));
        assert!(
            both.contains("--texel: 0.1 beside --base-faces 500"),
            "{both}"
        );
        let few = refused([64, 64], (Some(100), None), None);
        assert!(
            few.contains("--base-faces: 100") && few.contains("104"),
            "{few}"
        );
        let large = refused([64, 64], none, Some(2.0));
        assert!(
            large.contains("--texel: 2") && large.contains("at most 0.55"),
            "{large}"
        );
        assert!(refused([64, 64], none, Some(1e-6)).contains("too many faces"));
        assert!(refused([64, 64], none, Some(0.0)).contains("--texel"));
    }
}
