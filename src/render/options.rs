//! Options of rendering, in groups that check themselves.

mod camera;
mod files;
mod image;
mod lights;
mod ranges;
mod sweep;

use serde::Serialize;

pub use crate::render::options::camera::CameraOptions;
pub use crate::render::options::files::FileOptions;
pub use crate::render::options::image::ImageOptions;
pub use crate::render::options::lights::LightOptions;
pub use crate::render::options::sweep::SweepOptions;

use crate::error::{Error, Result};
use crate::render::option_values::Sweep;
use crate::render::renderer::Shadows;

/// How a map is rendered.
#[derive(Clone, Debug, Default, PartialEq, Serialize, clap::Args)]
pub struct RenderOptions {
    /// Which frames are made.
    #[command(flatten)]
    #[serde(flatten)]
    pub sweep: SweepOptions,
    /// How pixels are found.
    #[command(flatten)]
    #[serde(flatten)]
    pub image: ImageOptions,
    /// Where they are seen from.
    #[command(flatten)]
    #[serde(flatten)]
    pub camera: CameraOptions,
    /// What lights them.
    #[command(flatten)]
    #[serde(flatten)]
    pub lights: LightOptions,
    /// What is written.
    #[command(flatten)]
    #[serde(flatten)]
    pub files: FileOptions,
}

impl RenderOptions {
    /// Whether rows of a file may say what the options leave open.
    pub fn has_rows(&self) -> bool {
        matches!(self.sweep.kind, Sweep::File(_)) || self.camera.camera_path.is_some()
    }

    /// Refuses values that no frame can have.
    pub fn validate(&self) -> Result<()> {
        self.lights.validate()?;
        self.camera.validate()?;
        self.sweep.validate()?;
        self.files.validate()?;
        self.image.validate()?;
        self.check_ground()
    }

    fn check_ground(&self) -> Result<()> {
        match self.lights.ground && self.image.shadows == Shadows::None {
            true => Err(Error::option(
                "ground",
                "given with --shadows none",
                "--shadows vertex or pixel: the ground shows nothing but a shadow",
            )),
            false => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_values_are_refused_by_name() {
        let refused = |change: fn(&mut RenderOptions)| {
            let mut options = RenderOptions::default();
            change(&mut options);
            options.validate().unwrap_err().to_string()
        };
        assert!(refused(|o| o.lights.irradiance = f64::NAN).contains("--irradiance"));
        assert!(refused(|o| o.camera.fov = 180.0).contains("--fov"));
        assert!(refused(|o| o.files.layers.clear()).contains("--layers"));
        assert!(refused(|o| o.lights.shadow_rays = 0).contains("--shadow-rays"));
        assert!(refused(|o| o.image.size.0[1] = 0).contains("--size: 960x0; expected a size"));
        assert!(refused(|o| o.image.size.0[0] = 1 << 20).contains("--size"));
        let shadowless = refused(|o| {
            o.lights.ground = true;
            o.image.shadows = Shadows::None;
        });
        assert!(shadowless.contains("--ground: given with --shadows none"));
        assert!(refused(|o| o.sweep.sweep_length = Some(0)).contains("--sweep-length"));
        assert!(RenderOptions::default().validate().is_ok());
    }
}
