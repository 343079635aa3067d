//! mesotex puts measured appearance on real geometry.
//!
//! The data's way through the crate:
//!
//! ```text
//!  btf ──► texton ──► exemplar ──┐
//!  (sample)  (vocabulary) (space, ├──► synthesis ──► maps ──► render ──► frames
//!                neighbour table) │                                    ▲
//!  mesh (field, patches, stencils)┘                     btf, mesh ─────┘
//! ```
//!
//! Two chains meet once: appearance (`btf` → `texton` → `exemplar`) and surface (`mesh`)
//! know nothing of each other until `synthesis`; `render` reads the finished
//! [`maps`] and never sees how it was made, and [`textures`] makes texture maps of them.
//! [`vary`] makes exemplars whose pattern changes steadily.
//! [`format`](mod@format) lies below all rooms (bytes ↔ types), and `cli` alone sees all of them. The library never prints, exits or reads the environment:
//! progress is a callback ([`progress`]), failure an [`error::Error`].
//!
//! From a plain image to a map on the built-in mesh and on a flat grid:
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

pub mod error;
pub mod grid;
pub mod index;
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
