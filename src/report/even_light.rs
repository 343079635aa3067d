//! The images' shares under light that falls in evenly from all around.

use std::f64::consts::PI;

use crate::btf::direction::Direction;
use crate::render::nearest::{DirectionSet, Scratch, Weighting};

/// Directions that the integral is a sum of.
const DIRECTIONS: usize = 4096;

/// Per light ∫ w dω over the hemisphere, w its weight by the rule `continuous`: the sum of radiance by shares is what an
/// environment of radiance 1 gives.
pub(super) fn shares(lights: &[Direction]) -> Vec<f32> {
    let set = DirectionSet::new(lights, Weighting::Continuous);
    let mut shares = vec![0.0f64; set.len()];
    let (mut scratch, mut weights) = (Scratch::default(), Vec::new());
    let turn = PI * (3.0 - 5f64.sqrt());
    for at in 0..DIRECTIONS {
        let cosine = 1.0 - (at as f64 + 0.5) / DIRECTIONS as f64;
        let wanted = Direction::from_angles(cosine.acos(), turn * at as f64).0;
        set.weigh::<true>(wanted, &mut scratch, &mut weights);
        for weight in &weights {
            shares[weight.index as usize] += f64::from(weight.weight);
        }
    }
    let solid_angle = 2.0 * PI / DIRECTIONS as f64;
    shares
        .iter()
        .map(|share| (share * solid_angle) as f32)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_white_plane_shows_the_environment() {
        let angles = (0..5).flat_map(|ring| (0..12).map(move |k| (ring, k)));
        let lights: Vec<Direction> = angles
            .map(|(ring, k)| {
                Direction::from_angles(
                    f64::from(15 + 15 * ring).to_radians(),
                    f64::from(k) * PI / 6.0,
                )
            })
            .collect();
        let radiance = lights.iter().map(|light| light.cos_theta() / PI);
        let sum: f64 = radiance
            .zip(shares(&lights))
            .map(|(r, share)| r * f64::from(share))
            .sum();
        assert!((sum - 1.0).abs() < 0.02, "{sum}");
    }
}
