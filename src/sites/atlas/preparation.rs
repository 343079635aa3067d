//! The whole preparation of an atlas: charts, orientation field, and the sites of all levels.

use std::sync::Arc;

use glam::Vec3;

use super::collecting::{AtlasCounts, LevelSamples, Window};
use super::face_surface::FaceSurface;
use super::geometry::Geometry;
use super::level_cells::LevelCells;
use super::options::{AtlasOptions, ChartSource, Sampling};
use super::parents::parents;
use super::sites::AtlasSites;
use super::texels::LevelTexels;
use super::{edges, marching, paths, vertex_charts, vertex_stars};
use crate::error::{Error, Result};
use crate::mesh::atlas::{Atlas, TexelPoints};
use crate::mesh::reading::UserMesh;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::neighborhood::Template;
use crate::progress::Progress;
use crate::sites::level::{SampleLocation, SiteEdge, SiteHierarchy};
use crate::sites::vertices::stretch::{adjacent_samples, stretch_of_places};

/// The finest level of an atlas, for whoever writes textures; lists per site are in the order of the texels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AtlasSurface {
    /// The mesh under the atlas.
    pub mesh: TriangleMesh,
    /// Unit normals of its vertices.
    pub vertex_normals: Vec<Vec3>,
    /// Its texture coordinates, in charts.
    pub atlas: Atlas,
    /// The surface point of every texel, and the size of the image.
    pub points: TexelPoints,
    /// The texel of each site, row · width + column.
    pub texels: Vec<u32>,
    /// Where each site lies.
    pub positions: Vec<Vec3>,
    /// The unit normal at each site.
    pub normals: Vec<Vec3>,
    /// The orientation field at each site: s in space.
    pub orientations: Vec<Vec3>,
    /// The chart of each site.
    pub charts: Vec<u32>,
    /// Factor on the texel at each site; `None` for 1 everywhere.
    pub scale: Option<Vec<f32>>,
    /// Mesh units that a texel of the texture covers where the scale is 1.
    pub texel: f64,
    /// Texels side by side, across charts' borders too.
    pub edges: Vec<SiteEdge>,
    /// Triangles between the sites.
    pub triangles: Vec<[u32; 3]>,
    /// Per level, what became of the samples.
    pub counts: Vec<AtlasCounts>,
    /// How often a control mesh was subdivided, where each of its faces is a chart.
    pub subdivisions: Option<u32>,
}

impl AtlasSurface {
    /// Numbers of the mesh's vertices, blended at every site.
    pub fn blended(&self, numbers: &[f32]) -> Vec<f32> {
        self.at_corners(|corners, weights| {
            let parts = corners.into_iter().zip(weights);
            parts.map(|(vertex, weight)| numbers[vertex] * weight).sum()
        })
    }

    /// Numbers of the mesh's vertices at every site: that of the corner that weighs most.
    pub fn heaviest(&self, numbers: &[f32]) -> Vec<f32> {
        self.at_corners(|corners, weights| {
            let heavier = |best: usize, at: usize| match weights[at] > weights[best] {
                true => at,
                false => best,
            };
            numbers[corners[(0..3).fold(0, heavier)]]
        })
    }

    /// What a function makes of every site's triangle.
    fn at_corners(&self, of: impl Fn([usize; 3], [f32; 3]) -> f32) -> Vec<f32> {
        let texels = self.texels.iter().map(|&texel| texel as usize);
        let site = |texel: usize| {
            let corners = self.mesh.triangles[self.points.triangle[texel] as usize];
            of(
                corners.map(|vertex| vertex as usize),
                self.points.weights[texel],
            )
        };
        texels.map(site).collect()
    }
}

/// Prepares the atlas of a mesh and the sites of its levels, finest first.
pub fn prepare(
    user: &UserMesh,
    options: &AtlasOptions,
    progress: Progress<'_>,
) -> Result<(AtlasSurface, SiteHierarchy<AtlasSites>)> {
    options.validate()?;
    // Lay out the charts.
    let faces = match options.charts {
        ChartSource::Faces => Some(FaceSurface::new(user, options.resolution, progress)?),
        ChartSource::Uv => None,
    };
    let own;
    let (user, atlas) = match &faces {
        Some(faces) => (&faces.user, &faces.atlas),
        None => {
            own = charts(user, options, progress)?;
            (user, &own)
        }
    };
    progress.check()?;
    // Lay out texels on every level.
    let points = pyramid(&user.mesh, atlas, options)?;
    let texel = texel(&user.mesh, points[0].inside(), options.texture_scale)?;
    let guided = (&options.guides, options.seed);
    let geometry = Geometry::new(user, atlas, texel, guided, progress)?;
    let on_level = |(number, points)| {
        let texel = texel * f64::from(1_u32 << number);
        LevelTexels::new(&geometry, points, texel)
    };
    // Find the surface at each texel, and the cells between them.
    let levels: Vec<LevelTexels> = (0_u32..).zip(points).map(on_level).collect();
    let cells: Vec<LevelCells<'_>> = levels
        .iter()
        .map(|level| LevelCells::new(&geometry, level, progress))
        .collect::<Result<_>>()?;
    // Find the neighbourhoods.
    let pyramid = Pyramid {
        faces: faces.as_ref(),
        geometry: &geometry,
        levels: &levels,
        cells: &cells,
        texel,
        options,
    };
    let (hierarchy, counts) = pyramid.hierarchy(progress)?;
    pyramid.check_density(&hierarchy.levels[0])?;
    let surface = AtlasSurface {
        counts,
        ..pyramid.surface()
    };
    Ok((surface, hierarchy))
}

/// The charts that were asked for: the mesh's own, or new ones.
fn charts(user: &UserMesh, options: &AtlasOptions, progress: Progress<'_>) -> Result<Atlas> {
    if options.unwrap {
        return Atlas::unwrapped(&user.mesh, options.resolution, progress);
    }
    match &user.corner_uvs {
        Some(uvs) => Atlas::of_uvs(&user.mesh, uvs),
        None => Err(Error::data("mesh", "no texture coordinates")
            .expected("one at each corner of each face")
            .advice("--unwrap makes them")),
    }
}

/// The texels of all levels: the resolution halves from one to the next.
fn pyramid(mesh: &TriangleMesh, atlas: &Atlas, options: &AtlasOptions) -> Result<Vec<TexelPoints>> {
    let mut side = options.resolution;
    let mut points = vec![TexelPoints::new(mesh, atlas, side, side)?];
    for _ in 1..options.levels {
        side = side.div_ceil(2);
        points.push(TexelPoints::coarse(mesh, atlas, side, side)?);
    }
    Ok(points)
}

/// Mesh units per texel of the texture: `scale` times √(area / texels).
fn texel(mesh: &TriangleMesh, texels: usize, scale: f64) -> Result<f64> {
    let area = mesh.area();
    if !(area > 0.0 && area.is_finite()) {
        return Err(Error::data("mesh", format!("area {area}")).expected("a surface"));
    }
    Ok((area / texels as f64).sqrt() * scale)
}

/// Charts are made on levels with no more vertices per site than this.
const VERTICES_PER_SITE: usize = 4;

/// All levels while they are sampled.
struct Pyramid<'a> {
    /// The control mesh, where each of its faces is a chart.
    faces: Option<&'a FaceSurface>,
    geometry: &'a Geometry<'a>,
    levels: &'a [LevelTexels],
    cells: &'a [LevelCells<'a>],
    texel: f64,
    options: &'a AtlasOptions,
}

impl Pyramid<'_> {
    fn hierarchy(
        &self,
        progress: Progress<'_>,
    ) -> Result<(SiteHierarchy<AtlasSites>, Vec<AtlasCounts>)> {
        progress.begin("neighbourhoods", self.levels.len() as u64);
        let fine = Template::square(self.options.neighborhood);
        let coarse = Template::square(self.options.coarse_neighborhood);
        let (mut levels, mut counts) = (Vec::new(), Vec::new());
        for number in 0..self.levels.len() {
            // Sample the windows on this level.
            let own = self.sample(number, (&fine, self.options.neighborhood, true), progress)?;
            // Sample those on the coarser level.
            let coarser = number + 1;
            let (mut around, mut parent_points) = (None, Vec::new());
            if coarser < self.levels.len() {
                let window = (&coarse, self.options.coarse_neighborhood, false);
                let samples = self.sample(coarser, window, progress)?;
                around = Some(Arc::new(samples.stencils));
                let above = (&self.levels[coarser], &self.cells[coarser]);
                parent_points = parents(self.geometry, &self.levels[number], above);
            }
            // Put the level together.
            counts.push(own.counts);
            let level = &self.levels[number];
            let chart = |site| level.chart(self.geometry, site);
            levels.push(AtlasSites {
                fine: own.stencils,
                coarse: around,
                neighbors: own.neighbors,
                parents: parent_points,
                areas: level.areas(self.geometry),
                texels: level.texels.clone(),
                width: level.points.width,
                charts: (0..level.texels.len()).map(chart).collect(),
            });
            progress.advance(1)?;
        }
        progress.end();
        Ok((SiteHierarchy { levels }, counts))
    }

    /// The samples of a window on one level.
    fn sample(
        &self,
        number: usize,
        (template, width, neighbors): (&Template, u32, bool),
        progress: Progress<'_>,
    ) -> Result<LevelSamples> {
        let level = (&self.levels[number], &self.cells[number]);
        let window = Window {
            template,
            width,
            neighbors,
        };
        let texel = self.texel * f64::from(1_u32 << number);
        let marched = paths::marched_mesh(self.geometry, texel, progress)?;
        let surface = (self.geometry, &marched);
        if self.options.sampling == Sampling::Marching || self.is_coarse(number) {
            return marching::sample(surface, level, window, progress);
        }
        match self.faces {
            Some(faces) => vertex_stars::sample(faces, surface, level, window, progress),
            None => vertex_charts::sample(surface, level, window, progress),
        }
    }

    /// Whether windows are so wide on a level that charts do not pay and fold: they are marched to instead
    /// (Ying 2001 §4). The paper leaves open where that begins.
    fn is_coarse(&self, number: usize) -> bool {
        let sites = self.levels[number].texels.len();
        VERTICES_PER_SITE * sites < self.geometry.mesh.positions.len()
    }

    /// The finest level.
    fn surface(&self) -> AtlasSurface {
        let (level, cells) = (&self.levels[0], &self.cells[0]);
        let sites = 0..level.texels.len();
        let scale = |_| -> Vec<f32> {
            let spacing = level.spacing.iter();
            spacing.map(|spacing| spacing / self.texel as f32).collect()
        };
        AtlasSurface {
            mesh: self.geometry.mesh.clone(),
            vertex_normals: self.geometry.rings.normals.clone(),
            atlas: self.geometry.atlas.clone(),
            points: level.points.clone(),
            texels: level.texels.clone(),
            positions: level.positions.clone(),
            normals: level.frames.iter().map(|frame| frame.n).collect(),
            orientations: level.frames.iter().map(|frame| frame.s).collect(),
            charts: sites.map(|site| level.chart(self.geometry, site)).collect(),
            scale: self.geometry.scale.map(scale),
            texel: self.texel,
            edges: edges::edges(level, cells),
            triangles: edges::triangles(level, cells),
            counts: Vec::new(),
            subdivisions: self.faces.map(|faces| faces.steps),
        }
    }

    /// Refuses a texture so fine that most texels of the atlas see no other.
    fn check_density(&self, sites: &AtlasSites) -> Result<()> {
        let count = sites.areas.len();
        let is_alone = |&site: &usize| sites.neighbors.row(site).is_empty();
        let alone = (0..count).filter(is_alone).count();
        if count == 1 || 2 * alone <= count {
            return Ok(());
        }
        Err(Error::option(
            "texture-scale",
            format!(
                "{}: {alone} of {count} texels have no other within the neighbourhood",
                self.options.texture_scale
            ),
            "about 1, or a higher --resolution",
        ))
    }
}

impl AtlasSurface {
    /// A list of the sites laid out as the image, row by row from the top; `outside` where no chart lies.
    pub fn image<T: Copy>(&self, of_sites: &[T], outside: T) -> Vec<T> {
        let mut image = vec![outside; self.points.triangle.len()];
        for (&texel, &value) in self.texels.iter().zip(of_sites) {
            image[texel as usize] = value;
        }
        image
    }

    /// How much the samples of each site stretch the texture, as
    /// [`stretch`](crate::sites::vertices::stretch::stretch) measures it; `sites` is the finest level with
    /// square windows.
    pub fn stretch(&self, sites: &AtlasSites) -> Vec<f32> {
        let template = Template::square(sites.fine.samples_per_site.isqrt() as u32);
        let texels: Vec<f32> = match &self.scale {
            Some(scale) => scale.iter().map(|of| of * self.texel as f32).collect(),
            None => vec![self.texel as f32; self.positions.len()],
        };
        let place = |sample| match sample {
            SampleLocation::Outside => None,
            SampleLocation::AtSite(site) => Some(self.positions[site as usize]),
            SampleLocation::Between(sites, weights) => Some(
                (0..4)
                    .map(|k| self.positions[sites[k] as usize] * weights[k])
                    .sum(),
            ),
        };
        stretch_of_places(
            &template,
            &adjacent_samples(&template),
            &texels,
            |site, places| places.extend(sites.fine.of_site(site).map(place)),
        )
    }
}
