//! The ground: a level plane that a mesh stands on, and that shows only the mesh's shadow.
//!
//! The shadow is black, and its opacity is the share of light that the mesh keeps from the ground: of the lights by
//! shadow rays, of fill light by how much of the sky is hidden. So a frame can be laid over any background, which then
//! is the ground. Seen from below there is no ground.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::render::bounds::Bounds;
use crate::render::camera::View;
use crate::render::frame::GeometryLayers;
use crate::render::light::{Incidence, Light, luminance};
use crate::render::occlusion::{Cone, Occluders, RayOrigin};
use crate::render::raster::{Hit, SurfaceBuffer};
use crate::render::vertex_shading::ShadingScene;

/// Lights up to which each sample of a pixel casts its own rays; with more, one sample stands for all.
const FEW_LIGHTS: usize = 4;
/// Rays over a light's disc that tell whether a sample lies in the shadow's edge, where all are cast.
const FIRST_RAYS: u32 = 4;
/// The sky is found at so many points along either side of a square.
const SIDE: usize = 113;
/// Rays at each of them.
const RAYS: u32 = 192;
/// Half the square's side over the mesh's radius, and from where on the sky opens to its border.
const REACH: f64 = 4.0;
const FADING: f64 = 2.0;

/// A level plane below a mesh.
pub struct Ground {
    up: DVec3,
    /// The plane's distance from the origin, along `up`.
    height: f64,
    /// A sphere round the mesh: light that passes it by is not hidden.
    centre: Vec3,
    radius: f32,
    sky: Option<OpenSky>,
}

/// How much of the sky is open at points of a square of the ground.
struct OpenSky {
    /// The square's first corner and sides, one step long.
    corner: DVec3,
    steps: [DVec3; 2],
    /// Row after row.
    open: Vec<f32>,
}

/// A point of the ground in a pixel.
struct Seen {
    point: DVec3,
    depth: f64,
}

impl Ground {
    /// The plane that the lowest point of a mesh lies on. The sky is needed where there is fill light.
    pub fn below(bounds: &Bounds, up: DVec3, occluders: &Occluders, has_fill: bool) -> Self {
        let mut ground = Self {
            up,
            height: bounds.low.dot(up).min(bounds.high.dot(up)),
            centre: bounds.centre.as_vec3(),
            radius: (1.001 * bounds.radius) as f32,
            sky: None,
        };
        ground.sky = has_fill.then(|| OpenSky::find(&ground, bounds, occluders));
        ground
    }

    /// Adds the shadow to what is not covered by the surface: opacity to the colours, depth and normal to the layers of
    /// pixels that see nothing else.
    pub fn darken(
        &self,
        scene: &ShadingScene,
        surface: &SurfaceBuffer,
        rgba: &mut [[f32; 4]],
        layers: Option<&mut Arc<GeometryLayers>>,
    ) {
        let width = surface.size[0] as usize;
        let offsets = surface.samples.offsets();
        let depths: Vec<f32> = rgba
            .par_chunks_mut(width)
            .enumerate()
            .flat_map_iter(|(row, pixels)| {
                let darkened = |(column, pixel): (usize, &mut [f32; 4])| {
                    let place = [column as u32, row as u32];
                    self.darken_pixel((scene, surface), place, &offsets, pixel)
                };
                let row: Vec<f32> = pixels.iter_mut().enumerate().map(darkened).collect();
                row
            })
            .collect();
        if let Some(layers) = layers {
            self.show_in(Arc::make_mut(layers), &depths);
        }
    }

    /// Adds the shadow to a pixel with samples at these `offsets`; returns the ground's depth where the pixel sees its
    /// shadow and no surface, else infinity.
    fn darken_pixel(
        &self,
        (scene, surface): (&ShadingScene, &SurfaceBuffer),
        [column, row]: [u32; 2],
        offsets: &[[f64; 2]],
        pixel: &mut [f32; 4],
    ) -> f32 {
        if pixel[3] >= 1.0 || scene.progress.is_interrupted() {
            return f32::INFINITY;
        }
        // Find the samples that see the ground, and how dark it is there.
        let at = |[x, y]: [f64; 2]| {
            let place = [f64::from(column) + x, f64::from(row) + y];
            self.seen(scene.view, place)
        };
        let hits = surface.pixel(column, row);
        let most = match scene.lights.len() <= FEW_LIGHTS {
            true => offsets.len(),
            false => 1,
        };
        let (mut free, mut asked, mut dark) = (0, 0, 0.0);
        for (sample, offset) in offsets.iter().enumerate() {
            if hits.get(sample).is_some_and(Hit::is_surface) {
                continue;
            }
            free += 1;
            if asked < most {
                asked += 1;
                dark += at(*offset).map_or(0.0, |seen| self.darkness(scene, seen.point));
            }
        }
        if dark <= 0.0 {
            return f32::INFINITY;
        }
        // Add the darkness to the coverage.
        let is_bare = pixel[3] == 0.0;
        pixel[3] += dark / asked as f32 * free as f32 / offsets.len() as f32;
        match at([0.5; 2]) {
            Some(seen) if is_bare => seen.depth as f32,
            _ => f32::INFINITY,
        }
    }

    /// The point of the ground that is seen at a place of the image.
    fn seen(&self, view: &View, pixel: [f64; 2]) -> Option<Seen> {
        let (origin, direction) = view.line_of_sight(pixel);
        let sinks = -direction.dot(self.up);
        let depth = (origin.dot(self.up) - self.height) / sinks;
        (sinks > 0.0 && depth > 0.0).then(|| Seen {
            point: origin + direction * depth,
            depth,
        })
    }

    /// The share of the light that does not reach a point of the ground, 1 − received / sent.
    fn darkness(&self, scene: &ShadingScene, point: DVec3) -> f32 {
        let Some(occluders) = scene.occluders else {
            return 0.0;
        };
        // Ask whether light reaches the point past its occluders.
        let (p, up) = (point.as_vec3(), self.up.as_vec3());
        let turn = p.x.to_bits() ^ p.y.to_bits().rotate_left(11) ^ p.z.to_bits().rotate_left(22);
        let seen = |light: &Light, incidence: &Incidence, rays: u32| {
            let cone = Cone::of_light(light, rays);
            if self.passes_by(p, incidence, cone) {
                return 1.0;
            }
            occluders.visibility(p, up, RayOrigin::Point, incidence, cone, turn)
        };
        // Sum the light that is sent and that arrives; only penumbras are worth all rays.
        let (mut sent, mut received) = (0.0, 0.0);
        for light in scene.lights {
            let incidence = light.at(p);
            let falls = luminance(incidence.irradiance) * incidence.towards.dot(up);
            if falls > 0.0 {
                sent += falls;
                let first = seen(light, &incidence, scene.soft_rays.min(FIRST_RAYS));
                let is_edge = first > 0.0 && first < 1.0;
                received += falls
                    * match is_edge {
                        true => seen(light, &incidence, scene.soft_rays),
                        false => first,
                    };
            }
        }
        // Do the same for the fill light.
        if let Some(fill) = &scene.fill {
            let falls = fill.irradiance(fill.up.dot(self.up));
            sent += falls;
            received += falls * self.sky.as_ref().map_or(1.0, |sky| sky.open_at(point));
        }
        match sent > 0.0 {
            true => 1.0 - received / sent,
            false => 0.0,
        }
    }

    /// Whether all rays of a cone from a point miss the sphere round the mesh.
    fn passes_by(&self, point: Vec3, incidence: &Incidence, cone: Cone) -> bool {
        let offset = self.centre - point;
        let along = offset.dot(incidence.towards);
        let across = (offset.length_squared() - along * along).max(0.0).sqrt();
        across > self.radius + along.max(0.0) * cone.tangent
    }

    /// Gives pixels that show the ground its depth and normal.
    fn show_in(&self, layers: &mut GeometryLayers, depths: &[f32]) {
        for (pixel, &depth) in depths.iter().enumerate().filter(|(_, d)| d.is_finite()) {
            layers.depth[pixel] = depth;
            for (axis, normals) in layers.normals.iter_mut().enumerate() {
                normals[pixel] = self.up[axis] as f32;
            }
        }
    }
}

impl OpenSky {
    fn find(ground: &Ground, bounds: &Bounds, occluders: &Occluders) -> Self {
        let up = ground.up;
        let (right, ahead) = up.any_orthonormal_pair();
        let middle = bounds.centre + up * (ground.height - bounds.centre.dot(up));
        let half = REACH * bounds.radius;
        let step = 2.0 * half / (SIDE - 1) as f64;
        let sky = Self {
            corner: middle - (right + ahead) * half,
            steps: [right * step, ahead * step],
            open: Vec::new(),
        };
        let open = |at: usize| {
            let [i, j] = [at % SIDE, at / SIDE].map(|k| k as f64);
            let point = sky.corner + sky.steps[0] * i + sky.steps[1] * j;
            let found =
                occluders.openness(point.as_vec3(), up.as_vec3(), RayOrigin::Point, RAYS, 0);
            let away = (point - middle).length() / bounds.radius;
            let faded = ((away - FADING) / (REACH - FADING)).clamp(0.0, 1.0) as f32;
            found + (1.0 - found) * faded
        };
        let open = (0..SIDE * SIDE).into_par_iter().map(open).collect();
        Self { open, ..sky }
    }

    /// Between the points, by distance; 1 beyond the square.
    fn open_at(&self, point: DVec3) -> f32 {
        let offset = point - self.corner;
        let [x, y] = self
            .steps
            .map(|step| offset.dot(step) / step.length_squared());
        let last = (SIDE - 1) as f64;
        if !(0.0..last).contains(&x) || !(0.0..last).contains(&y) {
            return 1.0;
        }
        let (column, row) = (x as usize, y as usize);
        let (right, down) = (x.fract() as f32, y.fract() as f32);
        let at = |i: usize, j: usize| self.open[(row + j) * SIDE + column + i];
        let across = |j: usize| at(0, j) + (at(1, j) - at(0, j)) * right;
        across(0) + (across(1) - across(0)) * down
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn the_sky_is_hidden_below_a_ball_and_open_far_off() {
        let mesh = shapes::icosphere(3);
        let bounds = Bounds::of(&mesh).unwrap();
        let occluders = Occluders::new(&mesh, &bounds);
        let ground = Ground::below(&bounds, DVec3::Y, &occluders, true);
        assert!((ground.height + 1.0).abs() < 1e-3);
        let sky = ground.sky.unwrap();
        let open = |x: f64| sky.open_at(DVec3::new(x, ground.height, 0.0));
        assert!(open(0.0) < 0.1, "{}", open(0.0));
        // A ball of radius 1 that stands on the plane hides sin²ρ cos θ of the hemisphere of a point 2 away: ⅕ · 1/√5.
        assert!((open(2.0) - 0.911).abs() < 0.03, "{}", open(2.0));
        assert!((open(3.9) - 1.0).abs() < 0.01);
        assert_eq!(open(40.0), 1.0);
    }
}
