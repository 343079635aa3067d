//! Prepared surfaces kept beside the mesh, in a folder that may be deleted at any time: one file
//! for each hash of all that went in.
//!
//! A cached surface is checked like any file: its [seal](crate::format::seal) tells whether anything was
//! changed since it was written, and [`check`] whether it can be the surface that was asked for.

mod check;
pub(crate) mod lists;

use std::fs;
use std::path::{Path, PathBuf};

use bytemuck::Pod;
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::seal::{ENGINE, Seal};
use crate::mesh::compressed_rows::Rows;
use crate::mesh::frame::Frame;
use crate::mesh::reading::UserMesh;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::sites::level::{Neighbor, Parent};
use crate::sites::vertices::VertexSites;
use crate::sites::vertices::cache::lists::Lists;
use crate::sites::vertices::prepared_surface::{PreparedSurface, SurfaceLevel};
use crate::sites::vertices::sampling::SampleCounts;
use crate::sites::vertices::stencil::{PackedSample, PatchStencils};
use crate::sites::vertices::surface_options::SurfaceOptions;

/// `format` in the file's `meta.json`.
const FORMAT: &str = "mesotex-surface";
/// Changes whenever the same input would give another surface, or the file has another form.
const VERSION: u32 = 3;

/// The folder that belongs to a mesh file: `MESH.mesotex-cache`.
pub fn folder_of(mesh: &Path) -> PathBuf {
    let mut name = mesh.file_name().unwrap_or_default().to_os_string();
    name.push(".mesotex-cache");
    mesh.with_file_name(name)
}

/// The surface that is wanted: of this mesh, prepared with these options.
pub struct Wanted<'a> {
    user: &'a UserMesh,
    options: &'a SurfaceOptions,
    texel: f64,
    key: ContentId,
}

impl<'a> Wanted<'a> {
    /// Hashes everything a prepared surface depends on; a guide file counts by its content.
    pub fn new(user: &'a UserMesh, options: &'a SurfaceOptions) -> Result<Self> {
        Ok(Self {
            user,
            options,
            texel: options.texel_on(&user.mesh)?,
            key: key(user, options)?,
        })
    }

    /// Where it is kept in a cache folder.
    pub fn file(&self, folder: &Path) -> PathBuf {
        folder.join(format!("{}.surface.npz", self.key))
    }

    fn seal(&self) -> Seal {
        Seal::new(FORMAT, VERSION, &self.key)
    }
}

fn key(user: &UserMesh, options: &SurfaceOptions) -> Result<ContentId> {
    let mut hasher = blake3::Hasher::new();
    let mut section = |name: &str, bytes: &[u8]| {
        hasher.update(name.as_bytes());
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update_rayon(bytes);
    };
    section("version", &VERSION.to_le_bytes());
    section("engine", ENGINE.as_bytes());
    section("positions", bytemuck::cast_slice(&user.mesh.positions));
    section("triangles", bytemuck::cast_slice(&user.mesh.triangles));
    section("orientation", bytes_of(user.orientation.as_deref()));
    section("scale", bytes_of(user.scale.as_deref()));
    section("rotation", bytes_of(user.rotation.as_deref()));
    section("uvs", bytes_of(user.corner_uvs.as_deref()));
    section("vertices", bytes_of(Some(&user.from_file)));
    let content = |path: &Option<PathBuf>| match path {
        Some(path) => fs::read(path).map_err(Error::io(path, "read")),
        None => Ok(Vec::new()),
    };
    section("guide", &content(&options.guide)?);
    if options.keys.is_some() {
        section("keys", &content(&options.keys)?);
    }
    // Guides name points from zero; meshes near zero have no origin, and their keys none either.
    if user.origin != DVec3::ZERO {
        section("origin", bytemuck::cast_slice(&user.origin.to_array()));
    }
    let told = SurfaceOptions {
        guide: None,
        keys: None,
        ..options.clone()
    };
    let told = serde_json::to_vec(&told).map_err(not_json)?;
    section("options", &told);
    Ok(ContentId::of_hash(&hasher.finalize()))
}

fn bytes_of<T: Pod>(list: Option<&[T]>) -> &[u8] {
    bytemuck::cast_slice(list.unwrap_or_default())
}

#[derive(Serialize, Deserialize)]
struct Meta {
    format: String,
    version: u32,
    engine: String,
    seal: ContentId,
    texel: f64,
    levels: Vec<LevelMeta>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct LevelMeta {
    samples_per_site: usize,
    coarse_samples_per_site: Option<usize>,
    counts: [u64; 3],
}

impl LevelMeta {
    fn of(level: &SurfaceLevel) -> Self {
        let (sites, counts) = (&level.sites, &level.samples);
        Self {
            samples_per_site: sites.fine.samples_per_site,
            coarse_samples_per_site: sites.coarse.as_ref().map(|coarse| coarse.samples_per_site),
            counts: [counts.valued, counts.outside, counts.folded],
        }
    }
}

fn not_json(error: serde_json::Error) -> Error {
    Error::data("JSON", error.to_string())
}

/// Writes a surface, making the folder if need be; one that [`read`] would refuse is an error.
pub fn write(path: &Path, wanted: &Wanted<'_>, surface: &PreparedSurface) -> Result<()> {
    check::surface(surface, wanted)?;
    write_unchecked(path, wanted, surface)
}

fn write_unchecked(path: &Path, wanted: &Wanted<'_>, surface: &PreparedSurface) -> Result<()> {
    lists::make_folder(path)?;
    // List what each level holds.
    let levels: Vec<LevelMeta> = surface.levels.iter().map(LevelMeta::of).collect();
    let frames: Vec<[Vec<Vec3>; 2]> = surface.levels.iter().map(normals_and_s).collect();
    let lists: Vec<(String, &[u8])> = surface
        .levels
        .iter()
        .zip(&frames)
        .enumerate()
        .flat_map(|(number, (level, frames))| {
            lists(level, frames).map(move |(name, bytes)| (member(number, name), bytes))
        })
        .collect();
    // Seal the lists.
    let mut seal = wanted.seal();
    lists::seal(&mut seal, &lists).map_err(Error::io(path, "write"))?;
    // Write them.
    let meta = Meta {
        format: FORMAT.into(),
        version: VERSION,
        engine: ENGINE.into(),
        seal: sealed(seal, surface.texel, &levels)?,
        texel: surface.texel,
        levels,
    };
    lists::write(path, &meta, &lists)
}

/// The normals and the orientations of a level's frames.
fn normals_and_s(level: &SurfaceLevel) -> [Vec<Vec3>; 2] {
    let frames = || level.frames.iter();
    [
        frames().map(|frame| frame.n).collect(),
        frames().map(|frame| frame.s).collect(),
    ]
}

/// The lists of a level in the order of the file; the coarsest level lacks the coarse ones.
fn lists<'a>(
    level: &'a SurfaceLevel,
    [normals, orientations]: &'a [Vec<Vec3>; 2],
) -> impl Iterator<Item = (&'static str, &'a [u8])> + use<'a> {
    let (mesh, sites) = (&level.mesh, &level.sites);
    let coarse: &[u8] = match &sites.coarse {
        Some(coarse) => bytemuck::cast_slice(&coarse.samples),
        None => &[],
    };
    [
        ("triangles", bytemuck::cast_slice(&mesh.triangles)),
        ("positions", bytemuck::cast_slice(&mesh.positions)),
        ("normals", bytemuck::cast_slice(normals)),
        ("orientations", bytemuck::cast_slice(orientations)),
        ("samples", bytemuck::cast_slice(&sites.fine.samples)),
        ("coarse_samples", coarse),
        (
            "neighbor_starts",
            bytemuck::cast_slice(&sites.neighbors.starts),
        ),
        ("neighbors", bytemuck::cast_slice(&sites.neighbors.entries)),
        ("parents", bytemuck::cast_slice(&sites.parents)),
        ("areas", bytemuck::cast_slice(&sites.areas)),
    ]
    .into_iter()
}

/// The name of a level's list.
fn member(level: usize, name: &str) -> String {
    format!("L{level}/{name}")
}

/// Closes the seal over what `meta.json` states.
fn sealed(mut seal: Seal, texel: f64, levels: &[LevelMeta]) -> Result<ContentId> {
    seal.text("texel", &texel.to_bits().to_string());
    let levels = serde_json::to_string(levels).map_err(not_json)?;
    seal.text("levels", &levels);
    Ok(seal.finish())
}

/// Reads a surface back; a file that is not sound, or not the surface wanted, is an error.
pub fn read(path: &Path, wanted: &Wanted<'_>) -> Result<PreparedSurface> {
    let mut lists = Lists::open(path, wanted.seal())?;
    let meta: Meta = lists.meta()?;
    check::header(&meta, wanted).map_err(|error| error.in_file(path))?;
    let mut levels = Vec::with_capacity(meta.levels.len());
    for number in 0..meta.levels.len() {
        levels.push(CachedLevel::read(&mut lists, number)?);
    }
    if sealed(lists.finish(), meta.texel, &meta.levels)? != meta.seal {
        return Err(Error::data("seal", "it does not belong to what the file holds").in_file(path));
    }
    let surface = assemble(&meta, levels);
    check::surface(&surface, wanted).map_err(|error| error.in_file(path))?;
    Ok(surface)
}

/// The lists of a level, as the file has them.
struct CachedLevel {
    triangles: Vec<[u32; 3]>,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    orientations: Vec<Vec3>,
    samples: Vec<PackedSample>,
    coarse_samples: Vec<PackedSample>,
    neighbors: Rows<Neighbor>,
    parents: Vec<Parent>,
    areas: Vec<f32>,
}

impl CachedLevel {
    /// Reads the lists in the order in which they were sealed.
    fn read(lists: &mut Lists, number: usize) -> Result<Self> {
        Ok(Self {
            triangles: lists.list(&member(number, "triangles"))?,
            positions: lists.list(&member(number, "positions"))?,
            normals: lists.list(&member(number, "normals"))?,
            orientations: lists.list(&member(number, "orientations"))?,
            samples: lists.list(&member(number, "samples"))?,
            coarse_samples: lists.list(&member(number, "coarse_samples"))?,
            neighbors: Rows {
                starts: lists.list(&member(number, "neighbor_starts"))?,
                entries: lists.list(&member(number, "neighbors"))?,
            },
            parents: lists.list(&member(number, "parents"))?,
            areas: lists.list(&member(number, "areas"))?,
        })
    }

    /// The level with what `meta.json` says of it and the triangles of the coarser one.
    fn complete(self, meta: &LevelMeta, coarser: Option<Vec<[u32; 3]>>) -> SurfaceLevel {
        let stencils = |samples_per_site, cells, samples| PatchStencils {
            samples_per_site,
            cells,
            samples,
        };
        let fine = stencils(meta.samples_per_site, self.triangles.clone(), self.samples);
        let coarse = meta.coarse_samples_per_site.zip(coarser);
        let [valued, outside, folded] = meta.counts;
        SurfaceLevel {
            frames: frames(&self.normals, &self.orientations),
            mesh: TriangleMesh {
                positions: self.positions,
                triangles: self.triangles,
            },
            sites: VertexSites {
                fine,
                coarse: coarse
                    .map(|(per_site, cells)| stencils(per_site, cells, self.coarse_samples)),
                neighbors: self.neighbors,
                parents: self.parents,
                areas: self.areas,
            },
            samples: SampleCounts {
                valued,
                outside,
                folded,
            },
        }
    }
}

/// The surface of the levels read. The triangles of the next level are the cells of a level's coarse samples.
fn assemble(meta: &Meta, levels: Vec<CachedLevel>) -> PreparedSurface {
    let coarser = levels
        .iter()
        .skip(1)
        .map(|level| Some(level.triangles.clone()));
    let coarser: Vec<Option<Vec<[u32; 3]>>> = coarser.chain([None]).collect();
    let levels = levels.into_iter().zip(&meta.levels).zip(coarser);
    PreparedSurface {
        levels: levels
            .map(|((level, meta), coarser)| level.complete(meta, coarser))
            .collect(),
        texel: meta.texel,
    }
}

fn frames(normals: &[Vec3], orientations: &[Vec3]) -> Vec<Frame> {
    let frame = |(&n, &s): (&Vec3, &Vec3)| Frame {
        s,
        t: n.cross(s),
        n,
    };
    normals.iter().zip(orientations).map(frame).collect()
}

#[cfg(test)]
mod tests;
