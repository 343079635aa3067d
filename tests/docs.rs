//! Every command in README.md and docs/ is run, in order: first the README's, then each page's in a
//! copy of the folder the README leaves. Sizes are cut down; names and options are not.

mod image_set_files;
mod program;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Numbers of these options are cut down to the given one.
const CAPS: [(&str, u64); 10] = [
    ("--size", 64),
    ("--vertices", 4000),
    ("--textons", 16),
    ("--images", 9),
    ("--frames", 2),
    ("--k", 4),
    ("--samples", 2),
    ("--bounces", 2),
    ("--resolution", 96),
    ("--base-faces", 200),
];

/// Direction sets of these options become a small one.
const DIRECTIONS: [&str; 2] = ["--views", "--lights"];
const FEW_DIRECTIONS: &str = "fibonacci:9";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All pages, the README first.
fn pages() -> Vec<PathBuf> {
    let mut pages = Vec::new();
    let mut folders = vec![root().join("docs")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "md") {
                pages.push(path);
            }
        }
    }
    pages.sort();
    pages.insert(0, root().join("README.md"));
    pages
}

/// The command lines of a page's `sh` blocks, continued lines joined.
fn commands(page: &Path) -> Vec<String> {
    let text = fs::read_to_string(page).unwrap().replace("\\\n", " ");
    let mut commands = Vec::new();
    let mut inside = false;
    for line in text.lines() {
        if line.starts_with("```") {
            inside = line == "```sh" && !inside;
        } else if inside && !line.trim().is_empty() && !line.starts_with('#') {
            commands.push(line.trim().to_owned());
        }
    }
    commands
}

/// The words after `mesotex` of a command this test runs; `None` for other programs. A bake takes one sample unless it
/// says otherwise.
fn words_of(command: &str) -> Option<Vec<String>> {
    let command = command.split(" #").next().unwrap_or_default();
    let rest = command
        .strip_prefix("cargo run --release -- ")
        .or_else(|| command.strip_prefix("mesotex "))?;
    let mut words = cut_down(rest.split_whitespace());
    let says_samples = |word: &String| word == "--samples" || word == "--reduce";
    if words[0] == "bake" && !words.iter().any(says_samples) {
        words.extend(["--samples", "1"].map(str::to_owned));
    }
    Some(words)
}

fn cut_down<'a>(words: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut option = "";
    let mut cut = Vec::new();
    for word in words {
        let cap = CAPS.iter().find(|(name, _)| *name == option);
        cut.push(match cap {
            Some(&(_, cap)) => cut_number(word, cap),
            None if DIRECTIONS.contains(&option) => FEW_DIRECTIONS.to_owned(),
            None => word.to_owned(),
        });
        option = word;
    }
    cut
}

/// `1280x960` and `128` cut to the cap; what is no number stays.
fn cut_number(word: &str, cap: u64) -> String {
    let cut = |part: &str| {
        part.parse::<u64>()
            .map(|number| number.min(cap).to_string())
    };
    let parts: Result<Vec<String>, _> = word.split('x').map(cut).collect();
    parts.map_or(word.to_owned(), |parts| parts.join("x"))
}

fn run(words: &[String], folder: &Path) -> Result<(), String> {
    let output = Command::new(env!("CARGO_BIN_EXE_mesotex"))
        .args(words)
        .current_dir(folder)
        .output()
        .unwrap();
    match output.status.success() {
        true => Ok(()),
        false => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
    }
}

fn check_page(page: &Path, folder: &Path) -> usize {
    let mut ran = 0;
    for command in commands(page) {
        if let Some(words) = words_of(&command) {
            if let Err(error) = run(&words, folder) {
                panic!(
                    "{}: `{command}`, run as `{}`, failed:\n{error}",
                    page.display(),
                    words.join(" ")
                );
            }
            ran += 1;
        } else if let Some(script) = command
            .split_whitespace()
            .find(|word| word.starts_with("tools/"))
        {
            assert!(
                root().join(script).exists(),
                "{}: no {script}",
                page.display()
            );
        }
    }
    ran
}

#[test]
fn the_commands_of_every_page_run() {
    let first = tempfile::tempdir().unwrap();
    fixtures::fill(first.path());
    let pages = pages();
    let mut ran = check_page(&pages[0], first.path());
    for page in &pages[1..] {
        let copy = tempfile::tempdir().unwrap();
        copy_all(first.path(), copy.path());
        ran += check_page(page, copy.path());
    }
    assert!(ran > 10, "only {ran} commands were found");
}

#[test]
fn pages_link_only_to_what_is_there() {
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        for link in text
            .split("](")
            .skip(1)
            .filter_map(|rest| rest.split(')').next())
        {
            if link.contains("://") {
                continue;
            }
            let (target, anchor) = link.split_once('#').unwrap_or((link, ""));
            let path = match target {
                "" => page.clone(),
                _ => page.parent().unwrap().join(target),
            };
            assert!(path.exists(), "{}: dead link {link}", page.display());
            let is_there = anchor.is_empty() || anchors(&path).iter().any(|name| name == anchor);
            assert!(is_there, "{}: no heading {link}", page.display());
        }
    }
}

/// The names by which the headings of a page are linked.
fn anchors(page: &Path) -> Vec<String> {
    let text = fs::read_to_string(page).unwrap();
    let headings = text.lines().filter(|line| line.starts_with('#'));
    let kept = |sign: &char| sign.is_alphanumeric() || " -_".contains(*sign);
    headings
        .map(|line| {
            let title = line.trim_start_matches('#').trim().to_lowercase();
            title
                .chars()
                .filter(kept)
                .map(|sign| if sign == ' ' { '-' } else { sign })
                .collect()
        })
        .collect()
}

/// The lines of a text without their indentation.
fn unindented(text: &str) -> String {
    text.lines()
        .map(|line| format!("{}\n", line.trim()))
        .collect()
}

/// All source text below a folder, unindented.
fn sources(folder: &Path) -> String {
    let mut all = String::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.push_str(&sources(&path));
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            all.push_str(&unindented(&fs::read_to_string(&path).unwrap()));
        }
    }
    all
}

#[test]
fn every_tool_is_listed() {
    let listed = fs::read_to_string(root().join("tools/README.md")).unwrap();
    let is_program = |name: &String| {
        [".py", ".sh", ".mjs"]
            .iter()
            .any(|ending| name.ends_with(ending))
    };
    let files = fs::read_dir(root().join("tools")).unwrap();
    let names = files.map(|file| file.unwrap().file_name().into_string().unwrap());
    let mut missing: Vec<String> = names
        .filter(is_program)
        .filter(|name| !listed.contains(&format!("| `{name}` |")))
        .collect();
    missing.sort();
    assert!(missing.is_empty(), "tools/README.md lacks {missing:?}");
}

#[test]
fn quoted_code_is_that_of_the_sources() {
    let all = sources(&root().join("src"));
    let page = fs::read_to_string(root().join("docs/extending.md")).unwrap();
    let quotes: Vec<&str> = page.split("```rust\n").skip(1).collect();
    assert!(quotes.len() > 5, "{}", quotes.len());
    for quote in quotes {
        let (code, _) = quote.split_once("```").unwrap();
        assert!(
            all.contains(&unindented(code)),
            "docs/extending.md quotes no source:\n{code}"
        );
    }
}

fn copy_all(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy_all(&path, &target);
        } else {
            fs::copy(&path, &target).unwrap();
        }
    }
}

/// The user's files that the pages speak of.
mod fixtures {
    use std::collections::BTreeMap;
    use std::fmt::Write as _;
    use std::fs;
    use std::path::{Path, PathBuf};

    use image::{GrayImage, Luma, Rgb, RgbImage};
    use mesotex::mesh::builtin::kettlebell;

    use crate::{image_set_files, program};

    /// A scene of eight runs, quickly run.
    const SWEEP: &str = "name = \"sweep\"\noutput = \"out\"\n[matrix]\n\
        bake.preset = [\"weave\", \"knit\"]\nmesh.input = [\"bunny.obj\", \"horse.obj\"]\n\
        synth.seed = [0, 1]\n[bake]\nsize = 16\nviews = \"fibonacci:4\"\nlights = \"fibonacci:4\"\n\
        samples = 1\n[textons]\ntextons = 8\nlevels = 2\n[mesh]\nvertices = 400\n[synth]\nlevels = 2\n\
        [[render]]\nsize = \"32x24\"\nsweep = \"light-azimuth\"\nframes = 4\n";

    /// `bunny.obj`, `horse.obj`, `sweep.toml`, `keys.json`, `material/`, `capture/`, `felt/`, `near/`, `photos/`, `pictures/`,
    /// `mean.npy` of as many directions as commands are cut down to, and an archive as UBO2003 has them.
    pub fn fill(folder: &Path) {
        mesh(&folder.join("bunny.obj"));
        quadrilaterals(&folder.join("horse.obj"));
        fs::write(folder.join("sweep.toml"), SWEEP).unwrap();
        material(&folder.join("material"));
        capture(&folder.join("capture"));
        felt(&folder.join("felt"));
        near(&folder.join("near"));
        by_names(&folder.join("photos"), |light, view| {
            format!("light{light}-0_view{view}-90.png")
        });
        archive(folder);
        pictures(&folder.join("pictures"));
        let mean = ndarray::Array3::from_elem((9, 9, 3), 0.2f32);
        mesotex::format::npy::write(&folder.join("mean.npy"), mean.view().into_dyn()).unwrap();
        keys(&folder.join("keys.json"));
    }

    fn mesh(path: &Path) {
        let mesh = kettlebell(600);
        let mut text = String::new();
        for p in &mesh.positions {
            let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
        }
        for [a, b, c] in &mesh.triangles {
            let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
        }
        fs::write(path, text).unwrap();
    }

    /// Key values at two ends of the mesh.
    fn keys(path: &Path) {
        let keys =
            r#"{"keys": [{"vertex": 0, "transition": 0.1}, {"vertex": 40, "transition": 0.9}]}"#;
        fs::write(path, keys).unwrap();
    }

    /// The six faces of a cube.
    fn quadrilaterals(path: &Path) {
        let mut text = String::new();
        for corner in 0..8 {
            let _ = writeln!(text, "v {} {} {}", corner & 1, corner >> 1 & 1, corner >> 2);
        }
        text.push_str("f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n");
        fs::write(path, text).unwrap();
    }

    fn wave(x: u32, y: u32) -> u8 {
        let turn = |v: u32| (f64::from(v) / 16.0 * std::f64::consts::TAU).sin();
        (128.0 + 60.0 * turn(x) + 60.0 * turn(x + 2 * y)) as u8
    }

    fn material(folder: &Path) {
        fs::create_dir_all(folder).unwrap();
        let save = |image: GrayImage, name: &str| image.save(folder.join(name)).unwrap();
        save(
            GrayImage::from_fn(32, 32, |x, y| Luma([wave(x, y)])),
            "height.png",
        );
        save(GrayImage::from_pixel(32, 32, Luma([150])), "roughness.png");
        let albedo = RgbImage::from_fn(32, 32, |x, y| Rgb([wave(x, y), 90, 60]));
        albedo.save(folder.join("albedo.png")).unwrap();
    }

    fn photograph(path: &Path, shift: u32) {
        let image = RgbImage::from_fn(24, 16, |x, y| Rgb([wave(x + shift, y), 100, 80]));
        image.save(path).unwrap();
    }

    fn capture(folder: &Path) {
        fs::create_dir_all(folder).unwrap();
        let mut list = String::from("6\n");
        for light in 0..6u32 {
            photograph(&folder.join(format!("{light}.png")), light);
            let (y, x) = f64::from(light).sin_cos();
            let _ = writeln!(list, "{light}.png {} {} 0.8", 0.6 * x, 0.6 * y);
        }
        fs::write(folder.join("dirs.lp"), list).unwrap();
    }

    /// Three views and three lights at 0, 15 and 30 degrees.
    fn by_names(folder: &Path, name: impl Fn(u32, u32) -> String) {
        fs::create_dir_all(folder).unwrap();
        for (light, view) in (0..3).flat_map(|light| (0..3).map(move |view| (light, view))) {
            photograph(&folder.join(name(15 * light, 15 * view)), light + view);
        }
    }

    fn archive(folder: &Path) {
        let unpacked = folder.join("unpacked");
        by_names(&unpacked, |light, view| {
            format!("00000 tl{light:03} pl000 tv{view:03} pv000.jpg")
        });
        let members = program::files(&unpacked);
        image_set_files::zip(&folder.join("UBO_IMPALLA256.zip"), &members, true);
        in_two(&folder.join("parts"), &members);
        fs::remove_dir_all(unpacked).unwrap();
    }

    /// The members of an archive in two, by their lights.
    fn in_two(folder: &Path, members: &BTreeMap<PathBuf, Vec<u8>>) {
        fs::create_dir(folder).unwrap();
        for (name, is_first) in [("lights-a.zip", true), ("lights-b.zip", false)] {
            let mut own = members.clone();
            own.retain(|path, _| path.to_string_lossy().contains("tl000") == is_first);
            image_set_files::zip(&folder.join(name), &own, true);
        }
    }

    fn near(folder: &Path) {
        fs::create_dir_all(folder).unwrap();
        photograph(&folder.join("a.png"), 0);
        photograph(&folder.join("b.png"), 1);
        let table = "file,camera_x_mm,camera_y_mm,camera_z_mm,light_x_mm,light_y_mm,light_z_mm\n\
            a.png,0,0,600,300,0,400\nb.png,0,0,600,0,300,400\n";
        fs::write(folder.join("places.csv"), table).unwrap();
    }

    fn felt(folder: &Path) {
        fs::create_dir_all(folder).unwrap();
        let mut table =
            String::from("file,view_theta_deg,view_phi_deg,light_theta_deg,light_phi_deg\n");
        for image in 0..12u32 {
            photograph(&folder.join(format!("{image}.png")), image);
            let _ = writeln!(
                table,
                "{image}.png,{},0,30,{}",
                20 * (image / 4),
                90 * (image % 4)
            );
        }
        fs::write(folder.join("angles.csv"), table).unwrap();
    }
    /// Photographs of a patch, with their corners, by camera and lamp and by flash.
    fn pictures(folder: &Path) {
        fs::create_dir_all(folder).unwrap();
        let mut angles =
            String::from("file,view_theta_deg,view_phi_deg,light_theta_deg,light_phi_deg\n");
        let mut flash = String::from("file,view_theta_deg,view_phi_deg\n");
        let mut corners = String::from("file,x1,y1,x2,y2,x3,y3,x4,y4\n");
        for image in 0..5u32 {
            photograph(&folder.join(format!("{image}.png")), image);
            let view = format!("{image}.png,{},{}", 10 * image, 72 * image);
            let _ = writeln!(angles, "{view},30,{}", 90 * image);
            let _ = writeln!(flash, "{view}");
            let _ = writeln!(corners, "{image}.png,3.5,2,21,{image}.5,20,14,4,13");
        }
        let mut lamps =
            String::from("file,view_theta_deg,view_phi_deg,light_x_mm,light_y_mm,light_z_mm\n");
        for image in 0..5u32 {
            let _ = writeln!(lamps, "{image}.png,0,0,{},40,250", 50 * image);
        }
        fs::write(folder.join("lamps.csv"), lamps).unwrap();
        fs::write(folder.join("angles.csv"), angles).unwrap();
        fs::write(folder.join("flash.csv"), flash).unwrap();
        fs::write(folder.join("corners.csv"), corners).unwrap();
    }
}
