//! Texture coordinates of a mesh cut into charts, and where the texels of an image lie on the surface. Independent of
//! what the texels hold.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`charts`] | the charts of the mesh's own texture coordinates, checked |
//! | [`overlap`] | whether two triangles cover the same place of the texture |
//! | [`unwrapping`] | new texture coordinates |
//! | [`face_squares`] | a square for each face of a control mesh |
//! | [`texel_points`] | the surface point of every texel |
//! | [`rasterization`] | which texels the triangles of an atlas cover |
//! | [`stray_charts`] | a texel for a chart that contains no texel's centre |
//! | [`padding`] | texels outside charts and what continues the surface there |

mod charts;
mod face_squares;
mod overlap;
mod padding;
mod rasterization;
mod stray_charts;
mod texel_points;
mod unwrapping;

pub use charts::Atlas;
pub use face_squares::FaceSquares;
pub use padding::{Across, padding};
pub use texel_points::{MOST_TEXELS, TexelPoints};
