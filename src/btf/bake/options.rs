//! What a user may ask of a bake.

use crate::btf::bake::angular::AngularFilter;
use crate::btf::bake::material::Material;
use crate::btf::bake::samples::Samples;
use crate::btf::direction_set::DirectionSet;
use crate::btf::sample::DType;
use crate::error::{Error, Result};

/// The error that `--samples auto` refines to unless told otherwise.
const ERROR: f64 = 0.02;

/// From which directions, how finely, and with which light a material is baked.
#[derive(Clone, Debug, PartialEq, clap::Args)]
pub struct BakeOptions {
    /// View directions: 12x5, bonn81, bonn151, fibonacci:N, `rings:THETA:COUNT[:OFFSET],…` or FILE.csv
    #[arg(long, value_name = "SET", default_value_t = BakeOptions::default().views)]
    pub views: DirectionSet,
    /// Light directions, as for --views.
    #[arg(long, value_name = "SET", default_value_t = BakeOptions::default().lights)]
    pub lights: DirectionSet,
    /// Number type of the sample.
    #[arg(long, value_enum, default_value_t = BakeOptions::default().dtype)]
    pub dtype: DType,
    /// View rays per texel, 1 to 65536, spread over its area; or `auto`: 4 to 256, as many as each texel needs for
    /// --error.
    #[arg(long, value_name = "N|auto", default_value_t = BakeOptions::default().samples)]
    pub samples: Samples,
    /// Target relative error of --samples auto, above 0 and below 1. The remaining error is measured and reported.
    /// [default: 0.02]
    #[arg(long, value_name = "E")]
    pub error: Option<f64>,
    /// Most reflections within the surface, 0 to 1000; 0 gives direct light only. Paths are sampled at random: raise
    /// --samples as well.
    #[arg(long, default_value_t = BakeOptions::default().bounces)]
    pub bounces: u32,
    /// Angular diameter of the light in degrees, 0 to 90. 0 gives hard shadows; larger values give softer ones and need
    /// more --samples.
    #[arg(long, value_name = "DEGREES", default_value_t = BakeOptions::default().light_diameter)]
    pub light_diameter: f64,
    /// Lowest roughness of the coat, above 0, at most 1. Smoother texels are raised to it.
    #[arg(long, value_name = "ROUGHNESS")]
    pub min_roughness: Option<f64>,
    /// Whether highlights are widened to the spacing of the directions, so that none falls between two of them.
    #[arg(long, value_enum, default_value_t = BakeOptions::default().angular_filter)]
    pub angular_filter: AngularFilter,
    /// Clamp values beyond half precision to its largest number, 65504, and report how many there were. Without --clamp
    /// they are an error.
    #[arg(long)]
    pub clamp: bool,
    /// Seed of what is drawn at random.
    #[arg(skip)]
    pub seed: u64,
}

impl Default for BakeOptions {
    fn default() -> Self {
        Self {
            views: DirectionSet::Tong12x5,
            lights: DirectionSet::Tong12x5,
            dtype: DType::F2,
            samples: Samples::Fixed(4),
            error: None,
            bounces: 0,
            light_diameter: 0.0,
            min_roughness: None,
            angular_filter: AngularFilter::Auto,
            clamp: false,
            seed: 0,
        }
    }
}

impl BakeOptions {
    /// Refuses what cannot be baked.
    pub fn validate(&self) -> Result<()> {
        self.samples.validate()?;
        self.validate_error()?;
        if self.bounces > 1000 {
            let found = self.bounces.to_string();
            return Err(Error::option("bounces", found, "0 to 1000"));
        }
        if !(0.0..=90.0).contains(&self.light_diameter) {
            return Err(Error::option(
                "light-diameter",
                self.light_diameter.to_string(),
                "0 to 90 degrees",
            ));
        }
        if self.clamp && self.dtype == DType::F4 {
            return Err(Error::option(
                "clamp",
                "given with --dtype f4",
                "--dtype f2, whose numbers end at 65504",
            ));
        }
        match self.min_roughness {
            Some(least) if !(least > 0.0 && least <= 1.0) => Err(Error::option(
                "min-roughness",
                least.to_string(),
                "a roughness above 0, at most 1",
            )),
            _ => Ok(()),
        }
    }

    fn validate_error(&self) -> Result<()> {
        let Some(error) = self.error else {
            return Ok(());
        };
        if !(error > 0.0 && error < 1.0) {
            let expected = "a relative error above 0, below 1";
            return Err(Error::option("error", error.to_string(), expected));
        }
        if self.samples != Samples::Auto {
            let found = format!("given with --samples {}", self.samples);
            return Err(Error::option("error", found, "--samples auto"));
        }
        Ok(())
    }

    /// The error that `--samples auto` refines to.
    pub(super) fn wanted_error(&self) -> f64 {
        self.error.unwrap_or(ERROR)
    }

    /// The material as these options bake it: no smoother than `min_roughness`.
    pub fn applied_to(&self, mut material: Material) -> Result<Material> {
        let Some(least) = self.min_roughness else {
            return Ok(material);
        };
        let Some(roughness) = &mut material.roughness else {
            return Err(Error::option(
                "min-roughness",
                "given for a matte material",
                "a material with roughness",
            ));
        };
        roughness
            .iter_mut()
            .for_each(|rough| *rough = rough.max(least as f32));
        Ok(material)
    }
}
