//! Radiance of one texel for one view and many lights: what the view ray meets, shadow rays, and
//! the paths that carry interreflections.
//!
//! A view ray and the random path behind it do not depend on the light, so they are traced once and
//! lit by every light in turn (next event estimation at every point of the path).

use std::f64::consts::TAU;
use std::iter::Sum;
use std::ops::AddAssign;

use glam::{DVec2, DVec3, Vec3};
use rand::Rng;

use crate::btf::bake::brdf::{Columns, Lobe};
use crate::btf::bake::directions::View;
use crate::btf::bake::height_field::{HeightField, ReliefPoint};
use crate::btf::bake::lights::Lights;
use crate::btf::bake::material::Material;
use crate::btf::bake::sample_plan::SamplePlan;
use crate::random::{self, Stream};

/// From this bounce on, dark paths end early at random (Russian roulette).
const ROULETTE_FROM: u32 = 3;

/// The step of the R2 sequence, even in any number: how far out on the lights' discs the next sample looks, as a share
/// of their solid angle, and where round their middle, in turns.
const DISC_STEP: DVec2 = DVec2::new(0.754_877_666_246_693, 0.569_840_290_998_053);

/// All that the rays need to know.
#[derive(Clone, Copy)]
pub(super) struct BakeScene<'a> {
    pub(super) material: &'a Material,
    pub(super) surface: &'a HeightField,
    pub(super) plan: &'a SamplePlan,
    pub(super) bounces: u32,
    /// Half the angle that the light's disc is seen under, radians; 0: hard shadows.
    pub(super) light_radius: f64,
    pub(super) seed: u64,
}

/// What shading took.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Work {
    /// View rays.
    pub(super) samples: u64,
    /// View, shadow and path rays.
    pub(super) rays: u64,
}

impl AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.samples += other.samples;
        self.rays += other.rays;
    }
}

impl Sum for Work {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        let mut sum = Self::default();
        all.for_each(|work| sum += work);
        sum
    }
}

impl BakeScene<'_> {
    /// Puts the mean radiance of the texel at `row`, `col` into `radiance`, one RGB per light.
    pub(super) fn shade_texel(
        &self,
        view: View,
        (row, col): (usize, usize),
        lights: &Lights,
        (radiance, scratch): (&mut [Vec3], &mut Columns),
    ) -> Work {
        // Begin the random numbers of the texel.
        let centre = DVec2::new(
            col as f64,
            self.material.grid.height as f64 - 1.0 - row as f64,
        );
        let texel = row * self.material.grid.width as usize + col;
        let mut random = self.random(view, texel);
        let mut disc = random
            .as_mut()
            .filter(|_| self.light_radius > 0.0)
            .map(|random| DVec2::new(random.r#gen(), random.r#gen()));
        let mut course = self.plan.course();
        let (mut taken, mut rays) = (0, 0);
        // Follow a path through every place of the plan, until the mean is good enough.
        radiance.fill(Vec3::ZERO);
        for &place in &self.plan.places {
            rays += 1;
            if let Some(seen) = self.surface.seen_through(centre + place, view.direction.0) {
                let towards = view.direction.0;
                let path = Path {
                    seen,
                    towards,
                    disc: disc.map(|at| self.disc_place(at)),
                };
                rays += self.follow(path, lights, &mut random, (radiance, scratch));
            }
            disc = disc.map(|at| (at + DISC_STEP).fract());
            taken += 1;
            if course
                .as_mut()
                .is_some_and(|course| course.is_done(taken, radiance, lights))
            {
                break;
            }
        }
        // Take the mean.
        radiance.iter_mut().for_each(|sum| *sum /= taken as f32);
        Work {
            samples: u64::from(taken),
            rays,
        }
    }

    /// The mean radiance of what is seen through a footprint of the mean plane under one light.
    pub(super) fn seen_color(
        &self,
        view: View,
        centre: DVec2,
        footprint: DVec2,
        light: &Lights,
    ) -> Vec3 {
        let (mut sum, mut scratch) = ([Vec3::ZERO], Columns::default());
        for &place in &self.plan.places {
            let on_plane = centre + place * footprint;
            if let Some(seen) = self.surface.seen_through(on_plane, view.direction.0) {
                let path = Path {
                    seen,
                    towards: view.direction.0,
                    disc: None,
                };
                self.follow(path, light, &mut None, (&mut sum, &mut scratch));
            }
        }
        sum[0] / self.plan.places.len() as f32
    }

    /// A stream of its own for every view and texel, where anything is drawn at all.
    fn random(&self, view: View, texel: usize) -> Option<Stream> {
        let drawn = self.bounces > 0 || self.light_radius > 0.0;
        drawn.then(|| random::stream(self.seed, "bake", view.index as u32, texel as u64))
    }

    /// The place on the lights' discs so far out, as a share of their solid angle, and so many turns round.
    fn disc_place(&self, at: DVec2) -> DVec2 {
        let cos = 1.0 - at.x * (1.0 - self.light_radius.cos());
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        sin * DVec2::from_angle(TAU * at.y)
    }

    /// Lights every point of a path.
    fn follow(
        &self,
        path: Path,
        lights: &Lights,
        random: &mut Option<Stream>,
        (sums, scratch): (&mut [Vec3], &mut Columns),
    ) -> u64 {
        let (mut point, mut towards) = (path.seen, path.towards);
        let mut rays = 0;
        let mut throughput = Vec3::ONE;
        for bounce in 0..=self.bounces {
            let normal = self.surface.normal(point).as_vec3();
            let reflection = self.material.reflection(point);
            let lobe = reflection.towards(normal, towards.as_vec3());
            rays += match path.disc {
                None => self.light_sharply(point, &lobe, throughput, lights, (sums, scratch)),
                Some(place) => self.light_softly(point, &lobe, throughput, lights, (sums, place)),
            };
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

    /// Adds what a point reflects of lights without extent: one walk for all over a heading.
    fn light_sharply(
        &self,
        point: ReliefPoint,
        lobe: &Lobe,
        throughput: Vec3,
        lights: &Lights,
        (sums, radiance): (&mut [Vec3], &mut Columns),
    ) -> u64 {
        let least = lights.least_alpha_squared.as_deref();
        lobe.radiance_of_all(&lights.directions, least, radiance);
        let mut walks = 0;
        for heading in &lights.headings {
            let in_front = |&light: &usize| radiance.get(light) != Vec3::ZERO;
            let Some(first) = heading.members.iter().position(in_front) else {
                continue;
            };
            walks += 1;
            let slopes = &heading.slopes[first..];
            let shadowed = self.surface.shadowed(point, heading.direction, slopes);
            for &light in &heading.members[first + shadowed..] {
                sums[light] += throughput * radiance.get(light);
            }
        }
        walks
    }

    /// Adds what a point reflects of one place on every light's disc.
    fn light_softly(
        &self,
        point: ReliefPoint,
        lobe: &Lobe,
        throughput: Vec3,
        lights: &Lights,
        (sums, place): (&mut [Vec3], DVec2),
    ) -> u64 {
        let mut rays = 0;
        let least = lights.least_alpha_squared.as_deref();
        for (index, (lamp, sum)) in lights.lamps.iter().zip(sums).enumerate() {
            let (light, weight) = lamp.aim(place, self.light_radius);
            let least = least.map_or(0.0, |least| least[index]);
            let radiance = lobe.widened_radiance(light.as_vec3(), least);
            if radiance == Vec3::ZERO {
                continue;
            }
            rays += 1;
            if !self.surface.occluded(point, light) {
                *sum += throughput * radiance * weight;
            }
        }
        rays
    }
}

/// Where a path begins: what a view ray meets, the way back, and the place on the lights' discs.
struct Path {
    seen: ReliefPoint,
    towards: DVec3,
    disc: Option<DVec2>,
}

/// Ends dark paths at random, and makes up for it in those that continue.
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
