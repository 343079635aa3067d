//! The three passes that make edges alike (Botsch and Kobbelt 2004 §4): split the long, collapse
//! the short, flip those that leave vertices with too many or too few neighbours.

use glam::Vec3;

use crate::mesh::retile::edge_operations::{EditMesh, Freedom};
use crate::mesh::topology::NONE;

/// A triangle may turn this far in a collapse or flip: the cosine between its normals.
const TURN_LIMIT: f32 = 0.3;

/// Cuts every edge longer than `length`, the longest first by octaves, until none is left or the
/// mesh has `most` vertices.
pub fn split_long(edited: &mut EditMesh, length: f32, most: usize) {
    let longest = (0..edited.opposite.len() as u32)
        .filter(|&h| edited.stands_for_edge(h))
        .map(|h| edited.length_squared(h))
        .fold(0.0, f32::max)
        .sqrt();
    let mut threshold = longest * 0.75;
    loop {
        let limit = threshold.max(length);
        split_longer(edited, limit, most);
        if threshold <= length {
            return;
        }
        threshold *= 0.75;
    }
}

fn split_longer(edited: &mut EditMesh, limit: f32, most: usize) {
    // New half-edges are appended, so the loop meets them too.
    let mut half_edge = 0;
    while (half_edge as usize) < edited.opposite.len() && edited.vertex_count() < most {
        if edited.stands_for_edge(half_edge) && edited.length_squared(half_edge) > limit * limit {
            let [a, b] = edited.ends(half_edge).map(|v| edited.positions[v as usize]);
            edited.split(half_edge, a.midpoint(b));
        } else {
            half_edge += 1;
        }
    }
}

/// Collapses edges shorter than `short` where that makes none longer than `long`, until the mesh
/// has no more than `least` vertices; says how many it collapsed.
pub fn collapse_short(edited: &mut EditMesh, short: f32, long: f32, least: usize) -> usize {
    let mut rings = [Vec::new(), Vec::new()];
    let mut collapsed = 0;
    for half_edge in 0..edited.opposite.len() as u32 {
        if edited.vertex_count() <= least {
            break;
        }
        if edited.is_alive(half_edge) && edited.length_squared(half_edge) < short * short {
            collapsed += usize::from(try_collapse(edited, half_edge, long, &mut rings));
        }
    }
    collapsed
}

/// Collapses one edge, if freedom, topology, shape and length allow.
pub fn try_collapse(
    edited: &mut EditMesh,
    half_edge: u32,
    long: f32,
    rings: &mut [Vec<u32>; 2],
) -> bool {
    let [a, b] = edited.ends(half_edge);
    let Some(position) = collapse_position(edited, half_edge) else {
        return false;
    };
    if !edited.may_collapse(half_edge, rings) {
        return false;
    }
    let too_long = |&v: &u32| {
        v != a && v != b && edited.positions[v as usize].distance_squared(position) > long * long
    };
    if rings.iter().flatten().any(too_long) {
        return false;
    }
    if turns_over(edited, a, b, position) || turns_over(edited, b, a, position) {
        return false;
    }
    edited.collapse(half_edge, position);
    true
}

/// Where b goes when a → b collapses: the middle, or b itself where b is less free; `None` where a
/// may not leave.
fn collapse_position(edited: &EditMesh, half_edge: u32) -> Option<Vec3> {
    let [a, b] = edited.ends(half_edge).map(|v| v as usize);
    let middle = edited.positions[a].midpoint(edited.positions[b]);
    let sharp = edited.sharp[half_edge as usize];
    match (edited.freedom[a], edited.freedom[b]) {
        (Freedom::Surface, Freedom::Surface) => Some(middle),
        (Freedom::Surface, _) => Some(edited.positions[b]),
        (Freedom::Line, Freedom::Line) if sharp => Some(middle),
        (Freedom::Line, Freedom::Fixed) if sharp => Some(edited.positions[b]),
        _ => None,
    }
}

/// Whether moving a vertex turns one of its triangles too far, those at `other` left out.
fn turns_over(edited: &EditMesh, vertex: u32, other: u32, to: Vec3) -> bool {
    let mut bad = false;
    edited.each_leaving(vertex, |leaving| {
        let triangle = edited.triangles[leaving as usize / 3];
        if !triangle.contains(&other) {
            let before = edited.area_normal_with(triangle, NONE, Vec3::ZERO);
            let after = edited.area_normal_with(triangle, vertex, to);
            bad |= before.dot(after) <= TURN_LIMIT * before.length() * after.length();
        }
    });
    bad
}

/// Turns every edge whose turning brings the vertices round it nearer to six neighbours (four at
/// a line); says how many it turned.
pub fn even_out_valence(edited: &mut EditMesh) -> usize {
    let mut valence = valences(edited);
    let mut ring = Vec::new();
    let mut turned = 0;
    for half_edge in 0..edited.opposite.len() as u32 {
        if !edited.stands_for_edge(half_edge) || !improves_valence(edited, half_edge, &valence) {
            continue;
        }
        if edited.may_flip(half_edge, &mut ring) && keeps_shape(edited, half_edge, false) {
            let [a, b, c, d] = quad(edited, half_edge);
            edited.flip(half_edge);
            for (vertex, change) in [(a, -1), (b, -1), (c, 1), (d, 1)] {
                valence[vertex as usize] += change;
            }
            turned += 1;
        }
    }
    turned
}

/// Turns every edge that sees more than 180° in its two apexes: no smallest angle gets smaller.
pub fn make_delaunay(edited: &mut EditMesh) -> usize {
    let mut ring = Vec::new();
    let mut turned = 0;
    for half_edge in 0..edited.opposite.len() as u32 {
        if edited.stands_for_edge(half_edge)
            && edited.opposite[half_edge as usize] != NONE
            && sees_more_than_half_turn(edited, half_edge)
            && edited.may_flip(half_edge, &mut ring)
            && keeps_shape(edited, half_edge, true)
        {
            edited.flip(half_edge);
            turned += 1;
        }
    }
    turned
}

/// Ends, apex and far apex of an inner edge.
fn quad(edited: &EditMesh, half_edge: u32) -> [u32; 4] {
    let [a, b] = edited.ends(half_edge);
    let twin = edited.opposite[half_edge as usize];
    [a, b, edited.apex(half_edge), edited.apex(twin)]
}

fn valences(edited: &EditMesh) -> Vec<i32> {
    let mut valence = vec![0; edited.positions.len()];
    for half_edge in 0..edited.opposite.len() as u32 {
        if edited.stands_for_edge(half_edge) {
            for vertex in edited.ends(half_edge) {
                valence[vertex as usize] += 1;
            }
        }
    }
    valence
}

fn improves_valence(edited: &EditMesh, half_edge: u32, valence: &[i32]) -> bool {
    if edited.opposite[half_edge as usize] == NONE || edited.sharp[half_edge as usize] {
        return false;
    }
    let excess = |vertex: u32, change: i32| {
        let wanted = if edited.freedom[vertex as usize] == Freedom::Surface {
            6
        } else {
            4
        };
        let excess = valence[vertex as usize] + change - wanted;
        excess * excess
    };
    let [a, b, c, d] = quad(edited, half_edge);
    let before = excess(a, 0) + excess(b, 0) + excess(c, 0) + excess(d, 0);
    let after = excess(a, -1) + excess(b, -1) + excess(c, 1) + excess(d, 1);
    after < before
}

/// Whether the triangles of a turned edge still face the way the old ones do.
fn keeps_shape(edited: &EditMesh, half_edge: u32, delaunay: bool) -> bool {
    let [a, b, c, d] = quad(edited, half_edge);
    let normal = |triangle| edited.area_normal_with(triangle, NONE, Vec3::ZERO);
    let old = [normal([a, b, c]), normal([b, a, d])];
    let new = [normal([a, d, c]), normal([d, b, c])];
    let around = (old[0] + old[1]).normalize_or_zero();
    let limit = if delaunay { 0.5 } else { 0.8 };
    new.iter()
        .all(|n| n.dot(around) > limit * n.length() && n.length_squared() > 0.0)
        && old.iter().all(|n| n.dot(around) > 0.5 * n.length())
}

fn sees_more_than_half_turn(edited: &EditMesh, half_edge: u32) -> bool {
    let [a, b, c, d] = quad(edited, half_edge).map(|v| edited.positions[v as usize]);
    let cotangent = |apex: Vec3| {
        let (u, v) = (a - apex, b - apex);
        u.dot(v) / u.cross(v).length().max(f32::MIN_POSITIVE)
    };
    cotangent(c) + cotangent(d) < -1e-4
}
