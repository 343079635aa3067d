//! One layer of a tree: groups of children, each with a box and its least used point. The points of a leaf and the
//! children of a group are at most [`LANES`], and compared side by side.

use crate::lanes::{LANES, LaneBlock, least_of_lanes};

/// A count, and the smallest number of a point that has it.
pub type Least = (u32, u32);
/// What a child without points has.
pub const NOTHING: Least = (u32::MAX, u32::MAX);
/// Directions after which a sum is looked at.
pub const PART: usize = 8;

/// The lower and the upper corner in one direction, per child.
type Extent = [LaneBlock; 2];
/// The extent of children without points.
const EMPTY: Extent = [[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]];

/// The children of all groups: child c of group g is number LANES · g + c of the layer below, or of the leaves.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Per group its extents, direction after direction.
    extents: Vec<Extent>,
    /// Per child the least used of its points.
    least: Vec<Least>,
    dimensions: usize,
}

impl Layer {
    /// A layer of this many children, none of which has a point yet.
    pub fn new(children: usize, dimensions: usize) -> Self {
        let groups = children.div_ceil(LANES);
        Self {
            extents: vec![EMPTY; groups * dimensions],
            least: vec![NOTHING; groups * LANES],
            dimensions,
        }
    }

    /// The layer whose children are the groups of another.
    pub fn above(below: &Self) -> Self {
        let groups = below.groups();
        let mut layer = Self::new(groups, below.dimensions);
        for group in 0..groups {
            for (direction, [low, high]) in below.extents_of(group).iter().enumerate() {
                let low = low.iter().copied().fold(f32::INFINITY, f32::min);
                let high = high.iter().copied().fold(f32::NEG_INFINITY, f32::max);
                layer.extend(group, direction, [low, high]);
            }
        }
        layer
    }

    /// Groups in all.
    pub fn groups(&self) -> usize {
        self.least.len() / LANES
    }

    /// Extends the box of a child in one direction.
    pub fn extend(&mut self, child: usize, direction: usize, [low, high]: [f32; 2]) {
        let (group, lane) = (child / LANES, child % LANES);
        let [lows, highs] = &mut self.extents[group * self.dimensions + direction];
        lows[lane] = lows[lane].min(low);
        highs[lane] = highs[lane].max(high);
    }

    /// Sets the least used point of a child; says which its group has then.
    pub fn set_least(&mut self, child: usize, least: Least) -> Least {
        self.least[child] = least;
        self.least_of_group(child / LANES)
    }

    /// The least used point of a group.
    pub fn least_of_group(&self, group: usize) -> Least {
        let least = self.least_of_children(group).iter().min();
        least.copied().unwrap_or(NOTHING)
    }

    /// The least used points of the children of a group.
    #[inline(always)]
    pub fn least_of_children(&self, group: usize) -> &[Least; LANES] {
        &self.least.as_chunks().0[group]
    }

    #[inline(always)]
    fn extents_of(&self, group: usize) -> &[Extent] {
        &self.extents[group * self.dimensions..][..self.dimensions]
    }

    /// The squared distances of a query to the boxes of a group's children, or to less of them once all are above
    /// `limit`. Rounding is monotone and directions are added in the order of [`add_squares`], so they never are above
    /// the distances of points in the boxes.
    #[inline(always)]
    pub fn square_distances(&self, query: &[f32], group: usize, limit: f32) -> LaneBlock {
        let mut sums = [0.0; LANES];
        let extents = self.extents_of(group).chunks(PART);
        for (query, extents) in query.chunks(PART).zip(extents) {
            for (own, [low, high]) in query.iter().zip(extents) {
                for lane in 0..LANES {
                    let (below, above) = (low[lane] - own, own - high[lane]);
                    let beyond = if below > above { below } else { above };
                    let beyond = if beyond > 0.0 { beyond } else { 0.0 };
                    sums[lane] += beyond * beyond;
                }
            }
            if least_of_lanes(sums) > limit {
                break;
            }
        }
        sums
    }
}

/// Adds the squares of the distances of a query to points, one per lane, in some directions.
#[inline(always)]
pub fn add_squares(query: &[f32], points: &[LaneBlock], sums: &mut LaneBlock) {
    for (own, numbers) in query.iter().zip(points) {
        for lane in 0..LANES {
            let apart = own - numbers[lane];
            sums[lane] += apart * apart;
        }
    }
}
