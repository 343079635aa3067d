//! The controls of a target from what came with its mesh, and from keys.

use crate::error::Result;
use crate::mesh::keys::KeyFile;
use crate::mesh::reading::UserMesh;
use crate::progress::Progress;
use crate::sites::controls::SiteControls;
use crate::sites::target::TargetSurface;

impl SiteControls {
    /// The controls of the finest sites of a surface that was prepared from a mesh: what keys say, else the mesh's
    /// own transition; its mask. `None` where nothing is said.
    pub fn of_mesh(
        user: &UserMesh,
        surface: &TargetSurface,
        keys: Option<&KeyFile>,
        progress: Progress<'_>,
    ) -> Result<Option<Self>> {
        let of_keys = keys
            .map(|keys| keys.transition(user, progress))
            .transpose()?;
        let transition = of_keys.or_else(|| user.transition.clone());
        if transition.is_none() && user.mask.is_none() {
            return Ok(None);
        }
        let count = user.mesh.positions.len();
        let transition = transition.unwrap_or_else(|| vec![0.0; count]);
        let mask = user.mask.as_deref();
        let label = |label: &f32| *label as u8;
        Ok(Some(match &surface.atlas {
            Some(atlas) => Self {
                transition: atlas.blended(&transition),
                mask: mask.map(|mask| atlas.heaviest(mask).iter().map(label).collect()),
            },
            None => Self {
                transition,
                mask: mask.map(|mask| mask.iter().map(label).collect()),
            },
        }))
    }
}
