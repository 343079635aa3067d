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
//! [`maps`] and never sees how it was made. [`format`](mod@format) lies below all rooms (bytes ↔ types),
//! and `cli` alone sees all of them. The library never prints, exits or reads the environment:
//! progress is a callback ([`progress`]), failure an [`error::Error`].

pub mod error;
pub mod grid;
pub mod index;
pub mod neighborhood;
pub mod progress;
pub mod random;

pub mod format;

pub mod btf;
pub mod exemplar;
pub mod texton;

pub mod mesh;
pub mod sites;

pub mod maps;
pub mod synthesis;

pub mod render;
pub mod report;

#[doc(hidden)]
pub mod cli;
