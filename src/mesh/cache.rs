//! Prepared surfaces kept beside the mesh, in a folder that may be deleted at any time: one file
//! for each hash of all that went in.

use std::path::{Path, PathBuf};

use bytemuck::Pod;
use glam::Vec3;
use ndarray::{Array1, ArrayView1};
use serde::{Deserialize, Serialize};
use serde_json::{Map, json};

use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::npz;
use crate::mesh::frame::Frame;
use crate::mesh::hierarchy::{NeighborLists, PatchNeighbors, SiteHierarchy, SiteLevel};
use crate::mesh::reading::UserMesh;
use crate::mesh::sampling::SampleCounts;
use crate::mesh::stencil::{PackedSample, PatchStencils, Stencils};
use crate::mesh::surface::Surface;
use crate::mesh::surface_options::SurfaceOptions;
use crate::mesh::triangle_mesh::TriangleMesh;

/// Changes whenever the same input would give another surface.
const VERSION: u32 = 1;

/// The folder that belongs to a mesh file: `MESH.mesotex-cache`.
pub fn folder_of(mesh: &Path) -> PathBuf {
    let mut name = mesh.file_name().unwrap_or_default().to_os_string();
    name.push(".mesotex-cache");
    mesh.with_file_name(name)
}

/// The hash of everything a prepared surface depends on; a guide file counts by its content.
pub fn key(user: &UserMesh, options: &SurfaceOptions) -> Result<ContentId> {
    let mut hasher = blake3::Hasher::new();
    let mut section = |name: &str, bytes: &[u8]| {
        hasher.update(name.as_bytes());
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update_rayon(bytes);
    };
    section("version", &VERSION.to_le_bytes());
    section("positions", bytemuck::cast_slice(&user.mesh.positions));
    section("triangles", bytemuck::cast_slice(&user.mesh.triangles));
    section("orientation", bytes_of(user.orientation.as_deref()));
    section("scale", bytes_of(user.scale.as_deref()));
    section("rotation", bytes_of(user.rotation.as_deref()));
    section("uvs", bytes_of(user.corner_uvs.as_deref()));
    section("vertices", bytes_of(Some(&user.from_file)));
    let guide = match &options.guide {
        Some(path) => std::fs::read(path).map_err(Error::io(path, "read"))?,
        None => Vec::new(),
    };
    section("guide", &guide);
    let told = SurfaceOptions {
        guide: None,
        ..options.clone()
    };
    section("options", format!("{told:?}").as_bytes());
    Ok(ContentId::of_hash(&hasher.finalize()))
}

fn bytes_of<T: Pod>(list: Option<&[T]>) -> &[u8] {
    bytemuck::cast_slice(list.unwrap_or_default())
}

/// The file of a key.
pub fn file(folder: &Path, key: &ContentId) -> PathBuf {
    folder.join(format!("{key}.surface.npz"))
}

#[derive(Deserialize)]
struct Meta {
    texel: f64,
    levels: Vec<LevelMeta>,
}

#[derive(Serialize, Deserialize)]
struct LevelMeta {
    samples_per_site: usize,
    coarse_samples_per_site: Option<usize>,
    counts: [u64; 3],
}

/// What the patches of a level gave.
struct LevelPatches<'a> {
    fine: &'a PatchStencils,
    coarse: Option<&'a PatchStencils>,
    neighbors: &'a PatchNeighbors,
}

impl<'a> LevelPatches<'a> {
    fn of(level: &'a SiteLevel) -> Result<Self> {
        let stencils = |stencils: &'a Stencils| match stencils {
            Stencils::OfPatches(stencils) => Ok(stencils),
            Stencils::OfGrid(_) => Err(not_patches()),
        };
        Ok(Self {
            fine: stencils(&level.fine)?,
            coarse: level.coarse.as_ref().map(stencils).transpose()?,
            neighbors: match &level.neighbors {
                NeighborLists::OfPatches(lists) => lists,
                NeighborLists::OfGrid(_) => return Err(not_patches()),
            },
        })
    }
}

fn not_patches() -> Error {
    Error::data("stencils", "those of a flat grid").expected("those of a mesh")
}

/// Writes a surface, making the folder if need be.
pub fn write(path: &Path, surface: &Surface) -> Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(Error::io(folder, "create"))?;
    }
    let patches: Vec<LevelPatches<'_>> = surface
        .hierarchy
        .levels
        .iter()
        .map(LevelPatches::of)
        .collect::<Result<_>>()?;
    let levels: Vec<LevelMeta> = patches
        .iter()
        .zip(&surface.samples)
        .map(|(level, counts)| LevelMeta {
            samples_per_site: level.fine.samples_per_site,
            coarse_samples_per_site: level.coarse.map(|coarse| coarse.samples_per_site),
            counts: [counts.valued, counts.outside, counts.folded],
        })
        .collect();
    let mut meta = Map::new();
    meta.insert("texel".into(), json!(surface.texel));
    meta.insert("levels".into(), json!(levels));
    npz::write(path, meta, |writer| {
        for (number, level) in surface.hierarchy.levels.iter().enumerate() {
            let mut put = |name: &str, bytes: &[u8]| {
                writer.array(&format!("L{number}/{name}"), ArrayView1::from(bytes))
            };
            put(
                "positions",
                bytemuck::cast_slice(&surface.meshes[number].positions),
            )?;
            put(
                "triangles",
                bytemuck::cast_slice(&surface.meshes[number].triangles),
            )?;
            put("normals", bytemuck::cast_slice(&surface.normals[number]))?;
            let orientations: Vec<Vec3> = surface.frames[number].iter().map(|f| f.s).collect();
            put("orientations", bytemuck::cast_slice(&orientations))?;
            let LevelPatches {
                fine,
                coarse,
                neighbors,
            } = &patches[number];
            put("samples", bytemuck::cast_slice(&fine.samples))?;
            if let Some(coarse) = coarse {
                put("coarse_samples", bytemuck::cast_slice(&coarse.samples))?;
            }
            put("neighbor_starts", bytemuck::cast_slice(&neighbors.starts))?;
            put("neighbors", bytemuck::cast_slice(&neighbors.entries))?;
            put("parents", bytemuck::cast_slice(&level.parents))?;
            put(
                "parent_points",
                bytemuck::cast_slice(&surface.parent_points[number]),
            )?;
            put("areas", bytemuck::cast_slice(&level.areas))?;
        }
        Ok(())
    })?;
    Ok(())
}

/// Reads a surface back; a file that does not hold together is an error.
pub fn read(path: &Path) -> Result<Surface> {
    let mut reader = npz::Reader::open(path)?;
    let meta: Meta = reader.meta()?;
    let mut surface = Surface {
        meshes: Vec::new(),
        normals: Vec::new(),
        frames: Vec::new(),
        hierarchy: SiteHierarchy::default(),
        parent_points: Vec::new(),
        texel: meta.texel,
        samples: Vec::new(),
    };
    let triangles = (0..meta.levels.len()).map(|number| list(&mut reader, number, "triangles"));
    let triangles: Vec<Vec<[u32; 3]>> = triangles.collect::<Result<_>>()?;
    for (number, level) in meta.levels.iter().enumerate() {
        read_level(&mut reader, level, &triangles[number..], &mut surface)?;
    }
    check(&surface).map_err(|error| error.in_file(path))?;
    Ok(surface)
}

/// Reads the next level; `triangles` are its own and those of the coarser ones.
fn read_level(
    reader: &mut npz::Reader,
    meta: &LevelMeta,
    triangles: &[Vec<[u32; 3]>],
    surface: &mut Surface,
) -> Result<()> {
    let number = surface.meshes.len();
    let mesh = TriangleMesh {
        positions: list(reader, number, "positions")?,
        triangles: triangles[0].clone(),
    };
    let normals: Vec<Vec3> = list(reader, number, "normals")?;
    let orientations: Vec<Vec3> = list(reader, number, "orientations")?;
    let frame = |(&n, &s): (&Vec3, &Vec3)| Frame {
        s,
        t: n.cross(s),
        n,
    };
    surface
        .frames
        .push(normals.iter().zip(&orientations).map(frame).collect());
    let mut stencils = |samples_per_site, above: usize, name: &str| {
        let cells = triangles.get(above).cloned();
        Ok(Stencils::OfPatches(PatchStencils {
            samples_per_site,
            cells: cells.ok_or_else(|| Error::data("levels", "the coarsest has a coarser one"))?,
            samples: list(reader, number, name)?,
        }))
    };
    let fine = stencils(meta.samples_per_site, 0, "samples")?;
    let coarse = meta.coarse_samples_per_site;
    let coarse = coarse.map(|samples| stencils(samples, 1, "coarse_samples"));
    surface.hierarchy.levels.push(SiteLevel {
        site_count: mesh.positions.len(),
        fine,
        coarse: coarse.transpose()?,
        neighbors: NeighborLists::OfPatches(PatchNeighbors {
            starts: list(reader, number, "neighbor_starts")?,
            entries: list(reader, number, "neighbors")?,
        }),
        parents: list(reader, number, "parents")?,
        areas: list(reader, number, "areas")?,
    });
    surface
        .parent_points
        .push(list(reader, number, "parent_points")?);
    surface.meshes.push(mesh);
    surface.normals.push(normals);
    let [valued, outside, folded] = meta.counts;
    surface.samples.push(SampleCounts {
        valued,
        outside,
        folded,
    });
    Ok(())
}

fn list<T: Pod>(reader: &mut npz::Reader, level: usize, name: &str) -> Result<Vec<T>> {
    let name = format!("L{level}/{name}");
    let bytes: Array1<u8> = reader.array(&name)?;
    let bytes = bytes.as_slice().unwrap_or_default();
    if !bytes.len().is_multiple_of(size_of::<T>()) {
        return Err(reader.fault(&name, format!("{} bytes", bytes.len())));
    }
    Ok(bytemuck::pod_collect_to_vec(bytes))
}

/// Checks that all lists of a surface have the length they should and point to what is there.
fn check(surface: &Surface) -> Result<()> {
    for (number, level) in surface.hierarchy.levels.iter().enumerate() {
        let sites = level.site_count;
        let cells = surface.meshes[number].triangles.len() as u32;
        let above = surface.meshes.get(number + 1);
        let sites_above = above.map_or(0, |mesh| mesh.positions.len());
        let cells_above = above.map_or(0, |mesh| mesh.triangles.len() as u32);
        let LevelPatches {
            fine,
            coarse,
            neighbors,
        } = LevelPatches::of(level)?;
        let within = |stencils: &PatchStencils, cells: u32| {
            let in_cell = |s: &PackedSample| s.cell == PackedSample::NO_CELL || s.cell < cells;
            stencils.samples.len() == sites * stencils.samples_per_site
                && stencils.samples.iter().all(in_cell)
        };
        let starts = &neighbors.starts;
        let sound = surface.meshes[number]
            .triangles
            .iter()
            .flatten()
            .all(|&v| (v as usize) < sites)
            && [
                surface.normals[number].len(),
                surface.frames[number].len(),
                level.areas.len(),
            ] == [sites; 3]
            && within(fine, cells)
            && coarse.is_none_or(|coarse| within(coarse, cells_above))
            && coarse.is_some() == above.is_some()
            && starts.len() == sites + 1
            && starts.windows(2).all(|pair| pair[0] <= pair[1])
            && starts.last().map(|&end| end as usize) == Some(neighbors.entries.len())
            && neighbors.entries.iter().all(|n| (n.site as usize) < sites)
            && level.parents.len() == if above.is_some() { sites } else { 0 }
            && level
                .parents
                .iter()
                .all(|p| (p.site as usize) < sites_above);
        if !sound {
            return Err(
                Error::data(format!("L{number}"), "lists that do not belong together")
                    .advice("delete the folder; it will be made again"),
            );
        }
    }
    Ok(())
}
