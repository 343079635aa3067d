//! Recipes and maps as users write them; each warning and refusal.

use std::path::Path;
use std::sync::Mutex;

use super::*;
use crate::format::image::write_png;
use crate::progress::Event;

/// A folder with a ramp for height and a grey albedo, and what loading a recipe in it says.
struct Bench(tempfile::TempDir);

impl Bench {
    fn new() -> Self {
        let bench = Self(tempfile::tempdir().unwrap());
        let ramp: Vec<u8> = (0..32 * 16).map(|i| (8 * (i % 32)) as u8).collect();
        write_png(&bench.path("height.png"), 32, 16, &ramp).unwrap();
        write_png(&bench.path("albedo.png"), 32, 16, &[188; 3 * 512]).unwrap();
        write_png(&bench.path("small.png"), 16, 8, &[128; 128]).unwrap();
        write_png(&bench.path("square.png"), 16, 16, &[128; 256]).unwrap();
        bench
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }

    fn load(&self, toml: &str, options: &MapOptions, size: u32) -> (Result<Material>, Vec<String>) {
        let path = self.path("test.toml");
        std::fs::write(&path, toml).unwrap();
        let warnings = Mutex::new(Vec::new());
        let listener = |event: Event| {
            if let Event::Warn(text) = event {
                warnings.lock().unwrap().push(text);
            }
        };
        let material = read_recipe(&path)
            .and_then(|recipe| material(&recipe, options, size, Progress::new(&listener, None)));
        let material = material.map(|loaded| loaded.material);
        let warnings = std::mem::take(&mut *warnings.lock().unwrap());
        (material, warnings)
    }

    fn refused(&self, toml: &str) -> String {
        let (material, _) = self.load(toml, &MapOptions::default(), 16);
        material.unwrap_err().to_string()
    }
}

#[test]
fn a_recipe_becomes_a_material_in_texels() {
    let bench = Bench::new();
    let toml = "height = 'height.png'\nalbedo = 'albedo.png'\nheight-mm = 5\nwidth-mm = 16\n\
                roughness = 0.5\ntileable = false";
    let (material, warnings) = bench.load(toml, &MapOptions::default(), 16);
    let material = material.unwrap();
    assert_eq!((material.grid.width, material.grid.height), (16, 8));
    assert_eq!(material.texel_mm, Some(1.0));
    assert_eq!(material.name, "test");
    // Texels 0 and 1 of the map, 0 and 8 of 255, are the first texel: 5 mm · 4/255, a texel 1 mm.
    assert!((material.heights[0] - 5.0 * 4.0 / 255.0).abs() < 1e-5);
    assert!((material.albedo[3].x - 0.502_886).abs() < 1e-5);
    assert_eq!(material.roughness, Some(vec![0.5; 128]));
    assert_eq!(warnings, Vec::<String>::new());
    material.check().unwrap();
}

#[test]
fn a_recipe_without_relief_is_a_plane() {
    let bench = Bench::new();
    let (material, _) = bench.load("albedo = [0.8, 0.5, 0.1]", &MapOptions::default(), 8);
    let material = material.unwrap();
    assert_eq!((material.grid.width, material.grid.height), (8, 8));
    assert!(material.heights.iter().all(|&h| h == 0.0) && material.roughness.is_none());
}

#[test]
fn options_go_over_the_recipe() {
    let bench = Bench::new();
    let options = MapOptions {
        depth: Some(0.5),
        tiling: Some(Tiling::Mirror),
        ..MapOptions::default()
    };
    let toml = "height = 'height.png'\nheight-mm = 5\nwidth-mm = 16";
    let material = bench.load(toml, &options, 32).0.unwrap();
    assert!(!material.grid.tileable);
    assert!((material.heights[31] - 0.5 * 32.0 * 248.0 / 255.0).abs() < 1e-4);
    assert!(
        MapOptions {
            depth: Some(-1.0),
            ..options.clone()
        }
        .validate()
        .is_err()
    );
    assert!(
        MapOptions {
            height_mm: Some(1.0),
            ..options
        }
        .validate()
        .is_err()
    );
}

#[test]
fn what_commonly_goes_wrong_is_warned_of() {
    let bench = Bench::new();
    let warned = |toml: &str, says: &str| {
        let (material, warnings) = bench.load(toml, &MapOptions::default(), 16);
        material.unwrap();
        assert!(
            warnings.iter().any(|w| w.contains(says)),
            "{says}: {warnings:?}"
        );
    };
    warned(
        "height = 'height.png'\ndepth = 0.1",
        "does not seem tileable",
    );
    warned("height = 'height.png'", "does not state its depth");
    warned(
        "height = 'height.png'\nroughness = 'small.png'",
        "resampled",
    );
    let steps: Vec<u8> = (0..4096).map(|i| ((i % 64) / 8) as u8).collect();
    write_png(&bench.path("steps.png"), 64, 64, &steps).unwrap();
    warned("height = 'steps.png'\ndepth = 1.0", "--terraces smooth");
}

#[test]
fn bad_recipes_are_refused_by_line_or_field() {
    let bench = Bench::new();
    for (toml, says) in [
        ("hight = 'a.png'", "line 1"),
        ("name = 'x'\nroughness = true", "line 2"),
        (
            "height = 'height.png'\nnormal = 'height.png'",
            "normal: given with height",
        ),
        ("height-mm = -1", "height-mm: -1"),
        ("roughness = 1.5", "roughness: a number outside"),
        ("albedo = [0.1, 2.0, 0.0]", "albedo: a number outside"),
        (
            "height = 'height.png'\nheight-mm = 2",
            "width-mm or texel-mm",
        ),
        ("height-mm = 1\ndepth = 0.1", "one of the two"),
        ("width-mm = 1\ntexel-mm = 0.1", "one of the two"),
        ("height = 'none.png'", "none.png"),
        ("height = 'test.toml'", "test.toml"),
        ("normal = 'height.png'", "3: a normal map"),
        ("normal = 'albedo.png'\ndepth = 0.1", "neither"),
        (
            "height = 'height.png'\nroughness = 'square.png'",
            "proportions",
        ),
        ("oren-nayar-deg = 100", "oren-nayar-deg"),
    ] {
        let error = bench.refused(toml);
        assert!(error.contains(says), "{toml}: {error}");
    }
    let missing = read_recipe(Path::new("no/such.toml"))
        .unwrap_err()
        .to_string();
    assert!(missing.contains("no/such.toml"));
}

#[test]
fn not_a_number_in_a_map_is_refused_by_place() {
    let bench = Bench::new();
    exr::prelude::write_rgb_file(bench.path("nan.exr"), 32, 16, |x, y| {
        let v = if (x, y) == (3, 1) { f32::NAN } else { 0.5 };
        (v, v, v)
    })
    .unwrap();
    for key in ["height", "albedo", "roughness", "normal"] {
        let error = bench.refused(&format!("{key} = 'nan.exr'"));
        assert!(error.contains("nan.exr: row 1, column 3"), "{error}");
    }
}

#[test]
fn a_folder_is_a_material() {
    let bench = Bench::new();
    std::fs::remove_file(bench.path("small.png")).unwrap();
    let recipe = read_recipe(bench.0.path()).unwrap();
    assert_eq!(recipe.files().len(), 2);
    std::fs::write(bench.path("material.toml"), "albedo = [0.5, 0.5, 0.5]").unwrap();
    assert_eq!(read_recipe(bench.0.path()).unwrap().relief.height, None);
}

#[test]
fn the_command_says_how_the_albedo_is_read() {
    let bench = Bench::new();
    let options = |encoding| MapOptions {
        albedo_encoding: Some(encoding),
        ..MapOptions::default()
    };
    let albedo = |toml: &str, options: &MapOptions| {
        let (material, _) = bench.load(toml, options, 16);
        material.unwrap().albedo[3].x
    };
    let file = "albedo = 'albedo.png'";
    let stated = "albedo = 'albedo.png'\nalbedo-encoding = 'linear'";
    assert!((albedo(file, &options(SourceEncoding::Linear)) - 188.0 / 255.0).abs() < 1e-5);
    assert!((albedo(stated, &MapOptions::default()) - 188.0 / 255.0).abs() < 1e-5);
    assert!((albedo(stated, &options(SourceEncoding::Srgb)) - 0.502_886).abs() < 1e-5);
    let layered = MapOptions {
        layer: Some("diffuse".into()),
        ..MapOptions::default()
    };
    let (material, _) = bench.load(file, &layered, 16);
    let text = material.unwrap_err().to_string();
    assert!(text.starts_with("--layer: `diffuse`"), "{text}");
}
