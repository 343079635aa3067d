//! The fits of views or lights, eight directions at a time and without branches, so that loops become
//! vector code.

use glam::Vec3;

use super::angle;
use super::bins::{DIRECTION_LANES, DirectionLanes};
use super::fit;

/// Terms of a linear fit beside the constant: x, y.
pub(super) const LINEAR: usize = 2;
/// Terms of a quadratic fit beside the constant: x, y, x², y², √2 xy. With √2 the ridge is the same however
/// the basis of the tangent plane is turned.
pub(super) const QUADRATIC: usize = 5;

/// A number per direction of a block.
type Lanes = [f32; DIRECTION_LANES];

/// Directions as a wanted one sees them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    /// b = ((R − d)/(R d))², 0 from R on.
    nearness: Lanes,
    /// Log-map coordinates over R: the angle to the direction, laid out along its heading.
    x: Lanes,
    y: Lanes,
}

/// The plane that touches the sphere at a wanted direction.
pub(super) struct TangentPlane {
    wanted: Vec3,
    along_x: Vec3,
    along_y: Vec3,
}

impl TangentPlane {
    #[inline(always)]
    pub fn at(wanted: Vec3) -> Self {
        let (along_x, along_y) = wanted.any_orthonormal_pair();
        Self {
            wanted,
            along_x,
            along_y,
        }
    }

    /// Directions at these squared chords, none of them the wanted one itself.
    #[inline(always)]
    pub fn near(&self, block: &DirectionLanes, squared_chords: &Lanes, reach: f32) -> Near {
        let mut near = Near::NONE;
        for (lane, &squared_chord) in squared_chords.iter().enumerate() {
            let (dx, dy, dz) = (
                block.x[lane] - self.wanted.x,
                block.y[lane] - self.wanted.y,
                block.z[lane] - self.wanted.z,
            );
            let x = dx * self.along_x.x + dy * self.along_x.y + dz * self.along_x.z;
            let y = dx * self.along_y.x + dy * self.along_y.y + dz * self.along_y.z;
            let d = angle::of_squared_chord(squared_chord);
            // The length is sin d, and 0 for empty lanes and for the opposite direction.
            let length = (x * x + y * y).sqrt();
            let length = if length > 1e-9 { length } else { 1e-9 };
            let shared = 1.0 / (reach * d * length);
            let fading = (reach - d) * length * shared;
            let stretch = d * d * shared;
            near.nearness[lane] = if d < reach { fading * fading } else { 0.0 };
            (near.x[lane], near.y[lane]) = (x * stretch, y * stretch);
        }
        near
    }
}

impl Near {
    /// No direction at all.
    pub const NONE: Self = Self {
        nearness: [0.0; DIRECTION_LANES],
        x: [0.0; DIRECTION_LANES],
        y: [0.0; DIRECTION_LANES],
    };

    /// The terms of a fit beside the constant.
    #[inline(always)]
    fn terms<const N: usize>(&self) -> [Lanes; N] {
        let product = |factor: f32, a: &Lanes, b: &Lanes| {
            let mut product = [0.0; DIRECTION_LANES];
            for lane in 0..DIRECTION_LANES {
                product[lane] = factor * a[lane] * b[lane];
            }
            product
        };
        let (x, y) = (&self.x, &self.y);
        let all: [Lanes; QUADRATIC] = [
            *x,
            *y,
            product(1.0, x, x),
            product(1.0, y, y),
            product(std::f32::consts::SQRT_2, x, y),
        ];
        std::array::from_fn(|term| all[term])
    }

    /// The weights of a fit, before they are made to sum to 1: b (1 − p·g), negative ones times `negative`.
    #[inline(always)]
    pub fn tilted<const N: usize>(&self, tilt: [f32; N], negative: f32) -> Lanes {
        let mut weights = [1.0; DIRECTION_LANES];
        for (term, tilt) in self.terms::<N>().iter().zip(tilt) {
            for lane in 0..DIRECTION_LANES {
                weights[lane] -= term[lane] * tilt;
            }
        }
        for (weight, nearness) in weights.iter_mut().zip(&self.nearness) {
            let share = if *weight > 0.0 { 1.0 } else { negative };
            *weight *= nearness * share;
        }
        weights
    }
}

/// Sums of nearness, of terms times nearness, and of products of two terms times nearness.
pub(super) struct Moments<const N: usize> {
    nearness: Lanes,
    terms: [Lanes; N],
    /// Of each term with those up to itself.
    products: [[Lanes; N]; N],
}

impl<const N: usize> Moments<N> {
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            nearness: [0.0; DIRECTION_LANES],
            terms: [[0.0; DIRECTION_LANES]; N],
            products: [[[0.0; DIRECTION_LANES]; N]; N],
        }
    }

    #[inline(always)]
    pub fn add(&mut self, near: &Near) {
        let terms = near.terms::<N>();
        for lane in 0..DIRECTION_LANES {
            self.nearness[lane] += near.nearness[lane];
        }
        for (row, term) in terms.iter().enumerate() {
            let mut weighted = [0.0; DIRECTION_LANES];
            for lane in 0..DIRECTION_LANES {
                weighted[lane] = near.nearness[lane] * term[lane];
                self.terms[row][lane] += weighted[lane];
            }
            for (sum, other) in self.products[row][..=row].iter_mut().zip(&terms) {
                for lane in 0..DIRECTION_LANES {
                    sum[lane] += weighted[lane] * other[lane];
                }
            }
        }
    }

    /// The tilt of the fit.
    #[inline(always)]
    pub fn tilt(&self) -> [f32; N] {
        let whole = 1.0 / sum(&self.nearness);
        let mean = |lanes: &Lanes| f64::from(sum(lanes) * whole);
        let products = std::array::from_fn(|row| {
            std::array::from_fn(|column| match column <= row {
                true => mean(&self.products[row][column]),
                false => 0.0,
            })
        });
        let tilt = fit::tilt(
            std::array::from_fn(|term| mean(&self.terms[term])),
            products,
        );
        tilt.map(|tilt| tilt as f32)
    }
}

#[inline(always)]
fn sum(lanes: &Lanes) -> f32 {
    let [a, b, c, d, e, f, g, h] = *lanes;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}
