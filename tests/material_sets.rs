//! Folders as public libraries name them, baked: the right roles, a word on every file.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use image::{GrayImage, ImageBuffer, Luma, Rgb, RgbImage};
use mesotex::btf::Sample;
use serde_json::Value;

const SIDE: u32 = 16;

fn mesotex(folder: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mesotex"));
    command.args(words).current_dir(folder).output().unwrap()
}

fn bake(folder: &Path, material: &str, more: &[&str]) -> Output {
    let words = [
        "bake",
        material,
        "-o",
        "x.sample",
        "--size",
        "16",
        "--samples",
        "1",
        "--json",
    ];
    let directions = ["--views", "rings:0:1,40:2", "--lights", "rings:0:1,50:3"];
    mesotex(folder, &[&words[..], &directions, more].concat())
}

fn report(output: &Output) -> Value {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn refusal(output: &Output, code: i32) -> String {
    assert_eq!(output.status.code(), Some(code));
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A wave that wraps, 0 to 1.
fn wave(x: u32, y: u32) -> f64 {
    let turn = |v: u32| (f64::from(v) / f64::from(SIDE) * std::f64::consts::TAU).sin();
    0.5 + 0.25 * turn(x) + 0.25 * turn(2 * y)
}

/// An image that will do for any role: a wave in all channels, or a normal map where the name says so.
fn save(path: &Path) {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    let name = path.file_name().unwrap().to_string_lossy().to_lowercase();
    let level = |x, y| (wave(x, y) * 255.0) as u8;
    if name.ends_with(".exr") {
        let pixel = |x: usize, y: usize| {
            let level = wave(x as u32, y as u32) as f32;
            (level, level, level)
        };
        exr::prelude::write_rgb_file(path, SIDE as usize, SIDE as usize, pixel).unwrap();
    } else if name.ends_with(".tif") {
        let image = ImageBuffer::<Luma<u16>, _>::from_fn(SIDE, SIDE, |x, y| {
            Luma([(wave(x, y) * 65535.0) as u16])
        });
        image.save(path).unwrap();
    } else if ["jpg", "png"].iter().any(|ending| name.ends_with(ending)) {
        RgbImage::from_fn(SIDE, SIDE, |x, y| Rgb([level(x, y); 3]))
            .save(path)
            .unwrap();
    } else {
        fs::write(path, "no image").unwrap();
    }
}

/// What each file of a set is used as, `-` where it is not.
fn uses(report: &Value) -> Vec<(String, String)> {
    let files = report["files"].as_array().unwrap();
    files
        .iter()
        .map(|file| {
            assert!(!file["why"].as_str().unwrap().is_empty());
            let used = file["used"].as_bool().unwrap();
            let role = file["role"].as_str().unwrap();
            let name = file["file"].as_str().unwrap().to_owned();
            (
                name,
                if used {
                    role.to_owned()
                } else {
                    format!("- {role}")
                },
            )
        })
        .collect()
}

/// Ten libraries: files with the roles they play, and the roles left at defaults.
#[test]
fn ten_libraries_play_the_right_roles() {
    type Library = (
        &'static str,
        &'static [(&'static str, &'static str)],
        &'static [&'static str],
    );
    let libraries: [Library; 11] = [
        (
            "ambientCG",
            &[
                ("MetalPlates006_1K-JPG.mtlx", "- no image"),
                ("MetalPlates006.png", "- unknown"),
                (
                    "MetalPlates006_1K-JPG_AmbientOcclusion.jpg",
                    "- ambient occlusion",
                ),
                ("MetalPlates006_1K-JPG_Color.jpg", "albedo"),
                ("MetalPlates006_1K-JPG_Displacement.jpg", "height"),
                (
                    "MetalPlates006_1K-JPG_NormalDX.jpg",
                    "- normal, green down (DirectX)",
                ),
                (
                    "MetalPlates006_1K-JPG_NormalGL.jpg",
                    "- normal, green up (OpenGL)",
                ),
                ("MetalPlates006_1K-JPG_Roughness.jpg", "roughness"),
            ],
            &["metallic"],
        ),
        (
            "Poly Haven",
            &[
                ("rough_wood_1k.blend", "- no image"),
                ("textures/rough_wood_arm_1k.jpg", "packed"),
                ("textures/rough_wood_diff_1k.jpg", "albedo"),
                ("textures/rough_wood_disp_1k.png", "height"),
                (
                    "textures/rough_wood_nor_gl_1k.exr",
                    "- normal, green up (OpenGL)",
                ),
            ],
            &[],
        ),
        (
            "Poliigon",
            &[
                ("MetalRust012_AO_3K.jpg", "- ambient occlusion"),
                ("MetalRust012_COL_VAR1_3K.jpg", "albedo"),
                ("MetalRust012_COL_VAR2_3K.jpg", "- albedo"),
                ("MetalRust012_DISP16_3K.tif", "height"),
                ("MetalRust012_DISP_3K.jpg", "- height"),
                ("MetalRust012_GLOSS_3K.jpg", "gloss"),
                ("MetalRust012_NRM_3K.jpg", "- normal"),
                ("MetalRust012_REFL_3K.jpg", "- specular"),
            ],
            &["metallic"],
        ),
        (
            "Megascans",
            &[
                ("sjfnbeaa.json", "- no image"),
                ("sjfnbeaa_2K_AO.jpg", "- ambient occlusion"),
                ("sjfnbeaa_2K_Albedo.jpg", "albedo"),
                ("sjfnbeaa_2K_Bump.jpg", "- height"),
                ("sjfnbeaa_2K_Cavity.jpg", "- cavity"),
                ("sjfnbeaa_2K_Displacement.exr", "height"),
                ("sjfnbeaa_2K_Gloss.jpg", "- gloss"),
                ("sjfnbeaa_2K_Normal_LOD0.jpg", "- normal"),
                ("sjfnbeaa_2K_Roughness.jpg", "roughness"),
                ("sjfnbeaa_2K_Specular.jpg", "- specular"),
                ("sjfnbeaa_Preview.png", "- preview"),
            ],
            &["metallic"],
        ),
        (
            "3dtextures.me",
            &[
                ("Material_1843.png", "- unknown"),
                (
                    "Metal_Plate_041_ambientOcclusion.jpg",
                    "- ambient occlusion",
                ),
                ("Metal_Plate_041_basecolor.jpg", "albedo"),
                ("Metal_Plate_041_height.png", "height"),
                ("Metal_Plate_041_metallic.jpg", "metallic"),
                ("Metal_Plate_041_normal.jpg", "- normal"),
                ("Metal_Plate_041_roughness.jpg", "roughness"),
            ],
            &[],
        ),
        (
            "texturecan",
            &[
                ("metal_0068_ao_2k.jpg", "- ambient occlusion"),
                ("metal_0068_color_2k.jpg", "albedo"),
                ("metal_0068_height_2k.png", "height"),
                (
                    "metal_0068_normal_directx_2k.png",
                    "- normal, green down (DirectX)",
                ),
                (
                    "metal_0068_normal_opengl_2k.png",
                    "- normal, green up (OpenGL)",
                ),
                ("metal_0068_opacity_2k.jpg", "- opacity"),
                ("metal_0068_roughness_2k.jpg", "roughness"),
            ],
            &["metallic"],
        ),
        (
            "freepbr",
            &[
                ("rough-metal-albedo.png", "albedo"),
                ("rough-metal-ao.png", "- ambient occlusion"),
                ("rough-metal-height.png", "height"),
                (
                    "rough-metal-normal-dx.png",
                    "- normal, green down (DirectX)",
                ),
                ("rough-metal_Metallic.png", "metallic"),
                ("rough-metal_preview.jpg", "- preview"),
            ],
            &["roughness"],
        ),
        (
            "cgbookcase",
            &[
                ("MossyRocks02_2K_AO.png", "- ambient occlusion"),
                ("MossyRocks02_2K_BaseColor.png", "albedo"),
                ("MossyRocks02_2K_Height.png", "height"),
                ("MossyRocks02_2K_Normal.png", "- normal"),
                ("MossyRocks02_2K_Roughness.png", "roughness"),
            ],
            &["metallic"],
        ),
        (
            "sharetextures",
            &[
                ("wood_35-1K.jpg", "- unknown"),
                ("wood_35_ambientocclusion-1K.png", "- ambient occlusion"),
                ("wood_35_basecolor-1K.png", "albedo"),
                ("wood_35_height-1K.png", "height"),
                ("wood_35_roughness-1K.png", "roughness"),
            ],
            &["metallic"],
        ),
        (
            "textures.com",
            &[
                ("TCom_Metal_Scratched_1K_albedo.png", "albedo"),
                ("TCom_Metal_Scratched_1K_height.tif", "height"),
                ("TCom_Metal_Scratched_1K_metallic.png", "metallic"),
                ("TCom_Metal_Scratched_1K_normal.png", "- normal"),
                ("TCom_Metal_Scratched_1K_roughness.png", "roughness"),
                ("TCom_Metal_Scratched_header.jpg", "- unknown"),
            ],
            &[],
        ),
        (
            "Substance",
            &[
                ("Wall_BaseColor.png", "albedo"),
                ("Wall_Emissive.png", "- emission"),
                ("Wall_Height.png", "height"),
                ("Wall_Normal.png", "- normal"),
                ("Wall_OcclusionRoughnessMetallic.png", "packed"),
            ],
            &[],
        ),
    ];
    for (library, files, defaults) in libraries {
        let folder = tempfile::tempdir().unwrap();
        for (name, _) in files {
            save(&folder.path().join("set").join(name));
        }
        let output = bake(folder.path(), "set", &["--depth", "0.1"]);
        let report = report(&output);
        let mut wanted: Vec<(String, String)> = files
            .iter()
            .map(|&(name, role)| (name.into(), role.into()))
            .collect();
        wanted.sort();
        assert_eq!(uses(&report), wanted, "{library}");
        let left: Vec<&str> = report["defaults"]
            .as_array()
            .unwrap()
            .iter()
            .map(|role| role["role"].as_str().unwrap())
            .collect();
        assert_eq!(left, *defaults, "{library}");
    }
}

#[test]
fn the_report_names_every_file_and_every_default() {
    let folder = tempfile::tempdir().unwrap();
    for name in [
        "rusty_metal_diff_1k.png",
        "rusty_metal_disp_1k.png",
        "rusty_metal_ao_1k.png",
    ] {
        save(&folder.path().join("set").join(name));
    }
    let words = [
        "bake",
        "set",
        "-o",
        "x.sample",
        "--size",
        "16",
        "--samples",
        "1",
        "--views",
        "rings:0:1",
    ];
    let output = mesotex(
        folder.path(),
        &[&words[..], &["--lights", "rings:0:1"]].concat(),
    );
    let text = String::from_utf8(output.stdout).unwrap();
    for line in [
        "rusty_metal_disp_1k.png: height",
        "rusty_metal_ao_1k.png: not used (ambient occlusion)",
        "no roughness map: the surface is matte",
        "no metallic map: 0 everywhere",
        "slopes of the relief:",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let info = mesotex(folder.path(), &["info", "set", "--json"]);
    let report = report(&info);
    assert_eq!(report["kind"], "material set");
    assert_eq!(report["naming"], "Poly Haven");
    assert_eq!(uses(&report).len(), 3);
}

#[test]
fn two_materials_in_a_folder_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for name in [
        "bark_disp.png",
        "bark_diff.png",
        "moss_disp.png",
        "moss_diff.png",
    ] {
        save(&folder.path().join("set").join(name));
    }
    let error = refusal(&bake(folder.path(), "set", &[]), 1);
    assert!(
        error.contains("bark_disp.png") && error.contains("moss_disp.png"),
        "{error}"
    );
    let info = report(&mesotex(folder.path(), &["info", "set", "--json"]));
    assert_eq!(info["usable"], false);
}

/// Mean of all values of a sample.
fn mean(path: &Path) -> f64 {
    let sample = Sample::open(path).unwrap();
    let images = (0..sample.image_count()).map(|image| sample.image(image).unwrap());
    let values: Vec<f64> = images
        .flat_map(|image| {
            (0..image.len())
                .map(|i| f64::from(image.get(i)))
                .collect::<Vec<_>>()
        })
        .collect();
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn gloss_and_packed_recipes_are_those_of_roughness_and_metal() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let grey = |name: &str, level: &dyn Fn(u32, u32) -> u8| {
        GrayImage::from_fn(SIDE, SIDE, |x, y| Luma([level(x, y)]))
            .save(at(name))
            .unwrap();
    };
    let rough = |x, y| 100 + (wave(x, y) * 100.0) as u8;
    let metal = |x, y| (wave(y, x) * 255.0) as u8;
    grey("rough.png", &rough);
    grey("gloss.png", &|x, y| 255 - rough(x, y));
    grey("metal.png", &metal);
    let orm = RgbImage::from_fn(SIDE, SIDE, |x, y| Rgb([7, rough(x, y), metal(x, y)]));
    orm.save(at("orm.png")).unwrap();
    let mrx = RgbImage::from_fn(SIDE, SIDE, |x, y| Rgb([metal(x, y), 255 - rough(x, y), 7]));
    mrx.save(at("mgx.png")).unwrap();
    let baked = |name: &str, toml: &str| {
        fs::write(at(name), toml).unwrap();
        report(&bake(folder.path(), name, &["--dtype", "f4"]));
        mean(&at("x.sample"))
    };
    let plain = baked("a.toml", "roughness = 'rough.png'\nmetallic = 'metal.png'");
    for toml in [
        "gloss = 'gloss.png'\nmetallic = 'metal.png'",
        "packed = 'orm.png'",
        "packed = 'mgx.png'\npacked-order = 'mgx'",
        "packed = 'orm.png'\nroughness = 'rough.png'",
    ] {
        let found = baked("b.toml", toml);
        assert!(
            (found - plain).abs() < 1e-6 * plain,
            "{toml}: {found} {plain}"
        );
    }
    for (toml, says) in [
        ("gloss = 0.5\nroughness = 0.5", "one of the two"),
        (
            "packed = 'orm.png'\nroughness = 0.5\nmetallic = 0.5",
            "none of its channels",
        ),
        ("packed = 'rough.png'", "a map per channel"),
        (
            "packed = 'orm.png'\npacked-order = 'rgb'",
            "three of the letters",
        ),
        ("packed-order = 'mro'", "without packed"),
    ] {
        fs::write(at("c.toml"), toml).unwrap();
        let error = refusal(&bake(folder.path(), "c.toml", &[]), 1);
        assert!(error.contains(says), "{toml}: {error}");
    }
}

/// A normal map of a smooth wrapped surface, each vector through `stored`.
fn normal_map(path: &Path, stored: impl Fn([f64; 3]) -> [f64; 3] + Sync) {
    let at = |x: u32, y: u32| {
        let turn = |v: u32| (f64::from(v) / f64::from(SIDE) * std::f64::consts::TAU).cos();
        let (p, q) = (0.5 * turn(x), 0.4 * turn(y));
        let length = (p * p + q * q + 1.0).sqrt();
        stored([-p / length, -q / length, 1.0 / length])
    };
    if path.extension().is_some_and(|ending| ending == "exr") {
        let pixel = |x: usize, y: usize| {
            let [r, g, b] = at(x as u32, y as u32).map(|v| v as f32);
            (r, g, b)
        };
        exr::prelude::write_rgb_file(path, SIDE as usize, SIDE as usize, pixel).unwrap();
        return;
    }
    let image = ImageBuffer::<Rgb<u16>, _>::from_fn(SIDE, SIDE, |x, y| {
        Rgb(at(x, y).map(|v| (v * 65535.0).round() as u16))
    });
    image.save(path).unwrap();
}

#[test]
fn every_kind_of_normal_map_gives_the_same_relief() {
    let folder = tempfile::tempdir().unwrap();
    let half = |n: [f64; 3]| n.map(|v| 0.5 * v + 0.5);
    let with_blue = |blue: f64| move |n: [f64; 3]| [half(n)[0], half(n)[1], blue];
    let at = |name: &str| folder.path().join(name);
    normal_map(&at("full.png"), half);
    normal_map(&at("full.exr"), half);
    normal_map(&at("signed.exr"), |n| n);
    normal_map(&at("blue0.png"), with_blue(0.0));
    normal_map(&at("blue255.png"), with_blue(1.0));
    normal_map(&at("odd.png"), with_blue(0.8));
    let baked = |name: &str, more: &[&str]| {
        fs::write(at("m.toml"), format!("normal = '{name}'\nnormal-y = 'up'")).unwrap();
        let found = report(&bake(
            folder.path(),
            "m.toml",
            &[&["--dtype", "f4"], more].concat(),
        ));
        (
            mean(&at("x.sample")),
            found["slope_p95_deg"].as_f64().unwrap(),
        )
    };
    let (light, slope) = baked("full.png", &[]);
    assert!(slope > 15.0);
    let xy = ["--normal-kind", "unsigned-xy"];
    for (name, more) in [
        ("full.exr", &[][..]),
        ("signed.exr", &[]),
        ("blue0.png", &[]),
        ("blue255.png", &[]),
        ("odd.png", &xy),
    ] {
        let (found_light, found_slope) = baked(name, more);
        assert!(
            (found_light - light).abs() < 1e-4 * light,
            "{name}: {found_light} {light}"
        );
        assert!(
            (found_slope - slope).abs() < 0.05,
            "{name}: {found_slope} {slope}"
        );
    }
    fs::write(at("h.toml"), "height = 'full.png'").unwrap();
    let error = refusal(&bake(folder.path(), "h.toml", &xy), 2);
    assert!(error.contains("--normal-kind"), "{error}");
}

#[test]
fn glossy_materials_are_warned_of_and_made_rougher_on_request() {
    let folder = tempfile::tempdir().unwrap();
    save(&folder.path().join("height.png"));
    let recipe = "height = 'height.png'\ndepth = 0.1\nroughness = 0.01\nmetallic = 1";
    fs::write(folder.path().join("m.toml"), recipe).unwrap();
    let directions = ["--views", "12x5", "--lights", "12x5"];
    let baked = |more: &[&str]| {
        let words = [
            "bake",
            "m.toml",
            "-o",
            "x.sample",
            "--size",
            "16",
            "--samples",
            "1",
            "--json",
        ];
        mesotex(folder.path(), &[&words[..], &directions, more].concat())
    };
    let exact = ["--angular-filter", "off", "--dtype", "f4"];
    let warned = |report: &Value| report["warnings"].to_string().contains("--min-roughness");
    let glossy = report(&baked(&exact));
    assert!(warned(&glossy), "{glossy}");
    assert!(glossy["light_in_brightest_hundredth"].as_f64().unwrap() > 0.8);
    let rougher = report(&baked(&[&exact[..], &["--min-roughness", "0.4"]].concat()));
    assert!(!warned(&rougher), "{rougher}");
    let filtered = report(&baked(&[]));
    assert!(!warned(&filtered), "{filtered}");
    assert!(filtered["widened_to_roughness"].as_f64().unwrap() > 0.2);
    baked(&["--min-roughness", "0.4"]);
    let info = report(&mesotex(folder.path(), &["info", "x.sample", "--json"]));
    let least = info["source"]["min-roughness"].as_f64().unwrap();
    assert!((least - 0.4).abs() < 1e-6);
    for (least, code) in [("0", 2), ("1.5", 2), ("nan", 2)] {
        let error = refusal(&baked(&["--min-roughness", least]), code);
        assert!(error.contains("min-roughness"), "{error}");
    }
    fs::write(
        folder.path().join("m.toml"),
        "height = 'height.png'\ndepth = 0.1",
    )
    .unwrap();
    let matte = refusal(&baked(&["--min-roughness", "0.4"]), 2);
    assert!(matte.contains("matte"), "{matte}");
}

#[test]
fn implausible_depths_are_warned_of_with_a_better_one() {
    let folder = tempfile::tempdir().unwrap();
    save(&folder.path().join("height.png"));
    fs::write(folder.path().join("m.toml"), "height = 'height.png'").unwrap();
    for depth in ["0.001", "30"] {
        let found = report(&bake(folder.path(), "m.toml", &["--depth", depth]));
        let warnings = found["warnings"].to_string();
        let advised = warnings.split("--depth ").nth(1).unwrap();
        let advised = advised.split(' ').next().unwrap();
        let better = report(&bake(folder.path(), "m.toml", &["--depth", advised]));
        assert!(
            !better["warnings"].to_string().contains("--depth"),
            "{better}"
        );
        let steep = better["slope_p95_deg"].as_f64().unwrap();
        assert!((15.0..50.0).contains(&steep), "{steep}");
    }
}
