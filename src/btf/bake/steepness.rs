//! How steep a material's relief is on its texel grid, and which depth would make it plausible.

use crate::btf::bake::material::Material;

/// A relief steeper than this at the 95th percentile is implausible, degrees.
const TOO_STEEP_DEG: f64 = 70.0;
/// A relief flatter than this at the 95th percentile is next to invisible, degrees.
const TOO_FLAT_DEG: f64 = 1.0;
/// What is advised instead: slopes at the 95th percentile.
const PLAUSIBLE_STEEP_DEG: f64 = 45.0;
const PLAUSIBLE_FLAT_DEG: f64 = 20.0;

/// Slopes of a relief, in degrees from the horizontal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steepness {
    /// Mean over the texels.
    pub mean_deg: f64,
    /// 95 % of the texels are less steep.
    pub p95_deg: f64,
}

impl Steepness {
    /// The slopes of a material, by central differences.
    pub fn of(material: &Material) -> Self {
        let (width, height) = (material.grid.width as usize, material.grid.height as usize);
        let beside = |index: usize, side: usize| match material.grid.tileable {
            true => ((index + side - 1) % side, (index + 1) % side),
            false => (index.saturating_sub(1), (index + 1).min(side - 1)),
        };
        let at = |row: usize, col: usize| f64::from(material.heights[row * width + col]);
        let mut tangents: Vec<f64> = (0..width * height)
            .map(|texel| {
                let (row, col) = (texel / width, texel % width);
                let ((left, right), (above, below)) = (beside(col, width), beside(row, height));
                let along_x = (at(row, right) - at(row, left)) / 2.0;
                let along_y = (at(above, col) - at(below, col)) / 2.0;
                along_x.hypot(along_y)
            })
            .collect();
        let mean = tangents.iter().map(|tan| tan.atan()).sum::<f64>() / tangents.len() as f64;
        let rank = (tangents.len() - 1) * 95 / 100;
        let (_, p95, _) = tangents.select_nth_unstable_by(rank, f64::total_cmp);
        Self {
            mean_deg: mean.to_degrees(),
            p95_deg: p95.atan().to_degrees(),
        }
    }

    /// What a report says.
    pub fn describe(self) -> String {
        format!(
            "slopes of the relief: {:.1}° on average, 95 % of them below {:.1}°",
            self.mean_deg, self.p95_deg
        )
    }

    /// The slope that 95 % are below, in degrees, of the same relief so many times as deep.
    pub fn p95_at(self, times: f64) -> f64 {
        (times * self.p95_deg.to_radians().tan())
            .atan()
            .to_degrees()
    }

    /// The depth nearest to `depth` at which slopes are plausible; a relief without slopes keeps its own.
    pub fn plausible_depth(self, depth: f64) -> f64 {
        let wanted = self.p95_deg.clamp(PLAUSIBLE_FLAT_DEG, PLAUSIBLE_STEEP_DEG);
        match self.p95_deg > 0.0 {
            true => rounded(depth * wanted.to_radians().tan() / self.p95_deg.to_radians().tan()),
            false => depth,
        }
    }

    /// What is wrong with slopes that come from a height map of this depth (share of its width).
    pub fn objection(self, depth: f64) -> Option<String> {
        // Slopes are proportional to the depth.
        let depth_for = |degrees: f64| {
            rounded(depth * degrees.to_radians().tan() / self.p95_deg.to_radians().tan())
        };
        let Self { mean_deg, p95_deg } = self;
        if p95_deg > TOO_STEEP_DEG {
            return Some(format!(
                "the relief is implausibly steep: {mean_deg:.0}° on average, 5 % above {p95_deg:.0}°; \
                 --depth {} would give {PLAUSIBLE_STEEP_DEG:.0}° in place of {p95_deg:.0}°",
                depth_for(PLAUSIBLE_STEEP_DEG)
            ));
        }
        if mean_deg == 0.0 {
            return Some("the height map has the same value everywhere: there is no relief".into());
        }
        let wanted = depth_for(PLAUSIBLE_FLAT_DEG);
        if p95_deg < TOO_FLAT_DEG && wanted.is_finite() {
            return Some(format!(
                "the relief is nearly flat: 95 % of its slopes are below {p95_deg:.2}°; --depth {wanted} \
                 would give {PLAUSIBLE_FLAT_DEG:.0}° there"
            ));
        }
        None
    }
}

/// A number with two significant digits.
fn rounded(number: f64) -> f64 {
    format!("{number:.1e}").parse().unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::btf::bake::brdf::Diffuse;
    use crate::grid::TexelGrid;

    /// Waves of a height in texels, 16 texels long.
    fn waves(height: f32) -> Material {
        let grid = TexelGrid {
            width: 64,
            height: 32,
            tileable: true,
        };
        let phase = |texel: usize| std::f32::consts::TAU * (texel % 64) as f32 / 16.0;
        Material {
            name: "waves".into(),
            grid,
            texel_mm: None,
            heights: (0..2048).map(|texel| height * phase(texel).sin()).collect(),
            albedo: vec![Vec3::ONE; 2048],
            roughness: None,
            metallic: None,
            reflectance: 0.04,
            diffuse: Diffuse::Lambert,
        }
    }

    #[test]
    fn slopes_are_those_of_the_surface() {
        let found = Steepness::of(&waves(1.0));
        // The steepest slope by central differences: sin(2π/16).
        let steepest = (std::f64::consts::TAU / 16.0).sin().atan().to_degrees();
        assert!((found.p95_deg - steepest).abs() < 0.01, "{found:?}");
        assert!(found.mean_deg > 0.5 * steepest && found.mean_deg < steepest);
    }

    #[test]
    fn the_depth_that_is_advised_is_plausible() {
        for height in [0.01_f32, 40.0] {
            let objection = Steepness::of(&waves(height)).objection(0.5).unwrap();
            let advised = objection.split("--depth ").nth(1).unwrap();
            let advised: f32 = advised.split(' ').next().unwrap().parse().unwrap();
            let better = Steepness::of(&waves(height * advised / 0.5));
            assert_eq!(better.objection(f64::from(advised)), None);
            assert!((15.0..50.0).contains(&better.p95_deg), "{better:?}");
        }
        assert_eq!(Steepness::of(&waves(2.0)).objection(0.1), None);
        for height in [0.01_f32, 1.0, 40.0] {
            let slopes = Steepness::of(&waves(height));
            let chosen = slopes.plausible_depth(0.5);
            let better = Steepness::of(&waves(height * chosen as f32 / 0.5));
            assert!((19.0..46.0).contains(&better.p95_deg), "{better:?}");
            assert!((slopes.p95_at(chosen / 0.5) - better.p95_deg).abs() < 0.1);
        }
        let flat = Steepness::of(&waves(0.0)).objection(0.1).unwrap();
        assert!(flat.contains("same value everywhere"));
    }
}
