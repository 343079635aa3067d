//! CIE 1976 L*a*b* with the white of D50, as colour profiles have it, and linear Rec. 709.

use glam::{DMat3, DVec3};

/// D50 as XYZ: that of white in linear Rec. 709, the sum of the columns below.
const WHITE: DVec3 = DVec3::new(0.964_22, 1.0, 0.825_21);
/// XYZ of linear Rec. 709, its white adapted to D50 by the Bradford transform, as columns (ICC's sRGB profile).
const XYZ_FROM_RGB: DMat3 = DMat3::from_cols(
    DVec3::new(0.436_074_7, 0.222_504_5, 0.013_932_2),
    DVec3::new(0.385_064_9, 0.716_878_6, 0.097_104_5),
    DVec3::new(0.143_080_4, 0.060_616_9, 0.714_173_3),
);
/// Below this δ³ the cube root gives way to a line.
const DELTA: f64 = 6.0 / 29.0;

/// Linear Rec. 709 of L*, a*, b*.
pub(super) fn to_rgb(lab: DVec3) -> DVec3 {
    let y = (lab.x + 16.0) / 116.0;
    let parts = DVec3::new(y + lab.y / 500.0, y, y - lab.z / 200.0);
    let uncurve = |t: f64| match t > DELTA {
        true => t * t * t,
        false => 3.0 * DELTA * DELTA * (t - 4.0 / 29.0),
    };
    let xyz = WHITE * DVec3::new(uncurve(parts.x), uncurve(parts.y), uncurve(parts.z));
    XYZ_FROM_RGB.inverse() * xyz
}

/// L*, a*, b* of linear Rec. 709.
pub(super) fn of_rgb(rgb: DVec3) -> DVec3 {
    let xyz = XYZ_FROM_RGB * rgb / WHITE;
    let curve = |t: f64| match t > DELTA.powi(3) {
        true => t.cbrt(),
        false => t / (3.0 * DELTA * DELTA) + 4.0 / 29.0,
    };
    let (x, y, z) = (curve(xyz.x), curve(xyz.y), curve(xyz.z));
    DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_and_middle_grey_are_where_they_should_be() {
        let white = of_rgb(DVec3::ONE);
        assert!(
            (white - DVec3::new(100.0, 0.0, 0.0)).length() < 0.02,
            "{white}"
        );
        let grey = to_rgb(DVec3::new(50.0, 0.0, 0.0));
        assert!((grey - DVec3::splat(0.184_187)).length() < 1e-3, "{grey}");
    }
}
