//! A patch whose photographs are computed, and recovered from them.

use super::*;
use crate::format::image::{Encoding, Precision};

/// Smooth colours over the unit square.
fn pattern([u, v]: [f64; 2]) -> [f32; 3] {
    let wave = |a: f64, b: f64| (0.5 + 0.4 * (a * u + b * v).sin()) as f32;
    [wave(9.0, 2.0), wave(-3.0, 8.0), wave(5.0, 5.0)]
}

/// A photograph of the patch: each pixel looks up where its middle lies on it, by bisection on the inverse map.
fn photograph(
    corners: [[f64; 2]; 4],
    lens: &LensOptions,
    (width, height): (u32, u32),
) -> FloatImage {
    let lens = Lens::new(lens, (width, height));
    let back = inverse(corners.map(|corner| lens.undistorted(corner)));
    let pixel = |at: u32| {
        let middle = [f64::from(at % width) + 0.5, f64::from(at / width) + 0.5];
        let [x, y] = lens.undistorted(middle);
        let point = back * nalgebra::Vector3::new(x, y, 1.0);
        pattern([point.x / point.z, point.y / point.z])
    };
    FloatImage {
        width,
        height,
        channels: 3,
        data: (0..width * height).flat_map(pixel).collect(),
        encoding: Encoding::Linear,
        precision: Precision::Float,
    }
}

/// The map from a picture to the unit square, from the cross ratios of its corners (Heckbert 1989).
fn inverse([a, b, c, d]: [[f64; 2]; 4]) -> nalgebra::Matrix3<f64> {
    let (dx1, dx2, sx) = (b[0] - c[0], d[0] - c[0], a[0] - b[0] + c[0] - d[0]);
    let (dy1, dy2, sy) = (b[1] - c[1], d[1] - c[1], a[1] - b[1] + c[1] - d[1]);
    let determinant = dx1 * dy2 - dx2 * dy1;
    let g = (sx * dy2 - dx2 * sy) / determinant;
    let h = (dx1 * sy - sx * dy1) / determinant;
    let forward = nalgebra::Matrix3::new(
        b[0] - a[0] + g * b[0],
        d[0] - a[0] + h * d[0],
        a[0],
        b[1] - a[1] + g * b[1],
        d[1] - a[1] + h * d[1],
        a[1],
        g,
        h,
        1.0,
    );
    forward.try_inverse().unwrap()
}

fn rectification(corners: [[f64; 2]; 4], lens: LensOptions) -> Rectification {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("corners.csv");
    let numbers: Vec<String> = corners.as_flattened().iter().map(f64::to_string).collect();
    let text = format!(
        "file,x1,y1,x2,y2,x3,y3,x4,y4\na.png,{}\n",
        numbers.join(",")
    );
    std::fs::write(&table, text).unwrap();
    let options = PhotographOptions {
        corners: Some(table),
        size: Some((24, 18)),
        lens,
    };
    options.rectification().unwrap().unwrap()
}

#[test]
fn a_photographed_patch_is_found_again() {
    let corners = [[60.0, 40.0], [260.0, 70.0], [240.0, 190.0], [40.0, 210.0]];
    let bent = LensOptions {
        distortion: vec![-0.25, 0.05, 0.002, -0.001],
        focal: Some(300.0),
        center: vec![165.0, 118.0],
    };
    for lens in [LensOptions::default(), bent] {
        let picture = photograph(corners, &lens, (320, 240));
        let found = rectification(corners, lens)
            .rectify(Path::new("x/a.png"), &picture)
            .unwrap();
        assert_eq!((found.width, found.height), (24, 18));
        let mut worst = 0.0f32;
        for (at, texel) in found.data.chunks_exact(3).enumerate() {
            let middle = [(at % 24) as f64 + 0.5, (at / 24) as f64 + 0.5];
            let wanted = pattern([middle[0] / 24.0, middle[1] / 18.0]);
            for (found, wanted) in texel.iter().zip(wanted) {
                worst = worst.max((found - wanted).abs());
            }
        }
        // Means over a texel differ from its middle by the curvature of the waves.
        assert!(worst < 0.012, "{worst}");
    }
}

#[test]
fn corners_outside_the_picture_are_refused() {
    let corners = [[0.0, 0.0], [30.0, 0.0], [30.0, 20.0], [0.0, 20.0]];
    let picture = photograph(corners, &LensOptions::default(), (29, 30));
    let error =
        rectification(corners, LensOptions::default()).rectify(Path::new("a.png"), &picture);
    let text = error.unwrap_err().to_string();
    assert!(
        text.contains("a.png: corner 2: (30, 0)") && text.contains("29 × 30"),
        "{text}"
    );
    let crossed = [corners[0], corners[2], corners[1], corners[3]];
    let picture = photograph(corners, &LensOptions::default(), (30, 30));
    let error =
        rectification(crossed, LensOptions::default()).rectify(Path::new("a.png"), &picture);
    assert!(error.unwrap_err().to_string().contains("convex"));
}

#[test]
fn options_without_corners_are_refused() {
    let mut options = PhotographOptions {
        size: Some((8, 8)),
        ..PhotographOptions::default()
    };
    assert!(
        options
            .check()
            .unwrap_err()
            .to_string()
            .contains("--corners")
    );
    options.corners = Some("c.csv".into());
    options.check().unwrap();
    assert_eq!(parse_size("12x7"), Ok((12, 7)));
    assert_eq!(parse_size("12"), Ok((12, 12)));
    assert!(parse_size("0x3").is_err() && parse_size("a").is_err());
}
