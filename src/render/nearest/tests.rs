//! The fast weights against the contract's sentence, read literally in double precision.

use std::f64::consts::PI;

use glam::DVec3;
use rand::Rng;

use super::product::Scratch;
use super::*;
use crate::btf::direction::Direction;
use crate::random;

/// Rings like Tong's 12×5.
fn rings() -> Vec<Direction> {
    let ring = |k: usize| (0..12).map(move |j| (15.0 * (k + 1) as f64, 30.0 * j as f64));
    (0..5)
        .flat_map(ring)
        .map(|(theta, phi)| Direction::from_angles(theta.to_radians(), phi.to_radians()))
        .collect()
}

fn fibonacci(count: usize) -> Vec<Direction> {
    (0..count)
        .map(|i| {
            let cos = 1.0 - (i as f64 + 0.5) / count as f64;
            Direction::from_angles(cos.acos(), i as f64 * PI * (3.0 - 5f64.sqrt()))
        })
        .collect()
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// The weights `continuous` of docs/rendering.md, slowly: (index, weight) of all directions with a weight.
fn oracle(directions: &[Direction], wanted: DVec3) -> Vec<(usize, f64)> {
    let distances: Vec<f64> = directions.iter().map(|d| angle(d.0, wanted)).collect();
    if let Some(same) = distances.iter().position(|&d| d < 1e-4) {
        return vec![(same, 1.0)];
    }
    let mut sorted = distances.clone();
    sorted.sort_by(f64::total_cmp);
    let reach = if sorted.len() < 5 {
        PI
    } else {
        1.05 * sorted[4]
    };
    let raw: Vec<(usize, f64)> = (0..distances.len())
        .filter(|&i| distances[i] < reach)
        .map(|i| (i, ((reach - distances[i]) / (reach * distances[i])).powi(2)))
        .collect();
    let sum: f64 = raw.iter().map(|(_, w)| w).sum();
    raw.into_iter().map(|(i, w)| (i, w / sum)).collect()
}

fn random_direction(stream: &mut random::Stream) -> DVec3 {
    let phi = stream.gen_range(0.0..2.0 * PI);
    Direction::from_angles(stream.gen_range(0.0f64..1.0).acos(), phi).0
}

#[test]
fn continuous_weights_equal_the_slow_ones() {
    let mut stream = random::stream(7, "wanted", 0, 0);
    for directions in [
        rings(),
        fibonacci(200),
        fibonacci(7),
        fibonacci(3),
        fibonacci(1),
    ] {
        let set = DirectionSet::new(&directions);
        let (mut scratch, mut found) = (Scratch::default(), Vec::new());
        for round in 0..2000 {
            let wanted = match round % 4 {
                // On, and just beside, a sampled direction.
                0 => directions[round % directions.len()].0,
                1 => (directions[round % directions.len()].0 + DVec3::Z * 3e-4).normalize(),
                _ => random_direction(&mut stream),
            };
            let expected = oracle(&directions, wanted);
            set.continuous::<false>(wanted.as_vec3().to_array(), &mut scratch, &mut found);
            let mut dense = vec![0.0; directions.len()];
            for weight in &found {
                dense[weight.index as usize] += f64::from(weight.weight);
            }
            for (index, weight) in expected {
                assert!((dense[index] - weight).abs() < 2e-5, "{wanted} {index}");
                dense[index] = 0.0;
            }
            assert!(dense.iter().all(|w| w.abs() < 2e-5), "{wanted}");
        }
    }
}

#[test]
fn light_weights_carry_the_ratio_of_cosines() {
    let directions = rings();
    let set = DirectionSet::new(&directions);
    let (mut scratch, mut found) = (Scratch::default(), Vec::new());
    let mut stream = random::stream(8, "wanted", 0, 0);
    for _ in 0..300 {
        let wanted = random_direction(&mut stream);
        set.continuous::<true>(wanted.as_vec3().to_array(), &mut scratch, &mut found);
        for (index, weight) in oracle(&directions, wanted) {
            let ratio = (wanted.z / directions[index].0.z).min(2.0);
            let got = found.iter().find(|w| w.index as usize == index);
            let got = got.map_or(0.0, |w| f64::from(w.weight));
            assert!(
                (got - weight * ratio).abs() < 4e-5,
                "{got} {weight} {ratio}"
            );
        }
    }
}

#[test]
fn inverse_angle_takes_the_four_nearest_and_ties_by_index() {
    let directions = rings();
    let set = DirectionSet::new(&directions);
    let (mut scratch, mut found) = (Scratch::default(), Vec::new());
    // Twelve directions are equally near to the zenith: the first four win.
    set.inverse_angle::<false>(DVec3::Z, &mut scratch, &mut found);
    let mut indices: Vec<u32> = found.iter().map(|w| w.index).collect();
    indices.sort_unstable();
    assert_eq!(indices, [0, 1, 2, 3]);
    assert!(found.iter().all(|w| (w.weight - 0.25).abs() < 1e-6));

    let mut stream = random::stream(9, "wanted", 0, 0);
    for _ in 0..1000 {
        let wanted = random_direction(&mut stream);
        let mut all: Vec<(f64, usize)> = (0..directions.len())
            .map(|i| (angle(directions[i].0, wanted), i))
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let sum: f64 = all[..4].iter().map(|(d, _)| 1.0 / d).sum();
        let lowest = 75f64.to_radians().cos();
        let scale = (wanted.z / lowest).min(1.0);
        set.inverse_angle::<true>(wanted, &mut scratch, &mut found);
        for (d, index) in &all[..4] {
            let got = found.iter().find(|w| w.index as usize == *index).unwrap();
            assert!((f64::from(got.weight) - scale / d / sum).abs() < 1e-6);
        }
    }
}

#[test]
fn a_sampled_direction_takes_all_the_weight() {
    let directions = fibonacci(50);
    let set = DirectionSet::new(&directions);
    let (mut scratch, mut found) = (Scratch::default(), Vec::new());
    for (index, direction) in directions.iter().enumerate() {
        set.continuous::<false>(direction.0.as_vec3().to_array(), &mut scratch, &mut found);
        let only = Weight {
            index: index as u32,
            weight: 1.0,
        };
        assert_eq!(found, [only]);
        set.inverse_angle::<false>(direction.0, &mut scratch, &mut found);
        assert_eq!(found, [only]);
    }
}

#[test]
fn repeated_directions_count_once() {
    let mut directions = fibonacci(9);
    directions.insert(
        3,
        Direction((directions[1].0 + DVec3::X * 2e-5).normalize()),
    );
    let set = DirectionSet::new(&directions);
    assert_eq!(set.kept(), [0, 1, 2, 4, 5, 6, 7, 8, 9]);
}

#[test]
fn views_below_the_horizon_are_lifted() {
    let view = DVec3::new(0.6, 0.0, -0.8);
    let up = lifted(view);
    assert!((Direction(up).theta() - (PI / 2.0 - 1e-3)).abs() < 1e-12);
    assert!(up.y == 0.0 && up.x > 0.0);
    assert_eq!(lifted(DVec3::Z), DVec3::Z);
    assert!((lifted(-DVec3::Z).length() - 1.0).abs() < 1e-12);
}

#[test]
fn scattered_pairs_are_weighted_by_both_angles() {
    let (views, lights) = (fibonacci(13), fibonacci(11));
    let mut stream = random::stream(4, "pairs", 0, 0);
    let mut pairs: Vec<[u32; 2]> = (0..60)
        .map(|_| [stream.gen_range(0..13), stream.gen_range(0..11)])
        .collect();
    pairs.push(pairs[0]);
    let set = PairSet::new(&views, &lights, &pairs);
    assert!(set.len() < pairs.len());
    let mut found = Vec::new();
    for _ in 0..200 {
        let (view, light) = (random_direction(&mut stream), random_direction(&mut stream));
        let mut all: Vec<(f64, u32)> = (0..set.len() as u32)
            .map(|p| {
                let [v, l] = pairs[set.kept()[p as usize] as usize];
                let d = angle(views[v as usize].0, view).hypot(angle(lights[l as usize].0, light));
                (d, p)
            })
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let cos = |p: u32| {
            lights[pairs[set.kept()[p as usize] as usize][1] as usize]
                .0
                .z
        };

        let sum: f64 = all[..16].iter().map(|(d, _)| 1.0 / d).sum();
        let lowest = lights.iter().map(|l| l.0.z).fold(1.0, f64::min);
        set.inverse_angle(view, light, &mut found);
        assert_eq!(found.len(), 16);
        for (d, p) in &all[..16] {
            let got = found.iter().find(|w| w.index == *p).unwrap().weight;
            let scale = if light.z < lowest {
                light.z / lowest
            } else {
                1.0
            };
            assert!((f64::from(got) - scale / d / sum).abs() < 1e-6);
        }

        let reach = 1.05 * all[16].0;
        let fading = |d: f64| ((reach - d) / (reach * d)).powi(2);
        let within: Vec<_> = all.iter().filter(|(d, _)| *d < reach).collect();
        let sum: f64 = within.iter().map(|(d, _)| fading(*d)).sum();
        set.continuous(view, light, &mut found);
        assert_eq!(found.len(), within.len());
        for (d, p) in within {
            let got = found.iter().find(|w| w.index == *p).unwrap().weight;
            let wanted = fading(*d) / sum * (light.z / cos(*p)).min(2.0);
            assert!((f64::from(got) - wanted).abs() < 1e-5);
        }
    }
}
