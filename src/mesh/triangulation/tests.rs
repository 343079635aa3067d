//! Triangulation: areas, counts, the queue against the search, and polygons that are hard to cut.

use std::f64::consts::TAU;
use std::time::{Duration, Instant};

use rand::Rng;

use super::*;
use crate::random;

fn plane(points: impl IntoIterator<Item = (f64, f64)>) -> Vec<DVec3> {
    let lift = |(x, y)| DVec3::new(x, y, 0.0);
    points.into_iter().map(lift).collect()
}

fn cut(points: &[DVec3]) -> Vec<[usize; 3]> {
    triangulate(points, Progress::silent()).unwrap()
}

fn doubled_area(points: &[DVec3], [a, b, c]: [usize; 3]) -> f64 {
    (points[b] - points[a]).cross(points[c] - points[a]).z
}

fn area(points: &[DVec3]) -> f64 {
    let after = |k: usize| points[(k + 1) % points.len()];
    let doubled = (0..points.len()).map(|k| points[k].cross(after(k)).z);
    doubled.sum::<f64>() / 2.0
}

/// Checks the count, that every corner is used, and that the polygon is covered exactly once.
fn assert_covered(name: &str, points: &[DVec3]) {
    let triangles = cut(points);
    assert_eq!(triangles.len(), points.len() - 2, "{name}");
    let mut used = vec![false; points.len()];
    triangles.iter().flatten().for_each(|&k| used[k] = true);
    assert!(used.iter().all(|&used| used), "{name}");
    let whole = area(points);
    let covered: f64 = triangles
        .iter()
        .map(|&t| doubled_area(points, t).abs())
        .sum();
    assert!(
        (covered / 2.0 - whole).abs() < 1e-6 * whole,
        "{name}: {} of {whole}",
        covered / 2.0
    );
}

/// A simple polygon round the origin with uneven radii.
fn star_shaped(corners: usize, seed: u64) -> Vec<DVec3> {
    let mut random = random::stream(seed, "star-shaped test", 0, 0);
    let corner = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / corners as f64).sin_cos();
        let radius = random.gen_range(0.2..1.0);
        (radius * cos, radius * sin)
    };
    plane((0..corners).map(corner))
}

fn circle(corners: usize) -> Vec<DVec3> {
    plane((0..corners).map(|k| {
        let (sin, cos) = (TAU * k as f64 / corners as f64).sin_cos();
        (cos, sin)
    }))
}

/// Teeth between two combs that face each other.
fn comb(teeth: usize) -> Vec<DVec3> {
    let up = (0..teeth).flat_map(|k| [(k as f64, 0.0), (k as f64 + 0.5, 50.0)]);
    let back = (0..teeth).rev().map(|k| (k as f64, -1.0));
    plane(up.chain([(teeth as f64, 0.0)]).chain(back))
        .into_iter()
        .rev()
        .collect()
}

/// A band that winds outward.
fn spiral(corners: usize, turns: f64) -> Vec<DVec3> {
    let half = corners / 2;
    let at = |k: usize, width: f64| {
        let angle = TAU * turns * k as f64 / half as f64;
        let radius = 1.0 + angle / TAU + width;
        (radius * angle.cos(), radius * angle.sin())
    };
    let outward = (0..half).map(|k| at(k, 0.4));
    plane(outward.chain((0..half).rev().map(|k| at(k, 0.0))))
}

/// A rectangle with many corners on each side.
fn collinear(corners: usize) -> Vec<DVec3> {
    let side = corners / 4;
    let step = |k: usize| k as f64 / side as f64;
    let bottom = (0..side).map(|k| (step(k), 0.0));
    let right = (0..side).map(|k| (1.0, step(k)));
    let top = (0..side).map(|k| (1.0 - step(k), 1.0));
    let left = (0..side).map(|k| (0.0, 1.0 - step(k)));
    plane(bottom.chain(right).chain(top).chain(left))
}

#[test]
fn a_kite_is_cut_across_its_short_diagonal() {
    let kite = plane([(0., 0.), (3., -1.), (6., 0.), (3., 1.)]);
    let triangles = cut(&kite);
    assert!(triangles.iter().all(|t| t.contains(&1) && t.contains(&3)));
}

#[test]
fn a_hollow_polygon_is_covered_once() {
    let hollow = plane([
        (0., 0.),
        (4., 0.),
        (4., 4.),
        (3., 4.),
        (3., 1.),
        (1., 1.),
        (1., 4.),
        (0., 4.),
    ]);
    assert_covered("hollow", &hollow);
    assert!((area(&hollow) - 10.0).abs() < 1e-12);
}

#[test]
fn the_queue_cuts_the_ears_of_the_search() {
    let mut crossing = random::stream(7, "crossing test", 0, 0);
    for corners in [5, 8, 13, 40, 65, 150, 300] {
        for seed in 0..6 {
            let simple = flatten(&star_shaped(corners, seed));
            let crossing: Vec<DVec2> = (0..corners)
                .map(|_| DVec2::new(crossing.gen_range(-1.0..1.0), crossing.gen_range(-1.0..1.0)))
                .collect();
            // Whole numbers: collinear runs and repeated points.
            let coarse = crossing.iter().map(|p| (p * 6.0).round()).collect();
            for points in [simple, crossing.clone(), coarse] {
                let mut slow = Vec::new();
                cut_by_search(&points, (0..corners).collect(), &mut slow);
                let fast = Clipping::new(&points).cut(Progress::silent()).unwrap();
                assert_eq!(fast, slow, "{corners} corners, seed {seed}");
            }
        }
    }
}

#[test]
fn large_polygons_are_covered_in_little_time() {
    let count = 40_000;
    let polygons = [
        ("circle", circle(count)),
        ("star", star_shaped(count, 3)),
        ("comb", comb(count / 3)),
        ("spiral", spiral(count, 30.0)),
        ("collinear", collinear(count)),
    ];
    let begun = Instant::now();
    for (name, polygon) in &polygons {
        assert_covered(name, polygon);
    }
    // Seconds even unoptimised; a cubic search takes hours.
    assert!(
        begun.elapsed() < Duration::from_secs(60),
        "{:?}",
        begun.elapsed()
    );
}

#[test]
fn what_is_no_simple_polygon_is_cut_all_the_same() {
    let count = 20_000;
    let mut random = random::stream(5, "hard polygons test", 0, 0);
    let mut any = || random.gen_range(-1.0..1.0);
    let crossing: Vec<DVec3> = (0..count)
        .map(|_| DVec3::new(any(), any(), any()))
        .collect();
    let repeated: Vec<DVec3> = (0..count).map(|k| crossing[k % 5]).collect();
    let one_place = vec![DVec3::ONE; count];
    let line: Vec<DVec3> = (0..count).map(|k| DVec3::X * (k % 100) as f64).collect();
    // Two sheets on top of each other: the area normal is nothing.
    let circle = circle(count / 2);
    let folded: Vec<DVec3> = circle.iter().chain(circle.iter().rev()).copied().collect();
    for polygon in [crossing, repeated, one_place, line, folded] {
        assert_eq!(cut(&polygon).len(), count - 2);
    }
}

#[test]
fn a_large_polygon_can_be_interrupted() {
    let stop = std::sync::atomic::AtomicBool::new(true);
    let progress = Progress::new(&|_| {}, Some(&stop));
    let stopped = triangulate(&circle(5000), progress);
    assert!(matches!(stopped, Err(crate::error::Error::Interrupted)));
}
