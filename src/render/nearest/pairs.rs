//! Scattered samples (CUReT): pairs of view and light that are no product, weighted by
//! √(d_view² + d_light²), the angles to the wanted view and light.

use glam::DVec3;

use super::fit;
use super::product::Scratch;
use super::weights::{
    LARGEST_RATIO, REACH, Weight, Weighting, below_lowest, distinct, inverse_weights, keep_nearest,
    representative, same_direction,
};
use crate::btf::direction::Direction;
use crate::error::{Error, Result};

/// Pairs that `inverse-angle` takes.
const NEAREST: usize = 16;
/// The pair whose distance sets the reach of `continuous`.
const COUNTED: usize = 17;

/// Distinct pairs of directions.
#[derive(Clone, Debug)]
pub struct PairSet {
    /// Index of each kept pair in the sample.
    kept: Vec<u32>,
    pairs: Vec<(Direction, Direction)>,
    lowest_view: f64,
    lowest_light: f64,
    /// Whether they are weighted as the paper has it, not fitted.
    is_literal: bool,
}

impl PairSet {
    /// Keeps the first of pairs whose view and light are the same. Refuses `quadratic`: in the four
    /// coordinates of pairs it has 15 terms, and scattered samples have too few pairs near each other.
    pub fn new(
        views: &[Direction],
        lights: &[Direction],
        pairs: &[[u32; 2]],
        weighting: Weighting,
    ) -> Result<Self> {
        // Refuse a fit of too many terms.
        let is_literal = match weighting {
            Weighting::Continuous => false,
            Weighting::InverseAngle => true,
            Weighting::Quadratic => {
                return Err(Error::option(
                    "weights",
                    "`quadratic` for a sample of scattered pairs",
                    "`continuous` or `inverse-angle`: scattered pairs have too few neighbours for a quadratic fit",
                ));
            }
        };
        // Keep the first of equal pairs.
        let (kept_views, kept_lights) = (distinct(views), distinct(lights));
        let view_of = representative(views, &kept_views);
        let light_of = representative(lights, &kept_lights);
        let mut known = std::collections::HashSet::new();
        let mut set = Self {
            kept: Vec::new(),
            pairs: Vec::new(),
            lowest_view: 1.0,
            lowest_light: 1.0,
            is_literal,
        };
        for (index, &[view, light]) in pairs.iter().enumerate() {
            if known.insert((view_of[view as usize], light_of[light as usize])) {
                let (view, light) = (views[view as usize], lights[light as usize]);
                set.kept.push(index as u32);
                set.pairs.push((view, light));
                set.lowest_view = set.lowest_view.min(view.cos_theta());
                set.lowest_light = set.lowest_light.min(light.cos_theta());
            }
        }
        Ok(set)
    }

    /// How many distinct pairs there are.
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// The index in the sample of each distinct pair.
    pub fn kept(&self) -> &[u32] {
        &self.kept
    }

    /// Whether a view or light lies lower than every sampled one.
    pub fn is_below_all(&self, view_cosine: f32, light_cosine: f32) -> bool {
        f64::from(view_cosine) < self.lowest_view - 1e-6
            || f64::from(light_cosine) < self.lowest_light - 1e-6
    }

    /// The weights of a view and a light above the horizon, into `out`. Those of `continuous` are scaled
    /// to the wanted light, by min(cos θ / cos θᵢ, 2); those of `inverse-angle` together below the lowest
    /// sampled light.
    pub fn weigh(&self, view: DVec3, light: DVec3, scratch: &mut Scratch, out: &mut Vec<Weight>) {
        let distances = &mut scratch.distances;
        distances.clear();
        let distance = |(v, l): &(Direction, Direction)| {
            let view_angle = v.angle_to(Direction(view));
            view_angle.hypot(l.angle_to(Direction(light)))
        };
        distances.extend(self.pairs.iter().map(distance).zip(0..));
        if self.is_literal {
            keep_nearest(distances, NEAREST);
            inverse_weights(distances, out);
            let scale = below_lowest(light.z, self.lowest_light);
            out.iter_mut().for_each(|weight| weight.weight *= scale);
        } else {
            self.fit(view, light, distances, out);
        }
    }

    /// The weights of a linear [fit](super::fit) in four coordinates, two of the view and two of the light.
    fn fit(
        &self,
        view: DVec3,
        light: DVec3,
        distances: &mut Vec<(f64, u32)>,
        out: &mut Vec<Weight>,
    ) {
        out.clear();
        // Let an equal pair take all the weight.
        let ratio = |index: u32| {
            let cosine = self.pairs[index as usize].1.cos_theta().max(1e-9);
            (light.z / cosine).min(LARGEST_RATIO)
        };
        if let Some(index) = same_direction(distances) {
            let weight = ratio(index) as f32;
            out.push(Weight { index, weight });
            return;
        }
        // Keep the pairs within reach, in coordinates round the wanted one.
        let reach = keep_within_reach(distances);
        let (view_map, light_map) = (LogMap::at(view, reach), LogMap::at(light, reach));
        let coordinates = |index: u32| {
            let (v, l) = &self.pairs[index as usize];
            let ([a, b], [c, d]) = (view_map.of(*v), light_map.of(*l));
            [a, b, c, d]
        };
        // Sum the moments of the fit.
        let nearness = |d: f64| ((reach - d) / (reach * d)).powi(2);
        let sum: f64 = distances.iter().map(|&(d, _)| nearness(d)).sum();
        let (mut mean, mut products) = ([0.0; 4], [[0.0; 4]; 4]);
        for &(d, index) in distances.iter() {
            let (share, x) = (nearness(d) / sum, coordinates(index));
            for row in 0..4 {
                mean[row] += share * x[row];
                for (product, other) in products[row][..=row].iter_mut().zip(x) {
                    *product += share * x[row] * other;
                }
            }
        }
        // Weight each pair by the fitted plane.
        let tilt = fit::tilt(mean, products);
        let mut whole = 0.0;
        for &(d, index) in distances.iter() {
            let x = coordinates(index);
            let along: f64 = x.iter().zip(tilt).map(|(x, tilt)| x * tilt).sum();
            let weight = nearness(d) * (1.0 - along).max(0.0);
            whole += weight;
            if weight > 0.0 {
                let weight = (weight * ratio(index)) as f32;
                out.push(Weight { index, weight });
            }
        }
        // Normalize.
        let scale = (1.0 / whole) as f32;
        out.iter_mut().for_each(|weight| weight.weight *= scale);
    }
}

/// Keeps the pairs nearer than R, in order of their indices, and returns R.
fn keep_within_reach(distances: &mut Vec<(f64, u32)>) -> f64 {
    let reach = if distances.len() < COUNTED {
        std::f64::consts::PI
    } else {
        let counted = distances.select_nth_unstable_by(COUNTED - 1, |a, b| a.0.total_cmp(&b.0));
        REACH * counted.1.0
    };
    distances.retain(|&(d, _)| d < reach);
    distances.sort_unstable_by_key(|&(_, index)| index);
    reach
}

/// Directions laid out on the plane that touches the sphere at a wanted one, by angle and heading.
struct LogMap {
    along_x: DVec3,
    along_y: DVec3,
    wanted: Direction,
    reach: f64,
}

impl LogMap {
    fn at(wanted: DVec3, reach: f64) -> Self {
        let (along_x, along_y) = wanted.any_orthonormal_pair();
        Self {
            along_x,
            along_y,
            wanted: Direction(wanted),
            reach,
        }
    }

    /// Coordinates of a direction, over R.
    fn of(&self, direction: Direction) -> [f64; 2] {
        let offset = direction.0 - self.wanted.0;
        let (x, y) = (offset.dot(self.along_x), offset.dot(self.along_y));
        let stretch = self.wanted.angle_to(direction) / (self.reach * x.hypot(y).max(1e-12));
        [x * stretch, y * stretch]
    }
}
