//! The chapters of the mesh and of the map: the field and the pyramid, the map by coordinate, label and energy.

use crate::cli::report::name;
use crate::cli::report::products::Products;
use crate::cli::report::quality::{self, Measured};
use crate::cli::session::Session;
use crate::error::Result;
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::false_color::{coordinate_colors, energy_colors, label_colors};
use crate::format::guard::guarded;
use crate::format::rgb_image::RgbImage;
use crate::index::TextonLabel;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::field::Field;
use crate::mesh::field::singularities::singularities;
use crate::mesh::pictures;
use crate::mesh::reading::UserMesh;
use crate::mesh::rings::Rings;
use crate::mesh::topology::Topology;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::render::preview;
use crate::report::embedded::Embedded;
use crate::report::summary::{Chapter, Summary};
use crate::sites::vertices::cache;
use crate::sites::vertices::surface::prepare;
use crate::sites::vertices::surface_options::SurfaceOptions;

/// Pixels of a picture.
const SIZE: [u32; 2] = [640, 480];

/// Fills both chapters, and the figures.
pub(super) fn fill(summary: &mut Summary, products: &Products, session: &Session) -> Result<()> {
    // Note what is not drawn.
    for other in &products.other_maps {
        summary.map.note(format!(
            "{}: atlases and face maps are not drawn here; mesotex view shows them",
            name(other)
        ));
    }
    let Some(path) = &products.map else {
        if products.other_maps.is_empty() {
            summary
                .map
                .note("no surface texton map is there: mesotex synth makes one");
        }
        summary
            .mesh
            .note("no mesh to show; the pictures show the map's surface");
        return Ok(());
    };
    let map = SurfaceTextonMap::read(path)?;
    if map.mesh.triangles.is_empty() {
        summary
            .map
            .note(format!("{}: no triangle, nothing to draw", name(path)));
        return Ok(());
    }
    // State the facts of mesh and map.
    mesh_facts(&mut summary.mesh, &map);
    map_facts(&mut summary.map, &map);
    let field = guarded(path, || field_picture(&map.mesh, &map));
    match field {
        Ok(picture) => summary.mesh.pictures.push(picture),
        Err(error) => summary
            .mesh
            .note(format!("no picture of the field: {error}")),
    }
    let labelled = |colors: &[[u8; 3]], caption: &str| drawn(&map.mesh, colors, caption);
    summary.map.pictures.push(labelled(
        &coordinate_colors(map.grid(false), &map.coords),
        "by texture coordinate: copied patches are smooth pieces",
    )?);
    if map.textons.iter().any(|label| *label != TextonLabel::NONE) {
        summary
            .map
            .pictures
            .push(labelled(&label_colors(&map.textons), "by texton label")?);
    }
    measure(summary, products, &map, session)
}

/// Figures, the picture by energy, and the pyramid: what needs the space and the table.
fn measure(
    summary: &mut Summary,
    products: &Products,
    map: &SurfaceTextonMap,
    session: &Session,
) -> Result<()> {
    // Open the space and the table.
    let (Some(space), Some(table)) = (&products.space, &products.table) else {
        summary.map.note("no quality figures: they need the space and the neighbour table (.space.npz, .knn.npz)");
        return Ok(());
    };
    let (space, table) = (Space::read(space)?, NeighborTable::read(table)?);
    if space.levels[0].grid.len() != map.grid(false).len() {
        summary
            .map
            .note("no quality figures: the space is of a sample of another size");
        return Ok(());
    }
    // Measure the map.
    let options = SurfaceOptions {
        texel: Some(map.header.texel),
        seed: map.header.seed,
        ..SurfaceOptions::default()
    };
    let user = quality::user_mesh(map);
    match quality::measure((&space, &table), map, (&user, &options), session.progress()) {
        Ok(Measured { figures, energies }) => {
            summary.figures = figures;
            let picture = drawn(
                &map.mesh,
                &energy_colors(&energies),
                "by energy: bright where the neighbourhood fits worst",
            )?;
            summary.map.pictures.push(picture);
        }
        Err(error) => summary.map.note(format!("no quality figures: {error}")),
    }
    // Draw the levels.
    pyramid(&mut summary.mesh, products, &table, (map, options), session)
}

/// The coarser levels, where a synthesis has left them prepared.
fn pyramid(
    chapter: &mut Chapter,
    products: &Products,
    table: &NeighborTable,
    (map, options): (&SurfaceTextonMap, SurfaceOptions),
    session: &Session,
) -> Result<()> {
    // Find the mesh of the synthesis.
    let prepared = |path: &&std::path::PathBuf| cache::folder_of(path).is_dir();
    let Some(path) = products.meshes.iter().find(prepared) else {
        chapter.note(
            "no picture of the pyramid: the mesh of the synthesis, with its cache, is missing",
        );
        return Ok(());
    };
    let user: UserMesh = crate::mesh::reading::read(path, session.progress())?;
    if user.mesh.positions.len() != map.mesh.positions.len() {
        chapter.note(format!(
            "no picture of the pyramid: {} is not the map's mesh",
            name(path)
        ));
        return Ok(());
    }
    // Take its levels from the cache.
    let options = SurfaceOptions {
        texel: None,
        ..options
    }
    .with_neighborhoods(&table.neighborhoods());
    let surface = prepare(
        &user,
        &options,
        Some(&cache::folder_of(path)),
        session.progress(),
    )?;
    // Draw them.
    for (number, level) in surface.levels.iter().enumerate() {
        let picture = pictures::level(&level.mesh);
        let caption = format!(
            "level {number}: {} vertices, one colour per vertex",
            level.mesh.positions.len()
        );
        chapter
            .pictures
            .push(drawn(&picture.mesh, &picture.colors, &caption)?);
    }
    Ok(())
}

fn mesh_facts(chapter: &mut Chapter, map: &SurfaceTextonMap) {
    chapter.fact("vertices", map.mesh.positions.len());
    chapter.fact("triangles", map.mesh.triangles.len());
    chapter.fact("area", format!("{:.4} square mesh units", map.mesh.area()));
}

fn map_facts(chapter: &mut Chapter, map: &SurfaceTextonMap) {
    let [width, height] = map.header.exemplar;
    chapter.fact(
        "sample",
        format!("{width} × {height} texels, id {}", map.header.sample),
    );
    chapter.fact("space", format!("id {}", map.header.space));
    chapter.fact(
        "a texel covers",
        format!("{:.6} mesh units", map.header.texel),
    );
    chapter.fact("method", &map.header.method);
    if map.header.polish > 0 {
        chapter.fact("rounds of polish", map.header.polish);
    }
    chapter.fact("seed", map.header.seed);
}

fn field_picture(mesh: &TriangleMesh, map: &SurfaceTextonMap) -> Result<Embedded> {
    let rings = Rings::new(mesh, &Topology::new(&mesh.triangles));
    let angle = |vertex: usize| {
        rings
            .angle_of(vertex, map.orientations[vertex])
            .unwrap_or(0.0)
    };
    let vectors = (0..mesh.positions.len()).map(|vertex| glam::DVec2::from_angle(angle(vertex)));
    let field = Field::of_vectors(mesh, &rings, vectors.collect());
    let singular = singularities(mesh, &rings, &field.vectors);
    let picture = pictures::field(mesh, &rings, &field, &singular);
    let caption = format!("the orientation field; {} singularities", singular.len());
    drawn(&picture.mesh, &picture.colors, &caption)
}

fn drawn(mesh: &TriangleMesh, colors: &[[u8; 3]], caption: &str) -> Result<Embedded> {
    let picture = RgbImage {
        width: SIZE[0],
        height: SIZE[1],
        pixels: preview::vertex_colors(mesh, colors, SIZE)?,
    };
    Embedded::new(&picture, caption)
}
