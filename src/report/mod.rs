//! What people look at: contact sheets and moving previews of frames, and pages for a browser.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`contact_sheet`], [`lettering`], [`animation`] | pictures of frames, labelled or moving |
//! | [`viewer`] | the page of `mesotex view` |
//! | [`summary`], [`embedded`] | the page of `mesotex report`, pictures as parts of it |
//! | [`view_factors`], [`surface_columns`] | a sample and a surface small enough for a page |
//! | [`page`], [`numbers`] | templates filled in, numbers as text |
//!
//! `web/` has the templates, the style, the scripts and the shaders.

pub mod animation;
pub mod contact_sheet;
pub mod embedded;
pub mod lettering;
pub mod numbers;
pub mod page;
pub mod summary;
pub mod surface_columns;
pub mod view_factors;
pub mod viewer;
