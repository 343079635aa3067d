//! The whole preparation of a surface: pyramid, orientation field, frames, patches, stencils.
//!
//! In: a user's mesh. Out: everything synthesis needs of it, per level; level 0 is the user's own
//! vertices. Cached beside the mesh by the hash of all that went in.

use std::path::Path;

use glam::Vec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::mesh::connection::Connection;
use crate::mesh::field::guides::{GuideOptions, GuidedSurface, guided_field};
use crate::mesh::reading::UserMesh;
use crate::mesh::retile::Retiler;
use crate::mesh::retile::relax::ReferenceSurface;
use crate::mesh::rings::Rings;
use crate::mesh::surface_bvh::{SurfaceBvh, SurfacePoint};
use crate::mesh::topology::Topology;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::neighborhood::Template;
use crate::progress::Progress;
use crate::sites::level::Parent;
use crate::sites::vertices::VertexSites;
use crate::sites::vertices::cache;
use crate::sites::vertices::parents;
use crate::sites::vertices::patches::Patches;
use crate::sites::vertices::prepared_surface::{PreparedSurface, SurfaceLevel};
use crate::sites::vertices::sampling::SampleCounts;
use crate::sites::vertices::stencil::PatchStencils;
use crate::sites::vertices::surface_options::{SurfaceOptions, warn_of_texel};

/// One level while it is being prepared.
struct LevelGeometry {
    mesh: TriangleMesh,
    rings: Rings,
    connection: Connection,
    /// Mesh units per texel where the scale is 1.
    texel: f32,
    /// Per vertex the mesh units per texel, its scale included.
    texels: Vec<f32>,
}

/// Prepares a surface, or takes it from the folder `cache`, where it is then kept.
///
/// A cache that cannot be read or written, or that does not hold what it should, costs a warning, no more.
pub fn prepare(
    user: &UserMesh,
    options: &SurfaceOptions,
    cache: Option<&Path>,
    progress: Progress<'_>,
) -> Result<PreparedSurface> {
    options.validate()?;
    let Some(folder) = cache else {
        return prepare_afresh(user, options, progress);
    };
    let wanted = cache::Wanted::new(user, options)?;
    let file = wanted.file(folder);
    if file.exists() {
        match cache::read(&file, &wanted) {
            Ok(surface) => return Ok(surface),
            Err(error) => progress.warn(format!("{error}; the cached surface is made again")),
        }
    }
    let surface = prepare_afresh(user, options, progress)?;
    if let Err(error) = cache::write(&file, &wanted, &surface) {
        progress.warn(format!("the surface is not cached: {error}"));
    }
    Ok(surface)
}

fn prepare_afresh(
    user: &UserMesh,
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<PreparedSurface> {
    let texel = options.texel_on(&user.mesh)?;
    warn_of_texel(&user.mesh, texel, progress);
    progress.check()?;
    let target = ReferenceSurface::new(&user.mesh, options.crease.to_radians());
    progress.check()?;
    let meshes = pyramid(user, &target, options, progress)?;
    progress.begin("orientation field", 1);
    let levels = oriented_levels(user, options, meshes, (&target.tree, texel), progress)?;
    progress.advance(1)?;
    progress.end();
    assemble(levels, options, texel, progress)
}

/// No level is asked to have fewer vertices.
const FEWEST_VERTICES: usize = 4;

/// Level 0 and its retiled quarters.
fn pyramid(
    user: &UserMesh,
    target: &ReferenceSurface,
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<Vec<TriangleMesh>> {
    let mut meshes = vec![user.mesh.clone()];
    let mut retiler = Retiler::new(&user.mesh, target);
    for level in 1..options.levels {
        let wanted = user.mesh.referenced_count() >> (2 * level);
        meshes.push(retiler.to(wanted.max(FEWEST_VERTICES), progress)?);
    }
    Ok(meshes)
}

fn oriented_levels(
    user: &UserMesh,
    options: &SurfaceOptions,
    meshes: Vec<TriangleMesh>,
    (tree, texel): (&SurfaceBvh, f64),
    progress: Progress<'_>,
) -> Result<Vec<LevelGeometry>> {
    let mut levels: Vec<LevelGeometry> = Vec::with_capacity(meshes.len());
    for (number, mesh) in meshes.into_iter().enumerate() {
        progress.check()?;
        // Find the tangent planes.
        let rings = Rings::new(&mesh, &Topology::new(&mesh.triangles));
        progress.check()?;
        // Find the directions: of the finest level the field, of others what it has there.
        let (angles, scales) = match levels.first() {
            None => {
                let surface = GuidedSurface {
                    user,
                    rings: &rings,
                    tree,
                    texel,
                };
                let angles = guided_angles(surface, &options.guides(), options.seed, progress)?;
                (angles, user.scale.clone())
            }
            Some(first) => carried_down(&mesh, &rings, first, user.scale.as_deref(), tree),
        };
        // Scale the texel.
        let level_texel = (texel * f64::from(1u32 << number)) as f32;
        let texels = match scales {
            Some(scales) => scales.iter().map(|scale| scale * level_texel).collect(),
            None => vec![level_texel; mesh.positions.len()],
        };
        levels.push(LevelGeometry {
            connection: Connection::new(&rings, &angles),
            rings,
            mesh,
            texel: level_texel,
            texels,
        });
    }
    Ok(levels)
}

/// The angles of the finest frames: the field, rotated by the user's rotation.
pub fn guided_angles(
    surface: GuidedSurface<'_>,
    guides: &GuideOptions,
    seed: u64,
    progress: Progress<'_>,
) -> Result<Vec<f64>> {
    let mut angles = guided_field(surface, guides, seed, progress)?.angles();
    let turns = surface.user.rotation.iter().flatten();
    for (angle, degrees) in angles.iter_mut().zip(turns) {
        *angle += f64::from(*degrees).to_radians();
    }
    Ok(angles)
}

/// Directions and scales of a coarser level, read off the finest at the nearest point.
fn carried_down(
    mesh: &TriangleMesh,
    rings: &Rings,
    finest: &LevelGeometry,
    scales: Option<&[f32]>,
    tree: &SurfaceBvh,
) -> (Vec<f64>, Option<Vec<f32>>) {
    // Find the nearest point that faces the same way, or else the nearest.
    let points: Vec<Option<SurfacePoint>> = (0..mesh.positions.len())
        .into_par_iter()
        .map(|vertex| {
            let normal = rings.normals[vertex];
            let facing = |corners: &[Vec3; 3]| {
                (corners[1] - corners[0])
                    .cross(corners[2] - corners[0])
                    .dot(normal)
                    > 0.0
            };
            let position = mesh.positions[vertex];
            tree.nearest_accepted(position, f32::INFINITY, facing)
                .or_else(|| tree.nearest(position))
        })
        .collect();
    // Take the direction there.
    let corners = |point: &SurfacePoint| finest.mesh.triangles[point.triangle as usize];
    let angle = |(vertex, point): (usize, &Option<SurfacePoint>)| {
        let point = point.as_ref()?;
        let carried: Vec3 = corners(point)
            .iter()
            .zip(point.weights)
            .map(|(&corner, weight)| finest.connection.frames[corner as usize].s * weight)
            .sum();
        rings.angle_of(vertex, carried)
    };
    let angles = points
        .iter()
        .enumerate()
        .map(|at| angle(at).unwrap_or(0.0))
        .collect();
    // Take the scale there.
    let scale = |point: &Option<SurfacePoint>, scales: &[f32]| {
        point.as_ref().map_or(1.0, |point| {
            let terms = corners(point).into_iter().zip(point.weights);
            terms
                .map(|(corner, weight)| scales[corner as usize] * weight)
                .sum()
        })
    };
    let scales = scales.map(|scales| points.iter().map(|point| scale(point, scales)).collect());
    (angles, scales)
}

fn assemble(
    levels: Vec<LevelGeometry>,
    options: &SurfaceOptions,
    texel: f64,
    progress: Progress<'_>,
) -> Result<PreparedSurface> {
    // Make the sites, each level's with the geometry of the next.
    progress.begin("patches", levels.len() as u64);
    let mut sites = Vec::with_capacity(levels.len());
    for (number, level) in levels.iter().enumerate() {
        sites.push(level.sites(levels.get(number + 1), options, progress)?);
        progress.advance(1)?;
    }
    progress.end();
    // Keep of the geometry what synthesis needs.
    let levels = levels.into_iter().zip(sites);
    let levels = levels.map(|(level, (sites, samples))| SurfaceLevel {
        mesh: level.mesh,
        frames: level.connection.frames,
        sites,
        samples,
    });
    Ok(PreparedSurface {
        levels: levels.collect(),
        texel,
    })
}

impl LevelGeometry {
    fn patches(&self) -> Patches<'_> {
        Patches {
            mesh: &self.mesh,
            connection: &self.connection,
            texels: &self.texels,
        }
    }

    /// The level's sites, with their parents on the `coarser` level, and what became of their samples.
    fn sites(
        &self,
        coarser: Option<&Self>,
        options: &SurfaceOptions,
        progress: Progress<'_>,
    ) -> Result<(VertexSites, SampleCounts)> {
        let window = Template::square(options.neighborhood);
        let half_window = options.neighborhood as f32 / 2.0;
        let own = self
            .patches()
            .round_vertices(&window, half_window, progress)?;
        let above = coarser.map(|coarser| self.parent_samples(coarser, options, progress));
        let (coarse, parents) = above.transpose()?.unzip();
        let sites = VertexSites {
            fine: own.stencils,
            coarse,
            neighbors: own.neighbors,
            parents: parents.unwrap_or_default(),
            areas: self.mesh.vertex_areas(),
        };
        Ok((sites, own.counts))
    }

    /// The samples of the parent neighbourhood of every vertex on the coarser level, and the parents.
    fn parent_samples(
        &self,
        coarser: &Self,
        options: &SurfaceOptions,
        progress: Progress<'_>,
    ) -> Result<(PatchStencils, Vec<Parent>)> {
        progress.check()?;
        let tree = SurfaceBvh::new(&coarser.mesh);
        let points = parents::parent_points(&self.mesh, &self.rings.normals, &tree, coarser.texel);
        let texels: Vec<f32> = self.texels.iter().map(|texel| 2.0 * texel).collect();
        coarser.patches().round_points(
            &Template::square(options.coarse_neighborhood),
            &points,
            &self.connection,
            &texels,
            progress,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::sites::level::{SampleLocation, Sites};
    use glam::Vec2;

    fn user(mesh: TriangleMesh) -> UserMesh {
        UserMesh::from(mesh)
    }

    fn prepared(user: &UserMesh, levels: u32) -> PreparedSurface {
        let options = SurfaceOptions {
            levels,
            ..SurfaceOptions::default()
        };
        prepare(user, &options, None, Progress::silent()).unwrap()
    }

    /// A flat grid guided along x, one texel per step.
    fn flat(side: u32, levels: u32) -> (TriangleMesh, PreparedSurface) {
        let mesh = shapes::grid(side, side, 0.5);
        let mut user = user(mesh.clone());
        user.orientation = Some(vec![Vec3::X; mesh.positions.len()]);
        let options = SurfaceOptions {
            levels,
            texel: Some(0.5),
            ..SurfaceOptions::default()
        };
        (
            mesh,
            prepare(&user, &options, None, Progress::silent()).unwrap(),
        )
    }

    fn position(sample: SampleLocation<3>, mesh: &TriangleMesh) -> Vec3 {
        let (sites, weights) = match sample {
            SampleLocation::Outside => panic!("outside"),
            SampleLocation::AtSite(site) => ([site; 3], [1.0, 0.0, 0.0]),
            SampleLocation::Between(sites, weights) => (sites, weights),
        };
        let corners = sites.map(|site| mesh.positions[site as usize]);
        (0..3).map(|k| corners[k] * weights[k]).sum()
    }

    #[test]
    fn the_stencil_of_a_flat_grid_is_the_grid() {
        let (mesh, surface) = flat(12, 1);
        let template = Template::square(7);
        let level = &surface.levels[0].sites;
        let centre = 6 * 13 + 6;
        for (sample, offset) in level.fine.of_site(centre).zip(&template.positions) {
            let at = position(sample, &mesh);
            let expected = mesh.positions[centre] + offset.extend(0.0) * 0.5;
            assert!((at - expected).length() < 1e-3, "{at} {expected}");
        }
        assert_eq!(level.neighbors(centre).count(), 48);
        assert_eq!(level.neighbors(0).count(), 15);
        let nearest = level.neighbors(centre).next().unwrap();
        assert_eq!(nearest.site as usize, centre - 13);
        assert!((Vec2::new(nearest.x, nearest.y) - Vec2::new(0.0, -1.0)).length() < 1e-4);
        let corner = level.fine.of_site(0);
        let valued = corner.filter(|s| *s != SampleLocation::Outside);
        assert_eq!(valued.count(), 16);
    }

    #[test]
    fn coarse_stencils_and_parents_lie_where_they_should() {
        let (mesh, surface) = flat(24, 2);
        let template = Template::square(3);
        let level = &surface.levels[0].sites;
        let coarse = level.coarse.as_ref().unwrap();
        let above = &surface.levels[1].mesh;
        let centre = 12 * 25 + 12;
        for (sample, offset) in coarse.of_site(centre).zip(&template.positions) {
            let at = position(sample, above);
            let expected = mesh.positions[centre] + offset.extend(0.0);
            assert!((at - expected).length() < 2e-3, "{at} {expected}");
        }
        for (vertex, parent) in level.parents.iter().enumerate() {
            let at = above.positions[parent.site as usize] - mesh.positions[vertex];
            let expected = Vec2::new(parent.x, parent.y);
            assert!(
                (at.truncate() - expected).length() < 2e-3,
                "{vertex}: {at} {expected}"
            );
        }
    }

    #[test]
    fn stray_vertices_have_no_neighbours_and_default_frames() {
        let mut mesh = shapes::icosphere(3);
        mesh.positions.insert(0, Vec3::splat(7.0));
        mesh.triangles.iter_mut().flatten().for_each(|v| *v += 1);
        let surface = prepared(&user(mesh), 2);
        let level = &surface.levels[0].sites;
        assert_eq!(level.neighbors(0).count(), 0);
        for stencils in [&level.fine, level.coarse.as_ref().unwrap()] {
            assert!(stencils.of_site(0).all(|s| s == SampleLocation::Outside));
        }
        assert_eq!(level.areas[0], 0.0);
        assert_eq!(
            (surface.levels[0].frames[0].n, surface.levels[0].frames[0].s),
            (Vec3::Z, Vec3::X)
        );
    }

    #[test]
    fn a_cached_surface_is_the_same_and_a_damaged_one_is_made_again() {
        let user = user(shapes::torus(30, 16, 1.0, 0.4));
        let folder = tempfile::tempdir().unwrap();
        let options = SurfaceOptions {
            levels: 2,
            ..SurfaceOptions::default()
        };
        let run = || prepare(&user, &options, Some(folder.path()), Progress::silent()).unwrap();
        let first = run();
        assert_eq!(run(), first);
        let files: Vec<_> = std::fs::read_dir(folder.path())
            .unwrap()
            .flatten()
            .collect();
        assert_eq!(files.len(), 1);
        let path = files[0].path();
        let wanted = cache::Wanted::new(&user, &options).unwrap();
        assert!(cache::read(&path, &wanted).is_ok());
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        assert_eq!(run(), first);
        assert!(cache::read(&path, &wanted).is_ok());
        let other = SurfaceOptions {
            texel: Some(0.1),
            ..options.clone()
        };
        assert_ne!(
            wanted.file(folder.path()),
            cache::Wanted::new(&user, &other)
                .unwrap()
                .file(folder.path())
        );
    }

    #[test]
    fn scale_and_rotation_of_a_vertex_act_on_its_own_patch() {
        let mesh = shapes::grid(16, 16, 0.5);
        let mut user = user(mesh.clone());
        let count = mesh.positions.len();
        user.orientation = Some(vec![Vec3::X; count]);
        let centre = 8 * 17 + 8;
        let mut scale = vec![1.0; count];
        scale[centre] = 2.0;
        let mut rotation = vec![0.0; count];
        rotation[centre] = 90.0;
        (user.scale, user.rotation) = (Some(scale), Some(rotation));
        let options = SurfaceOptions {
            levels: 1,
            texel: Some(0.5),
            neighborhood: 3,
            ..SurfaceOptions::default()
        };
        let surface = prepare(&user, &options, None, Progress::silent()).unwrap();
        assert!((surface.levels[0].frames[centre].s - Vec3::Y).length() < 1e-5);
        let fine = &surface.levels[0].sites.fine;
        // One texel along s: up the mesh, and a whole unit at scale 2.
        let at = position(fine.of_site(centre).nth(5).unwrap(), &mesh);
        assert!(
            (at - mesh.positions[centre] - Vec3::Y).length() < 1e-3,
            "{at}"
        );
    }

    #[test]
    fn bad_options_are_refused_by_name() {
        let mesh = user(shapes::grid(2, 2, 1.0));
        let refused = |options: SurfaceOptions| {
            let error = prepare(&mesh, &options, None, Progress::silent()).unwrap_err();
            error.to_string()
        };
        let base = SurfaceOptions::default;
        for texel in [0.0, -1.0, f64::NAN] {
            let text = refused(SurfaceOptions {
                texel: Some(texel),
                ..base()
            });
            assert!(text.contains("--texel"), "{text}");
        }
        let text = refused(SurfaceOptions {
            neighborhood: 6,
            ..base()
        });
        assert!(text.contains("--neighborhood"), "{text}");
    }
}
