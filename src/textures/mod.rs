//! Texture maps: the channels of a sample carried onto a surface that synthesis has decorated, and their files.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`channel`] | a channel of the sample: linear light, unit normals, or numbers as they stand |
//! | [`texture`] | an image of numbers on an atlas, its borders padded |
//! | [`transfer`] | a channel onto an atlas or onto vertices |
//! | [`properties`] | the names of a channel's numbers as properties of vertices or faces |
//! | [`face_channels`] | channels onto the faces of a map, and their colours onto its vertices |
//! | [`face_model`] | the faces of a map in their colours as GLB |
//! | [`fine_texels`] | the texture coordinates of texels as fine as the atlas', or finer |
//! | [`frames`] | the frames that normals are turned between |
//! | [`growth`] | the texel of its own chart that each texel beyond a border is nearest to |
//! | [`atlas_surface`] | the surface of an atlas map |
//! | [`decorated`] | an atlas map on a mesh of about a vertex per texel, as it is rendered |
//! | [`image_file`] | a texture as PNG or OpenEXR |
//! | [`base_color`] | the base colour of the model, over a plain one if asked for |
//! | [`surface_color`] | the plain colour that shows where a texture is transparent |
//! | [`relief`] | the surface moved along its normals |
//! | [`holes`] | the surface without what is transparent |
//! | [`model`] | the surface with its textures as GLB |
//! | [`folder`] | all of them in one folder |
//! | [`texel_sites`] | the texels as points that are shaded one by one |
//! | [`memory`] | the memory that this takes |

pub(crate) mod atlas_surface;
mod base_color;
pub(crate) mod channel;
pub(crate) mod decorated;
pub(crate) mod face_channels;
pub(crate) mod face_model;
mod fine_texels;
pub(crate) mod folder;
mod frames;
mod growth;
mod holes;
mod image_file;
pub(crate) mod memory;
pub(crate) mod model;
pub(crate) mod properties;
mod relief;
pub(crate) mod surface_color;
pub(crate) mod texel_sites;
pub(crate) mod texture;
pub(crate) mod transfer;
pub(crate) mod vertex_model;

pub use channel::SampleChannel;
pub use decorated::{Decorated, Shape, decorated};
pub use face_channels::carry_onto_faces;
pub use folder::{Written, read_channel, write_atlas, write_lit, write_set, write_textures};
pub use model::{ModelFacts, ModelOptions, Subject, Transparency};
pub use surface_color::SurfaceColor;
pub use texel_sites::TexelSites;
pub use texture::Texture;
pub use transfer::{Canvas, onto_vertices};
pub use vertex_model::{ModelFormat, VertexModel};
