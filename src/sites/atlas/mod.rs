//! The texels of a texture atlas as sites: a site is a texel inside a chart, in row-major order
//! (Ying 2001).
//!
//! In: a [user's mesh](crate::mesh::reading::UserMesh) with texture coordinates, or without. Out: an
//! [`AtlasSurface`](preparation::AtlasSurface) and the sites of all levels of its pyramid: the same charts at
//! half the resolution each.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`preparation`], [`options`] | the whole preparation |
//! | [`geometry`] | the mesh, its orientation field and the way over it |
//! | [`texels`] | the texels of one level: places, frames, areas |
//! | [`cells`], [`level_cells`] | samples between four texels, across charts' borders too |
//! | [`face_surface`] | the subdivided surface of a control mesh, a chart per face |
//! | [`vertex_charts`], [`vertex_stars`], [`drawing`] | where samples lie: in planar charts |
//! | [`marching`], [`paths`] | where samples lie: along straight paths |
//! | [`collecting`], [`neighbors`] | samples and neighbours of all sites, packed |
//! | [`scan_lines`] | the order in which texels are visited one by one |
//! | [`parents`], [`edges`] | the place of every texel on the coarser level, and pairs of texels side by side |
//! | [`memory`] | how much memory preparation takes |

mod cells;
mod collecting;
mod drawing;
mod edges;
mod face_surface;
mod geometry;
mod level_cells;
mod marching;
pub(crate) mod memory;
mod neighbors;
pub(crate) mod options;
mod parents;
mod paths;
pub(crate) mod preparation;
mod scan_lines;
mod sites;
#[cfg(test)]
mod tests;
mod texels;
mod vertex_charts;
mod vertex_stars;

pub use collecting::AtlasCounts;
pub use sites::AtlasSites;
