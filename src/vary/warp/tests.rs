//! Warps of rectangles and discs, whose outcome is known.

use super::*;

fn warp(text: &str, mask: &Array2<u8>, transition: &Array2<f32>) -> Array2<u8> {
    text.parse::<Warp>()
        .unwrap()
        .apply(mask, transition)
        .unwrap()
}

/// Stripes of 8 of 16 columns.
fn stripes() -> Array2<u8> {
    Array2::from_shape_fn((6, 64), |(_, col)| u8::from((4..12).contains(&(col % 16))))
}

fn widths(mask: &Array2<u8>) -> Vec<usize> {
    let row: Vec<u8> = mask.row(2).to_vec();
    let runs = row.split(|&label| label == 0).map(<[u8]>::len);
    runs.filter(|&length| length > 0).collect()
}

#[test]
fn a_stripe_is_half_as_wide_where_the_transition_says_so() {
    let mask = stripes();
    let halves = Array2::from_shape_fn((6, 64), |(_, col)| if col < 32 { 0.0 } else { 1.0 });
    let found = warp("scale:by=0.5,along=horizontal", &mask, &halves);
    assert_eq!(widths(&found), [8, 8, 4, 4]);
    let found = warp("scale:by=1.5,along=horizontal", &mask, &halves);
    assert_eq!(widths(&found), [8, 8, 12, 12]);
    // Up and down the stripes go from border to border.
    assert_eq!(warp("scale:by=0.5,along=vertical", &mask, &halves), mask);
    let none = warp("scale:by=0,along=horizontal", &mask, &halves);
    assert_eq!(widths(&none), [8, 8]);
    let eroded = warp("erode:by=1,along=horizontal", &mask, &halves);
    assert_eq!(widths(&eroded), [8, 8, 6, 6]);
    let grown = warp("dilate:by=2,along=horizontal", &mask, &halves);
    assert_eq!(widths(&grown), [8, 8, 12, 12]);
}

#[test]
fn the_labels_of_a_feature_are_scaled_together() {
    let line = [0, 0, 0, 0, 1, 1, 2, 2, 2, 2, 1, 1, 3, 3, 3, 3];
    let mask = Array2::from_shape_fn((3, 16), |(_, col)| line[col]);
    let all = Array2::from_elem((3, 16), 1.0);
    let found = warp("scale:by=0.5,along=horizontal,labels=1+2", &mask, &all);
    let expected = [0, 0, 0, 0, 0, 0, 1, 2, 2, 1, 3, 3, 3, 3, 3, 3];
    assert_eq!(found.row(1).to_vec(), expected);
}

fn disc(centre: [f64; 2], radius: f64) -> Array2<u8> {
    Array2::from_shape_fn((48, 48), |(row, col)| {
        u8::from((row as f64 - centre[0]).hypot(col as f64 - centre[1]) <= radius)
    })
}

fn area(mask: &Array2<u8>) -> f64 {
    mask.iter().map(|&label| f64::from(label)).sum()
}

#[test]
fn features_are_scaled_about_their_centres_in_three_ways() {
    let (mask, all) = (disc([24.0, 22.0], 12.0), Array2::from_elem((48, 48), 1.0));
    for follow in ["radial", "mesh", "field"] {
        let found = warp(&format!("{follow}:scale=0.5"), &mask, &all);
        let share = area(&found) / area(&mask);
        assert!((share - 0.25).abs() < 0.06, "{follow} {share}");
        let features = MaskFeatures::of(&found, LabelSet::FEATURES);
        assert_eq!(features.list.len(), 1, "{follow}");
        let [row, col] = features.list[0].centre;
        assert!(
            (row - 24.0).abs() < 0.7 && (col - 22.0).abs() < 0.7,
            "{follow}"
        );
    }
}

#[test]
fn features_move_right_and_up() {
    let (mask, all) = (disc([24.0, 22.0], 6.0), Array2::from_elem((48, 48), 1.0));
    for follow in ["radial", "mesh", "field"] {
        let found = warp(&format!("{follow}:right=8,up=5"), &mask, &all);
        assert_eq!(found, disc([19.0, 30.0], 6.0), "{follow}");
    }
}

#[test]
fn nothing_moves_where_the_transition_is_0() {
    let (mask, none) = (disc([24.0, 22.0], 9.0), Array2::zeros((48, 48)));
    for text in [
        "scale:by=0.3",
        "erode:by=4",
        "dilate:by=4",
        "radial:scale=0.5",
        "mesh:turn=40",
        "field:up=9",
    ] {
        assert_eq!(warp(text, &mask, &none), mask, "{text}");
    }
}

#[test]
fn a_quarter_turn_lays_a_bar_down() {
    let bar = |rows: std::ops::Range<usize>, cols: std::ops::Range<usize>| {
        Array2::from_shape_fn((41, 41), |(row, col)| {
            u8::from(rows.contains(&row) && cols.contains(&col))
        })
    };
    let (upright, all) = (bar(10..31, 18..23), Array2::from_elem((41, 41), 1.0));
    for follow in ["mesh", "field"] {
        let found = warp(&format!("{follow}:turn=90"), &upright, &all);
        assert_eq!(found, bar(18..23, 10..31), "{follow}");
    }
}

#[test]
fn warps_that_cannot_be_are_refused() {
    let said = |text: &str| text.parse::<Warp>().unwrap_err();
    assert!(said("shrink:by=1").contains("scale, dilate, erode, radial, mesh or field"));
    assert!(said("scale").contains("by=NUMBER, 0 to 16"));
    assert!(said("scale:by=-1").contains("`by=-1`"));
    assert!(said("scale:by=nan").contains("`by=nan`"));
    assert!(said("scale:by=1,along=up").contains("horizontal"));
    assert!(said("erode:by=1,turn=3").contains("`turn`"));
    assert!(said("radial:labels=1").contains("a motion"));
    let empty = Array2::zeros((9, 9));
    let refused = "mesh:turn=9"
        .parse::<Warp>()
        .unwrap()
        .apply(&empty, &Array2::zeros((9, 9)));
    assert!(
        refused
            .unwrap_err()
            .to_string()
            .contains("no pixel of label 1+2+3")
    );
    let full = Array2::ones((9, 9));
    let refused = "mesh:turn=9"
        .parse::<Warp>()
        .unwrap()
        .apply(&full, &Array2::zeros((9, 9)));
    assert!(refused.unwrap_err().to_string().contains("every pixel"));
}
