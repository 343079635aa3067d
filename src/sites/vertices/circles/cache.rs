//! Circles kept beside the mesh, in the folder of its caches: one file for each hash of positions, triangles,
//! radii and number of circles. The orientation field does not enter, so another field reads the same file.
//!
//! A file is checked like any input: its [seal](crate::format::seal) tells whether anything was changed, and
//! the checks here, which do not rely on it, whether it can be what was asked for.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::arcs::{Arc, Circles, NearVertex};
use super::marching::MOST_NEIGHBORS;
use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::seal::{ENGINE, Seal};
use crate::mesh::compressed_rows::Rows;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::sites::vertices::cache::lists::{self, Lists};

/// `format` in the file's `meta.json`.
const FORMAT: &str = "mesotex-circles";
/// Changes whenever the same input would give other circles, or the file has another form.
const VERSION: u32 = 2;

#[derive(Serialize, Deserialize)]
struct Meta {
    format: String,
    version: u32,
    engine: String,
    seal: ContentId,
    circles: u32,
}

/// The circles that are wanted.
pub struct Wanted<'a> {
    mesh: &'a TriangleMesh,
    radii: &'a [f32],
    per_vertex: u32,
    key: ContentId,
}

impl<'a> Wanted<'a> {
    /// Hashes everything circles depend on.
    pub fn new(mesh: &'a TriangleMesh, radii: &'a [f32], per_vertex: u32) -> Self {
        let mut key = Seal::new(FORMAT, VERSION, &ContentId::of_bytes(b"key"));
        key.list("positions", &mesh.positions);
        key.list("triangles", &mesh.triangles);
        key.list("radii", radii);
        key.list("circles", &[per_vertex]);
        Self {
            mesh,
            radii,
            per_vertex,
            key: key.finish(),
        }
    }

    /// Where they are kept in a cache folder.
    pub fn file(&self, folder: &Path) -> PathBuf {
        folder.join(format!("{}.circles.npz", self.key))
    }

    fn seal(&self) -> Seal {
        Seal::new(FORMAT, VERSION, &self.key)
    }
}

/// Writes circles, making the folder if need be.
pub fn write(path: &Path, wanted: &Wanted<'_>, circles: &Circles) -> Result<()> {
    lists::make_folder(path)?;
    let arrays: [(&str, &[u8]); 5] = [
        ("arc_starts", bytemuck::cast_slice(&circles.arcs.starts)),
        ("arcs", bytemuck::cast_slice(&circles.arcs.entries)),
        ("perimeters", bytemuck::cast_slice(&circles.perimeters)),
        ("near_starts", bytemuck::cast_slice(&circles.near.starts)),
        ("near", bytemuck::cast_slice(&circles.near.entries)),
    ];
    let arrays = arrays.map(|(name, bytes)| (name.to_owned(), bytes));
    let mut seal = wanted.seal();
    lists::seal(&mut seal, &arrays).map_err(Error::io(path, "write"))?;
    let meta = Meta {
        format: FORMAT.into(),
        version: VERSION,
        engine: ENGINE.into(),
        seal: sealed(seal, circles.per_vertex),
        circles: circles.per_vertex,
    };
    lists::write(path, &meta, &arrays)
}

/// Closes the seal over what `meta.json` states.
fn sealed(mut seal: Seal, per_vertex: u32) -> ContentId {
    seal.text("circles", &per_vertex.to_string());
    seal.finish()
}

/// Reads circles back; a file that is not sound, or not what is wanted, is an error.
pub fn read(path: &Path, wanted: &Wanted<'_>) -> Result<Circles> {
    let mut lists = Lists::open(path, wanted.seal())?;
    let meta: Meta = lists.meta()?;
    check_header(&meta, wanted).map_err(|error| error.in_file(path))?;
    let circles = Circles {
        per_vertex: meta.circles,
        radii: wanted.radii.to_vec(),
        arcs: Rows {
            starts: lists.list("arc_starts")?,
            entries: lists.list("arcs")?,
        },
        perimeters: lists.list("perimeters")?,
        near: Rows {
            starts: lists.list("near_starts")?,
            entries: lists.list("near")?,
        },
    };
    if sealed(lists.finish(), meta.circles) != meta.seal {
        return Err(Error::data("seal", "it does not belong to what the file holds").in_file(path));
    }
    check(&circles, wanted).map_err(|error| error.in_file(path))?;
    Ok(circles)
}

fn check_header(meta: &Meta, wanted: &Wanted<'_>) -> Result<()> {
    let found = format!("{} {} of {}", meta.format, meta.version, meta.engine);
    let expected = format!("{FORMAT} {VERSION} of {ENGINE}");
    if found != expected {
        return Err(Error::data("meta.json, format", found).expected(expected));
    }
    if meta.circles != wanted.per_vertex {
        return Err(Error::data("meta.json, circles", meta.circles.to_string())
            .expected(wanted.per_vertex.to_string()));
    }
    Ok(())
}

/// Checks every list.
fn check(circles: &Circles, wanted: &Wanted<'_>) -> Result<()> {
    let vertices = wanted.mesh.positions.len();
    let rows = vertices * wanted.per_vertex as usize;
    check_rows("arc_starts", &circles.arcs, rows)?;
    check_rows("near_starts", &circles.near, vertices)?;
    count("perimeters", circles.perimeters.len(), rows)?;
    let positive = |length: &f32| length.is_finite() && *length > 0.0;
    first_fault("perimeters", rows, |row| positive(&circles.perimeters[row]))?;
    let triangles = wanted.mesh.triangles.len();
    first_fault("arcs", rows, |row| {
        is_partition(circles.arcs.row(row), triangles)
    })?;
    first_fault("near", vertices, |vertex| {
        are_neighbors(circles.near.row(vertex), vertex, vertices)
    })
}

fn check_rows<T: Copy + Send + Sync>(name: &str, rows: &Rows<T>, wanted: usize) -> Result<()> {
    count(name, rows.starts.len(), wanted + 1)?;
    let rising = rows.starts.par_windows(2).all(|pair| pair[0] <= pair[1]);
    let ends = (rows.starts[0] as usize, rows.starts[wanted] as usize);
    if rising && ends == (0, rows.entries.len()) {
        return Ok(());
    }
    Err(Error::data(name, format!("{} to {}", ends.0, ends.1))
        .expected(format!("rising from 0 to {}", rows.entries.len())))
}

fn count(name: &str, found: usize, wanted: usize) -> Result<()> {
    match found == wanted {
        true => Ok(()),
        false => Err(Error::data(name, format!("{found} entries")).expected(wanted.to_string())),
    }
}

/// Names the first row that is not sound.
fn first_fault(name: &str, rows: usize, sound: impl Fn(usize) -> bool + Sync) -> Result<()> {
    let fault = (0..rows)
        .into_par_iter()
        .with_min_len(1 << 10)
        .position_first(|row| !sound(row));
    match fault {
        None => Ok(()),
        Some(row) => Err(
            Error::data(format!("{name}, row {row}"), "numbers out of range")
                .expected("what marching gives"),
        ),
    }
}

/// Whether arcs begin at angle and length 0, rise, and lie in triangles of the mesh.
fn is_partition(arcs: &[Arc], triangles: usize) -> bool {
    let begins = arcs.first().is_some_and(|a| (a.turn, a.fraction) == (0, 0));
    let rises = |pair: &[Arc]| pair[0].turn < pair[1].turn && pair[0].fraction <= pair[1].fraction;
    let known = |arc: &Arc| (arc.triangle as usize) < triangles || arc.triangle == Arc::GAP;
    begins && arcs.windows(2).all(rises) && arcs.iter().all(known)
}

/// Whether neighbours are other vertices of the mesh, no more than are kept, nearest first.
fn are_neighbors(near: &[NearVertex], vertex: usize, vertices: usize) -> bool {
    let other = |near: &NearVertex| {
        let at = near.vertex as usize;
        at < vertices && at != vertex
    };
    let ordered = near.windows(2).all(|pair| pair[0].radius <= pair[1].radius);
    near.len() <= MOST_NEIGHBORS && ordered && near.iter().all(other)
}
