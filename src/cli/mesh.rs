//! `mesotex mesh`: clean a mesh, retile it, give it an orientation field, see how it stands.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use glam::Vec3;
use serde_json::{Value, json};

use crate::cli::machine::{self, Need};
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::error::{Error, Result};
use crate::format::gltf::companions::companions;
use crate::format::ours::Format;
use crate::format::{image, json as json_file};
use crate::mesh::cache;
use crate::mesh::connection::Connection;
use crate::mesh::distortion::distortion;
use crate::mesh::field::Field;
use crate::mesh::field::guides::{Canvas, guided_field};
use crate::mesh::field::singularities::{Singularity, singularities};
use crate::mesh::memory;
use crate::mesh::patches::Patches;
use crate::mesh::pictures::{self, Picture};
use crate::mesh::quality::{evenness, hausdorff};
use crate::mesh::reading::{CleaningOptions, UserMesh, read_with};
use crate::mesh::retile::retile;
use crate::mesh::rings::Rings;
use crate::mesh::surface::{Surface, prepare};
use crate::mesh::surface_options::SurfaceOptions;
use crate::mesh::surface_tree::SurfaceTree;
use crate::mesh::topology::{Shape, Topology};
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::mesh::writing;
use crate::progress::Progress;
use crate::render::preview;

const EXAMPLES: &str = "Examples:
  mesotex mesh bunny.obj -o bunny.ply                      clean and convert
  mesotex mesh bunny.obj -o even.ply --vertices 250000     retile to 250,000 even vertices
  mesotex mesh bunny.obj -o guided.ply --orient --direction 0,1,0
                                                           add a field that follows the y axis
  mesotex mesh bunny.obj -o even.ply --vertices 20000 --report mesh.json --pictures look
                                                           measure it and look at it
  mesotex mesh scan.stl -o scan.ply --strict               refuse a scan that needs repair";

/// The farthest a chart's samples lie, in texels, when its distortion is drawn.
const DISTORTION_RADIUS: f32 = 5.0;
/// Mean distortion drawn red.
const MOST_DISTORTION: f32 = 0.1;
/// Pixels of a picture.
const PICTURE: [u32; 2] = [1280, 960];

/// What is done to a mesh.
#[derive(Clone, Debug, PartialEq, Args)]
pub struct MeshOptions {
    /// Retile to so many vertices, spread evenly over the same surface (100 to 20,000,000).
    /// Default: the mesh's own vertices.
    #[arg(long)]
    pub vertices: Option<usize>,
    /// Refuse a mesh that needs repair.
    #[arg(long)]
    pub strict: bool,
    /// Drop components smaller than this fraction of the mesh, by the diagonals of their boxes.
    #[arg(long, default_value_t = 0.0)]
    pub specks: f64,
    /// Write the orientation field into the mesh (PLY: sx sy sz), for viewing or as a guide.
    #[arg(long)]
    pub orient: bool,
    /// Write what is measured here: evenness, distance to the input, field, singularities, samples.
    /// The prepared surface is kept beside the output, where synth finds it.
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Draw the field with its singularities, the levels and the distortion of patches into this
    /// folder, as PNG and coloured PLY.
    #[arg(long, value_name = "DIR")]
    pub pictures: Option<PathBuf>,
    /// Levels of the mesh pyramid that are measured and drawn.
    #[arg(long, default_value_t = SurfaceOptions::default().levels)]
    pub levels: u32,
}

impl MeshOptions {
    /// Checks every field.
    pub fn validate(&self) -> Result<()> {
        if let Some(vertices) = self.vertices {
            if !(100..=20_000_000).contains(&vertices) {
                return Err(Error::option(
                    "vertices",
                    vertices.to_string(),
                    "100 to 20,000,000",
                ));
            }
            check_memory(vertices)?;
        }
        if !(0.0..1.0).contains(&self.specks) {
            return Err(Error::option(
                "specks",
                self.specks.to_string(),
                "a fraction, 0 to below 1",
            ));
        }
        Ok(())
    }
}

/// Refuses more vertices than this machine has memory for, where that is known.
fn check_memory(vertices: usize) -> Result<()> {
    let available = machine::available_memory().map_or(u64::MAX, |size| size.0);
    let need = Need {
        bytes: memory::bytes_to_retile(vertices),
        work: format!("{vertices} vertices"),
        option: "vertices",
        advice: format!("{} vertices", memory::vertices_retiled_in(available)),
    };
    need.check()
}

/// Refuses a surface that this machine has too little memory to prepare.
fn check_field_memory(user: &UserMesh, options: &SurfaceOptions) -> Result<()> {
    let texel = options.texel_on(&user.mesh)?;
    let need = Need {
        bytes: memory::bytes_to_prepare(user, options, texel),
        work: format!(
            "{} vertices at a texel of {texel}",
            user.mesh.positions.len()
        ),
        option: "texel",
        advice: "a smaller --texel, or fewer --vertices".into(),
    };
    need.check()
}

/// Clean a mesh, retile it evenly, give it an orientation field.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The mesh: .obj, .ply, .stl, .off, .glb or .gltf, each also with .gz.
    pub input: PathBuf,
    /// Where to write it: .ply, .obj or .glb.
    #[arg(long, short)]
    pub output: PathBuf,
    /// What is done.
    #[command(flatten)]
    pub options: MeshOptions,
    /// How field, levels and patches are prepared.
    #[command(flatten)]
    pub surface: SurfaceOptions,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        self.check()?;
        let surface_options = self.surface_options(session.seed());
        let _locks = self.files()?.claim()?;
        let cleaning = CleaningOptions {
            strict: self.options.strict,
            specks: self.options.specks,
        };
        let read = read_with(&self.input, &cleaning, session.progress())?;
        warn_of_scales(session, &read.mesh);
        let mut outcome = read_outcome(&self.input, &read);
        let mut user = self.retiled(session, &read)?;
        outcome = with_shape(outcome, &user.mesh);
        if let Some(wanted) = self.options.vertices {
            let distance = hausdorff(&read.mesh, &user.mesh) / read.mesh.diagonal();
            warn_of_count(session, user.mesh.positions.len(), wanted);
            outcome = outcome
                .line(format!(
                    "distance to the input {:.4} % of its diagonal",
                    100.0 * distance
                ))
                .figure("hausdorff_over_diagonal", distance);
        }
        if self.wants_field() {
            check_field_memory(&user, &surface_options)?;
            outcome = self.with_field(session, outcome, &mut user, &surface_options)?;
        }
        writing::write_user(&self.output, &user)?;
        if let Some(report) = &self.options.report {
            json_file::write(report, &Value::Object(outcome.figures.clone()))?;
            outcome = outcome.wrote(report);
        }
        let next = format!(
            "mesotex synth X.space.npz X.knn.npz {} -o Y.map.ply",
            self.output.display()
        );
        Ok(outcome.wrote(&self.output).next(next))
    }

    /// What the command reads and writes.
    pub fn files(&self) -> Result<Files> {
        let mesh = Product::File(Format::Mesh);
        let mut files = Files::default()
            .read([&self.input])
            .read(&companions(&self.input)?)
            .read(&self.surface.guide)
            .write("output", [&self.output], mesh)
            .write("report", &self.options.report, Product::File(Format::Json));
        for folder in self
            .options
            .pictures
            .iter()
            .filter(|folder| folder.is_dir())
        {
            for name in picture_names(self.options.levels) {
                let [ply, png] = picture_files(folder, &name);
                files = files.write("pictures", [&ply], mesh).write(
                    "pictures",
                    [&png],
                    Product::File(Format::Picture),
                );
            }
        }
        Ok(files)
    }

    fn surface_options(&self, seed: u64) -> SurfaceOptions {
        SurfaceOptions {
            levels: self.options.levels,
            seed,
            ..self.surface.clone()
        }
    }

    /// Refuses options that no input could satisfy.
    pub fn check(&self) -> Result<()> {
        self.options.validate()?;
        self.surface_options(0).validate()?;
        writing::check_name(&self.output)?;
        let as_ply = self
            .output
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("ply"));
        if self.options.orient && !as_ply {
            return Err(Error::option(
                "orient",
                self.output.display().to_string(),
                "an output that ends in .ply",
            ));
        }
        Ok(())
    }

    fn wants_field(&self) -> bool {
        self.options.orient || self.options.report.is_some() || self.options.pictures.is_some()
    }

    /// The mesh itself, or its even retiling.
    fn retiled(&self, session: &Session, read: &UserMesh) -> Result<UserMesh> {
        let Some(vertices) = self.options.vertices else {
            return Ok(read.clone());
        };
        let crease = self.surface.crease.to_radians();
        let mesh = retile(&read.mesh, vertices, crease, session.progress())?;
        Ok(UserMesh {
            from_file: (0..mesh.positions.len() as u32).collect(),
            mesh,
            ..UserMesh::default()
        })
    }

    fn with_field(
        &self,
        session: &Session,
        outcome: Outcome,
        user: &mut UserMesh,
        options: &SurfaceOptions,
    ) -> Result<Outcome> {
        let oriented = Oriented::new(user, options, session.progress())?;
        let mut outcome = oriented.describe(outcome, user);
        if self.options.report.is_some() || self.options.pictures.is_some() {
            let folder = cache::folder_of(&self.output);
            let surface = prepare(user, options, Some(&folder), session.progress())?;
            outcome = describe_levels(outcome, &surface);
            if let Some(folder) = &self.options.pictures {
                outcome = draw(outcome, folder, user, &oriented, &surface)?;
            }
        }
        if self.options.orient {
            user.orientation = Some(oriented.directions());
        }
        Ok(outcome)
    }
}

/// A user's mesh with its field.
struct Oriented {
    rings: Rings,
    field: Field,
    singular: Vec<Singularity>,
    texel: f64,
}

impl Oriented {
    fn new(user: &UserMesh, options: &SurfaceOptions, progress: Progress<'_>) -> Result<Self> {
        let rings = Rings::new(&user.mesh, &Topology::new(&user.mesh.triangles));
        let texel = options.texel_on(&user.mesh)?;
        let canvas = Canvas {
            user,
            rings: &rings,
            tree: &SurfaceTree::new(&user.mesh),
            texel,
        };
        let field = guided_field(canvas, &options.guides(), options.seed, progress)?;
        let singular = singularities(&user.mesh, &rings, &field.vectors);
        Ok(Self {
            rings,
            field,
            singular,
            texel,
        })
    }

    fn directions(&self) -> Vec<Vec3> {
        let angles = self.field.angles();
        let direction = |vertex: usize| match self.rings.edges.row(vertex).is_empty() {
            true => Vec3::X,
            false => self.rings.direction(vertex, angles[vertex]),
        };
        (0..angles.len()).map(direction).collect()
    }

    fn describe(&self, outcome: Outcome, user: &UserMesh) -> Outcome {
        let sum: i32 = self.singular.iter().map(|s| s.index).sum();
        let list: Vec<Value> = self
            .singular
            .iter()
            .map(|s| {
                let centre = pictures::centroid(&user.mesh, s.triangle as usize);
                json!({ "triangle": s.triangle, "index": s.index, "position": centre.to_array() })
            })
            .collect();
        let energy = self.field.energy;
        outcome
            .line(format!(
                "field: {} singular triangles, index sum {sum}, smoothness energy {energy:.6e}",
                list.len()
            ))
            .figure("field_energy", energy)
            .figure("singularity_index_sum", sum)
            .figure("singularities", list)
    }

    /// Mean distortion of the chart round each vertex.
    fn distortion(&self, user: &UserMesh) -> Vec<f32> {
        let connection = Connection::new(&self.rings, &self.field.angles());
        let texels = vec![self.texel as f32; user.mesh.positions.len()];
        let patches = Patches {
            mesh: &user.mesh,
            connection: &connection,
            texels: &texels,
        };
        distortion(patches, DISTORTION_RADIUS)
    }
}

fn shape_of(mesh: &TriangleMesh) -> Shape {
    Topology::new(&mesh.triangles).shape(mesh)
}

pub(super) fn with_shape(outcome: Outcome, mesh: &TriangleMesh) -> Outcome {
    let shape = shape_of(mesh);
    let even = evenness(mesh);
    let texel = (mesh.area() / mesh.referenced_count() as f64).sqrt();
    outcome
        .line(format!(
            "{} vertices, {} triangles, {} components, {} boundaries, Euler characteristic {}",
            mesh.positions.len(),
            mesh.triangles.len(),
            shape.components,
            shape.boundaries,
            shape.euler_characteristic
        ))
        .line(format!(
            "area {:.6}, default texel {texel:.6}; edges vary by {:.3}, smallest angle of 99 % of triangles {:.1}°",
            mesh.area(),
            even.edge_variation,
            even.smallest_angle_of_99_percent
        ))
        .figure("vertices", mesh.positions.len())
        .figure("triangles", mesh.triangles.len())
        .figure("components", shape.components)
        .figure("boundaries", shape.boundaries)
        .figure("euler_characteristic", shape.euler_characteristic)
        .figure("area", mesh.area())
        .figure("texel", texel)
        .figure("evenness", json!(even))
}

fn describe_levels(outcome: Outcome, surface: &Surface) -> Outcome {
    let levels = surface.meshes.iter().zip(&surface.samples);
    let figures: Vec<Value> = levels
        .map(|(mesh, samples)| {
            let shape = shape_of(mesh);
            json!({
                "vertices": mesh.positions.len(),
                "boundaries": shape.boundaries,
                "euler_characteristic": shape.euler_characteristic,
                "evenness": evenness(mesh),
                "samples_with_value": samples.valued,
                "samples_outside": samples.outside,
                "samples_folded": samples.folded,
            })
        })
        .collect();
    let counts: Vec<String> = surface
        .meshes
        .iter()
        .map(|mesh| mesh.positions.len().to_string())
        .collect();
    let folded: u64 = surface.samples.iter().map(|samples| samples.folded).sum();
    outcome
        .line(format!(
            "levels of {} vertices; {folded} samples folded and left without value",
            counts.join(", ")
        ))
        .figure("levels", figures)
}

fn draw(
    outcome: Outcome,
    folder: &Path,
    user: &UserMesh,
    oriented: &Oriented,
    surface: &Surface,
) -> Result<Outcome> {
    fs::create_dir_all(folder).map_err(Error::io(folder, "create"))?;
    let bent = oriented.distortion(user);
    let mean = bent.iter().sum::<f32>() / bent.len() as f32;
    let mut all = vec![
        pictures::field(
            &user.mesh,
            &oriented.rings,
            &oriented.field,
            &oriented.singular,
        ),
        pictures::heat(&user.mesh, &bent, MOST_DISTORTION),
    ];
    all.extend(surface.meshes.iter().map(pictures::level));
    let mut outcome = outcome
        .line(format!(
            "patches bend lengths by {:.2} % on the average",
            100.0 * mean
        ))
        .figure("mean_distortion", mean);
    let names = picture_names(surface.meshes.len() as u32);
    for (name, picture) in names.iter().zip(all) {
        for path in write_picture(folder, name, &picture)? {
            outcome = outcome.wrote(&path).put_inside([path]);
        }
    }
    Ok(outcome)
}

/// What the pictures of a surface of so many levels are called.
fn picture_names(levels: u32) -> Vec<String> {
    let levels = (0..levels).map(|level| format!("level{level}"));
    ["field".to_owned(), "distortion".to_owned()]
        .into_iter()
        .chain(levels)
        .collect()
}

fn picture_files(folder: &Path, name: &str) -> [PathBuf; 2] {
    ["ply", "png"].map(|extension| folder.join(format!("{name}.{extension}")))
}

fn write_picture(folder: &Path, name: &str, picture: &Picture) -> Result<[PathBuf; 2]> {
    let [ply, png] = picture_files(folder, name);
    picture.write(&ply)?;
    let pixels = preview::vertex_colors(&picture.mesh, &picture.colors, PICTURE)?;
    image::write_png(&png, PICTURE[0], PICTURE[1], &pixels)?;
    Ok([ply, png])
}

pub(super) fn read_outcome(input: &Path, user: &UserMesh) -> Outcome {
    let mut outcome = Outcome::default().line(format!(
        "read {}: {} vertices, {} triangles",
        input.display(),
        user.from_file.len(),
        user.mesh.triangles.len()
    ));
    for line in user.report.lines() {
        outcome = outcome.line(format!("repair: {line}"));
    }
    outcome
        .figure("repairs", json!(user.report))
        .figure("file_vertices", user.from_file.len())
}

/// Components this many times smaller than the largest are far apart in scale.
const SCALE_RATIO: f32 = 1000.0;

/// Says so when components differ so much in size that one texel cannot suit all.
fn warn_of_scales(session: &Session, mesh: &TriangleMesh) {
    let sizes = crate::mesh::topology::component_diagonals(mesh);
    let largest = sizes.iter().copied().fold(0.0, f32::max);
    let small = sizes
        .iter()
        .filter(|&&size| size * SCALE_RATIO < largest)
        .count();
    if small > 0 {
        session.progress().warn(format!(
            "{small} components are more than {SCALE_RATIO} times smaller than the largest, too small for its texel; \
             drop them with --specks {}",
            1.0 / SCALE_RATIO
        ));
    }
}

fn warn_of_count(session: &Session, found: usize, wanted: usize) {
    if found.abs_diff(wanted) * 50 > wanted {
        session.progress().warn(format!(
            "{found} vertices instead of {wanted}: boundaries, creases or many small parts leave no fewer"
        ));
    }
}
