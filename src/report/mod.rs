//! Pictures about pictures, from finished 8-bit images: [`contact_sheet`] puts thumbnails on one, with
//! labels in [`lettering`], and [`animation`] makes them a looping GIF.

pub(crate) mod animation;
pub(crate) mod contact_sheet;
mod lettering;
