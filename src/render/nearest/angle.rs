//! Angles from squared chords in single precision, without branches, so that loops over it become
//! vector code.

/// The angle between two unit vectors whose difference has this squared length (0 to 4), in
/// radians; relative error below 3e-7. A polynomial of asin (Cephes `asinf`) on either side of 60°.
#[inline(always)]
pub(super) fn of_squared_chord(squared: f32) -> f32 {
    let quarter = 0.25 * squared;
    let quarter = if quarter < 1.0 { quarter } else { 1.0 };
    let half_chord = quarter.sqrt();
    let wide_z = 0.5 * (1.0 - half_chord);
    let wide_x = wide_z.sqrt();
    let is_wide = half_chord > 0.5;
    let z = if is_wide { wide_z } else { quarter };
    let x = if is_wide { wide_x } else { half_chord };
    let series = ((((4.216_32e-2 * z + 2.418_131e-2) * z + 4.547_002_6e-2) * z + 7.495_300_3e-2)
        * z
        + 1.666_675_2e-1)
        * z;
    let asin = x + x * series;
    let (wide, narrow) = (std::f32::consts::PI - 4.0 * asin, 2.0 * asin);
    if is_wide { wide } else { narrow }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_exact_to_single_precision() {
        for step in 1..=3000 {
            let angle = f64::from(step) / 3000.0 * std::f64::consts::PI;
            let chord = 2.0 * (0.5 * angle).sin();
            let found = f64::from(of_squared_chord((chord * chord) as f32));
            // Near 180° the chord itself says little of the angle.
            let tolerance = if angle < 2.8 { 1e-6 * angle } else { 1e-3 };
            assert!((found - angle).abs() < tolerance, "{angle} {found}");
        }
        assert_eq!(of_squared_chord(0.0), 0.0);
    }
}
