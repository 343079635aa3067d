//! The images' shares under light that falls in from all around.

use std::f64::consts::PI;

use crate::btf::direction::Direction;
use crate::render::nearest::{DirectionSet, Scratch, Weighting};

/// Directions that the integral is a sum of.
const DIRECTIONS: usize = 4096;

/// Per light ∫ w dω over the hemisphere, w its weight by the rule `continuous`: the sum of radiance by shares is what
/// an environment of radiance 1 gives.
pub(crate) fn shares(lights: &[Direction]) -> Vec<f32> {
    let set = DirectionSet::new(lights, Weighting::Continuous);
    let [even, ..] = sums(&set);
    even
}

/// Per light ∫ w dω over the hemisphere, and ∫ w (1 + ωₖ)/2 dω with ωₖ the direction's x, y and z, w the light's weight
/// by the rule of the set. Combinations of the four are environments whose radiance changes linearly with direction.
pub(crate) fn sums(lights: &DirectionSet) -> [Vec<f32>; 4] {
    let mut sums = [0; 4].map(|_| vec![0.0f64; lights.len()]);
    let (mut scratch, mut weights) = (Scratch::default(), Vec::new());
    let turn = PI * (3.0 - 5f64.sqrt());
    for at in 0..DIRECTIONS {
        let cosine = 1.0 - (at as f64 + 0.5) / DIRECTIONS as f64;
        let wanted = Direction::from_angles(cosine.acos(), turn * at as f64).0;
        lights.weigh::<true>(wanted, &mut scratch, &mut weights);
        let factors = [1.0, wanted.x, wanted.y, wanted.z].map(|of| 0.5 * (1.0 + of));
        for weight in &weights {
            for (sum, factor) in sums.iter_mut().zip(factors) {
                sum[weight.index as usize] += f64::from(weight.weight) * factor;
            }
        }
    }
    let solid_angle = 2.0 * PI / DIRECTIONS as f64;
    sums.map(|sum| {
        let of_light = sum.iter().map(|share| (share * solid_angle) as f32);
        of_light.collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rings() -> Vec<Direction> {
        let angles = (0..5).flat_map(|ring| (0..12).map(move |k| (ring, k)));
        angles
            .map(|(ring, k)| {
                Direction::from_angles(
                    f64::from(15 + 15 * ring).to_radians(),
                    f64::from(k) * PI / 6.0,
                )
            })
            .collect()
    }

    fn of_white(lights: &[Direction], shares: &[f32]) -> f64 {
        let radiance = lights.iter().map(|light| light.cos_theta() / PI);
        radiance
            .zip(shares)
            .map(|(r, &share)| r * f64::from(share))
            .sum()
    }

    #[test]
    fn a_white_plane_shows_the_environment() {
        let sum = of_white(&rings(), &shares(&rings()));
        assert!((sum - 1.0).abs() < 0.02, "{sum}");
    }

    #[test]
    fn sums_of_a_white_plane_are_those_of_the_integrals() {
        // ∫ cos θ/π (1 + ωₖ)/2 dω: a half for x and y, and 5/6 for z.
        for weighting in [Weighting::Continuous, Weighting::InverseAngle] {
            let sums = sums(&DirectionSet::new(&rings(), weighting));
            for (sum, wanted) in sums.iter().zip([1.0, 0.5, 0.5, 5.0 / 6.0]) {
                let found = of_white(&rings(), sum);
                assert!(
                    (found - wanted).abs() < 0.05,
                    "{weighting:?} {found} {wanted}"
                );
            }
        }
    }
}
