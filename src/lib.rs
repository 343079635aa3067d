//! mesotex puts measured appearance on real geometry.
//!
//! A *BTF sample* has images of one flat patch of material under many views and lights. mesotex finds the textons of a
//! sample, synthesizes a texture of them on a triangle mesh, and renders the decorated mesh under any view and light.
//! The command `mesotex` does all of it from files. This library is what the command is made of.
//!
//! # The way of the data
//!
//! ```text
//!  btf ──► texton ──► exemplar ──┐
//!  (sample)  (vocabulary) (space, ├──► synthesis ──► maps ──► render ──► frames
//!                neighbour table) │                                    ▲
//!  mesh (field, patches, stencils)┘                     btf, mesh ─────┘
//! ```
//!
//! Two chains meet once: appearance (`btf` → `texton` → `exemplar`) and surface (`mesh` → `sites`)
//! know nothing of each other until `synthesis`. [`render`] reads the finished [`maps`] and never sees how they were
//! made.
//!
//! # Where to begin
//!
//! | to | call |
//! | --- | --- |
//! | open, bake or import a sample | [`btf::Sample::open`], [`btf::bake::bake`], [`btf::import`] |
//! | find its textons | [`texton::analyze`] |
//! | make an exemplar of textons, or of plain images | [`exemplar::space_of_vocabulary`], [`exemplar::space_of_images`] |
//! | list the neighbours of its texels | [`exemplar::neighbor_table::build`] |
//! | read a mesh | [`mesh::reading::read`] |
//! | prepare a mesh or a flat grid | [`sites::Target::mesh`], [`sites::Target::grid`] |
//! | synthesize a map | [`synthesis::synthesize_map`] |
//! | render it | [`render::sweep::render`], or [`render::sweep::with_renderer`] for pixels in memory |
//! | make texture maps and models of it | [`textures`] |
//! | make exemplars whose pattern changes steadily | [`vary`] |
//! | read and write files | [`format`](mod@format), and `read`, `open` and `write` of the types themselves |
//!
//! Rooms re-export what is needed from outside; their files are private. `examples/` has whole programs: `flat` (2D
//! synthesis), `textons`, `surface`, `sweep`.
//!
//! # Conventions
//!
//! - Colours are linear Rec. 709; values of a sample are radiance for unit irradiance. Directions are unit vectors that
//!   point away from the surface. Texture coordinates are in texels, s to the right and t up. Angles are radians, in
//!   options degrees.
//! - Options are structs with `Default`. Whatever an option refuses, it refuses before the work begins.
//! - A failure is an [`error::Error`]: it says where, what was found, what was expected and who must act.
//! - Work that may last takes a [`progress::Progress`], which receives events and can cancel the work.
//! - The same inputs, options and seed give the same bytes, on any number of threads.
//! - The library never prints, exits or reads the environment.
//!
//! # From an image to maps
//!
//! A plain image on the built-in mesh and on a flat grid:
//!
//! ```
//! use mesotex::exemplar::{ChannelImage, ChannelKind, Controls, KnnOptions, neighbor_table, space_of_images};
//! use mesotex::format::ContentId;
//! use mesotex::format::image::{Encoding, FloatImage, Precision};
//! use mesotex::mesh::{UserMesh, builtin::kettlebell};
//! use mesotex::progress::Progress;
//! use mesotex::sites::{SiteGrid, SurfaceOptions, Target};
//! use mesotex::synthesis::{SynthesisOptions, synthesize_map};
//!
//! # fn main() -> mesotex::error::Result<()> {
//! let quiet = Progress::silent();
//! let bricks = (0..32 * 32).map(|at| f32::from(at / 32 % 8 > 0 && (at + at / 256 * 8) % 16 > 0));
//! let (encoding, precision) = (Encoding::Srgb, Precision::Float);
//! let image = FloatImage { width: 32, height: 32, channels: 1, data: bricks.collect(), encoding, precision };
//! let images = [ChannelImage::new(ChannelKind::Color, image)];
//! let space = space_of_images(&images, Controls::default(), 2, true, &ContentId::of_bytes(b"bricks"))?;
//! let table = neighbor_table::build(&space, &KnnOptions::default(), quiet)?;
//!
//! let mesh = UserMesh::from(kettlebell(2000));
//! let options = SurfaceOptions::default().with_neighborhoods(&table.neighborhoods());
//! let on_mesh = Target::mesh(&mesh, &options, None, quiet)?;
//! let flat = SiteGrid { width: 48, height: 48, toroidal: true };
//! let on_grid = Target::grid(flat, &table.neighborhoods())?;
//!
//! let folder = std::env::temp_dir().join(format!("mesotex-{}", std::process::id()));
//! # std::fs::create_dir_all(&folder).map_err(mesotex::error::Error::io(&folder, "create"))?;
//! for (name, target) in [("kettlebell", on_mesh), ("flat", on_grid)] {
//!     let map = synthesize_map(&space, &table, &target, &SynthesisOptions::default(), quiet)?;
//!     map.write(&folder.join(format!("{name}.map.ply")))?;
//! }
//! # assert!(folder.join("flat.map.ply").exists() && folder.join("kettlebell.map.ply").exists());
//! # std::fs::remove_dir_all(&folder).map_err(mesotex::error::Error::io(&folder, "remove"))?;
//! # Ok(())
//! # }
//! ```
//!
//! # From a material to frames
//!
//! The whole chain with a sample: bake, find textons, synthesize, render.
//!
//! ```
//! use mesotex::btf::Sample;
//! use mesotex::btf::bake::{BakeOptions, Preset, Samples, bake};
//! use mesotex::exemplar::{KnnOptions, neighbor_table, space_of_vocabulary};
//! use mesotex::format::ContentId;
//! use mesotex::mesh::{UserMesh, builtin::kettlebell};
//! use mesotex::progress::Progress;
//! use mesotex::render::sweep::{self, Inputs};
//! use mesotex::render::{ImageOptions, ImageSize, RenderOptions};
//! use mesotex::sites::{SurfaceOptions, Target};
//! use mesotex::synthesis::{SynthesisOptions, synthesize_map};
//! use mesotex::texton::{StoredVocabulary, TextonOptions, analyze};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = std::env::temp_dir().join(format!("mesotex-chain-{}", std::process::id()));
//! # std::fs::create_dir_all(&folder)?;
//! let quiet = Progress::silent();
//!
//! // A sample of a woven material, 16 × 16 texels, 5 views × 4 lights.
//! let material = Preset::Weave.material(16, 0, quiet)?;
//! let baking = BakeOptions {
//!     views: "rings:0:1,50:4".parse()?,
//!     lights: "rings:40:4".parse()?,
//!     samples: Samples::Fixed(1),
//!     ..BakeOptions::default()
//! };
//! bake(&material, &baking, &folder.join("weave.sample"), quiet)?;
//! let sample = Sample::open(&folder.join("weave.sample"))?;
//!
//! // Its textons, and the space of their dot products.
//! let options = TextonOptions { textons: 20, levels: 2, ..TextonOptions::default() };
//! analyze(&sample, &options, quiet)?.vocabulary.write(&folder.join("weave.textons.npz"))?;
//! let vocabulary = StoredVocabulary::open(&folder.join("weave.textons.npz"))?;
//! let space = space_of_vocabulary(&vocabulary)?;
//! let table = neighbor_table::build(&space, &KnnOptions { k: 3, ..KnnOptions::default() }, quiet)?;
//!
//! // A map on the built-in mesh.
//! let mesh = UserMesh::from(kettlebell(1000));
//! let surface = SurfaceOptions::default().with_neighborhoods(&table.neighborhoods());
//! let target = Target::mesh(&mesh, &surface, None, quiet)?;
//! let map = synthesize_map(&space, &table, &target, &SynthesisOptions::default(), quiet)?;
//! map.write(&folder.join("weave.map.ply"))?;
//!
//! // One frame of it.
//! let image = ImageOptions { size: ImageSize([64, 48]), ..ImageOptions::default() };
//! let inputs = Inputs {
//!     sample: &sample,
//!     map: &map,
//!     map_id: &ContentId::of_file(&folder.join("weave.map.ply"))?,
//!     cover: None,
//!     folder: &folder,
//!     force: false,
//! };
//! let rendered = sweep::render(&inputs, &RenderOptions { image, ..RenderOptions::default() }, quiet)?;
//! assert!(rendered.files[0].frame.exists());
//! # std::fs::remove_dir_all(&folder)?;
//! # Ok(())
//! # }
//! ```

pub mod byte_size;
pub mod error;
pub(crate) mod false_color;
pub mod grid;
pub mod index;
pub(crate) mod lanes;
pub mod matrix;
pub mod neighborhood;
pub mod progress;
pub(crate) mod radial_basis;
pub mod random;
pub mod shard;

pub mod format;

pub mod btf;
pub mod exemplar;
pub mod texton;

pub mod mesh;
pub mod sites;

pub mod maps;
pub mod synthesis;

pub mod textures;

pub mod vary;

pub mod render;
pub mod report;

#[doc(hidden)]
pub mod cli;
