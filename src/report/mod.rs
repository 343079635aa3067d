//! Pictures about pictures: contact sheets and moving previews, from finished 8-bit images.

pub(crate) mod animation;
pub(crate) mod contact_sheet;
mod lettering;
