//! The preparation of a target: which sites it has, and how they are made of a mesh.
//!
//! In: a mesh that was read, and the neighbourhoods of a method. Out: a target. Refused before the work: a mesh that
//! the scale gives too many texels, and one that this machine has too little memory for.

use std::path::Path;

use crate::cli::machine::Need;
use crate::cli::session::Session;
use crate::cli::synth::physical_scale::check_texel_count;
use crate::error::{Error, Result};
use crate::exemplar::neighbor_table::NeighborTable;
use crate::maps::vertex_map::check_scale;
use crate::mesh::reading::{UserMesh, varying};
use crate::neighborhood::Neighborhood;
use crate::sites::atlas;
use crate::sites::atlas::options::AtlasOptions;
use crate::sites::target::{Target, TargetSites};
use crate::sites::vertices::cache;
use crate::sites::vertices::circles::{CircleSource, RoundOptions};
use crate::sites::vertices::memory::{bytes_to_march, bytes_to_prepare};
use crate::sites::vertices::surface;
use crate::sites::vertices::surface_options::{SurfaceOptions, texel_on};
use crate::synthesis::check::{Plan, planned_neighborhoods};
use crate::synthesis::options::SynthesisOptions;

/// A target ready for synthesis, and how it came about.
pub struct Prepared {
    /// It.
    pub target: Target,
    /// Where the circles round its vertices came from, if it has any.
    pub circles: Option<CircleSource>,
}

impl From<Target> for Prepared {
    fn from(target: Target) -> Self {
        Self {
            target,
            circles: None,
        }
    }
}

/// The square windows of a target.
pub(super) struct Windows {
    /// What the method compares, level by level; none where its neighbourhoods are round.
    pub own: Vec<Neighborhood>,
    /// The table's on level 0, in which a map is measured.
    pub measured: Neighborhood,
}

impl Windows {
    /// Those that a method reads, and those that the figures are measured with.
    pub fn new(table: &NeighborTable, plan: &Plan, options: &SynthesisOptions) -> Self {
        Self {
            own: planned_neighborhoods(table, plan, options),
            measured: table.neighborhoods().swap_remove(0),
        }
    }

    /// Whether a map is measured in another window than the method compares on level 0.
    pub fn are_others_measured(&self) -> bool {
        let own = self.own.first().map(|own| &own.offsets);
        own != Some(&self.measured.offsets)
    }
}

/// The sites that a target is prepared with.
pub(super) struct PlannedSites {
    /// Their square windows.
    pub windows: Windows,
    /// Their round neighbourhoods, if the method has them.
    pub round: Option<RoundOptions>,
    /// Whether all figures of the map are wanted.
    pub is_measured: bool,
}

impl PlannedSites {
    /// The window of level 0 in which a map is measured, where it is wanted and another than the method compares.
    pub fn others_measured(&self) -> Option<&[Neighborhood]> {
        let are_others = self.is_measured && self.windows.are_others_measured();
        are_others.then(|| std::slice::from_ref(&self.windows.measured))
    }
}

/// A mesh that becomes a target.
pub(super) struct MeshTarget<'a> {
    /// Its file.
    pub path: &'a Path,
    /// What was read.
    pub user: &'a UserMesh,
    /// Bytes that are needed beside the target.
    pub exemplar: u64,
    /// The run.
    pub session: &'a Session,
}

impl MeshTarget<'_> {
    /// With square windows.
    pub fn prepare(&self, options: &SurfaceOptions) -> Result<Prepared> {
        check_mesh(self.path, self.user, options, self.exemplar)?;
        let cache = cache::folder_of(self.path);
        let target = Target::mesh(self.user, options, Some(&cache), self.session.progress())
            .map_err(|error| error.in_file(self.path))?;
        Ok(target.into())
    }

    /// Its texture atlas.
    pub fn prepare_atlas(&self, options: &AtlasOptions) -> Result<Target> {
        options.validate()?;
        check_memory(
            "resolution",
            format!("{0}x{0} texels", options.resolution),
            self.exemplar + atlas::memory::bytes_to_prepare(self.user, options),
            "a lower --resolution, or a table of a smaller knn --neighborhood",
        )?;
        let in_file = |error: Error| error.in_file(self.path);
        let target = Target::atlas(self.user, options, self.session.progress()).map_err(in_file)?;
        if let Some(scale) = &target.surface.scale {
            check_scale(scale, target.surface.texel).map_err(in_file)?;
        }
        Ok(target)
    }

    /// With round neighbourhoods.
    pub fn prepare_round(&self, options: &RoundOptions) -> Result<Prepared> {
        let user = self.user;
        let texel = texel_on(&user.mesh, options.texel)?;
        check_texel_count(&user.mesh, texel)?;
        check_memory(
            "rings",
            format!(
                "{} vertices at a texel of {texel}",
                user.mesh.positions.len()
            ),
            self.exemplar + bytes_to_march(user, options, texel),
            "fewer --rings or --levels, a smaller --texel, or a mesh of fewer vertices",
        )?;
        let cache = cache::folder_of(self.path);
        let progress = self.session.progress();
        let (target, source) = Target::round_mesh(user, options, Some(&cache), progress)
            .map_err(|error| error.in_file(self.path))?;
        Ok(Prepared {
            target,
            circles: Some(source),
        })
    }

    /// Its vertices with square windows on one level, in which a map is measured.
    pub fn measured_sites(&self, options: &SurfaceOptions) -> Result<TargetSites> {
        check_mesh(self.path, self.user, options, self.exemplar)?;
        let cache = cache::folder_of(self.path);
        let progress = self.session.progress();
        let surface = surface::prepare(self.user, options, Some(&cache), progress)
            .map_err(|error| error.in_file(self.path))?;
        Ok(TargetSites::Vertices(surface.into_sites()))
    }
}

/// Refuses a mesh whose scale makes no texel, and one that this machine has too little memory for.
fn check_mesh(path: &Path, user: &UserMesh, options: &SurfaceOptions, exemplar: u64) -> Result<()> {
    options.validate()?;
    let texel = options.texel_on(&user.mesh)?;
    check_texel_count(&user.mesh, texel)?;
    if let Some(scale) = varying(user.scale.as_deref()) {
        check_scale(scale, texel).map_err(|error| error.in_file(path))?;
    }
    check_memory(
        "texel",
        format!(
            "{} vertices at a texel of {texel}",
            user.mesh.positions.len()
        ),
        exemplar + bytes_to_prepare(user, options, texel),
        "a smaller --texel, a mesh of fewer vertices (mesh --vertices), or a table of a smaller \
         knn --neighborhood",
    )
}

/// Refuses a target that this machine has too little memory for.
pub(super) fn check_memory(
    option: &'static str,
    work: String,
    bytes: u64,
    advice: &str,
) -> Result<()> {
    let need = Need {
        bytes,
        work,
        option,
        advice: advice.into(),
    };
    need.check()
}
