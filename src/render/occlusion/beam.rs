//! Parallel rays from points near each other: which of them meet nothing.
//!
//! The rays traverse the hierarchy together. A box is widened by the distance of the points from their middle, and
//! entered if the ray from the middle meets it. So no box is skipped that one of the rays meets. Four rays from a pixel
//! cost about as much as two.

use std::ops::Range;

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::ray::Ray;

use super::{Occluders, RayOrigin, Shear};

/// A point of the surface from which a ray starts.
#[derive(Clone, Copy, Debug, Default)]
pub struct RayStart {
    /// The point.
    pub point: Vec3,
    /// The side of the surface that is lit.
    pub normal: Vec3,
    /// The part of the surface that cannot block the ray.
    pub ray_origin: RayOrigin,
}

/// Starts at most, a bit for each.
const MOST: usize = 16;

/// Parallel rays, about the middle of where they start.
struct Beam {
    middle: Vec3,
    /// How far the starts lie from it along each axis.
    reach: Vec3A,
    /// From the middle.
    ray: Ray,
    shear: Shear,
    /// Sheared starts, as seen from the middle, and how far they lie from it.
    starts: [Vec3A; MOST],
    sheared_reach: Vec3A,
    count: usize,
}

impl Beam {
    fn new(origins: impl Iterator<Item = Vec3> + Clone, towards: Vec3) -> Self {
        let low = origins.clone().reduce(Vec3::min).unwrap_or_default();
        let high = origins.clone().reduce(Vec3::max).unwrap_or_default();
        let middle = 0.5 * (low + high);
        let shear = Shear::new(towards);
        let (mut starts, mut sheared_reach, mut count) = ([Vec3A::ZERO; MOST], Vec3A::ZERO, 0);
        for (start, origin) in starts.iter_mut().zip(origins) {
            *start = shear.apply(origin - middle);
            sheared_reach = sheared_reach.max(start.abs());
            count += 1;
        }
        // The middle is rounded.
        let rounding = f32::EPSILON * low.abs().max(high.abs());
        Self {
            middle,
            reach: ((high - middle).max(middle - low) + rounding).into(),
            ray: Ray::new(middle.into(), towards.into(), 0.0, f32::INFINITY),
            shear,
            starts,
            sheared_reach,
            count,
        }
    }

    /// Where the beam enters a box; infinite where it does not.
    #[inline(always)]
    fn enters(&self, bounds: &Aabb) -> f32 {
        Aabb::new(bounds.min - self.reach, bounds.max + self.reach).intersect_ray(&self.ray)
    }

    /// Which of the `asked` rays meet a triangle.
    #[inline(always)]
    fn meets(&self, corners: &[Vec3; 3], asked: u32) -> u32 {
        let [a, b, c] = corners.map(|corner| self.shear.apply(corner - self.middle));
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let apart = low.cmpgt(self.sheared_reach) | high.cmplt(-self.sheared_reach);
        // Across the beam; along it, a triangle may lie anywhere ahead.
        if apart.bitmask() & 0b011 != 0 {
            return 0;
        }
        let meets = |&place: &usize| {
            let start = self.starts[place];
            asked >> place & 1 == 1 && Shear::meets([a - start, b - start, c - start]).is_finite()
        };
        (0..self.count).filter(meets).map(|place| 1 << place).sum()
    }
}

impl Occluders {
    /// Which of at most 16 points meet nothing in one direction, a bit for each.
    pub fn open_points(&self, starts: &[RayStart], towards: Vec3) -> u32 {
        debug_assert!(starts.len() <= MOST);
        // Make a beam of the rays.
        let origin = |start: &RayStart| start.point + start.normal * self.lift;
        let beam = Beam::new(starts.iter().take(MOST).map(origin), towards);
        let mut open = (1 << beam.count) - 1;
        // Visit the boxes that it enters, the nearer first.
        let nodes = &self.hierarchy.nodes;
        let mut waiting: Vec<&Bvh2Node> = Vec::with_capacity(64);
        waiting.extend(
            nodes
                .first()
                .filter(|root| beam.enters(root.aabb()).is_finite()),
        );
        while let Some(node) = waiting.pop() {
            let first = node.first_index as usize;
            if node.is_leaf() {
                open &= !self.hidden(&beam, starts, first..first + node.prim_count as usize, open);
                if open == 0 {
                    return 0;
                }
                continue;
            }
            let mut children = [&nodes[first], &nodes[first + 1]];
            let [mut near, mut far] = children.map(|child| beam.enters(child.aabb()));
            if far < near {
                children.swap(0, 1);
                std::mem::swap(&mut near, &mut far);
            }
            if far.is_finite() {
                waiting.push(children[1]);
            }
            if near.is_finite() {
                waiting.push(children[0]);
            }
        }
        open
    }

    /// Which of the `asked` rays some triangles block.
    #[inline(always)]
    fn hidden(&self, beam: &Beam, starts: &[RayStart], triangles: Range<usize>, asked: u32) -> u32 {
        let mut hidden = 0;
        for triangle in &self.triangles[triangles] {
            let met = beam.meets(&triangle.corners, asked & !hidden);
            let blocks = |place: &usize| {
                met >> place & 1 == 1 && !triangle.belongs_to(starts[*place].ray_origin)
            };
            if met != 0 {
                hidden |= (0..beam.count)
                    .filter(blocks)
                    .map(|place| 1 << place)
                    .sum::<u32>();
            }
        }
        hidden
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::random;
    use crate::render::bounds::Bounds;
    use crate::render::light::Incidence;
    use crate::render::occlusion::Cone;
    use rand::Rng;

    #[test]
    fn rays_together_meet_what_each_meets() {
        let mesh = shapes::torus(40, 24, 1.0, 0.4);
        let occluders = Occluders::new(&mesh, &Bounds::of(&mesh).unwrap());
        let mut stream = random::stream(5, "beams", 0, 0);
        let mut hidden = 0;
        for round in 0..4000 {
            let mut offset =
                |size: f32| Vec3::from_array([0; 3].map(|_| stream.gen_range(-size..size)));
            let (towards, wide) = (offset(1.0).normalize(), [0.0, 0.01, 0.3][round % 3]);
            let near = mesh.positions[round % mesh.positions.len()];
            let starts = [0; 5].map(|_| RayStart {
                point: near + offset(0.2) + if wide > 0.0 { offset(wide) } else { Vec3::ZERO },
                normal: towards,
                ray_origin: RayOrigin::Point,
            });
            let open = occluders.open_points(&starts, towards);
            for (place, start) in starts.iter().enumerate() {
                let incidence = Incidence {
                    towards,
                    irradiance: [1.0; 3],
                    distance: f32::INFINITY,
                };
                let alone = occluders.visibility(
                    start.point,
                    start.normal,
                    start.ray_origin,
                    &incidence,
                    Cone::single(),
                    0,
                );
                assert_eq!(f32::from((open >> place & 1) as u8), alone, "round {round}");
                hidden += u32::from(alone == 0.0);
            }
        }
        assert!((2000..18_000).contains(&hidden), "{hidden}");
        assert_eq!(occluders.open_points(&[], Vec3::X), 0);
    }
}
