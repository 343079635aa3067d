//! Computed patches under near lamps.

use std::f64::consts::FRAC_1_PI;

use std::ops::Range;

use glam::DVec3;

use super::station::{Spread, spread};
use super::*;
use crate::btf::direction::Direction;
use crate::progress::Progress;

const PATCH: Patch = Patch {
    width: 16,
    height: 12,
    sides_mm: [80.0, 60.0],
};

/// Lamps on a dome of this radius in millimetres, and the camera above.
fn dome(count: usize, radius: f64) -> Vec<Station> {
    let station = |lamp: usize| {
        let cosine = 1.0 - 0.8 * (lamp as f64 + 0.5) / count as f64;
        let light = Direction::from_angles(cosine.acos(), 2.399_963 * lamp as f64);
        Station {
            view: Direction::from_angles(0.0, 0.0),
            light,
            view_at: None,
            light_at: Some(light.0 * radius),
        }
    };
    (0..count).map(station).collect()
}

/// A smooth, not quite matte surface.
fn value(light: Direction) -> f64 {
    let highlight = light.0.z.max(0.0).powi(12);
    FRAC_1_PI * light.cos_theta() * (0.5 + 0.3 * light.0.x + 0.6 * highlight)
}

/// The image of a station as it is photographed: nearer lamps are brighter.
fn photographed(station: &Station) -> Vec<f32> {
    let texel = |at: u32| {
        let (u, v) = (
            (f64::from(at % 16) + 0.5) / 16.0,
            (f64::from(at / 16) + 0.5) / 12.0,
        );
        let point = PATCH.point(u, v);
        [(value(station.light_from(point)) / station.falloff(point)) as f32; 3]
    };
    (0..16 * 12).flat_map(texel).collect()
}

fn root_mean_square(image: &[f32], wanted: f64) -> f64 {
    let error = |found: &f32| (f64::from(*found) - wanted).powi(2);
    (image.iter().map(error).sum::<f64>() / image.len() as f64).sqrt()
}

#[test]
fn spreads_are_those_of_the_corners() {
    let station = Station {
        light_at: Some(DVec3::new(0.0, 0.0, 50.0)),
        ..dome(1, 50.0)[0]
    };
    let station = Station {
        light: Direction::from_angles(0.0, 0.0),
        ..station
    };
    let found = spread(&[station], PATCH);
    // Half the diagonal of 80 × 60 mm at a height of 50 mm.
    assert!((found.lights - 1f64.atan()).abs() < 1e-12 && found.views == 0.0);
    assert_eq!(found.most(), found.lights);
}

#[test]
fn resampled_images_are_those_of_distant_lamps() {
    let near_field = NearField {
        stations: dome(150, 400.0),
        patch: PATCH,
    };
    let folder = tempfile::tempdir().unwrap();
    let all: Vec<usize> = (0..near_field.stations.len()).collect();
    let mut resampler = Resampler::new(near_field.clone(), all.clone(), folder.path()).unwrap();
    for station in &near_field.stations {
        resampler.push(&photographed(station)).unwrap();
    }
    let mut found = Vec::new();
    resampler
        .finish(0..all.len(), Progress::silent(), |image| {
            found.push(image.to_vec());
            Ok(())
        })
        .unwrap();
    let (mut before, mut after) = (0.0, 0.0);
    for (station, image) in near_field.stations.iter().zip(&found) {
        before += root_mean_square(&photographed(station), value(station.light)).powi(2);
        after += root_mean_square(image, value(station.light)).powi(2);
    }
    let (before, after) = (before.sqrt(), after.sqrt());
    assert!(after < 0.15 * before, "{before} {after}");
}

#[test]
fn distant_stations_change_nothing() {
    let far = |station: &Station| Station {
        light_at: None,
        ..*station
    };
    let near_field = NearField {
        stations: dome(20, 400.0).iter().map(far).collect(),
        patch: PATCH,
    };
    assert_eq!(spread(&near_field.stations, PATCH), Spread::default());
    let folder = tempfile::tempdir().unwrap();
    let all: Vec<usize> = (0..near_field.stations.len()).collect();
    let mut resampler = Resampler::new(near_field.clone(), all.clone(), folder.path()).unwrap();
    let images: Vec<Vec<f32>> = near_field.stations.iter().map(photographed).collect();
    images
        .iter()
        .for_each(|image| resampler.push(image).unwrap());
    let mut at = 0;
    let check = |image: &[f32]| {
        let largest = images[at]
            .iter()
            .zip(image)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f32::max);
        assert!(largest < 1e-6, "{largest}");
        at += 1;
        Ok(())
    };
    resampler
        .finish(0..all.len(), Progress::silent(), check)
        .unwrap();
}

#[test]
fn some_images_are_resampled_from_some_of_all() {
    let near_field = NearField {
        stations: dome(150, 400.0),
        patch: PATCH,
    };
    let folder = tempfile::tempdir().unwrap();
    let resampled = |wanted: Range<usize>, sources: Vec<usize>| {
        let mut resampler =
            Resampler::new(near_field.clone(), sources.clone(), folder.path()).unwrap();
        for source in sources {
            let image = photographed(&near_field.stations[source]);
            resampler.push(&image).unwrap();
        }
        let mut found = Vec::new();
        let keep = |image: &[f32]| {
            found.push(image.to_vec());
            Ok(())
        };
        resampler.finish(wanted, Progress::silent(), keep).unwrap();
        found
    };
    let whole = resampled(0..150, (0..150).collect());
    let sources = near_field.sources_of(40..43);
    assert!((3..100).contains(&sources.len()), "{sources:?}");
    assert!(whole[40..43] == resampled(40..43, sources));
}
