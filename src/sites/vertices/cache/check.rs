//! What a cached surface must hold to be the surface wanted: the right sizes, indices that point to
//! what is there, numbers that a prepared surface can have.
//!
//! A sound seal says that nothing was changed since the file was written; these checks do not rely on it.

use glam::Vec3;
use rayon::prelude::*;

use super::{ENGINE, FORMAT, Meta, VERSION, Wanted, member};
use crate::error::{Error, Result};
use crate::mesh::compressed_rows::Rows;
use crate::mesh::frame::Frame;
use crate::sites::level::{Neighbor, Parent};
use crate::sites::vertices::prepared_surface::{PreparedSurface, SurfaceLevel};
use crate::sites::vertices::sampling::SampleCounts;
use crate::sites::vertices::stencil::{PackedSample, PatchStencils};

/// How far lengths and right angles may be off: rounding alone is a hundredth of it.
const TOLERANCE: f32 = 1e-3;

/// Checks what `meta.json` says, before any list is read.
pub(super) fn header(meta: &Meta, wanted: &Wanted<'_>) -> Result<()> {
    let place = |field: &str| format!("meta.json, {field}");
    // Check what the file is.
    let kind = (meta.format.as_str(), meta.version, meta.engine.as_str());
    if kind != (FORMAT, VERSION, ENGINE) {
        return Err(Error::data(
            place("format"),
            format!("{} {} of {}", kind.0, kind.1, kind.2),
        )
        .expected(format!("{FORMAT} {VERSION} of {ENGINE}")));
    }
    // Check what it was made for.
    if meta.texel.to_bits() != wanted.texel.to_bits() {
        return Err(
            Error::data(place("texel"), meta.texel.to_string()).expected(wanted.texel.to_string())
        );
    }
    let asked = wanted.options.levels as usize;
    if meta.levels.len() != asked {
        return Err(
            Error::data(place("levels"), meta.levels.len().to_string()).expected(asked.to_string())
        );
    }
    // Check the samples of each level.
    let samples = |width: u32| width as usize * width as usize;
    for (number, level) in meta.levels.iter().enumerate() {
        let found = (level.samples_per_site, level.coarse_samples_per_site);
        let coarse = (number + 1 < asked).then(|| samples(wanted.options.coarse_neighborhood));
        let expected = (samples(wanted.options.neighborhood), coarse);
        if found != expected {
            return Err(Error::data(
                place(&format!("samples of level {number}")),
                format!("{found:?}"),
            )
            .expected(format!("{expected:?}")));
        }
    }
    Ok(())
}

/// Checks every list of a surface.
pub(super) fn surface(surface: &PreparedSurface, wanted: &Wanted<'_>) -> Result<()> {
    let (finest, user) = (surface.levels.first(), &wanted.user.mesh);
    if finest.is_none_or(|finest| finest.mesh != *user) {
        return Err(Error::data("L0", "another mesh").expected("the vertices and triangles given"));
    }
    for (number, level) in surface.levels.iter().enumerate() {
        CheckedLevel::new(number, level, surface.levels.get(number + 1)).check(wanted)?;
    }
    Ok(())
}

/// One level and what it may point to.
struct CheckedLevel<'a> {
    number: usize,
    level: &'a SurfaceLevel,
    sites_above: usize,
    cells_above: usize,
}

impl<'a> CheckedLevel<'a> {
    fn new(number: usize, level: &'a SurfaceLevel, above: Option<&SurfaceLevel>) -> Self {
        Self {
            number,
            level,
            sites_above: above.map_or(0, |above| above.mesh.positions.len()),
            cells_above: above.map_or(0, |above| above.mesh.triangles.len()),
        }
    }

    fn check(&self, wanted: &Wanted<'_>) -> Result<()> {
        let sites = &self.level.sites;
        self.mesh()?;
        self.frames()?;
        self.stencils("samples", &sites.fine, self.level.mesh.triangles.len())?;
        match &sites.coarse {
            Some(coarse) => self.stencils("coarse_samples", coarse, self.cells_above)?,
            None => self.count("coarse_samples", 0, 0)?,
        }
        self.counts(&self.level.samples)?;
        self.neighbors(&sites.neighbors, wanted.options.neighborhood)?;
        self.parents()
    }

    /// Vertices of the level.
    fn sites(&self) -> usize {
        self.level.mesh.positions.len()
    }

    fn mesh(&self) -> Result<()> {
        let (mesh, areas) = (&self.level.mesh, &self.level.sites.areas);
        let within = |triangle: &[u32; 3]| triangle.iter().all(|&v| (v as usize) < self.sites());
        self.all(
            "triangles",
            &mesh.triangles,
            within,
            "vertices of the level",
        )?;
        self.all("positions", &mesh.positions, |p| p.is_finite(), "finite")?;
        self.count("areas", areas.len(), self.sites())?;
        let sound = |area: &f32| (0.0..f32::INFINITY).contains(area);
        self.all("areas", areas, sound, "finite, 0 or more")
    }

    fn frames(&self) -> Result<()> {
        let frames = &self.level.frames;
        self.count("normals", frames.len(), self.sites())?;
        self.all("normals", frames, |frame| is_unit(frame.n), "of length 1")?;
        let sound = |frame: &Frame| is_unit(frame.s) && frame.s.dot(frame.n).abs() <= TOLERANCE;
        let expected = "of length 1 and at right angles to the normal";
        self.all("orientations", frames, sound, expected)
    }

    fn stencils(&self, name: &str, stencils: &PatchStencils, cells: usize) -> Result<()> {
        let wanted = self.sites() * stencils.samples_per_site;
        self.count(name, stencils.samples.len(), wanted)?;
        let sound = |sample: &PackedSample| {
            let [first, second] = sample.weights.map(u32::from);
            let inside = (sample.cell as usize) < cells && first + second <= 65_535;
            inside || *sample == PackedSample::OUTSIDE
        };
        let expected = format!("a cell below {cells} with weights of at most 65535 in all");
        self.all(name, &stencils.samples, sound, &expected)
    }

    /// What became of the samples must be all of them.
    fn counts(&self, counts: &SampleCounts) -> Result<()> {
        let told = [counts.valued, counts.outside, counts.folded];
        let sum = told.iter().try_fold(0_u64, |sum, &n| sum.checked_add(n));
        match sum == Some(self.level.sites.fine.samples.len() as u64) {
            true => Ok(()),
            false => Err(Error::data(self.place("counts"), format!("{told:?}"))
                .expected(format!("{} in all", self.level.sites.fine.samples.len()))),
        }
    }

    fn neighbors(&self, lists: &Rows<Neighbor>, window: u32) -> Result<()> {
        let starts = &lists.starts;
        self.count("neighbor_starts", starts.len(), self.sites() + 1)?;
        let rising = starts.par_windows(2).all(|pair| pair[0] <= pair[1]);
        let ends = (starts[0] as usize, starts[self.sites()] as usize);
        if !rising || ends != (0, lists.entries.len()) {
            let found = format!("{} to {}", ends.0, ends.1);
            return Err(Error::data(self.place("neighbor_starts"), found)
                .expected(format!("rising from 0 to {}", lists.entries.len())));
        }
        let half = window as f32 / 2.0;
        let sound = |near: &Neighbor| {
            (near.site as usize) < self.sites() && near.x.abs() <= half && near.y.abs() <= half
        };
        let expected = format!("a vertex of the level within {half} texels");
        self.all("neighbors", &lists.entries, sound, &expected)
    }

    fn parents(&self) -> Result<()> {
        let wanted = if self.sites_above > 0 {
            self.sites()
        } else {
            0
        };
        let parents = &self.level.sites.parents;
        self.count("parents", parents.len(), wanted)?;
        let inside = |parent: &Parent| {
            (parent.site as usize) < self.sites_above && (parent.x + parent.y).is_finite()
        };
        let expected = "a vertex of the coarser level at a finite distance";
        self.all("parents", parents, inside, expected)
    }

    fn count(&self, name: &str, found: usize, wanted: usize) -> Result<()> {
        if found == wanted {
            return Ok(());
        }
        Err(Error::data(self.place(name), format!("{found} entries")).expected(wanted.to_string()))
    }

    /// Names the first entry that is not sound.
    fn all<T: Sync + std::fmt::Debug>(
        &self,
        name: &str,
        list: &[T],
        sound: impl Fn(&T) -> bool + Sync,
        expected: &str,
    ) -> Result<()> {
        match list
            .par_iter()
            .with_min_len(1 << 12)
            .position_first(|entry| !sound(entry))
        {
            None => Ok(()),
            Some(at) => Err(Error::data(
                format!("{}, entry {at}", self.place(name)),
                format!("{:?}", list[at]),
            )
            .expected(expected)),
        }
    }

    fn place(&self, name: &str) -> String {
        member(self.number, name)
    }
}

fn is_unit(vector: Vec3) -> bool {
    (vector.length() - 1.0).abs() <= TOLERANCE
}
