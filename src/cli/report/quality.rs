//! The quality of a finished map, measured again, each figure with its good range (docs/synthesis.md).

use std::path::Path;

use crate::error::Result;
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::RepairReport;
use crate::mesh::reading::UserMesh;
use crate::progress::Progress;
use crate::sites::level::{SiteEdge, SiteHierarchy, Sites};
use crate::sites::target::{Target, WithSites};
use crate::sites::vertices::surface_options::SurfaceOptions;
use crate::synthesis::inputs::Inputs;
use crate::synthesis::quality::figures::{QualityFigure, figures};
use crate::synthesis::quality::{self, energy};

/// What is measured of a map.
pub(super) struct Measured {
    pub(super) figures: Vec<QualityFigure>,
    /// The neighbourhood distance at every vertex.
    pub(super) energies: Vec<f64>,
}

/// A map's surface as a mesh that was read, its orientations as guides.
pub(super) fn user_mesh(map: &SurfaceTextonMap) -> UserMesh {
    UserMesh {
        mesh: map.mesh.clone(),
        from_file: (0..map.mesh.positions.len() as u32).collect(),
        orientation: Some(map.orientations.clone()),
        scale: map.scale.clone(),
        rotation: None,
        transition: None,
        mask: None,
        normals: None,
        corner_uvs: None,
        face_of: Vec::new(),
        origin: map.header.origin,
        report: RepairReport::default(),
    }
}

/// Measures a map in the table's window of level 0.
pub(super) fn measure(
    (space, table): (&Space, &NeighborTable),
    map: &SurfaceTextonMap,
    (user, options): (&UserMesh, &SurfaceOptions),
    progress: Progress<'_>,
) -> Result<Measured> {
    let options = options
        .clone()
        .with_neighborhoods(&table.neighborhoods()[..1]);
    crate::format::guard::guarded(Path::new("the map"), || {
        let target = Target::mesh(user, &options, None, progress)?;
        let edges = target.surface.edges();
        let work = Work {
            exemplar: (space, table),
            map,
            edges: &edges,
            progress,
        };
        target.sites.with(work)
    })
}

/// The measuring, on sites of any kind.
struct Work<'a> {
    exemplar: (&'a Space, &'a NeighborTable),
    map: &'a SurfaceTextonMap,
    edges: &'a [SiteEdge],
    progress: Progress<'a>,
}

impl WithSites for Work<'_> {
    type Found = Result<Measured>;

    fn run<const N: usize, S: Sites<N>>(self, sites: &SiteHierarchy<S>) -> Result<Measured> {
        let (space, table) = self.exemplar;
        let inputs = Inputs {
            space,
            table,
            sites,
            controls: None,
        };
        let coords = &self.map.coords;
        let found = quality::measure(
            inputs,
            coords,
            self.edges,
            self.map.header.seed,
            self.progress,
        )?;
        Ok(Measured {
            figures: figures(&found, self.map.header.polish > 0),
            energies: energy::of_every_site(inputs, coords, self.progress)?,
        })
    }
}
