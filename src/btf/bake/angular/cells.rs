//! How much of the sphere each direction of a set stands for.
//!
//! In: the directions of a set. Out: for each, the second moments of its cell, the part of the sphere that lies nearer
//! to it than to any other, about the direction itself. A cell reaches no further than the fifth nearest direction (as
//! far as rendering looks for images), and not below the horizon.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::btf::direction::{Direction, SAME_DIRECTION};

/// A set of fewer directions is not interpolated: its directions stand for themselves.
pub(super) const LEAST_DIRECTIONS: usize = 6;
/// Which neighbour bounds a cell.
const REACH: usize = 5;
/// The neighbours that a cell is cut by.
const NEIGHBORS: usize = 24;
/// No cell reaches further than this, radians: directions further apart cannot be interpolated.
const FARTHEST: f64 = PI / 6.0;
/// Directions tried in a cell.
const TRIED: usize = 256;

/// The mean of offset ⊗ offset over each direction's cell, in square radians: the offset is the tangent vector at the
/// direction that leads to a place of the cell. Zero for sets of fewer than [`LEAST_DIRECTIONS`].
pub(super) fn second_moments(directions: &[Direction]) -> Vec<DMat3> {
    if directions.len() < LEAST_DIRECTIONS {
        return vec![DMat3::ZERO; directions.len()];
    }
    directions
        .par_iter()
        .map(|direction| second_moment(direction.0, &neighbors(direction.0, directions)))
        .collect()
}

/// The nearest other directions, nearest first.
fn neighbors(direction: DVec3, all: &[Direction]) -> Vec<DVec3> {
    let same = SAME_DIRECTION.cos();
    let mut nearest: Vec<(f64, DVec3)> = Vec::with_capacity(NEIGHBORS + 1);
    let mut least = -2.0;
    for other in all {
        let cos = direction.dot(other.0);
        if cos <= least || cos >= same {
            continue;
        }
        let place = nearest.partition_point(|&(nearer, _)| nearer >= cos);
        nearest.insert(place, (cos, other.0));
        nearest.truncate(NEIGHBORS);
        if nearest.len() == NEIGHBORS {
            least = nearest[NEIGHBORS - 1].0;
        }
    }
    nearest.into_iter().map(|(_, other)| other).collect()
}

fn second_moment(direction: DVec3, neighbors: &[DVec3]) -> DMat3 {
    let Some(bound) = neighbors.get(REACH - 1).or(neighbors.last()) else {
        return DMat3::ZERO;
    };
    let reach = direction.angle_between(*bound).min(FARTHEST);
    let (mut sum, mut count) = (DMat3::ZERO, 0);
    for place in cap(direction, reach) {
        let nearness = place.dot(direction);
        let is_of_cell = place.z >= 0.0 && neighbors.iter().all(|n| place.dot(*n) <= nearness);
        if is_of_cell {
            let offset = offset(direction, place);
            sum += DMat3::from_cols(offset * offset.x, offset * offset.y, offset * offset.z);
            count += 1;
        }
    }
    sum * (1.0 / f64::from(count.max(1)))
}

/// Directions within an angle of another, even in solid angle.
fn cap(direction: DVec3, reach: f64) -> impl Iterator<Item = DVec3> {
    let (tangent, bitangent) = direction.any_orthonormal_pair();
    let depth = 1.0 - reach.cos();
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    (0..TRIED).map(move |index| {
        let cos = 1.0 - depth * (index as f64 + 0.5) / TRIED as f64;
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let (y, x) = (index as f64 * golden % TAU).sin_cos();
        cos * direction + sin * (x * tangent + y * bitangent)
    })
}

/// The tangent vector at `from` that leads to `to`; its length is the angle.
fn offset(from: DVec3, to: DVec3) -> DVec3 {
    let across = to - from * from.dot(to);
    let sin = across.length();
    if sin < 1e-12 {
        return DVec3::ZERO;
    }
    across * (sin.atan2(from.dot(to)) / sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions(set: &str) -> Vec<Direction> {
        let set: crate::btf::direction_set::DirectionSet = set.parse().unwrap();
        set.directions().unwrap()
    }

    fn trace(m: &DMat3) -> f64 {
        m.x_axis.x + m.y_axis.y + m.z_axis.z
    }

    #[test]
    fn cells_of_an_even_set_have_the_moments_of_their_area() {
        let set = directions("fibonacci:400");
        let moments = second_moments(&set);
        // A square of area A has second moments A/12 along each side.
        let wanted = TAU / 400.0 / 6.0;
        for (direction, moment) in set.iter().zip(&moments) {
            let found = trace(moment);
            assert!(
                (0.6..1.8).contains(&(found / wanted)),
                "{direction:?}: {found}"
            );
            assert!((*moment * direction.0).length() < 1e-12);
        }
        let mean = moments.iter().map(trace).sum::<f64>() / 400.0;
        assert!((mean / wanted - 1.0).abs() < 0.15, "{mean} {wanted}");
    }

    #[test]
    fn cells_of_rings_are_as_wide_as_the_steps_of_azimuth() {
        // At 60°: 15° along the meridian, 30° of azimuth along the ring.
        let set = directions("12x5");
        let moments = second_moments(&set);
        let index = 3 * 12;
        let (along, across) = (
            Direction::from_angles(150_f64.to_radians(), 0.0).0,
            DVec3::Y,
        );
        let spread = |axis: DVec3| (12.0 * axis.dot(moments[index] * axis)).sqrt().to_degrees();
        assert!((spread(along) - 15.0).abs() < 1.5, "{}", spread(along));
        let wanted = 30.0 * 60_f64.to_radians().sin();
        assert!((spread(across) - wanted).abs() < 2.5, "{}", spread(across));
    }

    #[test]
    fn few_directions_stand_for_themselves() {
        assert!(
            second_moments(&directions("rings:40:5"))
                .iter()
                .all(|m| *m == DMat3::ZERO)
        );
        assert!(
            second_moments(&directions("rings:40:6"))
                .iter()
                .all(|m| trace(m) > 0.0)
        );
    }
}
