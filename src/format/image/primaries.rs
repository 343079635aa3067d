//! Primaries and white points: matrices from a file's RGB to linear Rec. 709.
//!
//! White stays white: where the white points differ, the Bradford transform adapts (as ICC profiles and
//! ACES do). The one exception is OpenEXR whose primaries are those of XYZ itself: such numbers are
//! tristimulus values and are converted as they are, without adaptation.

use glam::{DMat3, DVec3};

/// The white of Rec. 709 and sRGB.
pub(super) const D65: [f64; 2] = [0.3127, 0.3290];
/// The white of ICC's connection space, as XYZ.
pub(super) const D50_XYZ: DVec3 = DVec3::new(0.9642, 1.0, 0.8249);
/// Chromaticities this near are the same.
const SAME: f64 = 2e-4;

/// Primaries and white point, as CIE x, y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Chromaticities {
    pub(super) red: [f64; 2],
    pub(super) green: [f64; 2],
    pub(super) blue: [f64; 2],
    pub(super) white: [f64; 2],
}

impl Chromaticities {
    const fn new(red: [f64; 2], green: [f64; 2], blue: [f64; 2], white: [f64; 2]) -> Self {
        Self {
            red,
            green,
            blue,
            white,
        }
    }

    pub(super) const REC709: Self = Self::new([0.64, 0.33], [0.30, 0.60], [0.15, 0.06], D65);
    pub(super) const REC2020: Self = Self::new([0.708, 0.292], [0.170, 0.797], [0.131, 0.046], D65);
    pub(super) const P3_D65: Self = Self::new([0.680, 0.320], [0.265, 0.690], [0.150, 0.060], D65);
    pub(super) const P3_DCI: Self = Self::new(
        [0.680, 0.320],
        [0.265, 0.690],
        [0.150, 0.060],
        [0.314, 0.351],
    );
    pub(super) const ADOBE: Self = Self::new([0.64, 0.33], [0.21, 0.71], [0.15, 0.06], D65);
    pub(super) const AP0: Self = Self::new(
        [0.7347, 0.2653],
        [0.0, 1.0],
        [0.0001, -0.0770],
        [0.32168, 0.33767],
    );
    pub(super) const AP1: Self = Self::new(
        [0.713, 0.293],
        [0.165, 0.830],
        [0.128, 0.044],
        [0.32168, 0.33767],
    );
    pub(super) const PAL: Self = Self::new([0.64, 0.33], [0.29, 0.60], [0.15, 0.06], D65);
    pub(super) const NTSC: Self = Self::new([0.630, 0.340], [0.310, 0.595], [0.155, 0.070], D65);
    /// XYZ itself, with the white of equal energy.
    pub(super) const XYZ: Self =
        Self::new([1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]);

    fn numbers(&self) -> [f64; 8] {
        let Self {
            red,
            green,
            blue,
            white,
        } = self;
        [
            red[0], red[1], green[0], green[1], blue[0], blue[1], white[0], white[1],
        ]
    }

    /// Whether two are the same within the rounding of files.
    pub(super) fn is(&self, other: &Self) -> bool {
        let pairs = self.numbers().into_iter().zip(other.numbers());
        pairs.into_iter().all(|(a, b)| (a - b).abs() < SAME)
    }

    /// The matrix to XYZ; `None` where the numbers span no space.
    pub(super) fn to_xyz(self) -> Option<DMat3> {
        let column = |[x, y]: [f64; 2]| DVec3::new(x, y, 1.0 - x - y);
        let columns = DMat3::from_cols(column(self.red), column(self.green), column(self.blue));
        let shares = inverse(columns)? * white_xyz(self.white)?;
        let matrix = columns * DMat3::from_diagonal(shares);
        inverse(matrix).map(|_| matrix)
    }

    /// The matrix to linear Rec. 709, white kept white. `None` where the numbers span no space.
    pub(super) fn to_rec709(self) -> Option<DMat3> {
        let adapted = bradford(white_xyz(self.white)?, white_xyz(D65)?)?;
        Some(xyz_to_rec709()? * adapted * self.to_xyz()?)
    }
}

impl std::fmt::Display for Chromaticities {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [rx, ry, gx, gy, bx, by, wx, wy] = self.numbers().map(|v| (v * 1e4).round() / 1e4);
        write!(
            f,
            "red {rx} {ry}, green {gx} {gy}, blue {bx} {by}, white {wx} {wy}"
        )
    }
}

/// The matrix from tristimulus values under a light to linear Rec. 709, the light's white kept white.
pub fn adapted_to_rec709(white: DVec3) -> Option<DMat3> {
    Some(xyz_to_rec709()? * bradford(white, white_xyz(D65)?)?)
}

/// The matrix from linear Rec. 709 to XYZ (D65).
pub fn rec709_to_xyz() -> Option<DMat3> {
    Chromaticities::REC709.to_xyz()
}

/// XYZ with the white of Rec. 709 to linear Rec. 709.
pub(super) fn xyz_to_rec709() -> Option<DMat3> {
    inverse(Chromaticities::REC709.to_xyz()?)
}

/// Bradford's adaptation from one white to another.
pub(super) fn bradford(from: DVec3, to: DVec3) -> Option<DMat3> {
    let cones = DMat3::from_cols(
        DVec3::new(0.8951, -0.7502, 0.0389),
        DVec3::new(0.2664, 1.7135, -0.0685),
        DVec3::new(-0.1614, 0.0367, 1.0296),
    );
    let scale = (cones * to) / (cones * from);
    scale
        .is_finite()
        .then(|| cones.inverse() * DMat3::from_diagonal(scale) * cones)
}

/// A white point's XYZ, Y being 1.
pub(super) fn white_xyz([x, y]: [f64; 2]) -> Option<DVec3> {
    let white = DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    (y > 0.0 && white.is_finite()).then_some(white)
}

/// The inverse of a matrix that has one.
pub(super) fn inverse(matrix: DMat3) -> Option<DMat3> {
    let sound = matrix.is_finite() && matrix.determinant().abs() > 1e-9;
    sound.then(|| matrix.inverse())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rec709_has_its_published_matrix() {
        let matrix = Chromaticities::REC709.to_xyz().unwrap();
        // IEC 61966-2-1, rows of RGB to XYZ.
        let published = [
            [0.4124, 0.3576, 0.1805],
            [0.2126, 0.7152, 0.0722],
            [0.0193, 0.1192, 0.9505],
        ];
        for (row, published) in published.iter().enumerate() {
            for (column, published) in published.iter().enumerate() {
                assert!((matrix.col(column)[row] - published).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn white_stays_white_and_other_primaries_do_not_stay() {
        for space in [
            Chromaticities::REC2020,
            Chromaticities::P3_DCI,
            Chromaticities::AP0,
            Chromaticities::AP1,
            Chromaticities::ADOBE,
            Chromaticities::XYZ,
        ] {
            let matrix = space.to_rec709().unwrap();
            assert!(
                (matrix * DVec3::ONE - DVec3::ONE).length() < 1e-9,
                "{space}"
            );
            assert!((matrix * DVec3::X - DVec3::X).length() > 0.1, "{space}");
        }
        // Published (ITU-R BT.2087): red of BT.2020 in BT.709.
        let red = Chromaticities::REC2020.to_rec709().unwrap() * DVec3::X;
        assert!((red - DVec3::new(1.6605, -0.1246, -0.0182)).length() < 1e-3);
    }

    #[test]
    fn numbers_that_span_no_space_are_none() {
        let flat = Chromaticities {
            green: [0.64, 0.33],
            ..Chromaticities::REC709
        };
        assert!(flat.to_rec709().is_none());
        let dark = Chromaticities {
            white: [0.3, 0.0],
            ..Chromaticities::REC709
        };
        assert!(dark.to_rec709().is_none());
    }
}
