//! Every signature, version, number type and layout is read to the numbers that were written.

use std::f64::consts::FRAC_1_PI;
use std::fs;

use glam::DVec3;
use mesotex::btf::bonn::{
    BonnImport, BonnOptions, Color, ColorModel, Compression, ExtraHeader, Header, Scalar,
};
use mesotex::btf::import::{Handedness, ImportOptions, Region};
use mesotex::btf::{DType, Sample};
use mesotex::progress::Progress;
use tempfile::TempDir;

use crate::files::{
    self, Dfmf, HEIGHT, IMAGES, LIGHTS, TEXELS, WIDTH, bdi, channels, fmf, header, number, pair,
    product, pvf, view,
};

/// The sample of a file's bytes, and the folder it lies in.
fn import_with(bytes: &[u8], bonn: &BonnOptions) -> (Sample, TempDir) {
    let options = ImportOptions {
        dtype: DType::F4,
        ..ImportOptions::default()
    };
    import_with_options(bytes, bonn, &options)
}

fn import_with_options(
    bytes: &[u8],
    bonn: &BonnOptions,
    options: &ImportOptions,
) -> (Sample, TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.btf");
    fs::write(&path, bytes).unwrap();
    let target = folder.path().join("a.sample");
    let import = BonnImport {
        path: &path,
        options,
        bonn,
        handedness: Handedness::Right,
        seed: 0,
        destination: target.as_path().into(),
        progress: Progress::silent(),
    };
    import.run().unwrap();
    (Sample::open(&target).unwrap(), folder)
}

fn expanded() -> BonnOptions {
    BonnOptions {
        expand: true,
        ..BonnOptions::default()
    }
}

/// Compares all values of a sample with reflectance: `wanted(image, texel)` times what the header leaves to do.
fn check(
    bytes: &[u8],
    bonn: &BonnOptions,
    header: &Header,
    tolerance: f64,
    wanted: impl Fn(usize, usize) -> [f64; 3],
) {
    let (sample, _folder) = import_with(bytes, bonn);
    let mut values = vec![0.0; TEXELS * 3];
    for image in 0..IMAGES {
        let light = header.sampling.lights[image % LIGHTS];
        let cosine = match header.meta.version > 1 && header.meta.has_cosine {
            true => 1.0,
            false => light.cos_theta(),
        };
        sample.image(image).unwrap().copy_to(&mut values);
        for (at, &found) in values.iter().enumerate() {
            let wanted = wanted(image, at / 3)[at % 3] * cosine * FRAC_1_PI;
            let wanted = wanted.max(0.0);
            assert!(
                (f64::from(found) - wanted).abs() <= tolerance,
                "image {image}, number {at}: {found}, not {wanted}"
            );
        }
    }
}

fn dfmf_value(color: &Color, image: usize, texel: usize) -> [f64; 3] {
    let channels = channels();
    let values = [0, 1, 2].map(|at| product(&channels[at], image, texel));
    color.to_rgb(DVec3::from_array(values)).to_array()
}

#[test]
fn dfmf_of_every_version_type_and_orientation() {
    for signature in ["!DFMF08FCR", "!DFMF08FC"] {
        for version in 1..=4 {
            for scalar in [Scalar::Half, Scalar::Single, Scalar::Double] {
                for transposed in [false, true] {
                    let mut header = header();
                    header.meta.version = version;
                    let file = Dfmf {
                        signature,
                        header: header.clone(),
                        scalar,
                        transposed,
                        ..Dfmf::default()
                    };
                    let bytes = file.bytes();
                    let wanted = |image, texel| dfmf_value(&file.color, image, texel);
                    check(&bytes, &BonnOptions::default(), &header, 1e-6, wanted);
                    check(&bytes, &expanded(), &header, 1e-6, wanted);
                }
            }
        }
    }
}

pub fn pca() -> Color {
    Color {
        model: ColorModel::Pca,
        mean: [0.1, 0.2, 0.05],
        transform: [0.5, 0.5, 0.25, 0.125, -0.25, 0.5, -0.25, 0.25, 0.5],
    }
}

#[test]
fn dfmf_of_every_linear_model_keeps_its_factors() {
    let models = [ColorModel::Yuv, ColorModel::YCoCg].map(Color::of);
    for color in [pca(), models[0], models[1]] {
        for has_cosine in [true, false] {
            let mut header = header();
            header.meta.has_cosine = has_cosine;
            let file = Dfmf {
                header: header.clone(),
                color,
                ..Dfmf::default()
            };
            let bytes = file.bytes();
            let (sample, _folder) = import_with(&bytes, &BonnOptions::default());
            assert!(sample.factors().is_some());
            let wanted = |image, texel| dfmf_value(&color, image, texel);
            check(&bytes, &BonnOptions::default(), &header, 2e-6, wanted);
            check(&bytes, &expanded(), &header, 2e-6, wanted);
        }
    }
}

#[test]
fn dfmf_of_every_other_model_is_factored_anew_or_expanded() {
    let models = [
        ColorModel::Lab,
        ColorModel::Spectral,
        ColorModel::LogYUv,
        ColorModel::LogYuv,
        ColorModel::LogYRatios,
        ColorModel::LogRgb,
    ];
    for model in models {
        let color = Color::of(model);
        let file = Dfmf {
            color,
            ..Dfmf::default()
        };
        let bytes = file.bytes();
        let wanted = |image, texel| dfmf_value(&color, image, texel);
        check(&bytes, &expanded(), &file.header, 1e-5, wanted);
        // As many components as images hold everything, as far as a factorization of floats can.
        let whole = BonnOptions {
            rank: Some(IMAGES as u32),
            ..BonnOptions::default()
        };
        let (sample, _folder) = import_with(&bytes, &whole);
        let told = sample.description().source["error"]["relative"].as_f64();
        let left = relative_error(&sample, wanted);
        assert!(left < 2e-3, "{model:?}: {left}");
        assert!((told.unwrap() - left).abs() < 1e-5, "{model:?}: {told:?}");
    }
}

/// ‖sample − wanted‖ / ‖wanted‖, of reflectance with the cosine.
fn relative_error(sample: &Sample, wanted: impl Fn(usize, usize) -> [f64; 3]) -> f64 {
    let (mut left, mut all) = (0.0, 0.0);
    for image in 0..IMAGES {
        let pixels = sample.image(image).unwrap();
        for at in 0..TEXELS * 3 {
            let wanted = wanted(image, at / 3)[at % 3].max(0.0) * FRAC_1_PI;
            left += (f64::from(pixels.get(at)) - wanted).powi(2);
            all += wanted * wanted;
        }
    }
    (left / all).sqrt()
}

/// Half factors are copied bit by bit: 1/π is in the colour step.
#[test]
fn factors_are_copied_bit_by_bit() {
    let (sample, _folder) = import_with(&Dfmf::default().bytes(), &BonnOptions::default());
    let factors = sample.factors().unwrap();
    let channels = channels();
    for (at, channel) in channels.iter().enumerate() {
        let mut row = vec![0.0; channel.rank()];
        for image in 0..IMAGES {
            channel.directions.read(image..image + 1, &mut row).unwrap();
            let (own, rest) = factors.direction(at, image).split_at(row.len());
            assert_eq!(own, row);
            assert!(rest.iter().all(|&number| number == 0.0));
        }
    }
}

#[test]
fn fmf_of_every_signature_and_orientation() {
    let plain = ExtraHeader::default();
    let heights = ExtraHeader {
        dynamic_range_reduction: 0,
        height_map: Some((vec![0.25; 12], 4)),
    };
    let extras = [(0, &plain), (1, &plain), (2, &plain), (2, &heights)];
    for transposed in [false, true] {
        for scalar in [Scalar::Half, Scalar::Single, Scalar::Double] {
            let header = header();
            let mut files: Vec<Vec<u8>> = ["!FMF06FC", "!FMF06FCR"]
                .map(|text| fmf(text, &header, None, scalar, transposed))
                .into();
            for text in ["!FMF12FCER", "!FMF12FCE"] {
                let of = |&extra| fmf(text, &header, Some(extra), scalar, transposed);
                files.extend(extras.iter().map(of));
            }
            for bytes in files {
                let wanted = |image, texel| fmf_value(transposed, image, texel);
                check(&bytes, &BonnOptions::default(), &header, 1e-6, wanted);
                check(&bytes, &expanded(), &header, 1e-6, wanted);
            }
        }
    }
}

/// Millimetres become texels above the mean height, in copied, expanded and cropped samples alike.
#[test]
fn heights_of_an_fmf_file_are_kept() {
    let millimetres: Vec<f32> = (0..TEXELS).map(|at| 0.25 * at as f32).collect();
    let heights = |header: &Header, columns: usize, bonn: &BonnOptions, crop: Option<Region>| {
        let extra = ExtraHeader {
            dynamic_range_reduction: 0,
            height_map: Some((millimetres.clone(), columns as u32)),
        };
        let bytes = fmf("!FMF12FCE", header, Some((2, &extra)), Scalar::Half, false);
        let mut options = ImportOptions::default();
        options.preparation.crop = crop;
        let (sample, _folder) = import_with_options(&bytes, bonn, &options);
        sample.heights().unwrap()
    };
    let sized = header();
    let mean = 0.25 * (TEXELS - 1) as f32 / 2.0;
    let in_texels = |mm: &f32| (mm - mean) * sized.meta.pixels_per_mm;
    let wanted: Vec<f32> = millimetres.iter().map(in_texels).collect();
    let mut unsized_header = header();
    unsized_header.meta.pixels_per_mm = 0.0;
    for bonn in [BonnOptions::default(), expanded()] {
        let kept = heights(&sized, WIDTH, &bonn, None).unwrap();
        assert_eq!(kept.heights(), wanted);
        let part = heights(&sized, WIDTH, &bonn, Some("3x2+1+1".parse().unwrap()));
        let rows = [1, 2].map(|row| &wanted[row * WIDTH + 1..row * WIDTH + 4]);
        assert_eq!(part.unwrap().heights(), rows.concat());
        // Of another size, or without a texel's size.
        assert_eq!(heights(&sized, HEIGHT, &bonn, None), None);
        assert_eq!(heights(&unsized_header, WIDTH, &bonn, None), None);
    }
}

/// The size of this header begins with the byte R, as a longer signature would go on.
#[test]
fn a_size_that_looks_like_a_signature_is_told_from_it() {
    let mut header = header();
    header.meta.xml = vec![b'x'; 47];
    let bytes = fmf("!FMF06FC", &header, None, Scalar::Half, false);
    assert!(bytes.starts_with(b"!FMF06FCR"));
    let wanted = |image, texel| fmf_value(false, image, texel);
    check(&bytes, &BonnOptions::default(), &header, 1e-6, wanted);
}

fn fmf_value(transposed: bool, image: usize, texel: usize) -> [f64; 3] {
    let [left, right] = pair(transposed);
    [0, 1, 2].map(|channel| {
        let (l, r) = match transposed {
            false => (left.row(image * 3 + channel), right.row(texel)),
            true => (left.row(texel * 3 + channel), right.row(image)),
        };
        f64::from(l.dot(&r))
    })
}

#[test]
fn fmf_with_a_reduced_range_is_undone() {
    let extra = ExtraHeader {
        dynamic_range_reduction: 1,
        height_map: None,
    };
    let header = header();
    let bytes = fmf(
        "!FMF12FCER",
        &header,
        Some((2, &extra)),
        Scalar::Half,
        false,
    );
    let wanted = |image, texel| fmf_value(false, image, texel).map(|v| v.exp() - 1e-5);
    check(&bytes, &expanded(), &header, 1e-5, wanted);
}

#[test]
fn fmf_shares_its_eigentextures() {
    let bytes = fmf("!FMF06FC", &header(), None, Scalar::Half, false);
    let (sample, _folder) = import_with(&bytes, &BonnOptions::default());
    assert!(
        sample
            .factors()
            .unwrap()
            .factorization()
            .shared_eigentextures
    );
}

#[test]
fn pvf_of_every_layout_and_age() {
    for (text, legacy) in [
        ("!PVF06FCR", false),
        ("!PVF06FC", false),
        ("!PVF06FC", true),
        ("!PVF06FCR", true),
    ] {
        for scalar in [Scalar::Half, Scalar::Single, Scalar::Double] {
            for per_light in [false, true] {
                let mut header = header();
                let bytes = pvf(text, &header, scalar, per_light, legacy);
                header.meta.has_cosine = !legacy;
                let wanted = |image: usize, texel: usize| {
                    let (numbers, light) = (view(image / LIGHTS, per_light), image % LIGHTS);
                    [0, 1, 2].map(|channel| {
                        let (row, weights) = match per_light {
                            false => (light * 3 + channel, texel),
                            true => (texel * 3 + channel, light),
                        };
                        let weights = numbers.weights.row(weights);
                        f64::from(numbers.mean[row] + numbers.components.row(row).dot(&weights))
                    })
                };
                check(&bytes, &BonnOptions::default(), &header, 1e-6, wanted);
            }
        }
    }
}

#[test]
fn bdi_of_every_compression_and_chunk() {
    let header = header();
    let mut mask = vec![true; TEXELS];
    (mask[1], mask[12]) = (false, false);
    for lines in [1, 2, 3, 4] {
        for compression in [Compression::Full, Compression::Bzip, Compression::Sparse] {
            let bytes = bdi(&header, compression, lines, &mask);
            let wanted = |image: usize, texel: usize| {
                let is_there = compression != Compression::Sparse || mask[texel];
                [0, 1, 2].map(|channel| match is_there {
                    true => f64::from(half::f16::from_f32(number(texel, image, channel))),
                    false => 0.0,
                })
            };
            check(&bytes, &BonnOptions::default(), &header, 1e-6, wanted);
        }
    }
}

/// btflib fills the last chunk up when it writes a tensor from memory.
#[test]
fn bdi_with_a_last_chunk_filled_up() {
    let header = header();
    let mut bytes = bdi(&header, Compression::Sparse, 2, &[true; TEXELS]);
    let texel = IMAGES * 3 * 2;
    let (short, full) = (WIDTH * texel, 2 * WIDTH * texel);
    let at = bytes.len() - short - 4;
    assert_eq!(bytes[at..at + 4], (short as u32).to_le_bytes());
    bytes[at..at + 4].copy_from_slice(&(full as u32).to_le_bytes());
    bytes.resize(bytes.len() + full - short, 0);
    let wanted = |image, texel| {
        [0, 1, 2].map(|channel| f64::from(half::f16::from_f32(number(texel, image, channel))))
    };
    check(&bytes, &BonnOptions::default(), &header, 1e-6, wanted);
}

#[test]
fn one_channel_is_grey() {
    let mut header = header();
    header.meta.channels = vec!["L".into()];
    let one = &channels()[..1];
    let content = mesotex::btf::bonn::DfmfContent {
        header: &header,
        color: Color::of(ColorModel::Rgb),
        channels: one,
        scalar: Scalar::Half,
        transposed: false,
    };
    let written = mesotex::btf::bonn::Written::Dfmf(content);
    let bytes = files::bytes_of(&files::signature("!DFMF08FCR"), written);
    let wanted = |image, texel| [product(&one[0], image, texel); 3];
    check(&bytes, &BonnOptions::default(), &header, 1e-6, wanted);
    check(&bytes, &expanded(), &header, 1e-6, wanted);
}

/// A quarter turn for all texels turns the directions; one per texel turns the values.
#[test]
fn rotations_into_local_frames_are_undone() {
    let mut turned = header();
    turned.sampling.views = files::directions("rings:30:3");
    // Rows: tangent +y, binormal −x, normal.
    let quarter = [0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    turned.rotations = vec![quarter];
    let file = Dfmf {
        header: turned.clone(),
        ..Dfmf::default()
    };
    let (sample, _folder) = import_with(&file.bytes(), &BonnOptions::default());
    let found = sample.description().lights[0];
    // The file's +x is the local tangent, which is the patch's +y.
    assert!((found.phi().to_degrees() - 90.0).abs() < 1e-4);
    turned.rotations = vec![quarter; TEXELS];
    let file = Dfmf {
        header: turned.clone(),
        ..Dfmf::default()
    };
    let (each, _folder) = import_with(&file.bytes(), &BonnOptions::default());
    assert_eq!(each.description().lights[0].phi(), 0.0);
    // View 3 of a quarter turn is between two; lights at quarters fall on each other.
    let value = |sample: &Sample, view: usize, light: usize| {
        sample.image(view * LIGHTS + light).unwrap().get(4 * 3)
    };
    let same = |found: f32, wanted: f32| (found - wanted).abs() < 1e-5;
    // Light 1 of the patch (90°) is light 0 of the local frame; weights of views are those of any light.
    let ratio = |view, light: usize| value(&each, view, light);
    assert!(ratio(0, 1) > 0.0);
    // With all views alike the turn is exact.
    turned.sampling.views = files::directions("rings:0:1,40:2");
    turned.rotations = vec![quarter; TEXELS];
    let file = Dfmf {
        header: turned,
        ..Dfmf::default()
    };
    let (top, _folder) = import_with(&file.bytes(), &BonnOptions::default());
    for light in 0..LIGHTS {
        let wanted = value(&sample, 0, (light + LIGHTS - 1) % LIGHTS);
        assert!(same(value(&top, 0, light), wanted), "light {light}");
    }
}

/// The part of a file is the part of its sample.
#[test]
fn crops_of_every_kind_are_parts_of_the_whole() {
    let region: Region = "3x2+1+1".parse().unwrap();
    for bytes in files::all() {
        let (whole, folder) = import_with(&bytes, &expanded());
        for expand in [true, false] {
            let bonn = BonnOptions { expand, rank: None };
            let mut options = ImportOptions {
                dtype: DType::F4,
                ..ImportOptions::default()
            };
            options.preparation.crop = Some(region);
            let target = folder.path().join("part.sample");
            let import = BonnImport {
                path: &folder.path().join("a.btf"),
                options: &options,
                bonn: &bonn,
                handedness: Handedness::Right,
                seed: 0,
                destination: target.as_path().into(),
                progress: Progress::silent(),
            };
            import.run().unwrap();
            let part = Sample::open(&target).unwrap();
            assert_eq!((part.grid().width, part.grid().height), (3, 2));
            if !expand && part.description().source["kind"] == "factored" {
                continue;
            }
            for image in 0..IMAGES {
                let (part, whole) = (part.image(image).unwrap(), whole.image(image).unwrap());
                for at in 0..18 {
                    let (row, column) = (at / 9 + 1, at / 3 % 3 + 1);
                    let wanted = whole.get((row * WIDTH + column) * 3 + at % 3);
                    let found = part.get(at);
                    assert!(
                        (found - wanted).abs() < 1e-5,
                        "{image} {at}: {found} {wanted}"
                    );
                }
            }
        }
    }
}

#[test]
fn every_file_of_the_fuzz_corpus_is_read() {
    for bytes in files::all() {
        let (sample, _folder) = import_with(&bytes, &BonnOptions::default());
        let grid = sample.grid();
        assert_eq!((grid.width as usize, grid.height as usize), (WIDTH, HEIGHT));
    }
}
