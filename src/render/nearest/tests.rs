//! The fast weights against their definition, computed directly in double precision.

use std::f64::consts::PI;

use clap::ValueEnum;
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

/// Coordinates of a direction on the plane that touches the sphere at a wanted one, whichever way it is turned.
fn log_map(direction: DVec3, wanted: DVec3) -> [f64; 2] {
    let x_axis = wanted.cross(DVec3::new(0.3, -0.5, 0.2)).normalize();
    let y_axis = wanted.cross(x_axis);
    let flat = direction - wanted * direction.dot(wanted);
    let heading = flat.normalize_or_zero() * angle(direction, wanted);
    [heading.dot(x_axis), heading.dot(y_axis)]
}

/// The first column of the inverse of a matrix, by Gauss and Jordan.
fn first_column_of_inverse(mut matrix: Vec<Vec<f64>>) -> Vec<f64> {
    let size = matrix.len();
    for (row, line) in matrix.iter_mut().enumerate() {
        line.push(if row == 0 { 1.0 } else { 0.0 });
    }
    for column in 0..size {
        let largest =
            |&a: &usize, &b: &usize| matrix[a][column].abs().total_cmp(&matrix[b][column].abs());
        let pivot = (column..size).max_by(largest).unwrap();
        matrix.swap(column, pivot);
        let pivot = matrix[column].clone();
        for row in (0..size).filter(|&row| row != column) {
            let factor = matrix[row][column] / pivot[column];
            let entries = matrix[row].iter_mut().zip(&pivot);
            entries.for_each(|(entry, pivot)| *entry -= factor * pivot);
        }
    }
    (0..size)
        .map(|row| matrix[row][size] / matrix[row][row])
        .collect()
}

/// Weights of a local fit with these nearnesses and rows (1, terms), slowly.
fn fitted(nearness: &[f64], rows: &[Vec<f64>], negative: f64) -> Vec<f64> {
    let (whole, size) = (nearness.iter().sum::<f64>(), rows[0].len());
    let entry = |i: usize, j: usize| {
        let terms = nearness.iter().zip(rows);
        terms.map(|(b, row)| b / whole * row[i] * row[j]).sum()
    };
    let mut matrix: Vec<Vec<f64>> = (0..size)
        .map(|i| (0..size).map(|j| entry(i, j)).collect())
        .collect();
    let trace: f64 = (0..size).map(|i| matrix[i][i]).sum();
    for (i, line) in matrix.iter_mut().enumerate().skip(1) {
        line[i] += 1e-3 * trace / size as f64;
    }
    let column = first_column_of_inverse(matrix);
    let along = |row: &Vec<f64>| row.iter().zip(&column).map(|(a, b)| a * b).sum::<f64>();
    let raw = nearness.iter().zip(rows).map(|(b, row)| b * along(row));
    let raw: Vec<f64> = raw
        .map(|w| if w < 0.0 { w * negative } else { w })
        .collect();
    let sum: f64 = raw.iter().sum();
    raw.into_iter().map(|w| w / sum).collect()
}

/// The weights of views of docs/rendering.md, slowly: (index, weight) of all directions with a weight.
fn oracle(directions: &[Direction], wanted: DVec3, weighting: Weighting) -> Vec<(usize, f64)> {
    let negative = if weighting == Weighting::Continuous {
        0.0
    } else {
        1.0
    };
    fit_oracle(directions, wanted, weighting, negative)
}

/// The same of lights, times the ratios of cosines.
fn light_oracle(
    directions: &[Direction],
    wanted: DVec3,
    weighting: Weighting,
) -> Vec<(usize, f64)> {
    let lowest = directions.iter().map(|d| d.0.z).fold(1.0, f64::min);
    let negative = match weighting {
        Weighting::Continuous => (4.0 * (1.0 - wanted.z / lowest)).clamp(0.0, 1.0),
        _ => 1.0,
    };
    let scaled = |(index, weight): (usize, f64)| {
        let ratio = (wanted.z / directions[index].0.z).min(2.0);
        (index, weight * ratio)
    };
    fit_oracle(directions, wanted, weighting, negative)
        .into_iter()
        .map(scaled)
        .collect()
}

fn fit_oracle(
    directions: &[Direction],
    wanted: DVec3,
    weighting: Weighting,
    negative: f64,
) -> Vec<(usize, f64)> {
    let distances: Vec<f64> = directions.iter().map(|d| angle(d.0, wanted)).collect();
    if let Some(same) = distances.iter().position(|&d| d < 1e-4) {
        return vec![(same, 1.0)];
    }
    let is_linear = weighting == Weighting::Continuous;
    let counted = if is_linear { 5 } else { 10 };
    let mut sorted = distances.clone();
    sorted.sort_by(f64::total_cmp);
    let reach = match sorted.get(counted - 1) {
        Some(d) => (1.05 * d).min(PI),
        None => PI,
    };
    let within: Vec<usize> = (0..distances.len())
        .filter(|&i| distances[i] < reach)
        .collect();
    let nearness = |&i: &usize| ((reach - distances[i]) / (reach * distances[i])).powi(2);
    let row = |&i: &usize| {
        let [x, y] = log_map(directions[i].0, wanted).map(|x| x / reach);
        match is_linear {
            true => vec![1.0, x, y],
            false => vec![1.0, x, y, x * x, y * y, 2f64.sqrt() * x * y],
        }
    };
    let nearnesses: Vec<f64> = within.iter().map(nearness).collect();
    let rows: Vec<Vec<f64>> = within.iter().map(row).collect();
    let weights = fitted(&nearnesses, &rows, negative);
    within.into_iter().zip(weights).collect()
}

const FITS: [Weighting; 2] = [Weighting::Continuous, Weighting::Quadratic];

/// What a set weighs a direction with, by index.
fn weights_of<const AS_LIGHTS: bool>(set: &DirectionSet, wanted: DVec3) -> Vec<f64> {
    let (mut scratch, mut found) = (Scratch::default(), Vec::new());
    set.weigh::<AS_LIGHTS>(wanted, &mut scratch, &mut found);
    let mut dense = vec![0.0; set.len()];
    for weight in &found {
        dense[weight.index as usize] += f64::from(weight.weight);
    }
    dense
}

fn random_direction(stream: &mut random::Stream) -> DVec3 {
    let phi = stream.gen_range(0.0..2.0 * PI);
    Direction::from_angles(stream.gen_range(0.0f64..1.0).acos(), phi).0
}

#[test]
fn fitted_weights_equal_the_slow_ones() {
    let mut stream = random::stream(7, "wanted", 0, 0);
    for (directions, weighting) in [
        rings(),
        fibonacci(200),
        fibonacci(7),
        fibonacci(3),
        fibonacci(1),
    ]
    .into_iter()
    .flat_map(|directions| FITS.map(|weighting| (directions.clone(), weighting)))
    {
        let set = DirectionSet::new(&directions, weighting);
        for round in 0..1000 {
            let wanted = match round % 4 {
                // On, and just beside, a sampled direction.
                0 => directions[round % directions.len()].0,
                1 => (directions[round % directions.len()].0 + DVec3::Z * 3e-4).normalize(),
                _ => random_direction(&mut stream),
            };
            let mut dense = weights_of::<false>(&set, wanted);
            for (index, weight) in oracle(&directions, wanted, weighting) {
                let error = (dense[index] - weight).abs();
                assert!(
                    error < 4e-5,
                    "{weighting:?} of {}: {wanted} {index} {error}",
                    directions.len()
                );
                dense[index] = 0.0;
            }
            assert!(dense.iter().all(|w| w.abs() < 4e-5), "{wanted}");
        }
    }
}

#[test]
fn light_weights_carry_the_ratio_of_cosines() {
    let directions = rings();
    let mut stream = random::stream(8, "wanted", 0, 0);
    for weighting in FITS {
        let set = DirectionSet::new(&directions, weighting);
        for _ in 0..300 {
            let wanted = random_direction(&mut stream);
            let dense = weights_of::<true>(&set, wanted);
            for (index, weight) in light_oracle(&directions, wanted, weighting) {
                let got = dense[index];
                assert!((got - weight).abs() < 6e-5, "{got} {weight}");
            }
        }
    }
}

/// The value that a set's weights give a function of directions.
fn blended(
    set: &DirectionSet,
    directions: &[Direction],
    wanted: DVec3,
    value: impl Fn(DVec3) -> f64,
) -> f64 {
    let weights = weights_of::<false>(set, wanted);
    weights
        .iter()
        .zip(directions)
        .map(|(w, d)| w * value(d.0))
        .sum()
}

#[test]
fn a_linear_fit_follows_linear_change_and_a_quadratic_one_curved_change() {
    let directions = fibonacci(200);
    let errors = |weighting: Weighting, value: fn(DVec3, DVec3) -> f64| {
        let set = DirectionSet::new(&directions, weighting);
        let mut stream = random::stream(11, "wanted", 0, 0);
        let error = |_| {
            let wanted =
                Direction::from_angles(stream.gen_range(0.0..1.0), stream.gen_range(0.0..6.0)).0;
            blended(&set, &directions, wanted, |d| value(d, wanted)).abs()
        };
        (0..300).map(error).fold(0.0, f64::max)
    };
    // Linear in coordinates about the wanted direction, and 0 there.
    let linear = |d: DVec3, wanted: DVec3| log_map(d, wanted)[0] - 2.0 * log_map(d, wanted)[1];
    let curved = |d: DVec3, wanted: DVec3| log_map(d, wanted)[0].powi(2);
    // The ridge and clamped weights leave a little: steps between the directions are 0.18 rad.
    assert!(errors(Weighting::Continuous, linear) < 0.06);
    assert!(errors(Weighting::Quadratic, linear) < 0.01);
    assert!(errors(Weighting::Quadratic, curved) < 0.2 * errors(Weighting::Continuous, curved));
}

#[test]
fn weights_are_continuous() {
    for directions in [rings(), fibonacci(200), fibonacci(11)] {
        for weighting in FITS {
            let set = DirectionSet::new(&directions, weighting);
            // The largest change of a weight along a way over the hemisphere, by steps.
            let change = |steps: usize| {
                let at = |step: usize| {
                    let way = step as f64 / steps as f64;
                    let wanted = Direction::from_angles(0.1 + 1.4 * way, 2.0 * way);
                    weights_of::<true>(&set, wanted.0)
                };
                let change = |step: usize| {
                    let (a, b) = (at(step), at(step + 1));
                    a.iter()
                        .zip(b)
                        .map(|(a, b)| (a - b).abs())
                        .fold(0.0, f64::max)
                };
                (0..steps).map(change).fold(0.0, f64::max)
            };
            let ratio = change(8000) / change(4000);
            assert!(
                ratio < 0.6,
                "{weighting:?} of {}: {ratio}",
                directions.len()
            );
        }
    }
}

#[test]
fn inverse_angle_takes_the_four_nearest_and_ties_by_index() {
    let directions = rings();
    let set = DirectionSet::new(&directions, Weighting::InverseAngle);
    let (mut scratch, mut found) = (Scratch::default(), Vec::new());
    // Twelve directions are equally near to the zenith: the first four win.
    set.weigh::<false>(DVec3::Z, &mut scratch, &mut found);
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
        set.weigh::<true>(wanted, &mut scratch, &mut found);
        for (d, index) in &all[..4] {
            let got = found.iter().find(|w| w.index as usize == *index).unwrap();
            assert!((f64::from(got.weight) - scale / d / sum).abs() < 1e-6);
        }
    }
}

#[test]
fn a_sampled_direction_takes_all_the_weight() {
    let directions = fibonacci(50);
    let (mut scratch, mut found) = (Scratch::default(), Vec::new());
    for &weighting in Weighting::value_variants() {
        let set = DirectionSet::new(&directions, weighting);
        for (index, direction) in (0..).zip(&directions) {
            set.weigh::<true>(direction.0, &mut scratch, &mut found);
            let [
                Weight {
                    index: only,
                    weight,
                },
            ] = found[..]
            else {
                panic!("{weighting:?}: {found:?}");
            };
            assert!(only == index && (weight - 1.0).abs() < 1e-6, "{weight}");
        }
    }
}

#[test]
fn repeated_directions_count_once() {
    let mut directions = fibonacci(9);
    directions.insert(
        3,
        Direction((directions[1].0 + DVec3::X * 2e-5).normalize()),
    );
    let set = DirectionSet::new(&directions, Weighting::Continuous);
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
    let of = |weighting| PairSet::new(&views, &lights, &pairs, weighting).unwrap();
    let (literal, fit) = (of(Weighting::InverseAngle), of(Weighting::Continuous));
    assert!(literal.len() < pairs.len());
    let (mut scratch, mut found) = (Scratch::default(), Vec::new());
    for _ in 0..200 {
        let (view, light) = (random_direction(&mut stream), random_direction(&mut stream));
        let mut all: Vec<(f64, u32)> = (0..literal.len() as u32)
            .map(|p| {
                let [v, l] = pairs[literal.kept()[p as usize] as usize];
                let d = angle(views[v as usize].0, view).hypot(angle(lights[l as usize].0, light));
                (d, p)
            })
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let cos = |p: u32| {
            lights[pairs[literal.kept()[p as usize] as usize][1] as usize]
                .0
                .z
        };

        let sum: f64 = all[..16].iter().map(|(d, _)| 1.0 / d).sum();
        let lowest = lights.iter().map(|l| l.0.z).fold(1.0, f64::min);
        literal.weigh(view, light, &mut scratch, &mut found);
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
        let nearness = |d: f64| ((reach - d) / (reach * d)).powi(2);
        let within: Vec<_> = all.iter().filter(|(d, _)| *d < reach).collect();
        let row = |p: u32| {
            let [v, l] = pairs[literal.kept()[p as usize] as usize];
            let [a, b] = log_map(views[v as usize].0, view).map(|x| x / reach);
            let [c, d] = log_map(lights[l as usize].0, light).map(|x| x / reach);
            vec![1.0, a, b, c, d]
        };
        let nearnesses: Vec<f64> = within.iter().map(|(d, _)| nearness(*d)).collect();
        let rows: Vec<Vec<f64>> = within.iter().map(|(_, p)| row(*p)).collect();
        fit.weigh(view, light, &mut scratch, &mut found);
        for ((_, p), weight) in within.iter().zip(fitted(&nearnesses, &rows, 0.0)) {
            let got = found
                .iter()
                .find(|w| w.index == *p)
                .map_or(0.0, |w| w.weight);
            let wanted = weight * (light.z / cos(*p)).min(2.0);
            assert!((f64::from(got) - wanted).abs() < 1e-5);
        }
    }
}

#[test]
fn scattered_pairs_have_no_quadratic_weights() {
    let directions = fibonacci(30);
    let pairs: Vec<[u32; 2]> = (0..30).map(|k| [k, k]).collect();
    let error = PairSet::new(&directions, &directions, &pairs, Weighting::Quadratic).unwrap_err();
    assert!(matches!(error, crate::error::Error::Option { .. }));
    assert!(error.to_string().contains("quadratic"));
}
