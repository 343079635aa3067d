//! Geometry: triangle meshes read, cleaned, retiled, given an orientation field, and charts on them.
//! Nothing here knows of textures or of synthesis.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`triangle_mesh`], [`topology`], [`compressed_rows`] | a mesh, how its triangles are connected, lists per vertex |
//! | [`reading`], [`triangulation`], [`cleaning`], [`origin`] | from a file of the user to a manifold mesh near zero |
//! | [`writing`], [`colored_vertices`] | meshes into files, with the colours of their vertices too |
//! | [`builtin`], [`shapes`] | the built-in mesh, and meshes with a formula |
//! | [`rings`], [`connection`], [`frame`] | tangent planes, and how directions are carried between them |
//! | [`field`] | the orientation field |
//! | [`keys`], [`user_vertex`] | values that a user states at a few vertices, spread over the surface |
//! | [`chart`] | the (s, t) chart round a point |
//! | [`surface_bvh`], [`point_tree`] | nearest points and crossings, and points in a triangle |
//! | [`tangents`], [`tessellation`] | tangents of textured triangles; triangles cut to a length |
//! | [`geodesic`], [`geodesic_distance`], [`smoothing`] | straight lines and distances on a surface, and a surface without its finest detail |
//! | [`subdivision`] | Catmull-Clark surfaces of meshes of quadrilaterals, butterfly surfaces of triangles |
//! | [`face_colors`] | triangles in two colours, and base meshes that have them |
//! | [`atlas`] | texture coordinates cut into charts, and where texels lie on the surface |
//! | [`retile`], [`texture_charts`] | another mesh on the same surface, seams kept |
//! | [`quality`], [`pictures`] | how even a mesh is, and pictures of its preparation |

pub mod atlas;
pub mod builtin;
pub(crate) mod chart;
mod cleaning;
pub(crate) mod colored_vertices;
pub(crate) mod compressed_rows;
pub(crate) mod connection;
pub(crate) mod face_colors;
pub mod field;
pub(crate) mod frame;
pub(crate) mod geodesic;
pub(crate) mod geodesic_distance;
pub(crate) mod keys;
pub(crate) mod origin;
pub(crate) mod pictures;
mod point_tree;
pub(crate) mod quality;
pub mod reading;
pub(crate) mod retile;
pub(crate) mod rings;
pub mod shapes;
pub(crate) mod smoothing;
pub mod subdivision;
pub(crate) mod surface_bvh;
pub(crate) mod tangents;
pub(crate) mod tessellation;
mod texture_charts;
pub(crate) mod topology;
pub(crate) mod triangle_mesh;
mod triangulation;
mod user_vertex;
pub(crate) mod writing;

pub use cleaning::{FlippedComponent, RepairReport};
pub use compressed_rows::Rows;
pub use connection::{Connection, frames_of};
pub use face_colors::{ColoredMesh, Coloring, two_coloring};
pub use frame::Frame;
pub use geodesic_distance::GeodesicDistances;
pub use keys::{Key, KeyFile};
pub use reading::UserMesh;
pub use retile::retile;
pub use rings::{RingEdge, Rings, vertex_normals};
pub use surface_bvh::{SurfaceBvh, SurfacePoint};
pub use topology::Topology;
pub use triangle_mesh::TriangleMesh;
pub use writing::{write_mesh, write_user};
