//! Neighbourhoods: where the samples round a texel or a site lie, and what they weigh. The one definition
//! of the square window, and of the texels whose windows lie on the grid.
//!
//! Offsets are whole texels (drow, dcol); positions are real, x along s and y along t, so that offset
//! (drow, dcol) lies at (dcol, −drow).

use glam::{DVec2, Vec2};

use crate::error::{Error, Result};
use crate::grid::TexelGrid;
use crate::index::TexelIndex;

/// The neighbourhood of a level of an exemplar.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Neighborhood {
    /// Samples on the level itself, (drow, dcol), centre included.
    pub offsets: Vec<[i32; 2]>,
    /// Their weights.
    pub weights: Vec<f32>,
    /// Samples on the parent level, round the parent texel; empty at the coarsest level.
    pub coarse_offsets: Vec<[i32; 2]>,
    /// Their weights.
    pub coarse_weights: Vec<f32>,
}

/// Positions of a neighbourhood's samples round its centre, in texels of their level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Template {
    /// One position per sample, in the order of the neighbourhood's offsets.
    pub positions: Vec<Vec2>,
    /// How many positions lie on each ring or inside it, the centre first; empty for a template that is
    /// not ordered by rings. The samples before `ring_ends[m]` are the neighbourhood of m rings.
    pub ring_ends: Vec<usize>,
}

/// The square window of odd `width`, row by row from the top left, centre included.
pub fn square_window(width: u32) -> Vec<[i32; 2]> {
    square_offsets(width).collect()
}

fn square_offsets(width: u32) -> impl Iterator<Item = [i32; 2]> {
    let first = -i64::from(width / 2);
    let along = move || (first..first + i64::from(width)).map(|step| step as i32);
    along().flat_map(move |drow| along().map(move |dcol| [drow, dcol]))
}

/// The full width of a window: twice its reach and the centre.
pub fn window_width(offsets: &[[i32; 2]]) -> u32 {
    let reach = offsets.iter().flatten().map(|offset| offset.unsigned_abs());
    reach.max().unwrap_or(0).saturating_mul(2).saturating_add(1)
}

/// How many levels there are, and the widths of the finest's square windows on the level itself and on its parent.
pub fn level_widths(neighborhoods: &[Neighborhood]) -> (u32, [u32; 2]) {
    let widths = |of: &Neighborhood| [&of.offsets, &of.coarse_offsets].map(|all| window_width(all));
    let finest = neighborhoods.first().map_or([1; 2], widths);
    (neighborhoods.len() as u32, finest)
}

/// Refuses numbers of levels that sites are not prepared for.
pub fn check_level_count(levels: usize) -> Result<()> {
    match levels {
        1..=12 => Ok(()),
        _ => Err(Error::option("levels", levels.to_string(), "1 to 12")),
    }
}

/// Refuses numbers of levels and widths that sites are not prepared for.
pub fn check_level_widths(levels: u32, [own, coarse]: [u32; 2]) -> Result<()> {
    check_level_count(levels as usize)?;
    for (name, width) in [("neighborhood", own), ("coarse-neighborhood", coarse)] {
        if width % 2 == 0 || width > 63 {
            let expected = "an odd width, 1 to 63";
            return Err(Error::option(name, width.to_string(), expected));
        }
    }
    Ok(())
}

/// Whether every offset of a texel leads to a texel of the grid.
pub fn is_on_grid(grid: TexelGrid, texel: TexelIndex, offsets: &[[i32; 2]]) -> bool {
    let on_grid = |&[drow, dcol]: &[i32; 2]| grid.offset(texel, drow, dcol).is_some();
    offsets.iter().all(on_grid)
}

impl Template {
    /// The square window of odd `width`, in the order of [`square_window`].
    pub fn square(width: u32) -> Self {
        let position = |[drow, dcol]: [i32; 2]| Vec2::new(dcol as f32, -drow as f32);
        Self {
            positions: square_window(width).into_iter().map(position).collect(),
            ..Self::default()
        }
    }

    /// The round neighbourhood (Chen 2008 §4.2): where circles of radius 1 to `rings` meet the lines x = i
    /// and y = j of the unit grid through the centre. The centre comes first, then ring by ring,
    /// counter-clockwise from +x.
    pub fn round(rings: u32) -> Self {
        let mut template = Self {
            positions: vec![Vec2::ZERO],
            ring_ends: vec![1],
        };
        for radius in 1..=i64::from(rings) {
            let mut ring = grid_crossings(radius);
            ring.sort_by(|a, b| turn_of(*a).total_cmp(&turn_of(*b)));
            template.positions.extend(ring.iter().map(|p| p.as_vec2()));
            template.ring_ends.push(template.positions.len());
        }
        template
    }
}

/// Where the circle of a whole radius meets the lines of the unit grid, each point once.
fn grid_crossings(radius: i64) -> Vec<DVec2> {
    let mut points = Vec::new();
    for line in -radius..=radius {
        let squared = radius * radius - line * line;
        let (at, across) = (line as f64, (squared as f64).sqrt());
        let ends = if squared == 0 {
            vec![0.0]
        } else {
            vec![across, -across]
        };
        points.extend(ends.iter().map(|&end| DVec2::new(at, end)));
        // A point on two lines is listed once, with the lines x = i.
        if across.fract() != 0.0 {
            points.extend(ends.iter().map(|&end| DVec2::new(end, at)));
        }
    }
    points
}

/// The angle of a point from +x, counter-clockwise, in turns from 0 up to 1.
pub fn turn_of(point: DVec2) -> f64 {
    let turn = point.y.atan2(point.x) / std::f64::consts::TAU;
    // A turn of −10⁻¹⁷ and one make 1 in floating point.
    turn.rem_euclid(1.0) % 1.0
}

impl Neighborhood {
    /// Square windows of odd widths, every sample of weight 1; `coarse` is the parent level's, 0 for none.
    pub fn square(fine: u32, coarse: u32) -> Self {
        let (offsets, coarse_offsets) = (square_window(fine), square_window(coarse));
        Self {
            weights: vec![1.0; offsets.len()],
            coarse_weights: vec![1.0; coarse_offsets.len()],
            offsets,
            coarse_offsets,
        }
    }

    /// Whether every sample of a texel's windows lies on the grid and on its parent's.
    pub fn fits(&self, grid: TexelGrid, texel: TexelIndex) -> bool {
        let coarse = &self.coarse_offsets;
        is_on_grid(grid, texel, &self.offsets)
            && (coarse.is_empty() || is_on_grid(grid.coarser(), grid.parent(texel), coarse))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OFFSETS: [[i32; 2]; 4] = [[0, 0], [-2, 1], [1, -2], [2, 2]];

    #[test]
    fn the_square_window_reads_like_an_image() {
        let template = Template::square(3);
        assert_eq!(template.positions[0], Vec2::new(-1.0, 1.0));
        assert_eq!(template.positions[4], Vec2::ZERO);
        assert_eq!(template.positions[5], Vec2::new(1.0, 0.0));
        assert_eq!(square_window(3)[5], [0, 1]);
        assert_eq!(
            (square_window(0).len(), window_width(&square_window(7))),
            (0, 7)
        );
        assert_eq!(window_width(&[[i32::MIN, 0]]), u32::MAX);
    }

    #[test]
    fn wide_windows_have_more_offsets_than_32_bits_count() {
        for width in [70_001, u32::MAX] {
            let half = (width / 2) as i32;
            let first: Vec<_> = square_offsets(width).take(2).collect();
            assert_eq!(first, [[-half, -half], [-half, 1 - half]]);
        }
    }

    #[test]
    fn rings_of_the_round_template_are_prefixes_and_lie_on_the_grid() {
        let template = Template::round(5);
        // 8m − 4 points on ring m; the eight points (±3, ±4) and (±4, ±3) lie on two lines each.
        assert_eq!(template.ring_ends, [1, 5, 17, 37, 65, 93]);
        assert_eq!(Template::round(3).positions, template.positions[..37]);
        for ring in 1..=5 {
            let of_ring =
                &template.positions[template.ring_ends[ring - 1]..template.ring_ends[ring]];
            assert_eq!(of_ring[0], Vec2::new(ring as f32, 0.0));
            let turns: Vec<f64> = of_ring.iter().map(|p| turn_of(p.as_dvec2())).collect();
            assert!(turns.windows(2).all(|pair| pair[1] - pair[0] > 1e-3));
            for p in of_ring {
                assert!((p.length() - ring as f32).abs() < 1e-5);
                assert!(p.x.fract() == 0.0 || p.y.fract() == 0.0, "{p}");
            }
        }
    }

    #[test]
    fn wholeness_ends_at_the_border() {
        let mut grid = TexelGrid {
            width: 5,
            height: 5,
            tileable: false,
        };
        let whole =
            |grid, row: u32, col: u32| is_on_grid(grid, TexelIndex(row * 5 + col), &OFFSETS);
        assert!(
            whole(grid, 2, 2) && !whole(grid, 1, 2) && !whole(grid, 2, 1) && !whole(grid, 3, 3)
        );
        grid.tileable = true;
        assert!(whole(grid, 0, 0));
    }
}
