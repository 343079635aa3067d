//! `transfer` onto atlases: what becomes of maps, and what is refused.

use super::*;

#[test]
fn maps_become_texture_maps_and_a_model() {
    let folder = folder();
    run(folder.path(), ALL);
    let out = folder.path().join("ball.textures");
    let told: Value =
        serde_json::from_slice(&fs::read(out.join("textures.json")).unwrap()).unwrap();
    assert_eq!(
        (&told["width"], &told["format"]),
        (&SIDE.into(), &"mesotex-textures".into())
    );
    let kinds: Vec<&str> = told["channels"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| c["kind"].as_str().unwrap())
        .collect();
    assert_eq!(kinds, ["color", "height", "mask", "alpha", "normal"]);
    // At every texel the image's value at the texel's coordinate, colours mixed in linear light.
    let map = AtlasMap::read(&folder.path().join("ball.atlas")).unwrap();
    let color = read(&out.join("color.png")).unwrap();
    let rough = read_with(&out.join("rough.png"), &ReadOptions::data())
        .unwrap()
        .image;
    let height = read_with(&out.join("height.png"), &ReadOptions::data())
        .unwrap()
        .image;
    assert_eq!(
        (rough.precision, height.precision),
        (Precision::Bits8, Precision::Bits16)
    );
    for (texel, coord) in map.coords.iter().enumerate() {
        let Some(coord) = coord else { continue };
        let row = f32::from(SAMPLE as u8) - coord.t - 0.5;
        let (above, share) = (row.floor().clamp(0.0, 15.0), row - row.floor());
        let below = (row.floor() + 1.0).clamp(0.0, 15.0);
        // Beyond the first and the last row the image goes on with the other end.
        if row > 0.0 && row < 15.0 {
            let green = |row: f32| decode_srgb(15.0 * row / 255.0);
            let wanted = green(above) * (1.0 - share) + green(below) * share;
            assert!((decode_srgb(color.data[3 * texel + 1]) - wanted).abs() < 0.01);
            assert!((height.data[texel] - 15.0 * row / 255.0).abs() < 1e-4);
        }
    }
    // Flat normals lie along the surface's: blue in tangent space, but for the facets of the mesh.
    let normal = read_with(&out.join("normal.png"), &ReadOptions::data())
        .unwrap()
        .image;
    let is_inside = |texel: &usize| map.chart[*texel] >= 0;
    for texel in (0..map.len()).filter(is_inside) {
        assert!(
            normal.data[3 * texel + 2] > 0.98,
            "{:?}",
            &normal.data[3 * texel..][..3]
        );
    }
    let model = reading::read(&out.join("surface.glb"), Progress::silent()).unwrap();
    assert!(model.mesh.triangles.len() > 2 * map.mesh.triangles.len());
    let lengths = model.mesh.positions.iter().map(|p| p.length());
    assert!(lengths.clone().fold(0.0, f32::max) > 1.05);
    assert!(lengths.fold(9.0, f32::min) > 0.97);
    let bytes = fs::read(out.join("surface.glb")).unwrap();
    let text = String::from_utf8_lossy(&bytes[..4000]).into_owned();
    for part in [
        "\"alphaMode\":\"MASK\"",
        "\"doubleSided\":true",
        "\"TANGENT\"",
        "normalTexture",
        "image/png",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn the_same_bytes_at_any_number_of_threads() {
    let folder = folder();
    let made = |threads: &str| {
        run(folder.path(), &format!("{ALL} --threads {threads}"));
        files(&folder.path().join("ball.textures"))
    };
    assert_eq!(made("1"), made("3"));
}

#[test]
fn larger_maps_are_reduced() {
    let folder = folder();
    run(
        folder.path(),
        "transfer ball.atlas --maps mask:fine.png -o a",
    );
    let map = AtlasMap::read(&folder.path().join("ball.atlas")).unwrap();
    let fine = read_with(&folder.path().join("a/fine.png"), &ReadOptions::data())
        .unwrap()
        .image;
    for texel in (0..map.len()).filter(|texel| map.chart[*texel] >= 0) {
        assert!((fine.data[texel] - 100.0 / 255.0).abs() < 0.003);
    }
}

#[test]
fn larger_maps_keep_their_detail_on_finer_textures() {
    let folder = folder();
    run(
        folder.path(),
        "transfer ball.atlas --maps mask:fine.png --finer 2 -o a",
    );
    let fine = read_with(&folder.path().join("a/fine.png"), &ReadOptions::data())
        .unwrap()
        .image;
    assert_eq!((fine.width, fine.height), (2 * SIDE, 2 * SIDE));
    let share = |of: &dyn Fn(f32) -> bool| {
        fine.data.iter().filter(|v| of(**v)).count() as f32 / fine.data.len() as f32
    };
    // Stripes of 0 and 200, where the reduced map is 100 everywhere.
    assert!(share(&|v| v < 0.2) > 0.1 && share(&|v| v > 0.6) > 0.1);
}

#[test]
fn what_cannot_be_carried_is_refused() {
    let folder = folder();
    let refused = |line: &str, code: i32| {
        let before = files(folder.path());
        let line = format!("transfer {line} -o out");
        let said = refuse(
            folder.path(),
            &line.split_whitespace().collect::<Vec<_>>(),
            code,
        );
        let after = files(folder.path());
        let changed = after.keys().filter(|path| !before.contains_key(*path));
        let changed: Vec<_> = changed
            .filter(|path| !path.to_string_lossy().contains(".lock"))
            .collect();
        assert!(changed.is_empty(), "{line}: {changed:?}");
        said
    };
    let said = refused("ball.atlas --maps odd.png", 1);
    assert!(
        said.contains("odd.png: size: 17×17; expected 16×16"),
        "{said}"
    );
    assert!(refused("ball.atlas --maps alpha:none.png", 1).contains("0 at every texel"));
    assert!(refused("ball.atlas --maps color.png --displace 1", 2).contains("--displace"));
    assert!(refused("ball.atlas --maps height.png --displace nan", 2).contains("--displace"));
    assert!(refused("ball.atlas --maps height.png --tile", 2).contains("--tile"));
    assert!(refused("ball.atlas --maps height.png --finer 0", 2).contains("--finer"));
    assert!(refused("ball.atlas --maps height.png --finer 86", 2).contains("1 to 85:"));
    assert!(refused("ball.atlas --maps normal:height.png", 1).contains("red, green and blue"));
    assert!(refused("ball.atlas --maps color.png color.png", 2).contains("twice"));
    assert!(refused("ball.atlas --maps missing.png", 1).contains("missing.png"));
    assert!(refused(". --maps color.png", 1).contains("atlas.json"));
    assert!(refused("color.png --maps color.png", 1).contains("color.png"));
}

#[test]
fn folders_of_others_are_kept() {
    let folder = folder();
    let photos = folder.path().join("photos");
    fs::create_dir(&photos).unwrap();
    fs::write(photos.join("a.jpg"), "mine").unwrap();
    let to = |out: &str| {
        [
            "transfer",
            "ball.atlas",
            "--maps",
            "mask:rough.png",
            "-o",
            out,
        ]
        .map(String::from)
    };
    let words = |out: &str| to(out);
    let refused = |out: &str| {
        let words = words(out);
        refuse(folder.path(), &words.each_ref().map(String::as_str), 2)
    };
    assert!(refused("photos").contains("`a.jpg`"));
    assert!(refused("ball.atlas").contains("--output"));
    // A second run replaces the first; not so where an image was painted over.
    for _ in 0..2 {
        succeed(folder.path(), &words("out").each_ref().map(String::as_str));
    }
    fs::write(folder.path().join("out/rough.png"), b"\x89PNG painted").unwrap();
    assert!(refused("out").contains("`rough.png`"));
}

#[test]
fn damaged_atlases_are_refused_by_file() {
    let folder = folder();
    for name in ["atlas.json", "coords.npy", "surface.npz"] {
        let copy = copy_of(folder.path());
        let path = copy.path().join("ball.atlas").join(name);
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        let words = [
            "transfer",
            "ball.atlas",
            "--maps",
            "mask:rough.png",
            "-o",
            "out",
        ];
        assert!(refuse(copy.path(), &words, 1).contains(name));
        fs::remove_file(&path).unwrap();
        refuse(copy.path(), &words, 1);
    }
}

#[test]
fn maps_of_other_depths_keep_what_they_hold() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let deep = |x: u32, y: u32| Luma([(257 * x + 16 * y) as u16]);
    image::ImageBuffer::from_fn(SAMPLE, SAMPLE, deep)
        .save(at("deep.png"))
        .unwrap();
    let texels = || (0..SAMPLE * SAMPLE).map(|texel| (texel % SAMPLE, texel / SAMPLE));
    let wide = |name: &str, of: &dyn Fn((u32, u32)) -> f32| {
        let numbers: Vec<f32> = texels().map(of).collect();
        (name.to_owned(), Numbers::Float(numbers.into()))
    };
    let image = ExrImage {
        size: [SAMPLE; 2],
        channels: [
            wide("R", &|(x, _)| x as f32 / 4.0),
            wide("G", &|(_, y)| y as f32 / 16.0),
            wide("B", &|_| 2.5),
        ]
        .into(),
        attributes: Default::default(),
    };
    let encoded = exr::encode(&image, exr::Compression::default()).unwrap();
    exr::write(&at("wide.exr"), &encoded).unwrap();
    let grey = |x: u32, _| Luma([16 * x as u8]);
    GrayImage::from_fn(SAMPLE, SAMPLE, grey)
        .save(at("grey.png"))
        .unwrap();
    run(
        folder.path(),
        "transfer ball.atlas --maps mask:deep.png color:wide.exr -o a",
    );
    let map = AtlasMap::read(&at("ball.atlas")).unwrap();
    let channel = |name: &str, kind, data: bool| {
        let options = match data {
            true => ReadOptions::data(),
            false => ReadOptions::default(),
        };
        let image = read_with(&at(name), &options).unwrap().image;
        SampleChannel::of_image("x".into(), kind, image, map.grid(), 1).unwrap()
    };
    let (deep, wide) = (
        channel("deep.png", ChannelKind::Mask, true),
        channel("wide.exr", ChannelKind::Color, false),
    );
    let stored = |name: &str| read_with(&at(name), &ReadOptions::data()).unwrap().image;
    let (deep_map, wide_map) = (stored("a/deep.png"), stored("a/wide.exr"));
    assert_eq!(
        [deep_map.precision, wide_map.precision],
        [Precision::Bits16, Precision::Float]
    );
    for texel in (0..map.len()).filter(|texel| map.chart[*texel] >= 0) {
        let coord = map.coords[texel].unwrap();
        // Half a step of 16 bits.
        assert!((deep_map.data[texel] - deep.at(coord)[0]).abs() < 0.6 / 65535.0);
        for (number, wanted) in wide_map.data[3 * texel..].iter().zip(wide.at(coord)) {
            assert!((number - wanted).abs() < 1e-5);
        }
    }
    // Grey colours stay grey in their image, and are all three in the model.
    run(
        folder.path(),
        "transfer ball.atlas --maps color:grey.png -o b",
    );
    assert_eq!(stored("b/grey.png").channels, 1);
    let model = embedded_png(&fs::read(at("b/surface.glb")).unwrap());
    assert_eq!(model.channels, 3);
    assert!(
        model
            .data
            .chunks_exact(3)
            .all(|c| c[0] == c[1] && c[1] == c[2])
    );
    // Of one number per texel there are no normals; of three no masks.
    let refused = |line: &str| refuse(folder.path(), &line.split(' ').collect::<Vec<_>>(), 1);
    let said = refused("transfer ball.atlas --maps mask:wide.exr -o c");
    assert!(said.contains("wide.exr"), "{said}");
    let said = refused("transfer ball.atlas --maps normal:deep.png -o c");
    assert!(said.contains("deep.png"), "{said}");
}
