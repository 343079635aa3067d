//! What a texture that changes follows on a target: keys of the user, or numbers of the mesh.

use std::path::Path;

use crate::cli::session::Session;
use crate::error::{Error, Result};
use crate::mesh::keys::KeyFile;
use crate::mesh::reading::UserMesh;
use crate::sites::controls::SiteControls;
use crate::sites::target::TargetSurface;

/// The controls of a surface prepared from a mesh or, without one, of a flat grid, whose sites are vertices of the
/// plane z = 0. `None` where nothing is said.
pub fn of_target(
    (surface, method): (&TargetSurface, &str),
    user: Option<UserMesh>,
    keys: Option<&Path>,
    session: &Session,
) -> Result<Option<SiteControls>> {
    let file = keys.map(KeyFile::read).transpose()?;
    let file = file.filter(KeyFile::has_transition);
    let user = user.unwrap_or_else(|| UserMesh::from(surface.mesh.clone()));
    if let Some(atlas) = &surface.atlas
        && atlas.mesh.positions.len() != user.mesh.positions.len()
    {
        return Err(Error::option(
            "charts",
            format!("faces with --method {method}, whose keys are of the mesh's own vertices"),
            "uv",
        ));
    }
    let controls = SiteControls::of_mesh(&user, surface, file.as_ref(), session.progress());
    match keys {
        Some(path) => controls.map_err(|error| error.in_file(path)),
        None => controls,
    }
}
