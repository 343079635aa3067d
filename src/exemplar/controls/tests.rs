//! Tests of controls: coarser levels, files, refusals.

use super::*;
use crate::exemplar::channels::Channels;
use crate::exemplar::space::Space;
use crate::exemplar::space::{Features, SpaceLevel};
use crate::format::id::ContentId;
use ndarray::array;

const GRID: TexelGrid = TexelGrid {
    width: 3,
    height: 2,
    tileable: false,
};

fn controls() -> Controls {
    Controls {
        mask: Some(array![[1, 2, 3], [2, 1, 0]]),
        transition: Some(array![[0.0, 0.5, 1.0], [0.25, 0.25, 0.5]]),
        orientation: Some(array![
            [[0.0, 1.0], [1.0, 0.0], [0.6, 0.8]],
            [[0.0, 1.0], [1.0, 0.0], [-0.6, -0.8]]
        ]),
    }
}

#[test]
fn coarser_levels_keep_what_most_texels_say() {
    let coarse = controls().coarser(GRID);
    // Two each: the label of the smallest flat index; so in the lone last column.
    assert_eq!(coarse.mask, Some(array![[1, 3]]));
    assert_eq!(coarse.transition, Some(array![[0.25, 0.75]]));
    let orientation = coarse.orientation.unwrap();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert!((orientation[[0, 0, 0]] - half).abs() < 1e-6);
    assert!((orientation[[0, 0, 1]] - half).abs() < 1e-6);
    // Opposite directions cancel: the first one stays.
    assert_eq!([orientation[[0, 1, 0]], orientation[[0, 1, 1]]], [0.6, 0.8]);
    assert_eq!(commonest(&[3, 0, 0, 1]), 0);
}

#[test]
fn levels_of_a_pyramid_pass_their_own_check() {
    let all = controls().pyramid(GRID, 3).unwrap();
    assert_eq!(all.len(), 3);
    assert!(all[1].check(GRID.coarser()).is_ok());
    assert!(all[2].check(GRID.coarser().coarser()).is_ok());
    assert!(Controls::default().pyramid(GRID, 3).unwrap().is_empty());
}

fn space(levels: Vec<Controls>) -> Space {
    let mut grid = GRID;
    let mut made = Vec::new();
    for _ in 0..levels.len() {
        let sides = (grid.height as usize, grid.width as usize, 4);
        let features = Features::Plain(Array3::from_elem(sides, 0.5));
        made.push(SpaceLevel { grid, features });
        grid = grid.coarser();
    }
    Space {
        levels: made,
        channels: Channels::default(),
        controls: levels,
        id: ContentId::of_bytes(b""),
        texel_mm: None,
        sample: ContentId::of_bytes(b"sample"),
    }
}

#[test]
fn controls_round_trip() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.space.npz");
    let mut all = space(controls().pyramid(GRID, 2).unwrap());
    all.write(&path, None).unwrap();
    assert_eq!(Space::read(&path).unwrap(), all);
    let mut one = space(
        Controls {
            transition: controls().transition,
            ..Controls::default()
        }
        .pyramid(GRID, 2)
        .unwrap(),
    );
    one.write(&path, None).unwrap();
    let read = Space::read(&path).unwrap();
    assert_eq!(read, one);
    let message = |kind| {
        let refused = read.required_control(0, kind, "method `progressive`");
        refused.unwrap_err().to_string()
    };
    let mask = message(ControlKind::Mask);
    assert!(
        mask.contains("controls: transition; expected mask, which method `progressive` needs"),
        "{mask}"
    );
    assert!(message(ControlKind::Orientation).contains("--orientation-map FILE"));
    assert!(
        read.required_control(1, ControlKind::Transition, "it")
            .is_ok()
    );
}

#[test]
fn controls_that_do_not_hold_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.space.npz");
    let refused = |edit: &dyn Fn(&mut [Controls])| {
        let mut levels = controls().pyramid(GRID, 2).unwrap();
        edit(&mut levels);
        space(levels).write(&path, None).unwrap();
        Space::read(&path).unwrap_err().to_string()
    };
    let said = refused(&|all| all[0].mask.as_mut().unwrap()[[1, 2]] = 4);
    assert!(
        said.contains("L0: mask, row 1, column 2: label 4; expected 0 to 3"),
        "{said}"
    );
    let said = refused(&|all| all[1].transition.as_mut().unwrap()[[0, 1]] = f32::NAN);
    assert!(
        said.contains("L1: transition, row 0, column 1: NaN"),
        "{said}"
    );
    let said = refused(&|all| all[0].transition.as_mut().unwrap()[[0, 1]] = 1.5);
    assert!(said.contains("1.5; expected 0 to 1"), "{said}");
    let said = refused(&|all| all[0].orientation.as_mut().unwrap()[[1, 1, 0]] = 0.5);
    assert!(
        said.contains("row 1, column 1: (0.5, 0); expected a vector of length 1"),
        "{said}"
    );
    let said = refused(&|all| all[1].mask = None);
    assert!(
        said.contains("L1/mask: missing") && said.contains("L0/mask"),
        "{said}"
    );
    let said = refused(&|all| all[0].mask = None);
    assert!(
        said.contains("L1/mask: there") && said.contains("L0/mask is missing"),
        "{said}"
    );
    let said = refused(&|all| all[0].mask = Some(Array2::zeros((2, 2))));
    assert!(said.contains("shape [2, 2]; expected [2, 3]"), "{said}");
    let said = refused(&|all| all[0].orientation = Some(Array3::zeros((2, 3, 3))));
    assert!(said.contains("[2, 3, 2]"), "{said}");
}
