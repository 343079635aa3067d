//! Vertices on the screen in fixed point, and triangles clipped to what can be drawn.
//!
//! Positions are rounded to 1/256 pixel before any edge is drawn, so that triangles that share
//! vertices share edges exactly. Only triangles that reach behind the camera or far beyond the
//! image are clipped; where two of them share an edge, it is cut at the same point.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::pattern::SUBPIXEL;
use crate::render::camera::View;

/// Pixels beyond the image's middle that fixed point reaches without clipping.
const GUARD: f64 = 100_000.0;

const NEAR: u32 = 1;
const FAR_OFF: u32 = 2;
/// Bits of the four sides of the image, for triangles that miss it altogether.
const SIDES: u32 = 0b11_1100;

/// A vertex on the screen.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScreenVertex {
    /// 1/256 pixel, rightwards.
    pub x: i32,
    /// 1/256 pixel, downwards.
    pub y: i32,
    /// Linear on the screen, the greater the nearer: 1/depth (perspective) or −depth.
    pub nearness: f32,
    /// Which limits the vertex lies beyond.
    outside: u32,
}

/// A piece of a clipped triangle.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// Screen vertices.
    pub corners: [u32; 3],
    /// The mesh triangle it was cut from.
    pub source: u32,
    /// Barycentric weights of the corners in that triangle.
    pub weights: [[f32; 3]; 3],
}

/// A mesh on the screen of one view.
pub(super) struct Screen {
    /// Mesh vertices, then vertices that clipping made.
    pub vertices: Vec<ScreenVertex>,
    /// What clipping left of the triangles that needed it.
    pub pieces: Vec<Piece>,
    /// Depth in front of which nothing is drawn.
    nearest: f64,
}

impl Screen {
    /// Projects a mesh and clips what must be.
    pub fn project(view: &View, positions: &[Vec3], triangles: &[[u32; 3]], nearest: f64) -> Self {
        let vertices = positions
            .par_iter()
            .map(|p| screen_vertex(view, view.camera_from_world(p.as_dvec3()), nearest))
            .collect();
        let mut screen = Self {
            vertices,
            pieces: Vec::new(),
            nearest,
        };
        let to_clip: Vec<u32> = (0..triangles.len() as u32)
            .into_par_iter()
            .filter(|&t| screen.needs_clipping(triangles[t as usize]))
            .collect();
        for triangle in to_clip {
            let corners = triangles[triangle as usize].map(|v| {
                let position = positions[v as usize].as_dvec3();
                view.camera_from_world(position)
            });
            screen.clip(view, corners, triangle);
        }
        screen
    }

    /// Whether a triangle can be drawn as it is.
    pub fn is_drawable(&self, corners: [u32; 3]) -> bool {
        let [a, b, c] = corners.map(|v| self.vertices[v as usize].outside);
        a & b & c & SIDES == 0 && (a | b | c) & (NEAR | FAR_OFF) == 0
    }

    fn needs_clipping(&self, corners: [u32; 3]) -> bool {
        let [a, b, c] = corners.map(|v| self.vertices[v as usize].outside);
        a & b & c & (SIDES | NEAR) == 0 && (a | b | c) & (NEAR | FAR_OFF) != 0
    }

    /// Cuts a triangle to the part in front of the camera and near the image.
    fn clip(&mut self, view: &View, corners: [DVec3; 3], source: u32) {
        let mut polygon: Vec<ClipVertex> = (0..3)
            .map(|corner| ClipVertex {
                position: corners[corner],
                weights: DVec3::AXES[corner],
            })
            .collect();
        polygon = cut(&polygon, |p| p.z - self.nearest);
        for side in 0..4 {
            polygon = cut(&polygon, |p| side_distance(view, side, p, GUARD));
        }
        if polygon.len() < 3 {
            return;
        }
        self.add_fan(view, &polygon, source);
    }

    fn add_fan(&mut self, view: &View, polygon: &[ClipVertex], source: u32) {
        let first = self.vertices.len() as u32;
        for vertex in polygon {
            let mut on_screen = screen_vertex(view, vertex.position, self.nearest);
            on_screen.outside &= SIDES;
            self.vertices.push(on_screen);
        }
        for k in 1..polygon.len() - 1 {
            let corners = [0, k, k + 1];
            self.pieces.push(Piece {
                corners: corners.map(|corner| first + corner as u32),
                source,
                weights: corners.map(|corner| polygon[corner].weights.as_vec3().to_array()),
            });
        }
    }
}

#[derive(Clone, Copy)]
struct ClipVertex {
    position: DVec3,
    weights: DVec3,
}

/// Keeps the part of a polygon where `distance` is not negative (Sutherland and Hodgman 1974).
fn cut(polygon: &[ClipVertex], distance: impl Fn(DVec3) -> f64) -> Vec<ClipVertex> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (index, &current) in polygon.iter().enumerate() {
        let next = polygon[(index + 1) % polygon.len()];
        let (here, there) = (distance(current.position), distance(next.position));
        if here >= 0.0 {
            kept.push(current);
        }
        if (here >= 0.0) != (there >= 0.0) {
            kept.push(crossing((current, here), (next, there)));
        }
    }
    kept
}

/// Where an edge meets a plane: the same point whichever end comes first.
fn crossing(a: (ClipVertex, f64), b: (ClipVertex, f64)) -> ClipVertex {
    let swap = a.0.position.to_array() > b.0.position.to_array();
    let ((a, from), (b, to)) = if swap { (b, a) } else { (a, b) };
    let fraction = from / (from - to);
    ClipVertex {
        position: a.position.lerp(b.position, fraction),
        weights: a.weights.lerp(b.weights, fraction),
    }
}

/// How far a point in camera space lies inside the left, right, upper or lower side (0–3) of the
/// pyramid that is `half_width` pixels wide on each side of the image's middle; times its depth.
fn side_distance(view: &View, side: usize, p: DVec3, half_width: f64) -> f64 {
    let scale = view.pixels_per_unit_at(1.0);
    let depth = if view.is_perspective() { p.z } else { 1.0 };
    match side {
        0 => scale * p.x + half_width * depth,
        1 => half_width * depth - scale * p.x,
        2 => half_width * depth - scale * p.y,
        _ => scale * p.y + half_width * depth,
    }
}

fn screen_vertex(view: &View, p: DVec3, nearest: f64) -> ScreenVertex {
    // Note which borders the point lies beyond.
    let half = view.size.map(|side| 0.5 * f64::from(side));
    let mut outside = if p.z < nearest { NEAR } else { 0 };
    for side in 0..4 {
        if side_distance(view, side, p, half[side / 2]) < 0.0 {
            outside |= 4 << side;
        }
        if side_distance(view, side, p, GUARD) < 0.0 {
            outside |= FAR_OFF;
        }
    }
    // Project it; clamp what is too far off for whole numbers.
    let (x, y) = if outside & (NEAR | FAR_OFF) == 0 {
        view.pixel_from_camera(p)
    } else {
        let clamped = DVec3::new(p.x, p.y, p.z.max(nearest));
        let (x, y) = view.pixel_from_camera(clamped);
        let reach = GUARD * 1.5;
        (x.clamp(-reach, reach), y.clamp(-reach, reach))
    };
    let fixed = |pixels: f64| (pixels * f64::from(SUBPIXEL)).round() as i32;
    let nearness = if view.is_perspective() {
        1.0 / p.z
    } else {
        -p.z
    };
    ScreenVertex {
        x: fixed(x),
        y: fixed(y),
        nearness: nearness as f32,
        outside,
    }
}
