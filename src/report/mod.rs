//! Pictures about pictures: contact sheets and moving previews, from finished 8-bit images.

pub mod animation;
pub mod contact_sheet;
mod lettering;
