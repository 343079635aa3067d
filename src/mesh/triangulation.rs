//! Polygons into triangles: ears are cut off in the polygon's own plane, roundest first.
//!
//! In: a polygon's corners in order. Out: n − 2 triangles of corner numbers. A polygon that crosses
//! itself is cut all the same, its ears then being what they are.

use glam::{DVec2, DVec3};

/// Cuts a polygon into triangles, each as three corner numbers in the polygon's direction.
pub fn triangulate(corners: &[DVec3]) -> Vec<[usize; 3]> {
    match corners.len() {
        0..=2 => Vec::new(),
        3 => vec![[0, 1, 2]],
        _ => cut_ears(&flatten(corners)),
    }
}

/// The polygon seen along its area normal (Newell).
fn flatten(corners: &[DVec3]) -> Vec<DVec2> {
    let after = |k: usize| corners[(k + 1) % corners.len()];
    let newell: DVec3 = (0..corners.len())
        .map(|k| (corners[k] - corners[0]).cross(after(k) - corners[0]))
        .sum();
    let normal = newell.try_normalize().unwrap_or(DVec3::Z);
    let x = normal.any_orthonormal_vector();
    let y = normal.cross(x);
    corners
        .iter()
        .map(|&corner| DVec2::new((corner - corners[0]).dot(x), (corner - corners[0]).dot(y)))
        .collect()
}

fn cut_ears(points: &[DVec2]) -> Vec<[usize; 3]> {
    let mut left: Vec<usize> = (0..points.len()).collect();
    let mut triangles = Vec::with_capacity(points.len() - 2);
    while left.len() > 3 {
        let ear = best_ear(points, &left);
        triangles.push(around(&left, ear));
        left.remove(ear);
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}

fn around(left: &[usize], at: usize) -> [usize; 3] {
    let count = left.len();
    [
        left[(at + count - 1) % count],
        left[at],
        left[(at + 1) % count],
    ]
}

/// The convex corner with no other inside its triangle whose smallest angle is largest, counting
/// also the one that the cut leaves behind in a quad; without any, the least bad.
fn best_ear(points: &[DVec2], left: &[usize]) -> usize {
    let quality = |at: usize| {
        let [a, b, c] = around(left, at);
        let (p, q, r) = (points[a], points[b], points[c]);
        let area = (q - p).perp_dot(r - p);
        if area <= 0.0 {
            return -1.0 + area.max(-1e300) * 1e-300;
        }
        let inside = |&other: &usize| {
            other != a && other != b && other != c && contains([p, q, r], points[other])
        };
        if left.iter().any(inside) {
            return -1.0;
        }
        let rest = match left.len() {
            4 => smallest_angle(around(left, (at + 2) % 4).map(|k| points[k])),
            _ => f64::INFINITY,
        };
        smallest_angle([p, q, r]).min(rest)
    };
    let scores: Vec<f64> = (0..left.len()).map(quality).collect();
    let mut best = 0;
    for (at, &score) in scores.iter().enumerate() {
        if score > scores[best] {
            best = at;
        }
    }
    best
}

fn contains([p, q, r]: [DVec2; 3], point: DVec2) -> bool {
    (q - p).perp_dot(point - p) >= 0.0
        && (r - q).perp_dot(point - q) >= 0.0
        && (p - r).perp_dot(point - r) >= 0.0
        && point != p
        && point != q
        && point != r
}

fn smallest_angle([p, q, r]: [DVec2; 3]) -> f64 {
    let angle = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a).atan2((b - a).dot(c - a));
    angle(p, q, r).min(angle(q, r, p)).min(angle(r, p, q))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[DVec3], triangles: &[[usize; 3]]) -> f64 {
        let doubled = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|k| points[k]);
            (b - a).cross(c - a).z
        };
        triangles.iter().map(doubled).sum::<f64>() / 2.0
    }

    #[test]
    fn a_kite_is_cut_across_its_short_diagonal() {
        let kite = [(0., 0.), (3., -1.), (6., 0.), (3., 1.)].map(|(x, y)| DVec3::new(x, y, 0.));
        let triangles = triangulate(&kite);
        assert!(triangles.iter().all(|t| t.contains(&1) && t.contains(&3)));
    }

    #[test]
    fn a_hollow_polygon_is_covered_once() {
        let hollow = [
            (0., 0.),
            (4., 0.),
            (4., 4.),
            (3., 4.),
            (3., 1.),
            (1., 1.),
            (1., 4.),
            (0., 4.),
        ]
        .map(|(x, y)| DVec3::new(x, y, 0.));
        let triangles = triangulate(&hollow);
        assert_eq!(triangles.len(), 6);
        assert!((area(&hollow, &triangles) - 10.0).abs() < 1e-12);
        for t in &triangles {
            assert!(area(&hollow, &[*t]) > 0.0);
        }
    }
}
