//! Every reader, with sound files to begin from and what must lie beside them.

use std::fs;
use std::path::{Path, PathBuf};

use image::ImageFormat;
use mesotex::btf::bake::maps::read_recipe;
use mesotex::btf::fits::{Fit, hsh, ptm};
use mesotex::btf::import::{
    ImportOptions, ListOptions, PhotographOptions, SetOptions, array, assemble, read_list,
    read_source,
};
use mesotex::btf::{DType, Direction, DirectionSet, HeightMap, Layout, Sample};
use mesotex::cli::run::{Faults, Scene};
use mesotex::error::{Error, Result};
use mesotex::exemplar::neighbor_table::NeighborTable;
use mesotex::exemplar::{Space, Windows, space_of_vocabulary};
use mesotex::format::guard::guarded;
use mesotex::format::{compress, exr, image as images, json, npy};
use mesotex::grid::{TexCoord, TexelGrid};
use mesotex::index::Level;
use mesotex::maps::{AtlasMap, FaceMap, SurfaceTextonMap};
use mesotex::mesh::field::guides::GuideFile;
use mesotex::mesh::reading;
use mesotex::progress::Progress;
use mesotex::render::path_file;
use mesotex::sites::SurfaceOptions;
use mesotex::sites::vertices::cache;
use mesotex::sites::vertices::surface::prepare;
use mesotex::synthesis::{Checkpoint, Inputs, LevelMap, SynthesisOptions};
use mesotex::texton::{PartFile, StoredVocabulary};

use crate::bonn_files;
use crate::corpus;
use crate::mesh_corpus;
use crate::mutation::Content;
use crate::set_corpus;

/// What reads a file.
type Read = dyn Fn(&Path) -> Result<()>;

/// One reader.
pub struct Reader {
    /// What it reads.
    pub name: &'static str,
    /// What the file holds, for mutations that know.
    pub content: Content,
    /// Sound files.
    pub files: Vec<Vec<u8>>,
    /// Where the file lies in the folder.
    file: &'static str,
    /// Other files in the folder.
    beside: Vec<(&'static str, Vec<u8>)>,
    /// Reads a file as the program does.
    pub read: Box<Read>,
}

impl Reader {
    /// Puts what lies beside the file into a folder; where the file itself goes.
    pub fn prepare(&self, folder: &Path) -> PathBuf {
        let path = folder.join(self.file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        for (name, bytes) in &self.beside {
            fs::write(folder.join(name), bytes).unwrap();
        }
        path
    }

    fn beside(mut self, name: &'static str, bytes: Vec<u8>) -> Self {
        self.beside.push((name, bytes));
        self
    }
}

fn reader<T>(
    name: &'static str,
    content: Content,
    file: &'static str,
    files: Vec<Vec<u8>>,
    read: impl Fn(&Path) -> Result<T> + 'static,
) -> Reader {
    Reader {
        name,
        content,
        files,
        file,
        beside: Vec::new(),
        read: Box::new(move |path| read(path).map(drop)),
    }
}

/// All readers.
pub fn readers() -> Vec<Reader> {
    let mut readers = image_readers();
    readers.extend(mesh_readers());
    readers.extend(text_readers());
    readers.extend(set_readers());
    readers.extend(fit_readers());
    readers.extend(product_readers());
    readers.extend(atlas_readers());
    readers.extend(surface_readers());
    readers.push(bonn_reader());
    readers
}

/// `.btf` files of Bonn, imported as a user does.
fn bonn_reader() -> Reader {
    let files = bonn_files::all();
    reader("btf", Content::Bytes, "a.btf", files, bonn_files::import)
}

fn image_readers() -> Vec<Reader> {
    let read = |path: &Path| {
        // Transparent texels are refused by most callers; here they are to be decoded.
        let options = images::ReadOptions {
            alpha: images::Alpha::OverBlack,
            missing: images::Missing::Black,
            ..images::ReadOptions::default()
        };
        images::inspect(path, &options)?.read
    };
    let image = |name, content, files| reader(name, content, "a.image", files, read);
    let bytes = Content::Bytes;
    vec![
        image("png", Content::Png, corpus::pngs()),
        image("jpeg", bytes, corpus::images(ImageFormat::Jpeg)),
        image("gif", bytes, corpus::images(ImageFormat::Gif)),
        image("bmp", bytes, corpus::images(ImageFormat::Bmp)),
        image("hdr", bytes, vec![corpus::hdr()]),
        image("tiff", bytes, corpus::tiffs()),
        image("exr", bytes, corpus::exrs()),
        reader("exr header", bytes, "a.exr", corpus::exrs(), |path| {
            Ok(exr::read_text_attribute(path, "mesotex:options"))
        }),
    ]
}

fn mesh_readers() -> Vec<Reader> {
    let read = |path: &Path| reading::read(path, Progress::silent());
    let mesh = |name, content, file, files| reader(name, content, file, files, read);
    let (text, obj) = (Content::Text, mesh_corpus::OBJ);
    vec![
        mesh("ply", text, "a.ply", mesh_corpus::plys()),
        mesh("obj", text, "a.obj", vec![obj.into()]),
        mesh("off", text, "a.off", vec![mesh_corpus::OFF.into()]),
        mesh("stl", text, "a.stl", mesh_corpus::stls()),
        mesh("glb", Content::Glb, "a.glb", vec![mesh_corpus::glb()]),
        mesh("gltf", Content::Json, "a.gltf", mesh_corpus::gltf_texts())
            .beside("a.bin", mesh_corpus::buffer()),
        mesh(
            "gz",
            Content::Gzip,
            "a.obj.gz",
            vec![mesh_corpus::packed(obj)],
        ),
    ]
}

fn text_readers() -> Vec<Reader> {
    let text = Content::Text;
    let path_csv =
        "light_azimuth,light_elevation,camera_x,camera_y,camera_z\n0,30,1,2,3\n9,4,5,6,7\n";
    let path_json = r#"[{"frame": 1, "camera_azimuth": 20, "fov": 30, "target": [0, 1, 2]},
        {"camera_azimuth": 25, "fov": 31, "up": [0, 1, 0]}]"#;
    let angles =
        "file,view_theta_deg,view_phi_deg,light_theta_deg,light_phi_deg\na.png,0,0,60,90\n";
    let directions = "# two\ntheta_deg,phi_deg\n0,0\n45,120\n";
    let material = "height = \"height.png\"\nwidth-mm = 50\nheight-mm = 2\nalbedo = [0.5, 0.4, 0.3]\n\
        roughness = 0.4\n";
    let scene = "name = \"small\"\n[bake]\npreset = \"weave\"\nsize = 32\n[textons]\ntextons = 24\n\
        [mesh]\ninput = \"a.ply\"\n[synth]\nlevels = 2\n[[render]]\nframes = 2\nsize = \"64x48\"\n";
    let guides = r#"{"guides": [{"vertex": 7, "direction": [1, 0, 0]},
        {"point": [0, 1, 2], "direction": [0, 1, 0]}]}"#;
    vec![
        reader(
            "lp",
            text,
            "a.lp",
            vec![b"2\na.png 0 0 1\nb c.png 0.1 0.2 0.9\n".to_vec()],
            read_list,
        ),
        reader("angles csv", text, "a.csv", vec![angles.into()], read_list),
        reader(
            "directions csv",
            text,
            "a.csv",
            vec![directions.into()],
            |path| DirectionSet::File(path.to_path_buf()).directions(),
        ),
        reader(
            "path csv",
            text,
            "a.csv",
            vec![path_csv.into()],
            path_file::read,
        ),
        reader(
            "path json",
            Content::Json,
            "a.json",
            vec![path_json.into()],
            path_file::read,
        ),
        reader(
            "material",
            text,
            "a.toml",
            vec![material.into()],
            read_recipe,
        ),
        reader("scene", text, "a.toml", vec![scene.into()], use_scene),
        reader(
            "guides",
            Content::Json,
            "a.json",
            vec![guides.into()],
            json::read::<GuideFile>,
        ),
    ]
}

/// Fits over lights, each evaluated once, and the corners of photographs.
fn fit_readers() -> Vec<Reader> {
    let evaluated = |read: fn(&Path) -> Result<Fit>| {
        move |path: &Path| {
            let fit = read(path)?;
            let mut image = vec![0.0; 3 * fit.texels()];
            fit.evaluate(Direction::from_angles(0.7, 2.0), &mut image);
            Ok::<_, Error>(())
        }
    };
    let corners = "file,x1,y1,x2,y2,x3,y3,x4,y4\na.jpg,1,2,30,4,25,26,7,18\n";
    let text = Content::Text;
    vec![
        reader("ptm", text, "a.ptm", corpus::ptms(), evaluated(ptm::read)),
        reader(
            "hsh",
            text,
            "a.rti",
            corpus::harmonics(),
            evaluated(hsh::read),
        ),
        reader(
            "array",
            text,
            "a.npy",
            vec![corpus::measured_array()],
            |path| {
                let target = path.with_file_name("a.sample");
                let directions = [0.1, 0.2].map(|theta| Direction::from_angles(theta, 1.0));
                let both = (&directions[..], &directions[..]);
                array::import(
                    path,
                    both,
                    &ImportOptions::default(),
                    target.as_path(),
                    Progress::silent(),
                )
            },
        ),
        reader("corners csv", text, "a.csv", vec![corners.into()], |path| {
            let options = PhotographOptions {
                corners: Some(path.to_path_buf()),
                ..PhotographOptions::default()
            };
            options.rectification()
        }),
    ]
}

/// Reads a scene and the command lines it stands for.
fn use_scene(path: &Path) -> Result<()> {
    let text = fs::read_to_string(path).map_err(Error::io(path, "read"))?;
    guarded(path, || {
        let mut faults = Faults::default();
        for scene in Scene::all(&text, &mut faults) {
            for draft in scene.drafts(&mut faults) {
                draft.words(&[]);
            }
        }
        faults.into_result(path)
    })
}

/// Archives of images, and what lies in them.
fn set_readers() -> Vec<Reader> {
    let set = |name, files| reader(name, Content::Zip, "a.zip", files, use_set);
    let positions = "file,camera_x_mm,camera_y_mm,camera_z_mm,light_theta_deg,light_phi_deg\n\
        a.png,0,0,500,60,90\n";
    vec![
        set("image set", set_corpus::image_sets()),
        set("spectral set", vec![set_corpus::spectral_set()]),
        reader(
            "compress",
            Content::Bytes,
            "a.Z",
            set_corpus::compressed_files(),
            |path| compress::expand(&fs::read(path).map_err(Error::io(path, "read"))?),
        ),
        reader(
            "positions csv",
            Content::Text,
            "a.csv",
            vec![positions.into()],
            read_list,
        ),
    ]
}

/// Imports an archive, beside it.
fn use_set(path: &Path) -> Result<()> {
    let list = read_source(&[path], &ListOptions::default(), &SetOptions::default())?;
    let target = path.with_file_name("x.sample");
    let options = ImportOptions::default();
    assemble(&list, &options, target.as_path(), Progress::silent()).map(drop)
}

fn product_readers() -> Vec<Reader> {
    let zip = Content::Zip;
    let (f2, pairs) = (
        corpus::sample(DType::F2, Layout::Product),
        corpus::sample(DType::F4, Layout::Pairs),
    );
    let [described, directions, eigentextures] = corpus::factored_sample();
    let spaces = vec![
        corpus::space_bytes(corpus::space()),
        corpus::space_bytes(corpus::features()),
        corpus::space_bytes(corpus::channels()),
    ];
    let text = Content::Text;
    vec![
        reader(
            "npy",
            text,
            "a.npy",
            vec![corpus::array()],
            npy::read::<f32>,
        ),
        reader(
            "textons",
            zip,
            "a.textons.npz",
            vec![corpus::vocabulary(false), corpus::vocabulary(true)],
            |path| space_of_vocabulary(&StoredVocabulary::open(path)?),
        ),
        reader(
            "texton part",
            zip,
            "p.npz",
            vec![corpus::texton_part()],
            PartFile::read,
        ),
        reader("space", zip, "a.space.npz", spaces, Space::read),
        reader("knn", zip, "a.knn.npz", vec![corpus::table().1], use_table),
        reader(
            "btf.json",
            Content::Json,
            "a.sample/btf.json",
            vec![f2.0.clone()],
            use_sample,
        )
        .beside("a.sample/radiance.npy", f2.1.clone()),
        reader(
            "btf.json pairs",
            Content::Json,
            "a.sample/btf.json",
            vec![pairs.0],
            use_sample,
        )
        .beside("a.sample/radiance.npy", pairs.1),
        reader(
            "btf.json factored",
            Content::Json,
            "a.sample/btf.json",
            vec![described.clone()],
            use_sample,
        )
        .beside("a.sample/directions.npy", directions.clone())
        .beside("a.sample/eigentextures.npy", eigentextures.clone()),
        reader(
            "directions",
            text,
            "a.sample/directions.npy",
            vec![directions.clone()],
            use_sample,
        )
        .beside("a.sample/btf.json", described.clone())
        .beside("a.sample/eigentextures.npy", eigentextures.clone()),
        reader(
            "eigentextures",
            text,
            "a.sample/eigentextures.npy",
            vec![eigentextures],
            use_sample,
        )
        .beside("a.sample/btf.json", described)
        .beside("a.sample/directions.npy", directions),
        reader(
            "heights",
            text,
            "a.sample/height.npy",
            vec![corpus::heights()],
            use_heights,
        ),
        reader(
            "radiance",
            text,
            "a.sample/radiance.npy",
            vec![f2.1],
            use_sample,
        )
        .beside("a.sample/btf.json", f2.0),
        reader(
            "map",
            text,
            "a.map.ply",
            vec![corpus::map()],
            SurfaceTextonMap::read,
        ),
        reader(
            "face map",
            text,
            "a.faces.ply",
            vec![corpus::face_map()],
            FaceMap::read,
        ),
    ]
}

/// One reader for each file of an atlas, the others beside it.
fn atlas_readers() -> Vec<Reader> {
    let files = [
        ("a.atlas/atlas.json", Content::Json),
        ("a.atlas/coords.npy", Content::Text),
        ("a.atlas/texton.npy", Content::Text),
        ("a.atlas/surface.npz", Content::Zip),
    ];
    let all = corpus::atlas();
    let read = |path: &Path| AtlasMap::read(path.parent().unwrap());
    let one = |(at, (place, content)): (usize, (&'static str, Content))| {
        let one = reader(place, content, place, vec![all[at].1.clone()], read);
        let others = files
            .iter()
            .zip(&all)
            .filter(|((other, _), _)| *other != place);
        others.fold(one, |one, ((other, _), (_, bytes))| {
            one.beside(other, bytes.clone())
        })
    };
    files.into_iter().enumerate().map(one).collect()
}

/// Reads a table and lays out the windows it describes, as synthesis does.
fn use_table(path: &Path) -> Result<()> {
    let table = NeighborTable::read(path)?;
    let space = corpus::space();
    table.check_belongs_to(&space, true)?;
    for (at, (level, listed)) in space.levels.iter().zip(&table.levels).enumerate() {
        let rows = vec![0; level.grid.len()];
        Windows::new(level.grid, &rows, 0, &listed.neighborhood.offsets);
        table.whole_texels(at, level.grid);
    }
    Ok(())
}

/// Reads the heights of a sample of 4 × 3 texels.
fn use_heights(path: &Path) -> Result<()> {
    let grid = TexelGrid {
        width: 4,
        height: 3,
        tileable: true,
    };
    HeightMap::read(path.parent().unwrap(), grid).map(drop)
}

/// Opens the sample a file belongs to and reads all its images.
fn use_sample(path: &Path) -> Result<()> {
    let sample = Sample::open(path.parent().unwrap())?;
    for image in 0..sample.image_count() {
        let pixels = sample.image(image)?;
        let mut values = vec![0.0; pixels.len()];
        pixels.copy_to(&mut values);
        sample.check_image(image, &values)?;
    }
    Ok(())
}

/// Caches of surfaces and checkpoints of syntheses.
fn surface_readers() -> Vec<Reader> {
    let options = SurfaceOptions {
        levels: 1,
        neighborhood: 3,
        ..SurfaceOptions::default()
    };
    let user = mesh_corpus::user_mesh();
    let surface = prepare(&user, &options, None, Progress::silent()).unwrap();
    let cached = corpus::file_bytes("a.surface.npz", |path| {
        let wanted = cache::Wanted::new(&user, &options).unwrap();
        cache::write(path, &wanted, &surface).unwrap()
    });
    let (space, table) = (corpus::space(), corpus::table().0);
    let sites = surface.into_sites();
    let load = move |path: &Path| {
        let inputs = Inputs {
            space: &space,
            table: &table,
            sites: &sites,
            controls: None,
        };
        let output = path.with_file_name("a.map.ply");
        Ok::<_, Error>((
            Checkpoint::new(&output, inputs, &SynthesisOptions::default())?,
            inputs.sites.levels[0].areas.len(),
        ))
    };
    let kept = corpus::file_bytes(".a.map.ply.resume", |path| {
        let (checkpoint, sites) = load(path).unwrap();
        let map = LevelMap {
            level: Level(0),
            coords: vec![TexCoord { s: 0.5, t: 0.5 }; sites],
            searched: 0,
        };
        checkpoint.save(&map).unwrap();
    });
    vec![
        reader(
            "mesh cache",
            Content::Zip,
            "a.surface.npz",
            vec![cached],
            move |path| cache::read(path, &cache::Wanted::new(&user, &options)?),
        ),
        reader(
            "checkpoint",
            Content::Zip,
            ".a.map.ply.resume",
            vec![kept],
            move |path| load(path)?.0.load(Progress::silent()),
        ),
    ]
}
