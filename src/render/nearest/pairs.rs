//! Scattered samples (CUReT): pairs of view and light that are no product, weighted by
//! √(d_view² + d_light²), the angles to the wanted view and light.

use glam::DVec3;

use super::weights::{
    LARGEST_RATIO, REACH, Weight, below_lowest, distinct, inverse_weights, keep_nearest,
    representative, same_direction,
};
use crate::btf::direction::Direction;

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
}

impl PairSet {
    /// Keeps the first of pairs whose view and light are the same.
    pub fn new(views: &[Direction], lights: &[Direction], pairs: &[[u32; 2]]) -> Self {
        let (kept_views, kept_lights) = (distinct(views), distinct(lights));
        let view_of = representative(views, &kept_views);
        let light_of = representative(lights, &kept_lights);
        let mut known = std::collections::HashSet::new();
        let mut set = Self {
            kept: Vec::new(),
            pairs: Vec::new(),
            lowest_view: 1.0,
            lowest_light: 1.0,
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
        set
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

    fn distances(&self, view: DVec3, light: DVec3) -> Vec<(f64, u32)> {
        let distance = |(index, (v, l)): (usize, &(Direction, Direction))| {
            let d = v
                .angle_to(Direction(view))
                .hypot(l.angle_to(Direction(light)));
            (d, index as u32)
        };
        self.pairs.iter().enumerate().map(distance).collect()
    }

    /// The `inverse-angle` weights of a view and a light above the horizon, into `out`.
    pub fn inverse_angle(&self, view: DVec3, light: DVec3, out: &mut Vec<Weight>) {
        let mut distances = self.distances(view, light);
        keep_nearest(&mut distances, NEAREST);
        inverse_weights(&distances, out);
        let scale = below_lowest(light.z, self.lowest_light);
        out.iter_mut().for_each(|weight| weight.weight *= scale);
    }

    /// The `continuous` weights of a view and a light above the horizon, into `out`, each scaled
    /// by min(cos θ / cos θᵢ, 2) of the lights.
    pub fn continuous(&self, view: DVec3, light: DVec3, out: &mut Vec<Weight>) {
        out.clear();
        let ratio = |index: u32| {
            let cosine = self.pairs[index as usize].1.cos_theta().max(1e-9);
            (light.z / cosine).min(LARGEST_RATIO)
        };
        let mut distances = self.distances(view, light);
        if let Some(index) = same_direction(&distances) {
            let weight = ratio(index) as f32;
            out.push(Weight { index, weight });
            return;
        }
        let reach = if distances.len() < COUNTED {
            std::f64::consts::PI
        } else {
            let counted = distances.select_nth_unstable_by(COUNTED - 1, |a, b| a.0.total_cmp(&b.0));
            REACH * counted.1.0
        };
        distances.retain(|&(d, _)| d < reach);
        distances.sort_unstable_by_key(|&(_, index)| index);
        let fading = |d: f64| ((reach - d) / (reach * d)).powi(2);
        let sum: f64 = distances.iter().map(|&(d, _)| fading(d)).sum();
        out.extend(distances.iter().map(|&(d, index)| Weight {
            index,
            weight: (fading(d) / sum * ratio(index)) as f32,
        }));
    }
}
