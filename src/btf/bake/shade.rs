//! Radiance of one texel for one view and many lights: what the view ray meets, shadow rays, and
//! the paths that carry interreflections.
//!
//! A view ray and the random path behind it do not depend on the light, so they are traced once and
//! lit by every light in turn (next event estimation at every point of the path).

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec3};
use rand::Rng;

use crate::btf::bake::height_field::{HeightField, SurfacePoint};
use crate::btf::bake::material::Material;
use crate::btf::direction::Direction;
use crate::random::{self, Stream};

/// From this bounce on, dark paths end early at random (Russian roulette).
const ROULETTE_FROM: u32 = 3;

/// All that the rays need to know.
pub(super) struct Scene<'a> {
    pub(super) material: &'a Material,
    pub(super) surface: HeightField,
    pub(super) samples: u32,
    pub(super) bounces: u32,
    /// Half the angle that the light's disc is seen under, radians; 0: hard shadows.
    pub(super) light_radius: f64,
    pub(super) seed: u64,
}

/// A view among those of the bake.
#[derive(Clone, Copy)]
pub(super) struct View {
    pub(super) index: usize,
    pub(super) direction: Direction,
}

/// A light under the disc's sampling: one direction a sample.
struct Lamp {
    direction: DVec3,
    tangent: DVec3,
    bitangent: DVec3,
}

impl Scene<'_> {
    /// Adds the radiance of the texel at `row`, `col` to `sums`, one RGB a light; returns how many rays
    /// were traced.
    pub(super) fn shade_texel(
        &self,
        view: View,
        (row, col): (usize, usize),
        lights: &[Direction],
        sums: &mut [Vec3],
    ) -> u64 {
        let lamps: Vec<Lamp> = lights.iter().map(|&light| Lamp::new(light)).collect();
        let centre = DVec2::new(
            col as f64,
            self.material.grid.height as f64 - 1.0 - row as f64,
        );
        let texel = row * self.material.grid.width as usize + col;
        let mut random = self.random(view, texel);
        let mut rays = 0;
        for sample in 0..self.samples {
            let on_plane = centre + in_texel(sample);
            rays += 1;
            let Some(seen) = self.surface.seen_through(on_plane, view.direction.0) else {
                continue;
            };
            let disc = self.disc_place(sample, &mut random);
            rays += self.follow(seen, view.direction.0, &lamps, disc, &mut random, sums);
        }
        rays
    }

    /// The mean radiance of what is seen through a footprint of the mean plane under one light.
    pub(super) fn seen_color(
        &self,
        view: View,
        centre: DVec2,
        footprint: DVec2,
        light: Direction,
    ) -> Vec3 {
        let lamps = [Lamp::new(light)];
        let mut sum = [Vec3::ZERO];
        for sample in 0..self.samples {
            let on_plane = centre + in_texel(sample) * footprint;
            if let Some(seen) = self.surface.seen_through(on_plane, view.direction.0) {
                self.follow(seen, view.direction.0, &lamps, None, &mut None, &mut sum);
            }
        }
        sum[0] / self.samples as f32
    }

    /// A stream of its own for every view and texel, where anything is drawn at all.
    fn random(&self, view: View, texel: usize) -> Option<Stream> {
        let drawn = self.bounces > 0 || self.light_radius > 0.0;
        drawn.then(|| random::stream(self.seed, "bake", view.index as u32, texel as u64))
    }

    /// Where on the light's disc a sample looks: stratified over the samples, turned at random.
    fn disc_place(&self, sample: u32, random: &mut Option<Stream>) -> Option<DVec2> {
        let random = random.as_mut().filter(|_| self.light_radius > 0.0)?;
        let stratum = (f64::from(sample) + random.r#gen::<f64>()) / f64::from(self.samples);
        let cos = 1.0 - stratum * (1.0 - self.light_radius.cos());
        let turn = TAU * random.r#gen::<f64>();
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        Some(DVec2::new(sin * turn.cos(), sin * turn.sin()))
    }

    /// Lights every point of a path that begins at `point`, seen from `towards`.
    fn follow(
        &self,
        mut point: SurfacePoint,
        mut towards: DVec3,
        lamps: &[Lamp],
        disc: Option<DVec2>,
        random: &mut Option<Stream>,
        sums: &mut [Vec3],
    ) -> u64 {
        let mut rays = 0;
        let mut throughput = Vec3::ONE;
        for bounce in 0..=self.bounces {
            let normal = self.surface.normal(point).as_vec3();
            let reflection = self.material.reflection(point);
            let lobe = reflection.towards(normal, towards.as_vec3());
            for (lamp, sum) in lamps.iter().zip(sums.iter_mut()) {
                let (light, weight) = lamp.aim(disc, self.light_radius);
                let radiance = lobe.radiance(light.as_vec3());
                if radiance == Vec3::ZERO {
                    continue;
                }
                rays += 1;
                if !self.surface.occluded(point, light) {
                    *sum += throughput * radiance * weight;
                }
            }
            let Some(random) = random.as_mut().filter(|_| bounce < self.bounces) else {
                break;
            };
            let Some((direction, carried)) = lobe.sample(random) else {
                break;
            };
            throughput *= carried;
            if !survives(bounce, &mut throughput, random) {
                break;
            }
            let direction = direction.as_dvec3().normalize();
            rays += 1;
            let Some(next) = self.surface.next_hit(point, direction) else {
                break;
            };
            (point, towards) = (next, -direction);
        }
        rays
    }
}

impl Lamp {
    fn new(light: Direction) -> Self {
        let (tangent, bitangent) = light.0.any_orthonormal_pair();
        Self {
            direction: light.0,
            tangent,
            bitangent,
        }
    }

    /// A direction on the disc, and what makes its irradiance one at normal incidence.
    #[inline]
    fn aim(&self, disc: Option<DVec2>, radius: f64) -> (DVec3, f32) {
        let Some(place) = disc else {
            return (self.direction, 1.0);
        };
        let cos = (1.0 - place.length_squared()).max(0.0).sqrt();
        let direction = cos * self.direction + place.x * self.tangent + place.y * self.bitangent;
        // The mean cosine over the disc's solid angle.
        (direction, (2.0 / (1.0 + radius.cos())) as f32)
    }
}

/// Where in the texel a sample looks through: its centre first, then the R2 sequence, an even
/// spread for any number of samples.
fn in_texel(sample: u32) -> DVec2 {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let step = DVec2::new(1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC));
    (DVec2::splat(0.5) + f64::from(sample) * step).fract() - DVec2::splat(0.5)
}

/// Ends dark paths at random, and makes up for it in those that go on.
fn survives(bounce: u32, throughput: &mut Vec3, random: &mut Stream) -> bool {
    if bounce < ROULETTE_FROM {
        return true;
    }
    let chance = throughput.max_element().min(1.0);
    if random.r#gen::<f32>() >= chance {
        return false;
    }
    *throughput /= chance;
    true
}
