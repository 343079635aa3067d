//! Straight geodesics: from a point of the surface in a direction over a length. A path that meets an edge continues
//! in the next triangle at the same angle to the edge (Ying 2001 §4.1), which is a straight line when the two
//! triangles are unfolded.

use glam::{DVec2, DVec3, Vec3};

use crate::mesh::surface_bvh::SurfacePoint;
use crate::mesh::topology::{NONE, Topology, next, previous};
use crate::mesh::triangle_mesh::TriangleMesh;

/// Edges that a path crosses at most.
const MOST_CROSSINGS: usize = 1 << 16;
/// A triangle is taken to be at least this high over an edge, as a share of the edge.
const LEAST_HEIGHT: f64 = 1e-9;

/// A surface on which straight lines are drawn.
#[derive(Clone, Copy, Debug)]
pub struct Geodesics<'a> {
    /// The surface.
    pub mesh: &'a TriangleMesh,
    /// Its neighbours across every edge.
    pub topology: &'a Topology,
}

/// A place on a path: a triangle unfolded with one half-edge along +x and its inside towards +y.
struct Unfolded {
    half_edge: u32,
    /// Weights of the half-edge's start, of its end and of the corner opposite.
    weights: [f64; 3],
    /// Unit.
    direction: DVec2,
}

impl Geodesics<'_> {
    /// Where a path ends that leaves `from` in a direction (projected on the triangle) and is `length` mesh
    /// units long. `None` where the surface ends before.
    pub fn trace(&self, from: &SurfacePoint, direction: Vec3, length: f32) -> Option<SurfacePoint> {
        let Some(mut at) = self.start(from, direction) else {
            return Some(*from);
        };
        let mut left = f64::from(length);
        for _ in 0..MOST_CROSSINGS {
            let Some((exit, distance)) = self.exit(&at).filter(|&(_, way)| way < left) else {
                return Some(self.end(&at, left));
            };
            left -= distance;
            at = self.cross(&at, exit, distance)?;
        }
        None
    }

    /// The point of departure; `None` for a direction that stands on the triangle.
    fn start(&self, from: &SurfacePoint, direction: Vec3) -> Option<Unfolded> {
        let half_edge = 3 * from.triangle;
        let [a, b, c] = self.corners(half_edge);
        let x = (b - a).try_normalize()?;
        let normal = (b - a).cross(c - a).try_normalize()?;
        let direction = direction.as_dvec3();
        let flat = DVec2::new(direction.dot(x), direction.dot(normal.cross(x)));
        Some(Unfolded {
            half_edge,
            weights: from.weights.map(f64::from),
            direction: flat.try_normalize()?,
        })
    }

    /// The start and the end of a half-edge and the corner opposite.
    fn corners(&self, half_edge: u32) -> [DVec3; 3] {
        let triangle = self.mesh.triangles[half_edge as usize / 3];
        [half_edge, next(half_edge), previous(half_edge)]
            .map(|corner| self.mesh.positions[triangle[corner as usize % 3] as usize].as_dvec3())
    }

    /// How fast the weights change per mesh unit of way.
    fn rates(&self, at: &Unfolded) -> [f64; 3] {
        let (length, apex) = flattened(self.corners(at.half_edge));
        let third = at.direction.y / apex.y;
        let second = (at.direction.x - third * apex.x) / length;
        [-second - third, second, third]
    }

    /// The corner opposite the edge through which the path leaves the triangle, and the way to it; `None`
    /// where it does not leave.
    fn exit(&self, at: &Unfolded) -> Option<(usize, f64)> {
        let rates = self.rates(at);
        (0..3)
            .filter(|&corner| rates[corner] < 0.0)
            .map(|corner| (corner, (at.weights[corner] / -rates[corner]).max(0.0)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The path beyond the edge opposite a corner; `None` at the end of the surface.
    fn cross(&self, at: &Unfolded, corner: usize, distance: f64) -> Option<Unfolded> {
        let exit = [next(at.half_edge), previous(at.half_edge), at.half_edge][corner];
        let twin = self.topology.opposite[exit as usize];
        if twin == NONE {
            return None;
        }
        let rates = self.rates(at);
        let weight = |of: usize| (at.weights[of] + distance * rates[of]).max(0.0);
        let [start, end] = [weight((corner + 1) % 3), weight((corner + 2) % 3)];
        let (length, apex) = flattened(self.corners(at.half_edge));
        let flat = [DVec2::ZERO, DVec2::new(length, 0.0), apex];
        let edge = (flat[(corner + 2) % 3] - flat[(corner + 1) % 3]).normalize_or(DVec2::X);
        let (along, out) = (at.direction.dot(edge), -edge.perp_dot(at.direction));
        // The twin starts where the edge ends.
        let sum = (start + end).max(f64::MIN_POSITIVE);
        Some(Unfolded {
            half_edge: twin,
            weights: [end / sum, start / sum, 0.0],
            direction: DVec2::new(-along, out.max(0.0)).normalize_or(DVec2::Y),
        })
    }

    fn end(&self, at: &Unfolded, left: f64) -> SurfacePoint {
        let rates = self.rates(at);
        let weights: [f64; 3] = std::array::from_fn(|k| (at.weights[k] + left * rates[k]).max(0.0));
        let sum: f64 = weights.iter().sum();
        // Back from the order of the half-edge to that of the triangle.
        let turn = at.half_edge as usize % 3;
        let weights: [f32; 3] = std::array::from_fn(|k| (weights[(k + 3 - turn) % 3] / sum) as f32);
        let triangle = at.half_edge / 3;
        let corners = self.mesh.corners(triangle as usize);
        SurfacePoint {
            triangle,
            weights,
            position: (0..3).map(|k| corners[k] * weights[k]).sum(),
        }
    }
}

/// A triangle laid in the plane with its first edge along +x: that edge's length and the third corner.
fn flattened([a, b, c]: [DVec3; 3]) -> (f64, DVec2) {
    let length = (b - a).length().max(f64::MIN_POSITIVE);
    let x = (c - a).dot(b - a) / length;
    let height = (b - a).cross(c - a).length() / length;
    (length, DVec2::new(x, height.max(LEAST_HEIGHT * length)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::surface_bvh::SurfaceBvh;
    use crate::random;
    use rand::Rng;

    fn traced(mesh: &TriangleMesh, from: Vec3, direction: Vec3, length: f32) -> Option<Vec3> {
        let topology = Topology::new(&mesh.triangles);
        let from = SurfaceBvh::new(mesh).nearest(from).unwrap();
        let geodesics = Geodesics {
            mesh,
            topology: &topology,
        };
        let end = geodesics.trace(&from, direction, length)?;
        let corners = mesh.corners(end.triangle as usize);
        let sum: Vec3 = (0..3).map(|k| corners[k] * end.weights[k]).sum();
        assert!(sum.distance(end.position) < 1e-5);
        Some(end.position)
    }

    #[test]
    fn on_a_plane_paths_are_straight_and_end_at_the_border() {
        let mesh = shapes::grid(9, 9, 0.5);
        let mut random = random::stream(1, "geodesic test", 0, 0);
        for _ in 0..100 {
            let from = Vec3::new(random.gen_range(0.0..4.5), random.gen_range(0.0..4.5), 0.0);
            let angle: f32 = random.gen_range(0.0..std::f32::consts::TAU);
            let way = Vec3::new(angle.cos(), angle.sin(), 0.0);
            let length = random.gen_range(0.0..4.0);
            let expected = from + way * length;
            let inside = expected.truncate().cmpge(glam::Vec2::ZERO).all()
                && expected.truncate().cmple(glam::Vec2::splat(4.5)).all();
            match traced(&mesh, from, way, length) {
                Some(end) => assert!(inside && end.distance(expected) < 1e-4),
                None => assert!(!inside, "{from} {way} {length}"),
            }
        }
        // Along edges and through vertices.
        let start = Vec3::new(0.5, 0.5, 0.0);
        for way in [Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.0).normalize()] {
            let end = traced(&mesh, start, way, 2.5).unwrap();
            assert!(end.distance(start + 2.5 * way) < 1e-5, "{end}");
        }
        assert_eq!(traced(&mesh, start, Vec3::Z, 1.0), Some(start));
    }

    #[test]
    fn over_the_edge_of_a_cube_the_path_unfolds() {
        // Two faces of a cube that share the edge x = 1, z = 0.
        let positions = [
            [0., 0., 0.],
            [1., 0., 0.],
            [1., 1., 0.],
            [0., 1., 0.],
            [1., 0., -1.],
            [1., 1., -1.],
        ];
        let mesh = TriangleMesh {
            positions: positions.map(Vec3::from_array).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]],
        };
        let way = Vec3::new(3.0, 1.0, 0.0).normalize();
        let end = traced(&mesh, Vec3::new(0.4, 0.3, 0.0), way, 1.0).unwrap();
        let unfolded = Vec3::new(0.4, 0.3, 0.0) + way;
        let expected = Vec3::new(1.0, unfolded.y, 1.0 - unfolded.x);
        assert!(end.distance(expected) < 1e-5, "{end} {expected}");
    }

    #[test]
    fn round_a_cylinder_the_path_unrolls() {
        let (around, radius) = (64, 1.0_f32);
        let mesh = shapes::cylinder(around, 20, radius, 0.2);
        // The prism's own circumference.
        let half = std::f32::consts::PI / around as f32;
        let circumference = 2.0 * around as f32 * radius * half.sin();
        for slope in [0.0, 0.3, -0.2] {
            let from = Vec3::new(radius, 0.0, 2.0);
            let way = Vec3::new(-half.sin(), half.cos(), slope);
            let length = circumference * (1.0 + slope * slope).sqrt();
            let end = traced(&mesh, from, way, length);
            let expected = from + Vec3::Z * slope * circumference;
            match (0.0..=4.0).contains(&expected.z) {
                true => assert!(end.unwrap().distance(expected) < 1e-3, "{slope} {end:?}"),
                false => assert_eq!(end, None),
            }
        }
    }

    #[test]
    fn on_a_sphere_paths_are_great_circles() {
        let mesh = shapes::icosphere(5);
        let mut random = random::stream(2, "geodesic test", 0, 0);
        for _ in 0..50 {
            let mut unit = || {
                Vec3::from_array(std::array::from_fn(|_| random.gen_range(-1.0..1.0_f32)))
                    .normalize_or(Vec3::X)
            };
            let (from, other) = (unit(), unit());
            let way = (other - from * from.dot(other)).normalize_or(Vec3::Y);
            let angle = 1.0;
            let end = traced(&mesh, from, way, angle).unwrap();
            let expected = from * angle.cos() + way * angle.sin();
            let apart = end.normalize().distance(expected);
            assert!(apart < 0.01, "{apart}");
        }
    }
}
