//! The distortion of a lens (Brown 1966, as in OpenCV): a point at (x, y) of an ideal picture, in focal lengths from
//! the centre, is seen at x(1 + k₁r² + k₂r⁴) + 2p₁xy + p₂(r² + 2x²), and y likewise.

use crate::error::{Error, Result};

/// Steps of the search for the ideal point of a seen one.
const STEPS: usize = 50;

/// What bends the lines of photographs.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
pub struct LensOptions {
    /// Distortion of the lens by OpenCV's model: radial k1, k2 and tangential p1, p2.
    #[arg(
        long,
        value_name = "K1,K2[,P1,P2]",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    pub distortion: Vec<f64>,
    /// Focal length of the lens in pixels; needed with --distortion.
    #[arg(long, value_name = "PIXELS")]
    pub focal: Option<f64>,
    /// The lens's centre in pixels from the picture's left and top border. [default: the middle of the picture]
    #[arg(long, value_name = "X,Y", value_delimiter = ',')]
    pub center: Vec<f64>,
}

impl LensOptions {
    /// Whether anything is said of the lens.
    pub fn is_given(&self) -> bool {
        *self != Self::default()
    }

    /// Refuses what is no lens.
    pub fn check(&self) -> Result<()> {
        // Check the numbers.
        let all_finite = self.distortion.iter().all(|number| number.is_finite());
        if !matches!(self.distortion.len(), 0 | 2 | 4) || !all_finite {
            let found = format!("{:?}", self.distortion);
            return Err(Error::option("distortion", found, "K1,K2 or K1,K2,P1,P2"));
        }
        if !matches!(self.center[..], [] | [_, _]) || !self.center.iter().all(|c| c.is_finite()) {
            return Err(Error::option("center", format!("{:?}", self.center), "X,Y"));
        }
        // Check that focal length, distortion and centre go together.
        match self.focal {
            Some(focal) if !(focal > 0.0 && focal.is_finite()) => {
                Err(Error::option("focal", focal.to_string(), "pixels, above 0"))
            }
            Some(_) if self.distortion.is_empty() => Err(Error::option(
                "focal",
                "given without --distortion",
                "both or none: a lens without distortion needs no focal length",
            )),
            None if !self.distortion.is_empty() => Err(Error::option(
                "distortion",
                "given without --focal",
                "the focal length in pixels too",
            )),
            _ if !self.center.is_empty() && self.distortion.is_empty() => Err(Error::option(
                "center",
                "given without --distortion",
                "both or none",
            )),
            _ => Ok(()),
        }
    }
}

/// The lens of a picture.
#[derive(Clone, Debug)]
pub(super) struct Lens {
    radial: [f64; 2],
    tangential: [f64; 2],
    focal: f64,
    center: [f64; 2],
}

impl Lens {
    /// For a picture of this many columns and rows; the options are sound.
    pub(super) fn new(options: &LensOptions, (width, height): (u32, u32)) -> Self {
        let number = |at: usize| options.distortion.get(at).copied().unwrap_or(0.0);
        let middle = [f64::from(width) / 2.0, f64::from(height) / 2.0];
        Self {
            radial: [number(0), number(1)],
            tangential: [number(2), number(3)],
            focal: options.focal.unwrap_or(1.0),
            center: match options.center[..] {
                [x, y] => [x, y],
                _ => middle,
            },
        }
    }

    fn bends_nothing(&self) -> bool {
        self.radial == [0.0; 2] && self.tangential == [0.0; 2]
    }

    /// Where a point of the ideal picture is seen.
    pub(super) fn distorted(&self, point: [f64; 2]) -> [f64; 2] {
        match self.bends_nothing() {
            true => point,
            false => self.to_pixels(self.bent(self.to_focal(point))),
        }
    }

    /// Where a seen point lies in the ideal picture, by a fixed-point search.
    pub(super) fn undistorted(&self, point: [f64; 2]) -> [f64; 2] {
        if self.bends_nothing() {
            return point;
        }
        let seen = self.to_focal(point);
        let mut ideal = seen;
        for _ in 0..STEPS {
            let bent = self.bent(ideal);
            ideal = [0, 1].map(|axis| ideal[axis] + seen[axis] - bent[axis]);
        }
        self.to_pixels(ideal)
    }

    fn bent(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (self.radial[0] + r2 * self.radial[1]);
        let [p1, p2] = self.tangential;
        [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ]
    }

    fn to_focal(&self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| (point[axis] - self.center[axis]) / self.focal)
    }

    fn to_pixels(&self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| point[axis] * self.focal + self.center[axis])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(distortion: &[f64], focal: Option<f64>) -> LensOptions {
        LensOptions {
            distortion: distortion.to_vec(),
            focal,
            center: Vec::new(),
        }
    }

    #[test]
    fn ideal_points_are_found_again() {
        let options = options(&[-0.2, 0.05, 1e-3, -2e-3], Some(900.0));
        options.check().unwrap();
        let lens = Lens::new(&options, (1200, 800));
        for point in [[600.0, 400.0], [10.0, 20.0], [1150.0, 700.0]] {
            let there = lens.distorted(point);
            let back = lens.undistorted(there);
            assert!(
                (back[0] - point[0]).hypot(back[1] - point[1]) < 1e-6,
                "{back:?}"
            );
        }
        assert_eq!(lens.distorted([600.0, 400.0]), [600.0, 400.0]);
        // A barrel: points are seen nearer to the middle.
        assert!(lens.distorted([1150.0, 400.0])[0] < 1150.0);
    }

    #[test]
    fn incomplete_lenses_are_refused() {
        let refused = |options: LensOptions| options.check().unwrap_err().to_string();
        assert!(refused(options(&[0.1], Some(1.0))).contains("K1,K2"));
        assert!(refused(options(&[0.1, 0.0], None)).contains("--focal"));
        assert!(refused(options(&[0.1, f64::NAN], Some(9.0))).contains("distortion"));
        assert!(refused(options(&[0.1, 0.0], Some(0.0))).contains("above 0"));
        assert!(refused(options(&[], Some(5.0))).contains("without --distortion"));
        let mut one = options(&[0.1, 0.0], Some(5.0));
        one.center = vec![3.0];
        assert!(refused(one).contains("X,Y"));
    }
}
