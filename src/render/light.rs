//! Lights as shading sees them: a direction and an irradiance at every point.

use glam::{DVec3, Vec3};

/// Where a light's rays come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Origin {
    /// Parallel rays from far away.
    Directional {
        /// Unit vector towards the light.
        towards: DVec3,
    },
    /// A point; irradiance falls with the square of the distance.
    Point {
        /// Where the light is.
        position: DVec3,
        /// The point at which [`Light::irradiance`] is meant.
        reference: DVec3,
    },
}

/// One light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where its rays come from.
    pub origin: Origin,
    /// Irradiance at normal incidence, linear Rec. 709: everywhere (directional), or at the
    /// reference point.
    pub irradiance: [f32; 3],
    /// The angle its disc's radius spans, in radians; 0 casts hard shadows.
    pub angular_radius: f64,
}

/// What a light does at a point.
#[derive(Clone, Copy, Debug)]
pub struct Incidence {
    /// Unit vector towards the light.
    pub towards: Vec3,
    /// Irradiance at normal incidence.
    pub irradiance: [f32; 3],
    /// Distance to the light, infinite for directional ones.
    pub distance: f32,
}

impl Light {
    /// Direction and irradiance at a point of the surface.
    #[inline]
    pub fn at(&self, point: Vec3) -> Incidence {
        match self.origin {
            Origin::Directional { towards } => Incidence {
                towards: towards.as_vec3(),
                irradiance: self.irradiance,
                distance: f32::INFINITY,
            },
            Origin::Point {
                position,
                reference,
            } => {
                let offset = position - point.as_dvec3();
                let squared = offset.length_squared().max(f64::MIN_POSITIVE);
                let fall = ((position - reference).length_squared() / squared) as f32;
                Incidence {
                    towards: (offset / squared.sqrt()).as_vec3(),
                    irradiance: self.irradiance.map(|value| value * fall),
                    distance: squared.sqrt() as f32,
                }
            }
        }
    }

    /// Whether its rays are parallel.
    pub fn is_directional(&self) -> bool {
        matches!(self.origin, Origin::Directional { .. })
    }

    /// Whether another light casts the same shadows.
    pub fn shines_like(&self, other: &Self) -> bool {
        self.origin == other.origin && self.angular_radius == other.angular_radius
    }

    /// Rec. 709 luminance of the irradiance.
    pub fn luminance(&self) -> f32 {
        luminance(self.irradiance)
    }
}

/// Rec. 709 luminance of a linear colour.
#[inline]
pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn point_lights_fall_with_the_square_of_the_distance() {
        let light = Light {
            origin: Origin::Point {
                position: DVec3::new(0.0, 0.0, 4.0),
                reference: DVec3::ZERO,
            },
            irradiance: [2.0, 1.0, 0.5],
            angular_radius: 0.0,
        };
        assert_eq!(light.at(Vec3::ZERO).irradiance, [2.0, 1.0, 0.5]);
        let nearer = light.at(Vec3::new(0.0, 0.0, 2.0));
        assert_eq!(nearer.irradiance, [8.0, 4.0, 2.0]);
        assert_eq!(nearer.towards, Vec3::Z);
        assert_eq!(nearer.distance, 2.0);
    }
}
