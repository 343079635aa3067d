//! `mesotex heights`: a sample's heights, estimated from its images.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::btf::HeightMap;
use crate::btf::heights::{Agreement, Estimate, HeightOptions, estimate};
use crate::btf::sample::{self, Sample};
use crate::cli::outcome::Outcome;
use crate::cli::outputs::Files;
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::{Error, Result};
use crate::format::lock::OutputLock;
use crate::render::nearest::Weighting;
use crate::render::parallax::Trial;

/// Views that are left out to see what the heights are worth.
const TRIED_VIEWS: usize = 12;
/// Ways that agree less than this are not to be trusted.
const POOR: f64 = 0.5;

/// Estimate the height of a sample's surface at every texel, and add it to the sample.
///
/// Two estimates are combined: a photometric one, from the change of texels with the light, and optical flow, from
/// their shift with the view. The report states how well the two agree. `render` uses the heights to correct the
/// parallax of views.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex heights felt.sample
  mesotex heights felt.sample --range 4 --force")]
pub struct Arguments {
    /// The BTF sample, a folder NAME.sample. Its height.npy is written.
    pub sample: PathBuf,
    #[command(flatten)]
    pub options: HeightOptions,
    /// Replace existing heights of the sample.
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub common: Common,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    /// What the command reads; what it writes lies among it.
    fn check(&self) -> Result<()> {
        self.options.validate()
    }

    fn files(&self) -> Result<Files> {
        Ok(Files::default()
            .read([&self.sample])
            .read(&sample::files_of(&self.sample)))
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        // Refuse what cannot be done before the work begins.
        let _lock = OutputLock::acquire(&self.sample)?;
        let sample = Sample::open(&self.sample)?;
        let path = HeightMap::path_in(&self.sample);
        if path.exists() && !self.force {
            return Err(Error::option(
                "force",
                format!("not given, but {} exists", path.display()),
                "--force to replace it",
            ));
        }
        // Estimate, and warn where the two ways disagree.
        let progress = session.progress();
        let estimate = estimate(&sample, &self.options, progress)
            .map_err(|error| error.in_file(&self.sample))?;
        if estimate.agreement.correlation < POOR {
            progress.warn(
                "the two estimates agree poorly: check the heights before you use them (glossy or plain materials \
                 give little information for either)",
            );
        }
        // Try the heights: render views that were held out, with and without them.
        let weighting = Weighting::default();
        let trial = Trial::of(&sample, &estimate.heights, weighting, TRIED_VIEWS, progress)?;
        // Write the heights and tell what was found.
        estimate.heights.write(&self.sample)?;
        let outcome = describe(&estimate);
        let outcome = match trial {
            Some(trial) => outcome
                .line(trial.describe())
                .figure("error_plain", trial.plain.relative())
                .figure("error_parallax", trial.parallax.relative()),
            None => outcome,
        };
        Ok(outcome.wrote(&path))
    }
}

fn describe(estimate: &Estimate) -> Outcome {
    let ([least, most], deviation) = (estimate.heights.range(), estimate.heights.deviation());
    let Agreement {
        correlation,
        difference,
        scale,
        photometric_deviation,
        flow_deviation,
        ..
    } = estimate.agreement;
    Outcome::default()
        .line(format!(
            "heights {least:.2} to {most:.2} texels above z = 0, standard deviation {deviation:.2}"
        ))
        .line(format!(
            "photometric against optical flow: correlation {correlation:.2} (good: above {POOR}), RMS difference \
             {difference:.2} texels; standard deviations {photometric_deviation:.2} (photometric, scaled by {scale:.2} to \
             fit) and {flow_deviation:.2} (flow)"
        ))
        .figure("least", least)
        .figure("most", most)
        .figure("deviation", deviation)
        .figure("agreement", json!(estimate.agreement))
}
