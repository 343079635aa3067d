//! The vertices of a mesh as sites with round neighbourhoods, the same at every level (Chen 2008 §6.2).
//!
//! In: a mesh, its orientation field and the options. Out: a [`SiteHierarchy`].

use std::path::Path;

use rayon::prelude::*;

use super::arcs::Circles;
use super::cache::Wanted;
use super::frame::Manifold;
use super::options::RoundOptions;
use super::{cache, marching, sampling};
use crate::error::Result;
use crate::mesh::connection::frames_of;
use crate::mesh::field::guides::GuidedSurface;
use crate::mesh::frame::Frame;
use crate::mesh::reading::UserMesh;
use crate::mesh::rings::Rings;
use crate::mesh::surface_bvh::SurfaceBvh;
use crate::mesh::topology::Topology;
use crate::neighborhood::Template;
use crate::progress::Progress;
use crate::sites::level::{Parent, SiteHierarchy};
use crate::sites::vertices::VertexSites;
use crate::sites::vertices::sampling::SampleCounts;
use crate::sites::vertices::surface::guided_angles;
use crate::sites::vertices::surface_options::{texel_on, warn_of_texel};

/// Where the circles of a level came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CircleSource {
    /// They were marched.
    Marched,
    /// They were read from the cache.
    Read,
}

impl CircleSource {
    /// What a report says.
    pub fn name(self) -> &'static str {
        match self {
            Self::Marched => "marched",
            Self::Read => "read from the cache",
        }
    }
}

/// What is known of a level beside its sites.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RoundLevel {
    /// Whether its circles were marched or read.
    pub source: CircleSource,
    /// What became of its samples.
    pub samples: SampleCounts,
}

/// The vertices of a mesh as sites with round neighbourhoods, the same at every level.
#[derive(Clone, Debug, PartialEq)]
pub struct RoundSites {
    /// Stencils in the order of the template, neighbours and parents of all levels, finest first.
    pub hierarchy: SiteHierarchy<VertexSites>,
    /// Per level, what is known beside that.
    pub levels: Vec<RoundLevel>,
    /// Where the samples lie on the flat template, and where its rings end.
    pub template: Template,
    /// The texture frames, per-vertex rotation included.
    pub frames: Vec<Frame>,
    /// Per vertex the mesh units per texel of the finest level, its scale included.
    pub texels: Vec<f32>,
}

/// Prepares the round sites of a user's mesh. Circles are taken from the folder `cache` where it has them,
/// and kept there otherwise; a cache that cannot be used costs a warning, no more.
pub fn prepare(
    user: &UserMesh,
    options: &RoundOptions,
    cache: Option<&Path>,
    progress: Progress<'_>,
) -> Result<RoundSites> {
    options.validate()?;
    let mesh = &user.mesh;
    let texel = texel_on(mesh, options.texel)?;
    warn_of_texel(mesh, texel, progress);
    let topology = Topology::new(&mesh.triangles);
    let rings = Rings::new(mesh, &topology);
    let surface = Manifold {
        mesh,
        topology: &topology,
        rings: &rings,
    };
    progress.check()?;
    let frames = oriented(user, &rings, texel, options, progress)?;
    let texels: Vec<f32> = match &user.scale {
        Some(scales) => scales.iter().map(|scale| scale * texel as f32).collect(),
        None => vec![texel as f32; mesh.positions.len()],
    };
    sites(surface, frames, &texels, options, cache, progress)
}

/// The frames of the orientation field, rotated by the user's rotation.
fn oriented(
    user: &UserMesh,
    rings: &Rings,
    texel: f64,
    options: &RoundOptions,
    progress: Progress<'_>,
) -> Result<Vec<Frame>> {
    progress.begin("orientation field", 1);
    let tree = SurfaceBvh::new(&user.mesh);
    let surface = GuidedSurface {
        user,
        rings,
        tree: &tree,
        texel,
    };
    let angles = guided_angles(surface, &options.guides, options.seed, progress)?;
    progress.advance(1)?;
    progress.end();
    Ok(frames_of(rings, &angles))
}

/// The round sites of a mesh under given frames. `texels` are the finest level's, in mesh units, each
/// vertex's scale included; level l has circles of radius 2^l, 2·2^l, … times its vertex's texel.
///
/// Every level has the same vertices and no samples of the level above: each vertex is its own parent.
pub fn sites(
    surface: Manifold<'_>,
    frames: Vec<Frame>,
    texels: &[f32],
    options: &RoundOptions,
    cache: Option<&Path>,
    progress: Progress<'_>,
) -> Result<RoundSites> {
    options.validate()?;
    let template = Template::round(options.rings);
    let mut hierarchy = SiteHierarchy { levels: Vec::new() };
    let mut levels = Vec::new();
    // Find the circles.
    progress.begin("circles", u64::from(options.levels));
    let circles = circles(surface, texels, options, cache, progress)?;
    // Sample them level by level.
    for (number, (circles, source)) in (1..).zip(circles) {
        let (fine, samples) = sampling::stencils(&circles, surface, &frames, &template)?;
        let neighbors = sampling::neighbors(&circles, surface, &frames)?;
        hierarchy.levels.push(VertexSites {
            fine,
            coarse: None,
            neighbors,
            parents: match number == options.levels {
                true => Vec::new(),
                false => own_parents(frames.len()),
            },
            areas: surface.mesh.vertex_areas(),
        });
        levels.push(RoundLevel { source, samples });
        progress.advance(1)?;
    }
    progress.end();
    Ok(RoundSites {
        hierarchy,
        levels,
        template,
        frames,
        texels: texels.to_vec(),
    })
}

/// Every vertex as its own parent.
fn own_parents(count: usize) -> Vec<Parent> {
    let parent = |site| Parent {
        site,
        x: 0.0,
        y: 0.0,
    };
    (0..count as u32).map(parent).collect()
}

/// The circles of every vertex, level by level: from the cache where it has them, else marched and kept
/// there.
pub fn circles(
    surface: Manifold<'_>,
    texels: &[f32],
    options: &RoundOptions,
    cache: Option<&Path>,
    progress: Progress<'_>,
) -> Result<Vec<(Circles, CircleSource)>> {
    // Look into the cache.
    let on_level = |level: u32| -> Vec<f32> {
        let scale = (1_u32 << level) as f32;
        texels.iter().map(|texel| texel * scale).collect()
    };
    let radii: Vec<Vec<f32>> = (0..options.levels).map(on_level).collect();
    let wanted: Vec<Wanted<'_>> = radii
        .iter()
        .map(|radii| Wanted::new(surface.mesh, radii, options.rings))
        .collect();
    let mut found: Vec<Option<Circles>> = wanted
        .par_iter()
        .map(|wanted| cache.and_then(|folder| read(folder, wanted, progress)))
        .collect();
    let missing: Vec<u32> = (0..options.levels)
        .filter(|&level| found[level as usize].is_none())
        .collect();
    if missing.is_empty() {
        let read = |circles| (circles, CircleSource::Read);
        return Ok(found.into_iter().flatten().map(read).collect());
    }
    // March what is missing, and keep it.
    let marched = marching::march_levels(surface, texels, options.rings, &missing, progress)?;
    if let Some(folder) = cache {
        let levels = missing.par_iter().zip(&marched);
        levels.for_each(|(&level, circles)| {
            write(folder, &wanted[level as usize], circles, progress);
        });
    }
    for (&level, circles) in missing.iter().zip(marched) {
        found[level as usize] = Some(circles);
    }
    // Tell where each came from.
    let source = |level: usize| match missing.contains(&(level as u32)) {
        true => CircleSource::Marched,
        false => CircleSource::Read,
    };
    let found = found.into_iter().flatten().enumerate();
    Ok(found
        .map(|(level, circles)| (circles, source(level)))
        .collect())
}

/// The circles in a cache folder, where they are there and sound.
fn read(folder: &Path, wanted: &Wanted<'_>, progress: Progress<'_>) -> Option<Circles> {
    let file = wanted.file(folder);
    if !file.exists() {
        return None;
    }
    let circles = cache::read(&file, wanted);
    circles
        .inspect_err(|error| progress.warn(format!("{error}; the circles are marched again")))
        .ok()
}

fn write(folder: &Path, wanted: &Wanted<'_>, circles: &Circles, progress: Progress<'_>) {
    if let Err(error) = cache::write(&wanted.file(folder), wanted, circles) {
        progress.warn(format!("the circles are not cached: {error}"));
    }
}
