//! Tests of spaces: the default texton, files, parts that do not belong together.

use ndarray::Array3;

use super::*;

fn space() -> Space {
    let grid = TexelGrid {
        width: 4,
        height: 2,
        tileable: true,
    };
    let products = Array2::from_shape_fn((3, 3), |(i, j)| ((i + 1) * (j + 1)) as f64);
    Space {
        levels: vec![SpaceLevel {
            grid,
            features: Features::Textons {
                labels: vec![0, 1, 2, 0, 1, 2, 0, 1],
                gram: with_default_texton(&products),
            },
        }],
        channels: Channels::default(),
        controls: Vec::new(),
        id: ContentId::of_bytes(&[]),
        texel_mm: None,
        sample: ContentId::of_bytes(b"sample"),
    }
}

#[test]
fn the_default_texton_is_the_mean() {
    let Features::Textons { gram, .. } = &space().levels[0].features else {
        unreachable!()
    };
    // Textons 1, 2, 3 on a line: the mean is 2.
    assert_eq!(gram.row(3).to_vec(), [2.0, 4.0, 6.0, 4.0]);
}

#[test]
fn spaces_of_both_kinds_round_trip() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.space.npz");
    let mut textons = space();
    textons
        .write(&path, Some(&ContentId::of_bytes(b"t")))
        .unwrap();
    assert_eq!(Space::read(&path).unwrap(), textons);
    let level = SpaceLevel {
        grid: TexelGrid {
            width: 2,
            height: 3,
            tileable: false,
        },
        features: Features::Plain(Array3::from_elem((3, 2, 3), 0.25)),
    };
    let color = channels::implied(std::slice::from_ref(&level));
    let mut features = Space::of_channels(vec![level], color, Vec::new(), textons.sample).unwrap();
    features.write(&path, None).unwrap();
    assert_eq!(Space::read(&path).unwrap(), features);
    assert_eq!(features.levels[0].default_feature(), [0.25; 3]);
}

#[test]
fn parts_that_do_not_belong_together_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.space.npz");
    let refused = |edit: &dyn Fn(&mut Vec<u16>, &mut Array2<f32>)| {
        let mut space = space();
        let Features::Textons { labels, gram } = &mut space.levels[0].features else {
            unreachable!()
        };
        edit(labels, gram);
        space.write(&path, None).unwrap();
        Space::read(&path).unwrap_err().to_string()
    };
    assert!(refused(&|labels, _| labels[3] = 3).contains("label 3"));
    assert!(refused(&|_, gram| gram[[1, 2]] = f32::NAN).contains("NaN at [1, 2]"));
    assert!(refused(&|_, gram| gram[[0, 2]] = 99.0).contains("[0, 2]"));
    assert!(refused(&|_, gram| *gram = Array2::zeros((1, 1))).contains("square"));
}
