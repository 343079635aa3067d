//! A fit evaluated at chosen lights becomes a sample of one view, directly above.

use std::ops::Range;
use std::path::Path;

use serde_json::json;

use crate::btf::direction::Direction;
use crate::btf::fits::fit::{Colors, Fit};
use crate::btf::import::curve::curve;
use crate::btf::import::destination::{Destination, InputIds};
use crate::btf::import::{Family, ImportOptions};
use crate::btf::parts::{WrittenSample, write_sample_or_part};
use crate::btf::sample::{Description, FORMAT, Layout, VERSION};
use crate::btf::writer::SampleWriter;
use crate::error::Result;
use crate::format::id::ContentId;
use crate::format::image::decode_srgb;
use crate::progress::Progress;

/// Writes the sample of a fit at `lights`, or the part of a shard; `path` is the fit's file, `kind` its format.
pub fn evaluate<'a>(
    fit: &Fit,
    (path, kind): (&Path, &str),
    lights: &[Direction],
    options: &ImportOptions,
    destination: impl Into<Destination<'a>>,
    progress: Progress<'_>,
) -> Result<WrittenSample> {
    // Describe the sample.
    let destination = destination.into();
    let linear = curve(options.encoding, decode_srgb)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let description = describe(fit, (&name, kind), lights, options);
    let part = destination.part(lights.len(), options, |_| {
        Ok(InputIds {
            source: ContentId::of_file(path)?,
            own: None,
        })
    })?;
    // Write an image per light, as radiance.
    let evaluate = |writer: &mut SampleWriter, images: Range<usize>| {
        progress.begin("evaluating the fit", images.len() as u64);
        let mut image = vec![0.0; 3 * fit.texels()];
        for &light in &lights[images] {
            fit.evaluate(light, &mut image);
            let scale = options.values.radiance_per_number(Family::Any, light);
            image
                .iter_mut()
                .for_each(|value| *value = scale * linear(*value));
            writer.push(&image)?;
            progress.advance(1)?;
        }
        progress.end();
        Ok(())
    };
    write_sample_or_part(destination.path, description, part.as_ref(), None, evaluate)
}

fn describe(
    fit: &Fit,
    (name, kind): (&str, &str),
    lights: &[Direction],
    options: &ImportOptions,
) -> Description {
    let colors = match fit.colors {
        Colors::Lrgb => "lrgb",
        Colors::Rgb => "rgb",
    };
    Description {
        format: FORMAT.into(),
        version: VERSION,
        name: options.name.clone().unwrap_or_else(|| name.into()),
        width: fit.width,
        height: fit.height,
        channels: 3,
        dtype: options.dtype,
        texel_mm: options.texel_mm,
        layout: Layout::Product,
        views: vec![Direction::from_angles(0.0, 0.0)],
        lights: lights.to_vec(),
        pairs: None,
        tileable: options.tileable,
        id: ContentId::of_bytes(b""),
        source: json!({ "kind": kind, "terms": fit.basis.terms(), "colors": colors,
            "values": options.values.of_family(Family::Any), "encoding": options.encoding }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::fits::basis::Basis;
    use crate::btf::fits::fitting::fit_sample;
    use crate::btf::sample::{DType, Sample};

    /// A texture of Lambertian texels of several normals and colours, as a sample of one view.
    fn lambertian(folder: &Path, lights: &[Direction], grey: bool) -> Sample {
        let fit = Fit {
            width: 8,
            height: 6,
            basis: Basis::Polynomial,
            colors: Colors::Rgb,
            scale: vec![1.0; 6],
            offset: vec![0.0; 6],
            coefficients: Vec::new(),
            texel_colors: Vec::new(),
            white: 255.0,
        };
        let options = ImportOptions {
            dtype: DType::F4,
            ..ImportOptions::default()
        };
        let target = folder.join("lambert.sample");
        let description = describe(&fit, ("lambert", "test"), lights, &options);
        let mut writer = SampleWriter::create(&target, description).unwrap();
        for light in lights {
            let mut image = Vec::new();
            for texel in 0..48 {
                let tilt = 0.15 * f64::from(texel % 8 - 4);
                let normal = Direction::from_angles(tilt.abs(), if tilt < 0.0 { 3.5 } else { 0.4 });
                let cosine = light.0.dot(normal.0).max(0.0) as f32 * std::f32::consts::FRAC_1_PI;
                let blue = if grey { 0.7 } else { 0.1 + 0.01 * texel as f32 };
                image.extend([0.7 * cosine, 0.7 * cosine, blue * cosine]);
            }
            writer.push(&image).unwrap();
        }
        writer.finish().unwrap();
        Sample::open(&target).unwrap()
    }

    fn lights() -> Vec<Direction> {
        let light = |k: usize| {
            let cosine = 1.0 - (k as f64 + 0.5) / 80.0;
            Direction::from_angles(cosine.acos(), 2.4 * k as f64)
        };
        (0..64).map(light).collect()
    }

    /// The root mean square of display steps between a sample and a fit of it, measured on its images.
    fn measured(sample: &Sample, fit: &Fit) -> f64 {
        let (mut error, mut count) = (0.0, 0.0);
        let mut image = vec![0.0; 3 * fit.texels()];
        for (at, &light) in sample.description().lights.iter().enumerate() {
            fit.evaluate(light, &mut image);
            let pixels = sample.image(at).unwrap();
            for (number, &found) in image.iter().enumerate() {
                let wanted = pixels.get(number) * std::f32::consts::PI;
                let wanted = crate::format::image::encode_srgb(wanted);
                error += f64::from(255.0 * (found - wanted)).powi(2);
                count += 1.0;
            }
        }
        (error / count).sqrt()
    }

    #[test]
    fn fits_repeat_their_sample_and_say_how_well() {
        let folder = tempfile::tempdir().unwrap();
        let sample = lambertian(folder.path(), &lights(), false);
        for (basis, colors) in [
            (Basis::Polynomial, Colors::Lrgb),
            (Basis::Polynomial, Colors::Rgb),
            (Basis::Hemispherical(4), Colors::Rgb),
            (Basis::Hemispherical(16), Colors::Rgb),
        ] {
            let fitted = fit_sample(&sample, basis, colors, Progress::silent()).unwrap();
            let found = measured(&sample, &fitted.fit);
            // Sums below 0 are cut, which only helps.
            assert!(
                found <= fitted.stored_residual * 1.001,
                "{basis:?} {colors:?}: {found} {fitted:?}"
            );
            assert!(
                found > 0.8 * fitted.stored_residual,
                "{basis:?} {colors:?}: {found}"
            );
            assert!(
                fitted.stored_residual < 1.1 * fitted.residual,
                "{basis:?} {colors:?}"
            );
        }
    }

    #[test]
    fn grey_texels_lose_nothing_to_one_sum() {
        let folder = tempfile::tempdir().unwrap();
        let sample = lambertian(folder.path(), &lights(), true);
        let fit =
            |colors| fit_sample(&sample, Basis::Polynomial, colors, Progress::silent()).unwrap();
        let (one, three) = (fit(Colors::Lrgb), fit(Colors::Rgb));
        assert!((one.residual - three.residual).abs() < 1e-6);
        assert!(one.fit.texel_colors.iter().all(|&byte| byte == 255));
    }

    #[test]
    fn samples_of_too_few_lights_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let sample = lambertian(folder.path(), &lights()[..5], true);
        let error = fit_sample(&sample, Basis::Polynomial, Colors::Rgb, Progress::silent());
        assert!(error.unwrap_err().to_string().contains("at least 6"));
    }
}
