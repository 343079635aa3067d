//! Tests of the whole method on small pictures: the band, turned patterns, masks.

use ndarray::{Array2, Array3};

use super::*;
use crate::exemplar::controls::Controls;
use crate::exemplar::neighbor_table::{NeighborTable, build};
use crate::exemplar::space::{Features, Space, SpaceLevel};
use crate::exemplar::{Channels, KnnOptions};
use crate::format::id::ContentId;
use crate::grid::TexCoord;
use crate::grid::TexelGrid;
use crate::sites::grid::GridSites;
use crate::sites::grid::window::SiteGrid;
use crate::sites::level::SiteHierarchy;
use crate::synthesis::all_levels::synthesize;
use crate::synthesis::check::neighborhoods;
use crate::synthesis::options::Method;

const GRID: TexelGrid = TexelGrid {
    width: 48,
    height: 24,
    tileable: false,
};

/// A picture of one number per texel, with its controls and table, two levels.
fn exemplar(picture: impl Fn(usize, usize) -> f32, controls: Controls) -> (Space, NeighborTable) {
    let sides = (GRID.height as usize, GRID.width as usize);
    let finest = Array3::from_shape_fn((sides.0, sides.1, 1), |(row, col, _)| picture(row, col));
    let coarse = Array3::from_shape_fn((sides.0 / 2, sides.1 / 2, 1), |(row, col, _)| {
        let of = |drow, dcol| finest[[2 * row + drow, 2 * col + dcol, 0]];
        (of(0, 0) + of(0, 1) + of(1, 0) + of(1, 1)) / 4.0
    });
    let above = controls.coarser(GRID);
    let varies = controls.transition.is_some();
    let space = Space {
        levels: [(GRID, finest), (GRID.coarser(), coarse)]
            .map(|(grid, numbers)| SpaceLevel {
                grid,
                features: Features::Plain(numbers),
            })
            .into(),
        channels: Channels::default(),
        controls: vec![controls, above],
        id: ContentId::of_bytes(b"space"),
        texel_mm: None,
        sample: ContentId::of_bytes(b"sample"),
    };
    let options = KnnOptions {
        k: 5,
        neighborhood: 5,
        transition_tolerance: varies.then_some(0.1),
        ..KnnOptions::default()
    };
    let table = build(&space, &options, Progress::silent()).unwrap();
    (space, table)
}

fn options() -> SynthesisOptions {
    let mut options = SynthesisOptions {
        method: Method::Progressive,
        ..SynthesisOptions::default()
    };
    options.progressive.mask_window = Widths::constant(7);
    options.progressive.color_window = Widths { first: 3, last: 5 };
    options.progressive.refine_window = 3;
    options
}

fn sites(space: &Space, table: &NeighborTable, side: u32) -> SiteHierarchy<GridSites> {
    let target = SiteGrid {
        width: side,
        height: side,
        toroidal: false,
    };
    let windows = neighborhoods(space, table, &options()).unwrap();
    target.hierarchy(&windows).unwrap()
}

fn run(inputs: Inputs<'_, GridSites>) -> LevelMap {
    synthesize(
        inputs,
        &options(),
        None,
        &mut |_| Ok(()),
        Progress::silent(),
    )
    .unwrap()
}

/// Stripes along t that grow wider to the right, with their transition and mask.
fn widening() -> (Space, NeighborTable) {
    let is_dark = |col: usize| {
        let place = (col as f32 / 6.0).powf(0.8) * 2.0;
        place.fract() < 0.5
    };
    let sides = (GRID.height as usize, GRID.width as usize);
    let controls = Controls {
        mask: Some(Array2::from_shape_fn(sides, |(_, col)| {
            u8::from(is_dark(col))
        })),
        transition: Some(Array2::from_shape_fn(sides, |(_, col)| col as f32 / 47.0)),
        orientation: None,
    };
    let picture =
        |row: usize, col: usize| f32::from(u8::from(is_dark(col))) + 0.01 * (row % 3) as f32;
    exemplar(picture, controls)
}

#[test]
fn every_site_holds_a_texel_of_its_band() {
    let (space, table) = widening();
    let sites = sites(&space, &table, 32);
    let controls = SiteControls {
        transition: (0..32 * 32)
            .map(|site| 0.1 + 0.8 * (site / 32) as f32 / 31.0)
            .collect(),
        mask: None,
    };
    let inputs = Inputs {
        space: &space,
        table: &table,
        sites: &sites,
        controls: Some(&controls),
    };
    let map = run(inputs);
    let values = space.controls[0].transition.as_ref().unwrap();
    for (site, at) in map.coords.iter().enumerate() {
        let (row, col) = GRID.row_col(GRID.texel_nearest(*at));
        let apart = values[[row as usize, col as usize]] - controls.transition[site];
        assert!(apart.abs() < 0.1, "{site}: {apart}");
    }
    // The same whatever the threads.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(3)
        .build()
        .unwrap();
    assert_eq!(pool.install(|| run(inputs)), map);
    // A surface that goes beyond the exemplar's band is refused.
    let beyond = SiteControls {
        transition: vec![1.2; 32 * 32],
        mask: None,
    };
    let inputs = Inputs {
        controls: Some(&beyond),
        ..inputs
    };
    let refused = synthesize(
        inputs,
        &options(),
        None,
        &mut |_| Ok(()),
        Progress::silent(),
    );
    let refused = refused.unwrap_err().to_string();
    assert!(
        refused.contains("1.2; expected less than 0.1 from"),
        "{refused}"
    );
}

#[test]
fn a_painted_mask_is_followed() {
    let (space, table) = widening();
    let sites = sites(&space, &table, 32);
    // As wide as the stripes are in the middle of the exemplar.
    let painted: Vec<u8> = (0..32 * 32)
        .map(|site| u8::from(site % 32 % 5 < 3))
        .collect();
    let controls = SiteControls {
        transition: vec![0.5; 32 * 32],
        mask: Some(painted.clone()),
    };
    let map = run(Inputs {
        space: &space,
        table: &table,
        sites: &sites,
        controls: Some(&controls),
    });
    let mask = space.controls[0].mask.as_ref().unwrap();
    let label = |at: &TexCoord| {
        let (row, col) = GRID.row_col(GRID.texel_nearest(*at));
        mask[[row as usize, col as usize]]
    };
    let pairs = map.coords.iter().zip(&painted);
    let same = pairs.filter(|(at, painted)| label(at) == **painted).count();
    assert!(same > 1000, "{same}");
}

#[test]
fn the_pattern_is_turned_to_the_exemplars_orientation() {
    // Stripes along t whose pattern has its x axis along t: on the sites they run along x.
    let sides = (GRID.height as usize, GRID.width as usize);
    let orientation = Array3::from_shape_fn((sides.0, sides.1, 2), |(_, _, axis)| axis as f32);
    let controls = Controls {
        orientation: Some(orientation),
        ..Controls::default()
    };
    let dark = |col: usize| f32::from(u8::from(col % 6 < 3));
    let (space, table) = exemplar(|row, col| dark(col) + 0.01 * (row % 3) as f32, controls);
    let sites = sites(&space, &table, 32);
    let map = run(Inputs {
        space: &space,
        table: &table,
        sites: &sites,
        controls: None,
    });
    let held = |row: usize, col: usize| dark(map.coords[32 * row + col].s as usize);
    let mut changes = [0, 0];
    for at in 0..31 * 31 {
        let (row, col) = (at / 31, at % 31);
        changes[0] += u32::from(held(row, col) != held(row, col + 1));
        changes[1] += u32::from(held(row, col) != held(row + 1, col));
    }
    assert!(changes[1] > 5 * changes[0], "{changes:?}");
}
