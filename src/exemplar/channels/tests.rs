//! Tests of channels: files with and without them, weights, refusals.

use std::path::Path;

use super::*;
use crate::exemplar::space::Space;
use crate::format::id::ContentId;
use crate::format::npz;
use crate::grid::TexelGrid;
use serde_json::{Value, json};

fn channel(name: &str, kind: ChannelKind, first: u32, count: u32, weight: f64) -> Channel {
    Channel {
        name: name.into(),
        kind,
        first,
        count,
        weight,
        low: 0.0,
        high: 1.0,
    }
}

/// A channel of every kind, 9 numbers per texel.
fn every_kind(weight: f64) -> Vec<Channel> {
    use ChannelKind::{Alpha, Color, Height, Mask, Normal};
    vec![
        channel("color", Color, 0, 3, 1.0),
        channel("height", Height, 3, 1, weight),
        channel("mask", Mask, 4, 1, weight),
        channel("alpha", Alpha, 5, 1, 0.0),
        channel("normal", Normal, 6, 3, 0.1),
    ]
}

fn levels(depth: usize) -> Vec<SpaceLevel> {
    let level = |side: u32| SpaceLevel {
        grid: TexelGrid {
            width: side,
            height: side,
            tileable: true,
        },
        features: Features::Plain(Array3::from_shape_fn(
            (side as usize, side as usize, depth),
            |(row, col, at)| ((row + 2 * col + 3 * at) % 7) as f32 / 7.0,
        )),
    };
    vec![level(4), level(2)]
}

fn space(depth: usize, list: Vec<Channel>) -> Result<Space> {
    Space::of_channels(levels(depth), list, Vec::new(), ContentId::of_bytes(b"s"))
}

/// Writes a space of `depth` numbers per texel with this as its `channels`.
fn write(path: &Path, depth: usize, channels: Option<Value>) {
    let mut meta = json!({
        "format": "mesotex-space", "version": 1, "kind": "features", "tileable": true,
        "levels": 2, "sample": ContentId::of_bytes(b"s").to_string(),
    });
    if let Some(channels) = channels {
        meta["channels"] = channels;
    }
    let levels = levels(depth);
    npz::write(path, meta.as_object().unwrap().clone(), |file| {
        for (at, level) in levels.iter().enumerate() {
            let Features::Plain(features) = &level.features else {
                unreachable!()
            };
            file.array(&format!("L{at}/features"), features.view())?;
        }
        Ok(())
    })
    .unwrap();
}

#[test]
fn channels_round_trip_and_files_hold_unweighted_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.space.npz");
    let mut space = space(9, every_kind(0.25)).unwrap();
    space.write(&path, None).unwrap();
    assert_eq!(Space::read(&path).unwrap(), space);
    let plain = levels(9);
    for (at, level) in space.levels.iter().enumerate() {
        let (Features::Plain(weighted), Features::Plain(stored)) =
            (&level.features, &plain[at].features)
        else {
            unreachable!()
        };
        let mut file = npz::Reader::open(&path).unwrap();
        let in_file = file
            .array::<f32, ndarray::Ix3>(&format!("L{at}/features"))
            .unwrap();
        assert_eq!(&in_file, stored);
        assert_eq!(
            weighted.slice(s![.., .., ..3]),
            stored.slice(s![.., .., ..3])
        );
        assert_eq!(weighted[[1, 1, 3]], 0.5 * stored[[1, 1, 3]]);
        assert_eq!(weighted[[1, 1, 5]], 0.0);
        assert_eq!(weighted[[1, 1, 7]], 0.1_f32.sqrt() * stored[[1, 1, 7]]);
        let alpha = space.required_channel(ChannelKind::Alpha, "it").unwrap();
        let numbers = space.channel_numbers(at, alpha).unwrap();
        assert_eq!(numbers, stored.slice(s![.., .., 5..6]));
    }
}

#[test]
fn weights_of_1_leave_the_numbers_alone() {
    let list = vec![channel("color", ChannelKind::Color, 0, 3, 1.0)];
    let space = space(3, list).unwrap();
    assert_eq!(space.levels, levels(3));
    assert!(space.channels.stored.is_empty());
}

#[test]
fn files_without_channels_are_read_as_colour_or_as_unknown() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.space.npz");
    for (depth, count) in [(1, 1), (3, 3)] {
        write(&path, depth, None);
        let space = Space::read(&path).unwrap();
        assert_eq!(space.levels, levels(depth));
        assert_eq!(
            space.channels.list(),
            [channel("color", ChannelKind::Color, 0, count, 1.0)]
        );
    }
    write(&path, 4, None);
    let space = Space::read(&path).unwrap();
    assert_eq!(space.levels, levels(4));
    let refused = space.required_channel(ChannelKind::Color, "method `x`");
    let message = refused.unwrap_err().to_string();
    assert!(message.contains("none are stated"), "{message}");
}

#[test]
fn a_method_that_needs_an_absent_channel_is_refused() {
    let space = space(3, vec![channel("color", ChannelKind::Color, 0, 3, 1.0)]).unwrap();
    let refused = space.required_channel(ChannelKind::Height, "method `progressive`");
    let message = refused.unwrap_err().to_string();
    assert!(
        message.contains(
            "channels: color; expected one of kind height, which method `progressive` needs"
        ),
        "{message}"
    );
}

#[test]
fn channels_need_not_be_listed_in_order() {
    let mut list = every_kind(1.0);
    list.reverse();
    assert_eq!(space(9, list).unwrap(), space(9, every_kind(1.0)).unwrap());
}

#[test]
fn channels_that_do_not_hold_are_refused() {
    let refused = |edit: &dyn Fn(&mut Vec<Channel>)| {
        let mut list = every_kind(1.0);
        edit(&mut list);
        space(9, list).unwrap_err().to_string()
    };
    type Edit<'a> = &'a dyn Fn(&mut Vec<Channel>);
    let cases: [(Edit<'_>, &str); 14] = [
        (
            &|all| all[1].first = 2,
            "channel `height`: first: 2, a number of channel `color`; expected 3",
        ),
        (
            &|all| drop(all.remove(2)),
            "number 4 is in none; expected a channel that begins there",
        ),
        (
            &|all| drop(all.pop()),
            "number 6 is in none; expected channels for all 9",
        ),
        (
            &|all| all[4].first = 7,
            "channel `normal`: first: 7; expected its 3 numbers among the 9",
        ),
        (
            &|all| all[4].first = u32::MAX,
            "channel `normal`: first: 4294967295",
        ),
        (
            &|all| all[0].count = 0,
            "channel `color`: count: 0; expected 1 or 3 for kind color",
        ),
        (
            &|all| all[1].count = 2,
            "count: 2; expected 1 for kind height",
        ),
        (
            &|all| all[1].weight = -0.5,
            "channel `height`: weight: -0.5",
        ),
        (&|all| all[1].weight = f64::INFINITY, "weight: inf"),
        (
            &|all| all.iter_mut().for_each(|c| c.weight = 0.0),
            "every weight is 0",
        ),
        (&|all| all[3].low = 1.0, "channel `alpha`: low, high: 1, 1"),
        (&|all| all[3].high = f64::NAN, "low, high: 0, NaN"),
        (
            &|all| all[3].high = 0.5,
            "expected 0 to 0.5, its low and high",
        ),
        (&|all| all[3].name = "mask".into(), "two named `mask`"),
    ];
    for (edit, expected) in cases {
        let said = refused(edit);
        assert!(said.contains(expected), "{said}\n{expected}");
    }
    let said = refused(&|all| all[2].name.clear());
    assert!(said.contains("name: 0 characters"), "{said}");
}

#[test]
fn weights_that_make_features_too_large_are_refused() {
    let mut big = levels(3);
    let Features::Plain(features) = &mut big[0].features else {
        unreachable!()
    };
    features[[0, 0, 1]] = 9e14;
    let color = Channel {
        high: 1e15,
        weight: 100.0,
        ..channel("color", ChannelKind::Color, 0, 3, 1.0)
    };
    let refused = Space::of_channels(big, vec![color], Vec::new(), ContentId::of_bytes(b"s"));
    let said = refused.unwrap_err().to_string();
    assert!(
        said.contains("channel `color`: weight: 100 makes"),
        "{said}"
    );
}

#[test]
fn damaged_channels_of_a_file_are_told_by_field() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.space.npz");
    let refused = |channels: Value| {
        write(&path, 3, Some(channels));
        let said = Space::read(&path).unwrap_err().to_string();
        assert!(said.contains("a.space.npz: meta.json: channel"), "{said}");
        said
    };
    let sound = json!({"name": "color", "kind": "color", "first": 0, "count": 3, "weight": 1, "low": 0, "high": 1});
    let with = |field: &str, value: Value| {
        let mut entry = sound.clone();
        entry[field] = value;
        refused(json!([entry]))
    };
    for (field, value, expected) in [
        (
            "kind",
            json!("colour"),
            "channels[0]: kind: \"colour\"; expected color, height, mask, alpha, normal",
        ),
        ("kind", json!(3), "kind: 3; expected"),
        ("name", json!(null), "name: null; expected text"),
        ("first", json!(-1), "first: -1; expected a whole number"),
        (
            "count",
            json!(1e20),
            "count: 1e+20; expected a whole number",
        ),
        (
            "count",
            json!(u64::MAX),
            "count: 18446744073709551615; expected a whole number",
        ),
        ("count", json!(2), "count: 2; expected 1 or 3"),
        ("weight", json!("1"), "weight: \"1\"; expected a number"),
        ("low", json!([0]), "low: [0]; expected a number"),
        ("high", json!(1e300), "low, high"),
    ] {
        let said = with(field, value);
        assert!(said.contains(expected), "{said}\n{expected}");
    }
    let mut partial = sound.clone();
    partial.as_object_mut().unwrap().remove("high");
    assert!(refused(json!([partial])).contains("high: missing; expected a number"));
    assert!(refused(json!([])).contains("channels: []; expected a list"));
    assert!(refused(json!("x")).contains("channels: \"x\""));
    assert!(refused(json!([1])).contains("channels[0]: kind: missing"));
    assert!(refused(json!(vec![sound.clone(); 4])).contains("channels: 4; expected at most 3"));
    write(&path, 3, Some(json!([sound])));
    assert!(Space::read(&path).is_ok());
}

#[test]
fn levels_of_other_numbers_are_refused() {
    let mut levels = levels(3);
    levels[1].features = Features::Plain(Array3::zeros((2, 2, 4)));
    let list = vec![channel("color", ChannelKind::Color, 0, 3, 1.0)];
    let refused = Space::of_channels(levels, list, Vec::new(), ContentId::of_bytes(b"s"));
    assert!(refused.unwrap_err().to_string().contains("L1/features"));
}
