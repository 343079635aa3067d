//! Reads against closed forms: planes at any height, a wall, patches of made maps.

use glam::{DVec3, Vec3};

use crate::btf::HeightMap;
use crate::btf::direction::Direction;
use crate::format::id::ContentId;
use crate::grid::{TexCoord, TexelGrid};
use crate::index::{TexelIndex, TextonLabel};
use crate::maps::MapHeader;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::shapes;
use crate::render::nearest::Weight;
use crate::render::parallax::{PatchReach, Place, Read, ReadList, Relief};

const GRID: TexelGrid = TexelGrid {
    width: 16,
    height: 8,
    tileable: true,
};

/// A view whose image moves a point by (x, y) texels per texel of height.
fn view(x: f64, y: f64) -> Direction {
    Direction(DVec3::new(x, y, 1.0).normalize())
}

fn relief(height: impl Fn(u32, u32) -> f32, views: &[Direction]) -> Relief {
    let texels = (0..GRID.height).flat_map(|row| (0..GRID.width).map(move |col| (row, col)));
    let heights = texels.map(|(row, col)| height(row, col)).collect();
    Relief::new(&HeightMap::new(GRID, heights).unwrap(), views, 1)
}

fn found(
    relief: &Relief,
    (row, col): (u32, u32),
    wanted: Direction,
    reach: f32,
    weights: &[f32],
) -> (Vec<Read>, Vec<Weight>) {
    let weights: Vec<Weight> = (0..)
        .zip(weights)
        .map(|(index, &weight)| Weight { index, weight })
        .collect();
    let place = Place {
        coord: GRID.centre(GRID.texel(row, col)),
        level: 0,
        view: wanted.0.as_vec3(),
        reach,
    };
    let mut list = ReadList::default();
    list.find(relief, &place, &weights);
    (list.reads().to_vec(), list.plain().to_vec())
}

fn sum(reads: &[Read], view: Option<u32>) -> f32 {
    let of_view = |read: &&Read| view.is_none_or(|view| read.view == view);
    reads.iter().filter(of_view).map(|read| read.share).sum()
}

#[test]
fn on_the_plane_every_image_is_read_at_the_texel_itself() {
    let views = [view(0.0, 0.0), view(1.0, 0.5), view(-2.0, 0.1)];
    let flat = relief(|_, _| 0.0, &views);
    let (reads, plain) = found(
        &flat,
        (3, 5),
        view(0.7, -0.3),
        f32::INFINITY,
        &[0.5, 0.2, 0.3],
    );
    assert!(plain.is_empty());
    let texel = GRID.texel(3, 5);
    for (read, (view, share)) in reads.iter().zip([(0, 0.5), (1, 0.2), (2, 0.3)]) {
        assert_eq!((read.view, read.texel), (view, texel));
        assert!((read.share - share).abs() < 1e-5);
    }
    assert_eq!(reads.len(), 3);
}

#[test]
fn a_raised_plane_is_read_where_each_view_shows_its_point() {
    // Over z = 2 the wanted view (½, 0) looks at a point one texel to the right; the view (−1, 1) shows it at 1 + 2
    // texels to the right and 2 down, the view from above where it is. Far rows and columns wrap.
    let views = [view(0.0, 0.0), view(-1.0, 1.0)];
    let raised = relief(|_, _| 2.0, &views);
    let (reads, _) = found(
        &raised,
        (7, 14),
        view(0.5, 0.0),
        f32::INFINITY,
        &[0.25, 0.75],
    );
    let strongest = |view| {
        let of_view = reads.iter().filter(|read| read.view == view);
        *of_view.max_by(|a, b| a.share.total_cmp(&b.share)).unwrap()
    };
    assert_eq!(strongest(0).texel, GRID.texel(7, 15));
    assert_eq!(strongest(1).texel, GRID.texel(1, 1));
    assert!((strongest(0).share - 0.25).abs() < 1e-3 && (strongest(1).share - 0.75).abs() < 1e-3);
}

/// High ground on the left half, low ground on the right, 4 texels apart.
fn wall(_: u32, col: u32) -> f32 {
    if col < 8 { 2.0 } else { -2.0 }
}

#[test]
fn a_view_that_does_not_see_the_point_is_left_out_for_those_that_do() {
    // The low ground beside the wall, as seen from the right: a view from the left sees the wall's top before it.
    let views = [view(1.0, 0.0), view(0.0, 0.0), view(-1.5, 0.0)];
    let walls = relief(wall, &views);
    let wanted = view(0.5, 0.0);
    // It shows the ground of column 10, for −2 · ½ = −1.
    let (reads, plain) = found(&walls, (4, 11), wanted, f32::INFINITY, &[0.4, 0.4, 0.2]);
    assert!(plain.is_empty());
    assert_eq!(sum(&reads, Some(2)), 0.0);
    assert!((sum(&reads, None) - 1.0).abs() < 1e-5);
    assert!((sum(&reads, Some(0)) - 0.5).abs() < 1e-3, "{reads:?}");
    // Seen from above at column 10, from (1, 0) at 10 + 2.
    assert!(
        reads
            .iter()
            .any(|read| read.texel == GRID.texel(4, 10) && read.view == 1)
    );
    assert!(
        reads
            .iter()
            .any(|read| read.texel == GRID.texel(4, 12) && read.view == 0)
    );
    // Negative weights keep the sum too.
    let (reads, _) = found(&walls, (4, 11), wanted, f32::INFINITY, &[0.9, 0.4, -0.3]);
    assert!((sum(&reads, None) - 1.0).abs() < 1e-5);
    assert!(reads.iter().all(|read| read.share.abs() <= 1.0));
}

#[test]
fn what_no_view_sees_is_blended_plainly() {
    let views = [view(-1.5, 0.0), view(-1.4, 0.2)];
    let walls = relief(wall, &views);
    let (reads, plain) = found(&walls, (4, 11), view(0.5, 0.0), f32::INFINITY, &[0.5, 0.5]);
    assert!(sum(&reads, None).abs() < 1e-3, "{reads:?}");
    let left: f32 = plain.iter().map(|weight| weight.weight).sum();
    assert!((left - 1.0).abs() < 1e-3);
}

#[test]
fn beyond_the_reach_blending_is_plain() {
    let views = [view(0.0, 0.0), view(-1.0, 0.0)];
    let raised = relief(|_, _| 2.0, &views);
    let at = |reach| found(&raised, (4, 4), view(0.0, 0.0), reach, &[0.5, 0.5]);
    let (reads, plain) = at(0.0);
    assert!(reads.is_empty());
    assert_eq!(plain.len(), 2);
    // The first view is not moved; the second by 2 texels, of which a reach of 2½ lets half.
    let (reads, plain) = at(2.5);
    assert!((sum(&reads, Some(0)) - 0.5).abs() < 1e-5);
    assert!((sum(&reads, Some(1)) - 0.25).abs() < 1e-3);
    assert_eq!(plain.len(), 1);
    assert!((plain[0].weight - 0.25).abs() < 1e-3 && plain[0].index == 1);
}

#[test]
fn off_a_sample_that_does_not_tile_nothing_is_read() {
    let grid = TexelGrid {
        tileable: false,
        ..GRID
    };
    let views = [view(0.0, 0.0), view(2.0, 0.0)];
    let heights = HeightMap::new(grid, vec![1.0; grid.len()]).unwrap();
    let raised = Relief::new(&heights, &views, 1);
    // Two texels beyond the left border.
    let (reads, _) = found(&raised, (4, 0), view(0.0, 0.0), f32::INFINITY, &[0.5, 0.5]);
    assert!((sum(&reads, Some(0)) - 1.0).abs() < 1e-5, "{reads:?}");
}

/// A flat square whose right part shows another place of the sample.
fn cut_map(cells: u32, cut: u32) -> SurfaceTextonMap {
    let mesh = shapes::grid(cells, cells, 1.0);
    let coord = |p: &Vec3| {
        let moved = if p.x > cut as f32 - 0.5 { 5.0 } else { 0.0 };
        TexCoord {
            s: (p.x + 0.5 + moved).rem_euclid(16.0),
            t: (p.y + 0.5).rem_euclid(16.0),
        }
    };
    let count = mesh.positions.len();
    SurfaceTextonMap {
        coords: mesh.positions.iter().map(coord).collect(),
        normals: vec![Vec3::Z; count],
        orientations: vec![Vec3::X; count],
        scale: None,
        textons: vec![TextonLabel(0); count],
        transition: None,
        mask: None,
        mesh,
        header: MapHeader {
            exemplar: [16, 16],
            texel: 1.0,
            origin: DVec3::ZERO,
            seed: 0,
            method: "k-coherence".into(),
            polish: 0,
            sample: ContentId::of_bytes(b""),
            space: ContentId::of_bytes(b""),
        },
    }
}

#[test]
fn patches_reach_to_the_next_cut() {
    let whole = PatchReach::of_map(&cut_map(12, 100));
    assert!((0..13 * 13).all(|vertex| whole.of(vertex) == f32::INFINITY));
    let map = cut_map(12, 6);
    let cut = PatchReach::of_map(&map);
    for (vertex, place) in map.mesh.positions.iter().enumerate() {
        // Columns 5 and 6 lie on either side of the cut; rows at the square's own border have fewer neighbours.
        let column = place.x;
        if !(3.0..=9.0).contains(&place.y) {
            continue;
        }
        let wanted = if column < 6.0 {
            5.0 - column
        } else {
            column - 6.0
        };
        assert!(
            (cut.of(vertex) - wanted).abs() < 1e-3,
            "{place}: {}",
            cut.of(vertex)
        );
    }
}

#[test]
fn the_texel_index_of_reads_is_that_of_their_level() {
    let views = [view(0.0, 0.0), view(1.0, 0.0)];
    let heights = HeightMap::new(GRID, vec![0.0; GRID.len()]).unwrap();
    let relief = Relief::new(&heights, &views, 3);
    let place = Place {
        coord: TexCoord { s: 6.0, t: 4.0 },
        level: 1,
        view: Vec3::Z,
        reach: f32::INFINITY,
    };
    let mut list = ReadList::default();
    let weight = Weight {
        index: 1,
        weight: 1.0,
    };
    list.find(&relief, &place, &[weight]);
    // Between columns 2 and 3, and rows 1 and 2, of 8 × 4 texels.
    let texels: Vec<TexelIndex> = list.reads().iter().map(|read| read.texel).collect();
    assert_eq!(texels, [10, 11, 18, 19].map(TexelIndex));
    assert!(
        list.reads()
            .iter()
            .all(|read| (read.share - 0.25).abs() < 1e-5)
    );
}
