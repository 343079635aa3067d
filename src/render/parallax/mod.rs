//! Parallax-aware blending: images of neighbouring views show a point of a relief at different texels, because all are
//! rectified on the plane z = 0. Each is read where it shows the point that is wanted, before they are blended.
//!
//! In: a height per texel, and the sample's views. Out: the texels that a blend reads, image by image, with their
//! shares. A view in whose image the point is hidden is left out; where it is hidden in all, blending is plain.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`relief`] | the surface, and the height that every view sees at every texel |
//! | [`reads`] | the texels that a blend reads |
//! | [`patches`] | how far a coherent patch of a map continues round a vertex |
//! | [`trial`] | whether it helps: views left out and predicted from the others |
//! | [`decision`] | on or off, and why |

pub(crate) mod decision;
pub(crate) mod patches;
pub(crate) mod reads;
pub(crate) mod relief;
pub(crate) mod trial;

pub use decision::{Decision, Parallax};
pub use patches::PatchReach;
pub use reads::{Place, Read, ReadList};
pub use relief::Relief;
pub use trial::Trial;

#[cfg(test)]
mod tests;
