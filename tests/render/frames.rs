//! Frames hold what the contract says, and the same bytes whatever the threads, interruptions and shards.

use super::*;

#[test]
fn frames_hold_what_the_contract_says() {
    let bench = small_ball(DType::F2);
    let words = [
        "--size",
        "48x36",
        "--sweep",
        "light-azimuth",
        "--frames",
        "2",
    ];
    let folder = bench.render("frames", &words);
    for name in [
        "frame.0001.exr",
        "frame.0001.png",
        "frame.0002.exr",
        "frame.0002.png",
        "contact.png",
    ] {
        assert!(folder.join(name).is_file(), "{name}");
    }
    let path = folder.join("frame.0002.exr");
    let frame = read_frame(&path);
    assert_eq!(frame.size, [48, 36]);
    let kinds: Vec<(&str, &str)> = frame.kinds.iter().map(|(n, k)| (n.as_str(), *k)).collect();
    assert_eq!(
        kinds,
        [
            ("A", "half"),
            ("B", "half"),
            ("G", "half"),
            ("N.X", "float"),
            ("N.Y", "float"),
            ("N.Z", "float"),
            ("R", "half"),
            ("Z", "float"),
            ("texton.I", "uint"),
            ("uv.U", "float"),
            ("uv.V", "float"),
        ]
    );
    let map = SurfaceTextonMap::read(&bench.map).unwrap();
    let at = |name: &str, pixel: usize| frame.channels[name][pixel];
    for pixel in 0..48 * 36 {
        let coverage = at("A", pixel);
        assert!((coverage * 4.0).fract() == 0.0 && coverage <= 1.0);
        if coverage == 0.0 {
            assert_eq!(at("Z", pixel), f64::INFINITY);
            assert_eq!(at("texton.I", pixel), 65535.0);
            for name in ["R", "G", "B", "N.X", "N.Y", "N.Z", "uv.U", "uv.V"] {
                assert_eq!(at(name, pixel), 0.0);
            }
        } else {
            let normal = DVec3::new(at("N.X", pixel), at("N.Y", pixel), at("N.Z", pixel));
            assert!((normal.length() - 1.0).abs() < 1e-5);
            // The label and the coordinate are one vertex's own.
            let (s, t) = (at("uv.U", pixel) * 8.0, at("uv.V", pixel) * 6.0);
            let same = |v: &usize| {
                (f64::from(map.coords[*v].s) - s).abs() < 1e-4
                    && (f64::from(map.coords[*v].t) - t).abs() < 1e-4
                    && f64::from(map.textons[*v].0) == at("texton.I", pixel)
            };
            assert!((0..map.coords.len()).find(same).is_some());
        }
    }
    check_header(&bench, &path, &frame);
}

fn check_header(bench: &Bench, path: &Path, frame: &Picture) {
    use exr::meta::attribute::AttributeValue as Value;
    let meta = exr::meta::MetaData::read_from_file(path, true).unwrap();
    let header = &meta.headers[0];
    let own = &header.own_attributes;
    let other = |name: &str| {
        own.other
            .get(&exr::meta::attribute::Text::from(name))
            .unwrap()
            .clone()
    };
    let to_text = |name: &str| match other(name) {
        Value::Text(value) => value.to_string(),
        value => panic!("{name}: {value:?}"),
    };
    assert_eq!(to_text("colorInteropID"), "lin_rec709_scene");
    assert_eq!(to_text("mesotex:seed"), "5");
    assert_eq!(
        to_text("mesotex:sample"),
        Sample::open(&bench.sample).unwrap().id().to_string()
    );
    assert_eq!(
        to_text("mesotex:map"),
        ContentId::of_file(&bench.map).unwrap().to_string()
    );
    let options: serde_json::Value = serde_json::from_str(&to_text("mesotex:options")).unwrap();
    assert_eq!(options["weights"], "continuous");
    assert!(!to_text("mesotex:options").contains(text(bench.folder.path())));
    assert_eq!(other("frame"), Value::I32(2));
    let Value::F32(irradiance) = other("lightIrradiance") else {
        panic!()
    };
    assert!((irradiance - std::f32::consts::PI).abs() < 1e-6);
    let Value::FloatVec3((x, y, z)) = other("lightDirection") else {
        panic!()
    };
    assert!((x * x + y * y + z * z - 1.0).abs() < 1e-5);
    assert!(header.shared_attributes.chromaticities.is_some());

    // Points of the surface, by Z and the matrices, lie on the unit ball.
    let to_camera = own.world_to_camera.unwrap().map(f64::from);
    let to_ndc = own.world_to_normalized_device.unwrap().map(f64::from);
    let times = |p: DVec3, m: &[f64; 16]| {
        let row = [p.x, p.y, p.z, 1.0];
        [0, 1, 2, 3].map(|column: usize| (0..4).map(|k| row[k] * m[k * 4 + column]).sum::<f64>())
    };
    // The matrix is a rotation and a shift with a mirrored axis: invert it by its transpose.
    let axis = |column: usize| {
        DVec3::new(
            to_camera[column],
            to_camera[4 + column],
            to_camera[8 + column],
        )
    };
    let (right, up, ahead) = (axis(0), axis(1), axis(2));
    assert!((right.cross(up) + ahead).length() < 1e-5, "left-handed");
    let origin = -(right * to_camera[12] + up * to_camera[13] + ahead * to_camera[14]);
    let mut seen = 0;
    for pixel in 0..48 * 36 {
        if frame.channels["A"][pixel] < 1.0 {
            continue;
        }
        let ndc = [
            ((pixel % 48) as f64 + 0.5) / 48.0,
            ((pixel / 48) as f64 + 0.5) / 36.0,
        ];
        // Solve for the camera ray through the pixel by two probes of the linear map.
        let depth = frame.channels["Z"][pixel];
        let probe = |x: f64, y: f64| {
            let p = origin + right * x + up * y + ahead * depth;
            let [u, v, _, w] = times(p, &to_ndc);
            [u / w, v / w]
        };
        let ([u0, v0], [u1, _], [_, v1]) = (probe(0.0, 0.0), probe(1.0, 0.0), probe(0.0, 1.0));
        let (x, y) = ((ndc[0] - u0) / (u1 - u0), (ndc[1] - v0) / (v1 - v0));
        let p = origin + right * x + up * y + ahead * depth;
        assert!((p.length() - 1.0).abs() < 0.02, "{p}");
        seen += 1;
    }
    assert!(seen > 200);
}

#[test]
fn bytes_do_not_depend_on_threads_interruptions_or_shards() {
    let bench = small_ball(DType::F2);
    let sweep = [
        "--size",
        "40x30",
        "--sweep",
        "view-orbit",
        "--frames",
        "7",
        "--layers",
        "rgba,depth,shadow,weight",
    ];
    let with = |more: &[&'static str]| [&sweep[..], more].concat();
    let whole = files(&bench.render("one", &with(&["--threads", "1"])));
    assert_eq!(whole.len(), 15);
    assert_eq!(
        whole,
        files(&bench.render("eight", &with(&["--threads", "8"])))
    );

    for shard in ["2/3", "0/3", "1/3"] {
        bench.render("shards", &with(&["--shard", shard]));
    }
    assert_eq!(whole, files(&bench.path("shards")));

    // What a killed run leaves: some frames whole, one preview without its frame, a temporary file.
    let resumed = bench.render("resumed", &with(&[]));
    let kept = fs::metadata(resumed.join("frame.0002.exr"))
        .unwrap()
        .modified()
        .unwrap();
    for gone in [
        "frame.0003.exr",
        "frame.0005.exr",
        "frame.0005.png",
        "contact.png",
    ] {
        fs::remove_file(resumed.join(gone)).unwrap();
    }
    bench.render("resumed", &with(&["--skip-existing"]));
    assert_eq!(whole, files(&resumed));
    let now = fs::metadata(resumed.join("frame.0002.exr"))
        .unwrap()
        .modified()
        .unwrap();
    assert_eq!(kept, now, "kept frames are not touched");

    // Frames of other options are made anew.
    let other = bench.run("resumed", &with(&["--skip-existing", "--irradiance", "2"]));
    assert!(String::from_utf8_lossy(&other.stdout).contains("7 frames of other options"));
}
