//! Which lights reach which vertices, by shadow rays: found once, and kept while the light stays.
//!
//! Rays are cast in the order in which the vertices lie in the hierarchy of occluders, so that consecutive rays read
//! nearby memory.

use rayon::prelude::*;

use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;
use crate::render::light::Light;
use crate::render::occlusion::{Cone, Occluders, RayOrigin};

/// What casts shadows on the vertices of a map.
pub struct ShadowCaster {
    /// Whether light is asked for on both sides of the mesh; else what lies below the horizon has none.
    both_sides: bool,
    /// The mesh as an obstacle.
    pub occluders: Occluders,
    /// All vertices that a triangle uses, neighbours after each other.
    by_place: Vec<u32>,
}

/// Vertices' visibilities of the lights asked for last.
#[derive(Clone, Debug, Default)]
pub struct VertexShadows {
    lights: Vec<KnownLight>,
}

#[derive(Clone, Debug)]
struct KnownLight {
    light: Light,
    /// The share of the light that reaches each vertex, or [`UNKNOWN`].
    reaches: Vec<f32>,
}

const UNKNOWN: f32 = -1.0;
/// Rays cast by one task.
const CHUNK: usize = 1 << 9;

impl ShadowCaster {
    /// A mesh and its occluders; `both_sides` where it has a border.
    pub fn new(mesh: &TriangleMesh, occluders: Occluders, both_sides: bool) -> Self {
        let mut is_known = vec![false; mesh.positions.len()];
        let mut by_place = Vec::with_capacity(mesh.positions.len());
        for triangle in occluders.triangles_by_place() {
            for vertex in mesh.triangles[triangle as usize] {
                if !std::mem::replace(&mut is_known[vertex as usize], true) {
                    by_place.push(vertex);
                }
            }
        }
        Self {
            both_sides,
            occluders,
            by_place,
        }
    }

    /// All vertices that a triangle uses, neighbours after each other.
    pub fn vertices(&self) -> &[u32] {
        &self.by_place
    }

    fn visibility(&self, map: &SurfaceTextonMap, light: &Light, rays: u32, vertex: u32) -> f32 {
        let (point, mut normal) = (
            map.mesh.positions[vertex as usize],
            map.normals[vertex as usize],
        );
        let incidence = light.at(point);
        if incidence.towards.dot(normal) <= 0.0 {
            if !self.both_sides {
                return 0.0;
            }
            normal = -normal;
        }
        let cone = Cone::of_light(light, rays);
        let ray_origin = RayOrigin::Vertex(point);
        self.occluders
            .visibility(point, normal, ray_origin, &incidence, cone, vertex)
    }
}

impl VertexShadows {
    /// Finds what is not yet known of the `lights` and the `vertices`. `rays` are cast to lights
    /// that have a size. After an interruption, what is found is invalid.
    pub fn find(
        &mut self,
        caster: &ShadowCaster,
        map: &SurfaceTextonMap,
        lights: &[Light],
        rays: u32,
        vertices: &[u32],
        progress: Progress<'_>,
    ) {
        self.lights.truncate(lights.len());
        for (index, light) in lights.iter().enumerate() {
            let known = self.known(index, light, map.mesh.positions.len());
            let is_unknown = |&vertex: &u32| known.reaches[vertex as usize] == UNKNOWN;
            let missing: Vec<u32> = vertices.iter().copied().filter(is_unknown).collect();
            let found: Vec<f32> = missing
                .par_iter()
                .with_min_len(CHUNK)
                .map(|&vertex| match progress.is_interrupted() {
                    true => UNKNOWN,
                    false => caster.visibility(map, light, rays, vertex),
                })
                .collect();
            for (vertex, found) in missing.into_iter().zip(found) {
                known.reaches[vertex as usize] = found;
            }
        }
    }

    /// The entry of a light; nothing is known of one that is not the last frame's.
    fn known(&mut self, index: usize, light: &Light, vertices: usize) -> &mut KnownLight {
        let fresh = || KnownLight {
            light: *light,
            reaches: vec![UNKNOWN; vertices],
        };
        if index == self.lights.len() {
            self.lights.push(fresh());
        } else if !self.lights[index].light.shines_like(light) {
            self.lights[index] = fresh();
        }
        &mut self.lights[index]
    }

    /// Light by light the share that reaches each vertex asked for.
    pub fn of_lights(&self) -> Vec<&[f32]> {
        self.lights.iter().map(|known| &known.reaches[..]).collect()
    }
}
