//! What lies between a surface point and a light: shadow rays through a bounding volume hierarchy.
//!
//! The triangle test is the watertight one of Woop, Benthin and Wald 2013, and boxes are widened by
//! more than a rounding error, so that no ray slips between two triangles. A ray leaves the
//! surface a little above its point and passes over the triangles that the point belongs to.

pub(crate) mod beam;

use std::time::Duration;

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ray::Ray;
use obvhs::{Boundable, BvhBuildParams};

use crate::mesh::triangle_mesh::TriangleMesh;
use crate::render::bounds::Bounds;
use crate::render::light::{Incidence, Light};

/// A mesh that casts shadows.
pub struct Occluders {
    hierarchy: Bvh2,
    /// In the hierarchy's order.
    triangles: Vec<Occluder>,
    /// How far above its point a ray begins, in mesh units.
    lift: f32,
}

#[derive(Clone, Copy)]
struct Occluder {
    corners: [Vec3; 3],
    /// The mesh triangle.
    id: u32,
}

struct Padded {
    bounds: Aabb,
}

impl Boundable for Padded {
    fn aabb(&self) -> Aabb {
        self.bounds
    }
}

/// The part of the surface that a ray starts from and cannot be blocked by.
#[derive(Clone, Copy, Debug, Default)]
pub enum RayOrigin {
    /// A vertex: all triangles with a corner at this position.
    Vertex(Vec3),
    /// A point inside a triangle.
    Triangle(u32),
    /// A point of the surface whose triangle is not known.
    #[default]
    Point,
}

impl Occluders {
    /// Builds the hierarchy.
    pub fn new(mesh: &TriangleMesh, bounds: &Bounds) -> Self {
        // Choose how far rays start off the surface.
        let furthest = bounds.low.abs().max(bounds.high.abs()).max_element();
        let lift = (1e-5 * bounds.radius + 1e-6 * furthest) as f32;
        // Build the tree over boxes with a margin.
        let boxes: Vec<Padded> = (0..mesh.triangles.len())
            .map(|triangle| {
                let corners = mesh.corners(triangle).map(Vec3A::from);
                let tight = Aabb::from_points(&corners);
                let margin = Vec3A::splat(0.1 * lift);
                Padded {
                    bounds: Aabb::new(tight.min - margin, tight.max + margin),
                }
            })
            .collect();
        let mut hierarchy = build_bvh2(
            &boxes,
            BvhBuildParams::medium_build(),
            &mut Duration::default(),
        );
        // Put the triangles in the order of its leaves.
        let order = std::mem::take(&mut hierarchy.primitive_indices);
        let triangles = order
            .iter()
            .map(|&id| Occluder {
                corners: mesh.corners(id as usize),
                id,
            })
            .collect();
        Self {
            hierarchy,
            triangles,
            lift,
        }
    }

    /// The mesh's triangles, neighbours after each other.
    pub fn triangles_by_place(&self) -> impl Iterator<Item = u32> + '_ {
        self.triangles.iter().map(|triangle| triangle.id)
    }

    /// The share of a light's disc that is seen from a point of the surface: 0 or 1 for one ray,
    /// else the mean over those of the cone's rays that the point casts. `normal` is the side that is lit;
    /// `turn` turns the pattern of rays, so that neighbours do not repeat it.
    pub fn visibility(
        &self,
        point: Vec3,
        normal: Vec3,
        ray_origin: RayOrigin,
        incidence: &Incidence,
        cone: Cone,
        turn: u32,
    ) -> f32 {
        let origin = point + normal * self.lift;
        if cone.rays == 1 {
            let free = self.is_free(origin, incidence.towards, incidence.distance, ray_origin);
            return f32::from(u8::from(free));
        }
        let (side, up) = incidence.towards.any_orthonormal_pair();
        let cast = cone.rays.div_ceil(cone.points);
        let mut seen = 0;
        for ray in (cone.point..)
            .step_by(cone.points as usize)
            .take(cast as usize)
        {
            let [x, y] = disc_point(ray, cast * cone.points, turn);
            let offset = (side * x + up * y) * cone.tangent;
            let towards = (incidence.towards + offset).normalize();
            let above = towards.dot(normal) > 0.0;
            seen +=
                u32::from(above && self.is_free(origin, towards, incidence.distance, ray_origin));
        }
        seen as f32 / cast as f32
    }

    /// The share of the hemisphere about `normal` that is open, by cosine: the mean over `rays`, whose pattern `turn`
    /// turns.
    pub fn openness(
        &self,
        point: Vec3,
        normal: Vec3,
        ray_origin: RayOrigin,
        rays: u32,
        turn: u32,
    ) -> f32 {
        let origin = point + normal * self.lift;
        let (side, up) = normal.any_orthonormal_pair();
        let is_open = |&ray: &u32| {
            // A point of the disc, lifted to the hemisphere above it.
            let [x, y] = disc_point(ray, rays, turn);
            let z = (1.0 - x * x - y * y).max(0.0).sqrt();
            let towards = side * x + up * y + normal * z;
            self.is_free(origin, towards.normalize(), f32::INFINITY, ray_origin)
        };
        (0..rays).filter(is_open).count() as f32 / rays as f32
    }

    /// Whether nothing lies between a point above the surface and the light.
    fn is_free(&self, origin: Vec3, towards: Vec3, distance: f32, ray_origin: RayOrigin) -> bool {
        let shear = Shear::new(towards);
        let ray = Ray::new(origin.into(), towards.into(), 0.0, distance);
        self.hierarchy.ray_traverse_miss(ray, |_, index| {
            let triangle = &self.triangles[index];
            let hit = shear.distance(origin, &triangle.corners);
            if hit < distance && !triangle.belongs_to(ray_origin) {
                0.0
            } else {
                f32::INFINITY
            }
        })
    }
}

impl Occluder {
    fn belongs_to(&self, ray_origin: RayOrigin) -> bool {
        match ray_origin {
            RayOrigin::Vertex(position) => self.corners.contains(&position),
            RayOrigin::Triangle(id) => self.id == id,
            RayOrigin::Point => false,
        }
    }
}

/// How a light's disc is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Rays a point and light.
    pub rays: u32,
    /// Tangent of the angle that the disc's radius spans.
    pub tangent: f32,
    /// Points that share the rays, spread evenly over the disc.
    points: u32,
    /// Which of them casts its part.
    point: u32,
}

impl Cone {
    /// One ray to a light without size, else `rays` over its disc.
    pub fn of_light(light: &Light, rays: u32) -> Self {
        match light.angular_radius > 0.0 {
            true => Self {
                rays,
                tangent: light.angular_radius.tan() as f32,
                ..Self::single()
            },
            false => Self::single(),
        }
    }

    /// One ray.
    pub fn single() -> Self {
        Self {
            rays: 1,
            tangent: 0.0,
            points: 1,
            point: 0,
        }
    }

    /// The part of the rays that one of several points casts, whose pattern has the same turn; at least one each.
    #[must_use]
    pub fn shared(self, point: u32, points: u32) -> Self {
        Self {
            points,
            point,
            ..self
        }
    }
}

/// Point `index` of `count` spread evenly over the unit disc (Vogel 1979), rotated by a hash.
fn disc_point(index: u32, count: u32, turn: u32) -> [f32; 2] {
    const GOLDEN_ANGLE: f32 = 2.399_963_1;
    let hashed = (turn.wrapping_mul(0x9e37_79b9) ^ (turn >> 16)).wrapping_mul(0x85eb_ca6b);
    let angle =
        index as f32 * GOLDEN_ANGLE + (hashed >> 8) as f32 * (std::f32::consts::TAU / 1.6777216e7);
    let radius = ((index as f32 + 0.5) / count as f32).sqrt();
    [radius * angle.cos(), radius * angle.sin()]
}

/// A ray's shear to the unit ray along one axis (Woop 2013 §3.1), as the columns of a matrix whose
/// other entries are 0 and 1, so that its products are exact to the one rounding of the paper's.
struct Shear {
    columns: [Vec3A; 3],
}

impl Shear {
    fn new(direction: Vec3) -> Self {
        let size = direction.abs();
        let z = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if direction[z] < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        let inverse = 1.0 / direction[z];
        let mut columns = [Vec3A::ZERO; 3];
        columns[x] = Vec3A::X;
        columns[y] = Vec3A::Y;
        columns[z] = Vec3A::new(-direction[x] * inverse, -direction[y] * inverse, inverse);
        Self { columns }
    }

    #[inline(always)]
    fn apply(&self, p: Vec3) -> Vec3A {
        self.columns[0] * p.x + self.columns[1] * p.y + self.columns[2] * p.z
    }

    /// The distance at which the ray from `origin` meets a triangle, from either side; infinite
    /// where it does not.
    #[inline(always)]
    fn distance(&self, origin: Vec3, corners: &[Vec3; 3]) -> f32 {
        Self::meets(corners.map(|corner| self.apply(corner - origin)))
    }

    /// The distance at which the unit ray from 0 meets a sheared triangle; infinite where it does not.
    #[inline(always)]
    fn meets([a, b, c]: [Vec3A; 3]) -> f32 {
        let (mut u, mut v, mut w) = (cross(c, b), cross(a, c), cross(b, a));
        if u == 0.0 || v == 0.0 || w == 0.0 {
            (u, v, w) = (exact_cross(c, b), exact_cross(a, c), exact_cross(b, a));
        }
        let mixed = (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0);
        let determinant = u + v + w;
        if mixed || determinant == 0.0 {
            return f32::INFINITY;
        }
        let distance = (u * a.z + v * b.z + w * c.z) / determinant;
        if distance > 0.0 {
            distance
        } else {
            f32::INFINITY
        }
    }
}

#[inline(always)]
fn cross(p: Vec3A, q: Vec3A) -> f32 {
    p.x * q.y - p.y * q.x
}

/// The cross product with products that are not rounded.
fn exact_cross(p: Vec3A, q: Vec3A) -> f32 {
    (f64::from(p.x) * f64::from(q.y) - f64::from(p.y) * f64::from(q.x)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;
    use glam::DVec3;
    use rand::Rng;

    fn incidence(towards: Vec3, distance: f32) -> Incidence {
        Incidence {
            towards,
            irradiance: [1.0; 3],
            distance,
        }
    }

    /// A closed ball of many triangles whose edges no ray may slip through.
    fn ball(rings: u32) -> TriangleMesh {
        let mut mesh = TriangleMesh::default();
        for i in 0..=rings {
            for j in 0..2 * rings {
                let theta = std::f32::consts::PI * i as f32 / rings as f32;
                let phi = std::f32::consts::PI * j as f32 / rings as f32;
                let (sin, cos) = theta.sin_cos();
                mesh.positions
                    .push(Vec3::new(sin * phi.cos(), sin * phi.sin(), cos));
            }
        }
        for i in 0..rings {
            for j in 0..2 * rings {
                let at = |i: u32, j: u32| i * 2 * rings + j % (2 * rings);
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        mesh
    }

    #[test]
    fn no_ray_leaves_a_closed_ball() {
        let mesh = ball(40);
        let occluders = Occluders::new(&mesh, &Bounds::of(&mesh).unwrap());
        let mut stream = random::stream(2, "rays", 0, 0);
        for k in 0..20_000 {
            // Aim at edges and vertices, where leaks are.
            let [a, b, _] = mesh.corners(k % mesh.triangles.len());
            let aim = a.lerp(b, stream.gen_range(0.0..1.0));
            let origin = Vec3::from_array([0; 3].map(|_| stream.gen_range(-0.3..0.3)));
            let towards = (aim - origin).normalize();
            let away = RayOrigin::Triangle(u32::MAX);
            assert!(!occluders.is_free(origin, towards, f32::INFINITY, away));
        }
    }

    #[test]
    fn vertices_of_a_convex_body_see_every_light_above_their_horizon() {
        let mesh = ball(24);
        let occluders = Occluders::new(&mesh, &Bounds::of(&mesh).unwrap());
        let mut stream = random::stream(3, "lights", 0, 0);
        for &vertex in &mesh.positions {
            let light = Vec3::from_array([0; 3].map(|_| stream.gen_range(-1.0..1.0))).normalize();
            // Between the facets' horizon and the vertex's, the ball's own facets may hide it.
            let up = light.dot(vertex);
            if up.abs() < 0.15 {
                continue;
            }
            let from = RayOrigin::Vertex(vertex);
            let incidence = incidence(light, f32::INFINITY);
            let seen = occluders.visibility(vertex, vertex, from, &incidence, Cone::single(), 0);
            assert_eq!(seen, if up > 0.0 { 1.0 } else { 0.0 }, "{vertex} {light}");
        }
    }

    #[test]
    fn lights_nearer_than_the_occluder_are_seen() {
        let mesh = TriangleMesh {
            positions: vec![
                Vec3::new(-1.0, -1.0, 2.0),
                Vec3::new(1.0, -1.0, 2.0),
                Vec3::new(0.0, 1.0, 2.0),
            ],
            triangles: vec![[0, 1, 2]],
        };
        let bounds = Bounds {
            low: DVec3::ZERO,
            high: DVec3::ONE,
            centre: DVec3::ZERO,
            radius: 1.0,
        };
        let occluders = Occluders::new(&mesh, &bounds);
        let away = RayOrigin::Triangle(u32::MAX);
        let seen = |distance| {
            let incidence = incidence(Vec3::Z, distance);
            occluders.visibility(Vec3::ZERO, Vec3::Z, away, &incidence, Cone::single(), 0)
        };
        assert_eq!(seen(1.5), 1.0);
        assert_eq!(seen(2.5), 0.0);
        // A disc half hidden behind the triangle's lower edge, seen from below it.
        let soft = Cone {
            rays: 256,
            tangent: 0.2,
            ..Cone::single()
        };
        let below = Vec3::new(0.0, -1.0, 0.0);
        let half = incidence(Vec3::Z, f32::INFINITY);
        let share = |cone| occluders.visibility(below, Vec3::Z, away, &half, cone, 7);
        let whole = share(soft);
        assert!((whole - 0.5).abs() < 0.02, "{whole}");
        // Four points at one place cast the rays of one.
        let parts = (0..4).map(|point| share(soft.shared(point, 4)));
        assert_eq!(parts.sum::<f32>() / 4.0, whole);
    }
}
