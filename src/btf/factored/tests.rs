//! Factored samples written and read back, and every fault of their files.

use std::fs;
use std::path::Path;

use ndarray::{Array3, Ix3};

use crate::btf::description::{DIRECTIONS, DType, Description, EIGENTEXTURES, Layout};
use crate::btf::direction::Direction;
use crate::btf::factored::factorization::Factorization;
use crate::btf::factored::products::Values;
use crate::btf::factored::writer::FactoredWriter;
use crate::btf::image_source::ImageSource;
use crate::btf::sample::{DESCRIPTION, Pixels, Sample};
use crate::btf::writer::SampleWriter;
use crate::format::{json, npy};

const WIDTH: usize = 30;
const HEIGHT: usize = 19;
const TEXELS: usize = WIDTH * HEIGHT;
const IMAGES: usize = 6;
const RANK: usize = 5;

fn description(factors: Factorization) -> Description {
    Description {
        layout: Layout::Factored(factors),
        tileable: true,
        ..Description::product(
            "test",
            [WIDTH as u32, HEIGHT as u32],
            [0.0, 0.4]
                .map(|theta| Direction::from_angles(theta, 0.0))
                .into(),
            [0.1, 0.5, 0.9]
                .map(|theta| Direction::from_angles(theta, 1.0))
                .into(),
        )
    }
}

/// Some number between −0.5 and 1.
fn number(seed: usize) -> f32 {
    (seed * 7919 % 613) as f32 / 408.0 - 0.5
}

fn directions() -> Array3<f32> {
    Array3::from_shape_fn((3, IMAGES, RANK), |(c, i, k)| {
        number(c * 131 + i * 17 + k * 3)
    })
}

fn eigentextures(sets: usize) -> Array3<f32> {
    Array3::from_shape_fn((sets, TEXELS, RANK), |(c, x, k)| {
        number(c * 37 + x * 11 + k * 5 + 1)
    })
}

fn write(target: &Path, description: Description) -> Description {
    let sets = description.factors().unwrap().sets();
    let mut writer = FactoredWriter::create(target, description).unwrap();
    let (u, e) = (directions(), eigentextures(sets));
    // By turns, in runs that end anywhere.
    let u = u.as_slice().unwrap();
    let (first, second) = e.as_slice().unwrap().split_at(7 * RANK);
    writer.push_eigentextures(first).unwrap();
    u.chunks(4 * RANK)
        .for_each(|rows| writer.push_directions(rows).unwrap());
    writer.push_eigentextures(second).unwrap();
    writer.finish().unwrap()
}

/// RGB of an image at a texel by the definition, without the last step.
fn exact(factors: &Factorization, image: usize, texel: usize) -> [f64; 3] {
    let (u, e) = (directions(), eigentextures(factors.sets()));
    let channels = [0, 1, 2].map(|c| {
        let set = c.min(factors.sets() - 1);
        (0..RANK)
            .map(|k| f64::from(u[[c, image, k]]) * f64::from(e[[set, texel, k]]))
            .sum::<f64>()
    });
    [0, 1, 2].map(|row| {
        let weights = &factors.color_transform[3 * row..3 * row + 3];
        let sum: f64 = weights.iter().zip(channels).map(|(w, v)| w * v).sum();
        sum + factors.color_mean[row]
    })
}

#[test]
fn images_are_multiplied_out_as_defined() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("x.sample");
    let colored = Factorization {
        color_transform: [1.0, 0.0, 1.14, 1.0, -0.39, -0.58, 1.0, 2.03, 0.0],
        color_mean: [0.1, 0.2, 0.3],
        ..Factorization::of_rank(RANK as u32)
    };
    let shared = Factorization {
        shared_eigentextures: true,
        ..Factorization::of_rank(RANK as u32)
    };
    for factors in [Factorization::of_rank(RANK as u32), colored, shared] {
        let written = write(&target, description(factors));
        let sample = Sample::open(&target).unwrap();
        assert_eq!(sample.description(), &written);
        assert_eq!(sample.content_id().unwrap(), written.id);
        let mut some_negative = false;
        for image in 0..IMAGES {
            let pixels = sample.image(image).unwrap();
            for texel in 0..TEXELS {
                for (channel, wanted) in exact(&factors, image, texel).into_iter().enumerate() {
                    let found = f64::from(pixels.get(3 * texel + channel));
                    assert!((found - wanted.max(0.0)).abs() < 1e-5, "{found} {wanted}");
                    some_negative |= wanted < 0.0;
                }
            }
        }
        assert!(some_negative);
    }
}

#[test]
fn every_way_of_reading_gives_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("x.sample");
    write(&target, description(Factorization::of_rank(RANK as u32)));
    let sample = Sample::open(&target).unwrap();
    let mut all = vec![0.0; IMAGES * TEXELS * 3];
    sample.read_images(0..IMAGES, &mut all).unwrap();
    let mut part = Pixels::of_type(DType::F2);
    for range in [0..TEXELS, 3..4, 250..260, 256..512, 511..TEXELS] {
        for image in 0..IMAGES {
            sample.read_texels(image, range.clone(), &mut part).unwrap();
            let from = 3 * (image * TEXELS + range.start);
            for at in 0..part.len() {
                assert_eq!(part.get(at).to_bits(), all[from + at].to_bits());
            }
        }
    }
    let factors = sample.factors().unwrap();
    let mut signed = vec![0.0; 2 * TEXELS * 3];
    factors.multiply(&[4, 1], 0..TEXELS, Values::Signed, &mut signed);
    for (at, &value) in signed[TEXELS * 3..].iter().enumerate() {
        assert_eq!(value.max(0.0), all[TEXELS * 3 + at]);
    }
    let mut plane = vec![0.0; TEXELS];
    factors.copy_eigentexture(2, 3, &mut plane);
    assert_eq!(plane[300], eigentextures(3)[[2, 300, 3]]);
}

#[test]
fn halves_hold_factors_and_images() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("x.sample");
    let half = Description {
        dtype: DType::F2,
        ..description(Factorization::of_rank(RANK as u32))
    };
    write(&target, half);
    let sample = Sample::open(&target).unwrap();
    let wanted = exact(&Factorization::of_rank(RANK as u32), 3, 77)[1].max(0.0);
    assert!((f64::from(sample.image(3).unwrap().get(3 * 77 + 1)) - wanted).abs() < 2e-3);
    assert!(matches!(sample.image(0).unwrap(), Pixels::F2(_)));
}

#[test]
fn faults_of_the_files_name_file_and_place() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("x.sample");
    let good = description(Factorization::of_rank(RANK as u32));
    let refused = |says: &[&str]| {
        let error = Sample::open(&target).unwrap_err().to_string();
        assert!(says.iter().all(|text| error.contains(text)), "{error}");
    };
    let with = |factors: Factorization| {
        let written = write(&target, good.clone());
        let changed = Description {
            layout: Layout::Factored(factors),
            ..written
        };
        json::write(&target.join(DESCRIPTION), &changed).unwrap();
    };
    with(Factorization::of_rank(0));
    refused(&[DESCRIPTION, "rank: 0; expected 1 to 6"]);
    with(Factorization::of_rank(7));
    refused(&[DESCRIPTION, "rank: 7"]);
    with(Factorization::of_rank(4));
    refused(&[DIRECTIONS, "[3, 6, 5]", "[3, 6, 4]"]);
    with(Factorization {
        shared_eigentextures: true,
        ..Factorization::of_rank(RANK as u32)
    });
    refused(&[EIGENTEXTURES, "[3, 570, 5]", "[1, 570, 5]"]);

    write(&target, good.clone());
    let path = target.join(EIGENTEXTURES);
    let mut array = npy::read::<f32>(&path)
        .unwrap()
        .into_dimensionality::<Ix3>()
        .unwrap();
    for bad in [f32::NAN, f32::NEG_INFINITY, 1e13] {
        array[[1, 400, 2]] = bad;
        npy::write(&path, array.view().into_dyn()).unwrap();
        refused(&[EIGENTEXTURES, "[1, 400, 2]", &bad.to_string()]);
    }
    let mut bytes = fs::read(&path).unwrap();
    bytes.extend([0; 4]);
    fs::write(&path, bytes).unwrap();
    refused(&[EIGENTEXTURES, "bytes of numbers"]);
    fs::remove_file(&path).unwrap();
    refused(&[EIGENTEXTURES]);

    let text = fs::read_to_string(target.join(DESCRIPTION)).unwrap();
    fs::write(target.join(DESCRIPTION), text.replace("\"rank\": 5,", "")).unwrap();
    refused(&[DESCRIPTION, "missing field `rank`"]);
    fs::write(
        target.join(DESCRIPTION),
        text.replace("\"rank\": 5,", "\"rank\": -1,"),
    )
    .unwrap();
    refused(&[DESCRIPTION, "invalid value"]);
}

#[test]
fn writers_refuse_what_does_not_fit() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("x.sample");
    let good = description(Factorization::of_rank(RANK as u32));
    let whole = Description {
        layout: Layout::Product,
        ..good.clone()
    };
    assert!(FactoredWriter::create(&target, whole).is_err());
    let refused = SampleWriter::create(&target, good.clone())
        .unwrap_err()
        .to_string();
    assert!(refused.contains("layout: `factored`"), "{refused}");
    let mut writer = FactoredWriter::create(&target, good).unwrap();
    assert!(writer.push_directions(&[0.0; RANK - 1]).is_err());
    assert!(
        writer
            .push_directions(&[0.0; (3 * IMAGES + 1) * RANK])
            .is_err()
    );
    writer.push_directions(&[0.0; 8 * RANK]).unwrap();
    let mut row = [0.0; RANK];
    row[3] = f32::INFINITY;
    let refused = writer.push_directions(&row).unwrap_err().to_string();
    assert!(refused.contains("[1, 2, 3]: inf"), "{refused}");
    let refused = writer.finish().unwrap_err().to_string();
    assert!(
        refused.contains("directions.npy: 40 numbers; expected 90"),
        "{refused}"
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}
