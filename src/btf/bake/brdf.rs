//! How a surface point reflects: a microfacet coat over a diffuse base.
//!
//! GGX distribution (Walter 2007) with height-correlated Smith masking (Heitz 2014) and Schlick's
//! Fresnel; below it Lambert or Oren-Nayar (1994, the qualitative model) times what the coat lets
//! in and out, (1 − F(θv))(1 − F(θl))/(1 − F̄) with F̄ the mean over the hemisphere (Kelemen and
//! Szirmay-Kalos 2001), and times 1 − metallic. α is the roughness squared. Every term is symmetric in view and light
//! (Helmholtz). Not handled: anisotropy, transmission, several layers.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::Vec3;
use macro_rules_attribute::apply;
use rand::Rng;

use crate::lanes::vectorized;
use crate::random::Stream;

/// The least α: below it a highlight falls between any directions one samples.
const LEAST_ALPHA: f32 = 1e-3;

/// The diffuse base.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Diffuse {
    /// The same radiance in all directions.
    #[default]
    Lambert,
    /// Rough diffuse facets; σ, the standard deviation of their slope angle, in radians.
    OrenNayar(f32),
}

/// The microfacet coat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// Roughness, 0 (mirror) to 1; α is its square.
    pub roughness: f32,
    /// Dielectric reflectance at normal incidence; 0.04 is a refractive index of 1.5.
    pub reflectance: f32,
}

/// What one point reflects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reflection {
    /// Base colour: linear albedo of the diffuse base, reflectance of metal.
    pub albedo: Vec3,
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// The diffuse base.
    pub diffuse: Diffuse,
    /// The coat; none on a matte surface.
    pub coat: Option<Coat>,
}

/// A reflection with its normal and the direction it is looked at from, ready for many lights.
#[derive(Clone, Copy, Debug)]
pub struct Lobe {
    normal: Vec3,
    view: Vec3,
    cos_view: f32,
    base: Vec3,
    diffuse: Diffuse,
    specular: Option<Specular>,
}

#[derive(Clone, Copy, Debug)]
struct Specular {
    alpha_squared: f32,
    normal_reflectance: Vec3,
    grazing_reflectance: f32,
    /// What the base sees of the light: (1 − F(θv))/(1 − F̄).
    let_through: Vec3,
}

impl Reflection {
    /// The lobe towards `view`; both unit vectors, `normal`·`view` ≥ 0.
    pub fn towards(&self, normal: Vec3, view: Vec3) -> Lobe {
        let cos_view = normal.dot(view).max(0.0);
        let specular = self.coat.map(|coat| {
            let dielectric = Vec3::splat(coat.reflectance);
            let normal_reflectance = dielectric.lerp(self.albedo, self.metallic);
            Specular::new(coat.roughness, normal_reflectance, cos_view)
        });
        Lobe {
            normal,
            view,
            cos_view,
            base: self.albedo * ((1.0 - self.metallic) * FRAC_1_PI),
            diffuse: self.diffuse,
            specular,
        }
    }
}

impl Lobe {
    /// Reflected radiance for unit irradiance at normal incidence from `light`: f · cos θ.
    #[inline(always)]
    pub fn radiance(&self, light: Vec3) -> Vec3 {
        self.widened_radiance(light, 0.0)
    }

    /// [`radiance`](Self::radiance) with a highlight whose α² is at least `least_alpha_squared`.
    #[inline(always)]
    pub fn widened_radiance(&self, light: Vec3, least_alpha_squared: f32) -> Vec3 {
        let cos_light = self.normal.dot(light);
        let together = light.dot(self.view);
        let base = self.base * self.diffuse_factor(together, cos_light);
        let reflected = match &self.specular {
            None => base,
            Some(specular) => {
                // |l + v|² = 2 + 2 l·v gives both cosines of the half vector.
                let length = (2.0 + 2.0 * together).max(1e-12).sqrt();
                let cos_half = ((cos_light + self.cos_view) / length).clamp(0.0, 1.0);
                let fresnel = specular.fresnel((0.5 * length).min(1.0));
                let squared = specular.alpha_squared.max(least_alpha_squared);
                let facets = facets(squared, cos_half, (self.cos_view, cos_light));
                let let_in = Vec3::ONE - specular.fresnel(cos_light.clamp(0.0, 1.0));
                base * let_in * specular.let_through + fresnel * facets
            }
        };
        reflected * if cos_light > 0.0 { cos_light } else { 0.0 }
    }

    /// [`radiance`](Self::radiance) of every light at once, with highlights of at least so large an α², one per light;
    /// `None`: as they are.
    pub fn radiance_of_all(
        &self,
        lights: &Columns,
        least_alpha_squared: Option<&[f32]>,
        radiance: &mut Columns,
    ) {
        radiance.resize(lights.len());
        match (least_alpha_squared, self.specular) {
            (Some(least), Some(_)) => widened_radiance_of_columns(self, lights, least, radiance),
            _ => radiance_of_columns(self, lights, radiance),
        }
    }

    /// How the diffuse base departs from Lambert's: Oren and Nayar 1994, equation 30,
    /// A + B max(0, cos Δφ) sin α tan β.
    #[inline(always)]
    fn diffuse_factor(&self, together: f32, cos_light: f32) -> f32 {
        let Diffuse::OrenNayar(sigma) = self.diffuse else {
            return 1.0;
        };
        let squared = sigma * sigma;
        let a = 1.0 - 0.5 * squared / (squared + 0.33);
        let b = 0.45 * squared / (squared + 0.09);
        // sin θ_v sin θ_l cos Δφ is what the directions share beyond the normal.
        let shared = together - cos_light * self.cos_view;
        // sin α tan β = sin θ_v sin θ_l / max(cos θ_v, cos θ_l)
        a + b * shared.max(0.0) / cos_light.max(self.cos_view).max(1e-6)
    }

    /// Draws a direction to continue a path in; returns it with f · cos θ / density, or `None` where
    /// the path ends.
    pub fn sample(&self, random: &mut Stream) -> Option<(Vec3, Vec3)> {
        let share = self.specular_share();
        let direction = if random.r#gen::<f32>() < share {
            self.sample_facets(random)
        } else {
            frame_to_world(self.normal, cosine_weighted(random))
        };
        if self.normal.dot(direction) <= 0.0 {
            return None;
        }
        let density = self.density(direction, share);
        (density > 0.0).then(|| (direction, self.radiance(direction) / density))
    }

    /// How often the coat is sampled instead of the base.
    fn specular_share(&self) -> f32 {
        let Some(specular) = &self.specular else {
            return 0.0;
        };
        let coat = specular.fresnel(self.cos_view).max_element();
        let base = (self.base * PI).max_element();
        (coat / (coat + base).max(1e-6)).clamp(0.1, 1.0)
    }

    fn density(&self, direction: Vec3, share: f32) -> f32 {
        let cosine = self.normal.dot(direction) * FRAC_1_PI;
        let Some(specular) = &self.specular else {
            return cosine;
        };
        let half = (direction + self.view).normalize_or_zero();
        let squared = specular.alpha_squared;
        let visible = distribution(squared, self.normal.dot(half).max(0.0))
            * smith(squared, self.cos_view)
            / (4.0 * self.cos_view.max(1e-6));
        share * visible + (1.0 - share) * cosine
    }

    /// A mirror direction about a visible facet (Dupuy and Benyoub 2023, spherical caps).
    fn sample_facets(&self, random: &mut Stream) -> Vec3 {
        let alpha = self.specular.map_or(1.0, |s| s.alpha_squared.sqrt());
        let (tangent, bitangent) = self.normal.any_orthonormal_pair();
        let local = |w: Vec3| Vec3::new(w.dot(tangent), w.dot(bitangent), w.dot(self.normal));
        let view = local(self.view);
        let stretched = Vec3::new(alpha * view.x, alpha * view.y, view.z.max(0.0)).normalize();
        let phi = TAU * random.r#gen::<f32>();
        let z = (1.0 - random.r#gen::<f32>()) * (1.0 + stretched.z) - stretched.z;
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let cap = Vec3::new(radius * phi.cos(), radius * phi.sin(), z);
        let half = cap + stretched;
        let half = Vec3::new(alpha * half.x, alpha * half.y, half.z.max(1e-6)).normalize();
        let facet = frame_to_world(self.normal, half);
        facet * (2.0 * self.view.dot(facet)) - self.view
    }
}

/// Vectors coordinate by coordinate, so that several are worked on at a time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
}

impl Columns {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// One of them.
    #[inline]
    pub fn get(&self, index: usize) -> Vec3 {
        Vec3::new(self.x[index], self.y[index], self.z[index])
    }

    fn resize(&mut self, count: usize) {
        for column in [&mut self.x, &mut self.y, &mut self.z] {
            column.resize(count, 0.0);
        }
    }
}

impl FromIterator<Vec3> for Columns {
    fn from_iter<I: IntoIterator<Item = Vec3>>(vectors: I) -> Self {
        let mut columns = Self::default();
        for vector in vectors {
            columns.x.push(vector.x);
            columns.y.push(vector.y);
            columns.z.push(vector.z);
        }
        columns
    }
}

#[apply(vectorized!)]
fn radiance_of_columns(lobe: &Lobe, lights: &Columns, radiance: &mut Columns) {
    let lobe = *lobe;
    let lights = lights.x.iter().zip(&lights.y).zip(&lights.z);
    let columns = radiance
        .x
        .iter_mut()
        .zip(&mut radiance.y)
        .zip(&mut radiance.z);
    for (((&x, &y), &z), ((r, g), b)) in lights.zip(columns) {
        let value = lobe.radiance(Vec3::new(x, y, z));
        (*r, *g, *b) = (value.x, value.y, value.z);
    }
}

#[apply(vectorized!)]
fn widened_radiance_of_columns(
    lobe: &Lobe,
    lights: &Columns,
    least: &[f32],
    radiance: &mut Columns,
) {
    let lobe = *lobe;
    let lights = lights.x.iter().zip(&lights.y).zip(&lights.z).zip(least);
    let columns = radiance
        .x
        .iter_mut()
        .zip(&mut radiance.y)
        .zip(&mut radiance.z);
    for ((((&x, &y), &z), &least), ((r, g), b)) in lights.zip(columns) {
        let value = lobe.widened_radiance(Vec3::new(x, y, z), least);
        (*r, *g, *b) = (value.x, value.y, value.z);
    }
}

impl Specular {
    fn new(roughness: f32, normal_reflectance: Vec3, cos_view: f32) -> Self {
        let mut specular = Self {
            alpha_squared: (roughness * roughness).max(LEAST_ALPHA).powi(2),
            normal_reflectance,
            // Below 2 % no material reflects: fade to none (Lagarde and de Rousiers 2014).
            grazing_reflectance: (50.0 * normal_reflectance.max_element()).min(1.0),
            let_through: Vec3::ZERO,
        };
        // ∫ (1 − cos θ)⁵ cos θ dω / π = 1/21
        let grazing = Vec3::splat(specular.grazing_reflectance) - normal_reflectance;
        let mean = normal_reflectance + grazing / 21.0;
        let escaping = (Vec3::ONE - mean).max(Vec3::splat(1e-6));
        specular.let_through = (Vec3::ONE - specular.fresnel(cos_view.min(1.0))) / escaping;
        specular
    }

    /// Schlick 1994.
    #[inline(always)]
    fn fresnel(&self, cos: f32) -> Vec3 {
        let weight = (1.0 - cos).powi(5);
        self.normal_reflectance
            + (Vec3::splat(self.grazing_reflectance) - self.normal_reflectance) * weight
    }
}

/// GGX, Walter 2007 equation 33.
#[inline(always)]
fn distribution(alpha_squared: f32, cos_half: f32) -> f32 {
    let denominator = cos_half * cos_half * (alpha_squared - 1.0) + 1.0;
    alpha_squared / (PI * denominator * denominator)
}

/// D·G / (4 cos θv cos θl), Heitz 2014 equation 99 with the cosines cancelled.
#[inline(always)]
fn facets(alpha_squared: f32, cos_half: f32, (cos_view, cos_light): (f32, f32)) -> f32 {
    let stretch = |cos: f32| (alpha_squared + (1.0 - alpha_squared) * cos * cos).sqrt();
    let both = cos_light * stretch(cos_view) + cos_view * stretch(cos_light);
    distribution(alpha_squared, cos_half) * 0.5 / both.max(1e-9)
}

/// Smith's G1 of GGX: the share of facets seen from `cos`.
fn smith(alpha_squared: f32, cos: f32) -> f32 {
    2.0 * cos / (cos + (alpha_squared + (1.0 - alpha_squared) * cos * cos).sqrt()).max(1e-9)
}

fn cosine_weighted(random: &mut Stream) -> Vec3 {
    let (height, phi) = (random.r#gen::<f32>(), TAU * random.r#gen::<f32>());
    let radius = height.sqrt();
    Vec3::new(
        radius * phi.cos(),
        radius * phi.sin(),
        (1.0 - height).max(0.0).sqrt(),
    )
}

fn frame_to_world(normal: Vec3, local: Vec3) -> Vec3 {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    local.x * tangent + local.y * bitangent + local.z * normal
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    fn direction(theta: f32, phi: f32) -> Vec3 {
        Vec3::new(
            theta.sin() * phi.cos(),
            theta.sin() * phi.sin(),
            theta.cos(),
        )
    }

    fn coated(roughness: f32, metallic: f32) -> Reflection {
        Reflection {
            albedo: Vec3::new(0.9, 0.5, 0.2),
            metallic,
            diffuse: Diffuse::OrenNayar(0.4),
            coat: Some(Coat {
                roughness,
                reflectance: 0.04,
            }),
        }
    }

    /// ∫ f cos θ dω over the hemisphere by the midpoint rule.
    fn reflected(reflection: &Reflection, view: Vec3) -> Vec3 {
        let lobe = reflection.towards(Vec3::Z, view);
        let (rows, columns) = (400, 800);
        let mut sum = Vec3::ZERO;
        for row in 0..rows {
            let cos = (row as f32 + 0.5) / rows as f32;
            for column in 0..columns {
                let phi = TAU * (column as f32 + 0.5) / columns as f32;
                sum += lobe.radiance(direction(cos.acos(), phi));
            }
        }
        sum * (TAU / (rows * columns) as f32)
    }

    #[test]
    fn lambert_is_albedo_cosine_over_pi() {
        let white = Reflection {
            albedo: Vec3::ONE,
            metallic: 0.0,
            diffuse: Diffuse::Lambert,
            coat: None,
        };
        let lobe = white.towards(Vec3::Z, direction(1.0, 2.0));
        for theta in [0.0, 0.5, 1.5] {
            let value = lobe.radiance(direction(theta, 0.3)).x;
            assert!((value - theta.cos() / PI).abs() < 1e-7);
        }
        assert_eq!(lobe.radiance(-Vec3::Z), Vec3::ZERO);
        let rough = Reflection {
            diffuse: Diffuse::OrenNayar(0.0),
            ..white
        };
        let light = direction(0.7, 1.0);
        let (a, b) = (rough.towards(Vec3::Z, light), white.towards(Vec3::Z, light));
        assert!((a.radiance(light) - b.radiance(light)).length() < 1e-6);
    }

    #[test]
    fn reflection_is_reciprocal() {
        for (roughness, metallic) in [(0.2, 0.0), (0.6, 0.5), (1.0, 1.0)] {
            let reflection = coated(roughness, metallic);
            for (a, b) in [((0.3, 0.0), (1.2, 2.0)), ((0.9, 1.0), (0.5, 1.3))] {
                let (a, b) = (direction(a.0, a.1), direction(b.0, b.1));
                let forth = reflection.towards(Vec3::Z, a).radiance(b) / b.z;
                let back = reflection.towards(Vec3::Z, b).radiance(a) / a.z;
                assert!(
                    (forth - back).length() < 1e-5 * forth.length(),
                    "{forth} {back}"
                );
            }
        }
    }

    #[test]
    fn nothing_reflects_more_than_it_gets() {
        for roughness in [0.15, 0.4, 0.8] {
            for theta in [0.1, 0.8, 1.3] {
                let white = Reflection {
                    albedo: Vec3::ONE,
                    diffuse: Diffuse::Lambert,
                    ..coated(roughness, 0.0)
                };
                let total = reflected(&white, direction(theta, 0.0)).max_element();
                assert!((0.8..1.02).contains(&total), "{roughness} {theta}: {total}");
            }
        }
    }

    #[test]
    fn facets_are_normalised() {
        // ∫ D(h) (n·h) dω = 1 (Walter 2007 equation 4).
        for alpha in [0.05_f32, 0.3, 0.9] {
            let steps = 200_000;
            let integral: f64 = (0..steps)
                .map(|i| {
                    let cos = (i as f32 + 0.5) / steps as f32;
                    f64::from(distribution(alpha * alpha, cos) * cos * TAU)
                })
                .sum::<f64>()
                / f64::from(steps);
            assert!((integral - 1.0).abs() < 1e-3, "{alpha}: {integral}");
        }
    }

    #[test]
    fn widened_highlights_are_those_of_a_rougher_coat() {
        let (narrow, wide) = (coated(0.2, 0.3), coated(0.5, 0.3));
        let view = direction(0.6, 0.4);
        let lights: Columns = (0..40)
            .map(|i| direction(0.04 * i as f32, 0.2 * i as f32))
            .collect();
        let all = |reflection: &Reflection, least: f32| {
            let (least, mut radiance) = (vec![least; 40], Columns::default());
            let lobe = reflection.towards(Vec3::Z, view);
            lobe.radiance_of_all(&lights, Some(&least), &mut radiance);
            radiance
        };
        let (widened, rougher) = (all(&narrow, 0.5_f32.powi(4)), all(&wide, 0.0));
        let lobe = narrow.towards(Vec3::Z, view);
        for i in 0..40 {
            let (a, b) = (widened.get(i), rougher.get(i));
            assert!((a - b).length() <= 1e-5 * b.length(), "{i}: {a} {b}");
            let alone = lobe.widened_radiance(lights.get(i), 0.5_f32.powi(4));
            assert!((a - alone).length() <= 1e-5 * a.length());
        }
        // A coat that is rough enough stays as it is.
        assert_eq!(all(&wide, 0.1_f32.powi(4)), rougher);
    }

    #[test]
    fn sampling_finds_the_same_integral() {
        for (roughness, metallic) in [(0.3, 0.0), (0.5, 1.0), (0.9, 0.3)] {
            let reflection = coated(roughness, metallic);
            let view = direction(0.9, 0.4);
            let lobe = reflection.towards(Vec3::Z, view);
            let mut random = random::stream(1, "test", 0, 0);
            let count = 200_000;
            let sum: glam::DVec3 = (0..count)
                .filter_map(|_| lobe.sample(&mut random))
                .map(|(_, weight)| weight.as_dvec3())
                .sum();
            let (found, wanted) = (sum / f64::from(count), reflected(&reflection, view));
            let off = (found.as_vec3() - wanted).length() / wanted.length();
            assert!(off < 0.01, "{roughness} {metallic}: {found} {wanted}");
        }
    }
}
