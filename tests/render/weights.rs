//! The weights of docs/rendering.md, literally and in double precision.

use super::*;

pub fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// A direction about a wanted one: its angle, laid out along its heading.
pub fn log_map(direction: DVec3, wanted: DVec3) -> [f64; 2] {
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

/// A thing to be weighted: its distance, its index, and its coordinates about what is wanted.
pub type Near = (f64, usize, Vec<f64>);

/// The terms of a fit: the constant, the coordinates, and their products for a quadratic one.
fn terms(coordinates: &[f64], reach: f64, is_quadratic: bool) -> Vec<f64> {
    let scaled: Vec<f64> = coordinates.iter().map(|x| x / reach).collect();
    let mut terms = [&[1.0], &scaled[..]].concat();
    if let ([x, y], true) = (&scaled[..], is_quadratic) {
        terms.extend([x * x, y * y, 2f64.sqrt() * x * y]);
    }
    terms
}

/// The weights of a fit to all things nearer than 1.05 times the `counted`th.
pub fn fit(all: &[Near], counted: usize, is_quadratic: bool, negative: f64) -> Vec<(usize, f64)> {
    let mut sorted: Vec<&Near> = all.iter().collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    if sorted[0].0 < 1e-4 {
        return vec![(sorted[0].1, 1.0)];
    }
    let reach = sorted
        .get(counted - 1)
        .map_or(PI, |last| (1.05 * last.0).min(PI));
    sorted.retain(|(d, ..)| *d < reach);
    let nearness = |d: f64| ((reach - d) / (reach * d)).powi(2);
    let sum: f64 = sorted.iter().map(|(d, ..)| nearness(*d)).sum();
    let shares: Vec<f64> = sorted.iter().map(|(d, ..)| nearness(*d) / sum).collect();
    let rows: Vec<Vec<f64>> = sorted
        .iter()
        .map(|(_, _, at)| terms(at, reach, is_quadratic))
        .collect();
    let size = rows[0].len();
    let entry = |i: usize, j: usize| -> f64 {
        let each = shares.iter().zip(&rows);
        each.map(|(b, row)| b * row[i] * row[j]).sum()
    };
    let trace: f64 = (0..size).map(|i| entry(i, i)).sum();
    let ridge = |i: usize, j: usize| match i == j && i > 0 {
        true => 1e-3 * trace / size as f64,
        false => 0.0,
    };
    let line = |i: usize| (0..size).map(|j| entry(i, j) + ridge(i, j)).collect();
    let column = first_column_of_inverse((0..size).map(line).collect());
    let raw = shares.iter().zip(&rows).map(|(b, row)| {
        let along: f64 = row.iter().zip(&column).map(|(a, b)| a * b).sum();
        b * along * if along < 0.0 { negative } else { 1.0 }
    });
    let raw: Vec<f64> = raw.collect();
    let whole: f64 = raw.iter().sum();
    sorted
        .iter()
        .zip(raw)
        .map(|((_, index, _), w)| (*index, w / whole))
        .collect()
}

/// The weights of the `count` nearest by inverse distance.
pub fn nearest(mut all: Vec<(f64, usize)>, count: usize) -> Vec<(usize, f64)> {
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    if all[0].0 < 1e-4 {
        return vec![(all[0].1, 1.0)];
    }
    all.truncate(count);
    let sum: f64 = all.iter().map(|(d, _)| 1.0 / d).sum();
    all.into_iter()
        .map(|(d, index)| (index, 1.0 / d / sum))
        .collect()
}

/// Weights of views, by index.
pub fn view_weights(directions: &[Direction], wanted: DVec3, weighting: &str) -> Vec<(usize, f64)> {
    directions_weights(directions, wanted, weighting, 0.0)
}

/// Weights of lights, by index, scaled to the wanted light.
pub fn light_weights(
    directions: &[Direction],
    wanted: DVec3,
    weighting: &str,
) -> Vec<(usize, f64)> {
    let lowest = directions.iter().map(|d| d.0.z).fold(1.0, f64::min);
    let negative = (4.0 * (1.0 - wanted.z / lowest)).clamp(0.0, 1.0);
    let weights = directions_weights(directions, wanted, weighting, negative);
    let scaled = |(index, weight): (usize, f64)| {
        let scale = match weighting {
            "inverse-angle" => (wanted.z / lowest).min(1.0),
            _ => (wanted.z / directions[index].0.z).min(2.0),
        };
        (index, weight * scale)
    };
    weights.into_iter().map(scaled).collect()
}

fn directions_weights(
    directions: &[Direction],
    wanted: DVec3,
    weighting: &str,
    negative: f64,
) -> Vec<(usize, f64)> {
    let numbered = directions.iter().enumerate();
    let near =
        numbered.map(|(index, d)| (angle(d.0, wanted), index, log_map(d.0, wanted).to_vec()));
    let near: Vec<Near> = near.collect();
    match weighting {
        "continuous" => fit(&near, 5, false, negative),
        "quadratic" => fit(&near, 10, true, 1.0),
        _ => nearest(near.iter().map(|(d, index, _)| (*d, *index)).collect(), 4),
    }
}
