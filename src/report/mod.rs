//! What people look at: contact sheets and moving previews of frames, and pages for a browser.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`contact_sheet`], [`lettering`] | pictures of frames, labelled |
//! | [`animation`], [`video`] | pictures of frames, moving |
//! | [`viewer`] | the page of `mesotex view` |
//! | [`coarser_surface`] | a surface with fewer vertices, where a page has no room for all |
//! | [`summary`], [`embedded`] | the page of `mesotex report`, pictures as parts of it |
//! | [`view_factors`], [`surface_columns`] | a sample and a surface small enough for a page |
//! | [`page`], [`numbers`] | templates filled in, numbers as text |
//!
//! `web/` has the templates, the style, the scripts and the shaders.

pub(crate) mod animation;
pub(crate) mod coarser_surface;
pub(crate) mod contact_sheet;
pub(crate) mod embedded;
pub(crate) mod lettering;
pub(crate) mod numbers;
pub(crate) mod page;
pub(crate) mod summary;
pub(crate) mod surface_columns;
pub(crate) mod video;
pub(crate) mod view_factors;
pub(crate) mod viewer;

pub use animation::{write_apng, write_gif};
pub use contact_sheet::contact_sheet;
pub use embedded::Embedded;
pub use summary::{Chapter, Fact, OutputFacts, Sequence, StageFacts, Summary};
pub use video::{Container, VideoEncoder};
pub use view_factors::{Limits, ViewFactors, view_factors};
pub use viewer::{ViewerOptions, ViewerPage, viewer_page};
