//! Which images stand for a direction at a point of the patch: those whose directions there are near, blended so that
//! linear change is met.
//!
//! With d the distance of an image's view and light at the point from those wanted, R = 1.05 times that of the 5th
//! nearest (the 17th where both views and lights vary): b = ((R − d)/(R d))², and the blend is the value at 0 of the
//! plane fitted to all with d < R with weights b, in coordinates of the tangent plane over R.

use glam::{DVec2, DVec3};
use nalgebra::{DMatrix, DVector};

use crate::btf::direction::{Direction, SAME_DIRECTION};
use crate::btf::import::stations::station::Station;

/// R is this many times the distance of the first image that is left out.
const REACH: f64 = 1.05;
/// Added to the diagonal of coordinates, over the mean of the diagonal.
const RIDGE: f64 = 1e-3;
/// The most by which a value is scaled to another light's cosine.
const LARGEST_RATIO: f64 = 2.0;

/// What differs from image to image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Varying {
    pub(super) views: bool,
    pub(super) lights: bool,
}

impl Varying {
    pub(super) fn of(stations: &[Station]) -> Self {
        let differ = |of: fn(&Station) -> Direction| {
            let first = stations.first().map(of);
            let is_other = |station: &Station| {
                first.is_some_and(|first| first.angle_to(of(station)) > SAME_DIRECTION)
            };
            stations.iter().any(is_other)
        };
        Self {
            views: differ(|station| station.view),
            lights: differ(|station| station.light),
        }
    }

    /// The image whose distance sets the reach.
    fn counted(self) -> usize {
        if self.views && self.lights { 17 } else { 5 }
    }

    fn distance(self, views: f64, lights: f64) -> f64 {
        match (self.views, self.lights) {
            (true, true) => views.hypot(lights),
            (true, false) => views,
            (false, _) => lights,
        }
    }
}

/// The images that may count anywhere on the patch for the directions of image `wanted`.
pub(super) fn candidates(
    stations: &[Station],
    wanted: usize,
    varying: Varying,
    spread: f64,
) -> Vec<usize> {
    let target = stations[wanted];
    let distance = |station: &Station| {
        varying.distance(
            station.view.angle_to(target.view),
            station.light.angle_to(target.light),
        )
    };
    let distances: Vec<f64> = stations.iter().map(distance).collect();
    // At a point of the patch every distance may be as much larger or smaller.
    let shift = spread * std::f64::consts::SQRT_2;
    let reach = REACH * (nth_smallest(&distances, varying.counted()) + shift) + shift;
    (0..stations.len())
        .filter(|&image| distances[image] <= reach)
        .collect()
}

/// The weights of some images at a point for the directions of `target`, each times what its value is scaled by.
pub(super) fn weights(
    images: &[Station],
    target: &Station,
    point: DVec3,
    varying: Varying,
) -> Vec<f64> {
    let there: Vec<(Direction, Direction)> = images
        .iter()
        .map(|image| (image.view_from(point), image.light_from(point)))
        .collect();
    let distances: Vec<f64> = there
        .iter()
        .map(|(view, light)| {
            varying.distance(view.angle_to(target.view), light.angle_to(target.light))
        })
        .collect();
    let mut weights = blend(&distances, &there, target, varying);
    for ((weight, (_, light)), image) in weights.iter_mut().zip(&there).zip(images) {
        let ratio = target.light.cos_theta() / light.cos_theta().max(1e-9);
        *weight *= ratio.min(LARGEST_RATIO) * image.falloff(point);
    }
    weights
}

fn blend(
    distances: &[f64],
    there: &[(Direction, Direction)],
    target: &Station,
    varying: Varying,
) -> Vec<f64> {
    // Let an equal station take all the weight.
    let nearest = (0..distances.len()).min_by(|&a, &b| distances[a].total_cmp(&distances[b]));
    if let Some(same) = nearest.filter(|&image| distances[image] < SAME_DIRECTION) {
        return (0..distances.len())
            .map(|image| f64::from(u8::from(image == same)))
            .collect();
    }
    // Weight the stations within reach, the nearer the more.
    let reach = REACH * nth_smallest(distances, varying.counted());
    let share = |&d: &f64| {
        if d < reach {
            ((reach - d) / (reach * d)).powi(2)
        } else {
            0.0
        }
    };
    let shares: Vec<f64> = distances.iter().map(share).collect();
    // Fit a plane to them, so that linear change is reproduced.
    let rows: Vec<DVector<f64>> = there
        .iter()
        .map(|(view, light)| row(*view, *light, target, varying, reach))
        .collect();
    let size = rows.first().map_or(1, DVector::len);
    let mut matrix = DMatrix::<f64>::zeros(size, size);
    for (row, share) in rows.iter().zip(&shares) {
        matrix += row * row.transpose() * *share;
    }
    let ridge = RIDGE * matrix.trace() / size as f64;
    (1..size).for_each(|at| matrix[(at, at)] += ridge);
    let mut first = DVector::zeros(size);
    first[0] = 1.0;
    let plane = matrix.lu().solve(&first).unwrap_or(first);
    // Weight each by its part in the plane's value at the target.
    let fitted = rows
        .iter()
        .zip(&shares)
        .map(|(row, share)| (share * row.dot(&plane)).max(0.0));
    let fitted: Vec<f64> = fitted.collect();
    let sum: f64 = fitted.iter().sum();
    fitted.iter().map(|weight| weight / sum).collect()
}

/// 1 and the coordinates of an image's directions about the wanted ones, over the reach.
fn row(
    view: Direction,
    light: Direction,
    target: &Station,
    varying: Varying,
    reach: f64,
) -> DVector<f64> {
    let mut row = vec![1.0];
    let mut add = |direction, about| {
        let at = tangent_coordinates(direction, about) / reach;
        row.extend([at.x, at.y]);
    };
    if varying.views {
        add(view, target.view);
    }
    if varying.lights {
        add(light, target.light);
    }
    DVector::from_vec(row)
}

/// The logarithm of a direction about another, in an orthonormal basis of its tangent plane.
fn tangent_coordinates(direction: Direction, about: Direction) -> DVec2 {
    let (x, y) = about.0.any_orthonormal_pair();
    let along = DVec2::new(direction.0.dot(x), direction.0.dot(y));
    along.normalize_or_zero() * direction.angle_to(about)
}

/// The `count`th smallest number, or π where there are fewer.
fn nth_smallest(numbers: &[f64], count: usize) -> f64 {
    let mut sorted = numbers.to_vec();
    match sorted.len() < count {
        true => std::f64::consts::PI,
        false => *sorted.select_nth_unstable_by(count - 1, f64::total_cmp).1,
    }
}
