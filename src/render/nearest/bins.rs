//! Candidate lists: for each cell of the upper hemisphere, every direction that could be nearer
//! than R, 1.05 times the angle to the direction that decides it, to some direction of the cell. Exact: nothing is left
//! out.
//!
//! Cells are squares of the octahedral map of the hemisphere, rotated by 45° so that it fills [−1, 1]². The map sends
//! each cell (cut along its diagonal where the octahedron folds) to convex spherical polygons with the cell's
//! corners, so a cell's radius is the largest angle from its centre to a corner.

use glam::{DVec3, Vec3};

use super::weights::{LARGEST_RATIO, REACH};

/// Directions handled together.
pub(super) const DIRECTION_LANES: usize = 8;

/// Eight candidates, ready for vector code; unused lanes lie far away.
#[derive(Clone, Copy, Debug)]
pub(super) struct DirectionLanes {
    pub x: [f32; DIRECTION_LANES],
    pub y: [f32; DIRECTION_LANES],
    pub z: [f32; DIRECTION_LANES],
    /// Index among the kept directions.
    pub index: [u32; DIRECTION_LANES],
}

impl DirectionLanes {
    /// The squared distances from a direction's tip to the candidates'.
    #[inline(always)]
    pub fn squared_chords(&self, Vec3 { x, y, z }: Vec3) -> [f32; DIRECTION_LANES] {
        let mut squared = [0.0; DIRECTION_LANES];
        for (lane, squared) in squared.iter_mut().enumerate() {
            let (dx, dy, dz) = (x - self.x[lane], y - self.y[lane], z - self.z[lane]);
            *squared = dx * dx + dy * dy + dz * dz;
        }
        squared
    }

    /// min(cosine / cos θᵢ, 2) of the candidates.
    #[inline(always)]
    pub fn cosine_ratios(&self, cosine: f32) -> [f32; DIRECTION_LANES] {
        let largest = LARGEST_RATIO as f32;
        let mut ratios = [0.0; DIRECTION_LANES];
        for (ratio, &z) in ratios.iter_mut().zip(&self.z) {
            let exact = cosine / if z > 1e-9 { z } else { 1e-9 };
            *ratio = if exact < largest { exact } else { largest };
        }
        ratios
    }
}

const EMPTY: DirectionLanes = DirectionLanes {
    x: [0.0; DIRECTION_LANES],
    y: [0.0; DIRECTION_LANES],
    z: [-8.0; DIRECTION_LANES],
    index: [0; DIRECTION_LANES],
};

/// The candidate lists of all cells.
#[derive(Clone, Debug)]
pub(super) struct Bins {
    side: usize,
    /// Where each cell's blocks begin; one more entry than cells.
    starts: Vec<u32>,
    blocks: Vec<DirectionLanes>,
}

impl Bins {
    /// Lists for directions of which `counted` decide R; all directions when there are fewer.
    pub fn new(directions: &[DVec3], counted: usize) -> Self {
        let side = (6.0 * (directions.len() as f64).sqrt())
            .ceil()
            .clamp(4.0, 96.0) as usize;
        let mut bins = Self {
            side,
            starts: vec![0],
            blocks: Vec::new(),
        };
        for cell in 0..side * side {
            let list = candidates(directions, counted, side, cell);
            for eight in list.chunks(DIRECTION_LANES) {
                bins.blocks.push(block(directions, eight));
            }
            bins.starts.push(bins.blocks.len() as u32);
        }
        bins
    }

    /// The candidates for a unit direction above the horizon.
    #[inline(always)]
    pub fn of_direction(&self, x: f32, y: f32, z: f32) -> &[DirectionLanes] {
        let scale = 0.5 * self.side as f32 / (x.abs() + y.abs() + z.abs());
        let middle = 0.5 * self.side as f32;
        let last = self.side - 1;
        // `as` saturates: rounding at the rim stays in the outermost cells.
        let column = (((x + y) * scale + middle) as usize).min(last);
        let row = (((x - y) * scale + middle) as usize).min(last);
        let cell = row * self.side + column;
        &self.blocks[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }
}

/// The direction at a point (p, q) of [−1, 1]².
fn unmapped(p: f64, q: f64) -> DVec3 {
    let (x, y) = (0.5 * (p + q), 0.5 * (p - q));
    DVec3::new(x, y, (1.0 - x.abs() - y.abs()).max(0.0)).normalize()
}

fn candidates(directions: &[DVec3], counted: usize, side: usize, cell: usize) -> Vec<u32> {
    if directions.len() < counted {
        return (0..directions.len() as u32).collect();
    }
    let at = |column: f64, row: f64| {
        let unit = |k: f64| 2.0 * k / side as f64 - 1.0;
        unmapped(unit(column), unit(row))
    };
    let (column, row) = ((cell % side) as f64, (cell / side) as f64);
    let centre = at(column + 0.5, row + 0.5);
    let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
    // The margin covers single-precision cell numbers and angles.
    let radius = corners
        .map(|(i, j)| centre.angle_between(at(column + i, row + j)))
        .into_iter()
        .fold(0.0, f64::max)
        + 1e-4;
    let distances: Vec<f64> = directions
        .iter()
        .map(|d| centre.angle_between(*d))
        .collect();
    let mut sorted = distances.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let reach = REACH * (sorted[counted - 1] + radius) + radius;
    (0..directions.len() as u32)
        .filter(|&index| distances[index as usize] <= reach)
        .collect()
}

fn block(directions: &[DVec3], indices: &[u32]) -> DirectionLanes {
    let mut block = EMPTY;
    for (lane, &index) in indices.iter().enumerate() {
        let [x, y, z] = directions[index as usize].as_vec3().to_array();
        (block.x[lane], block.y[lane], block.z[lane]) = (x, y, z);
        block.index[lane] = index;
    }
    block
}
