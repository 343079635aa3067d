//! `mesotex factor`: sample → factored sample.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::btf::factored::residual::Residual;
use crate::btf::factored::{Accuracy, FactorOptions, factorize};
use crate::btf::sample::{self, DType, Description, Sample};
use crate::btf::writer::SAMPLE_FOLDER;
use crate::cli::info::kind::Kind;
use crate::cli::machine::Need;
use crate::cli::outcome::{Outcome, next_textons};
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::{Error, Result};

/// Store a BTF sample as factors: every image is a sum of a few eigentextures.
///
/// Each of R, G and B gets K eigentextures and, per image, K numbers. Every other command reads the result like the
/// sample. The remaining error is measured and reported.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex factor weave.sample --rank 32 -o weave32.sample
  mesotex factor weave.sample --error 0.02 -o small.sample
  mesotex factor weave.sample --rank 16 --dtype f4 -o weave16.sample")]
pub struct Arguments {
    /// The BTF sample, a folder NAME.sample.
    pub sample: PathBuf,
    /// The factored sample to write, NAME.sample.
    #[arg(long, short)]
    pub output: PathBuf,
    /// Eigentextures per channel.
    #[arg(long, value_name = "K", required_unless_present = "error")]
    pub rank: Option<u32>,
    /// Use the fewest eigentextures whose error is at most this, relative to the root mean square of all values.
    #[arg(long, value_name = "E", conflicts_with = "rank")]
    pub error: Option<f64>,
    /// Number type of the factors. [default: that of the sample]
    #[arg(long, value_name = "TYPE")]
    pub dtype: Option<DType>,
    #[command(flatten)]
    pub common: Common,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn files(&self) -> Result<Files> {
        Ok(Files::default()
            .read_as(&[Kind::Sample], &self.sample)
            .read(&sample::files_of(&self.sample))
            .write("output", [&self.output], Product::Folder(&SAMPLE_FOLDER)))
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        let sample = Sample::open(&self.sample)?;
        let options = FactorOptions {
            accuracy: match (self.rank, self.error) {
                (Some(rank), _) => Accuracy::Rank(rank),
                (None, Some(error)) => Accuracy::Error(error),
                (None, None) => {
                    return Err(Error::option("rank", "missing", "--rank K or --error E"));
                }
            },
            dtype: self.dtype.unwrap_or(sample.description().dtype),
            seed: session.seed(),
        };
        options.validate(sample.description())?;
        let need = Need {
            bytes: options.planned_bytes(&sample),
            work: format!("factors of {} images", sample.image_count()),
            option: "rank",
            advice: "a smaller --rank".into(),
        };
        need.check()?;
        let of = sample.description();
        let origin = json!({"sample": of.id, "source": of.source});
        let (made, left) = factorize(&sample, &options, origin, &self.output, session.progress())?;
        Ok(self.outcome(&made, &left))
    }
}

impl Arguments {
    fn outcome(&self, made: &Description, left: &Residual) -> Outcome {
        // Find where the worst errors are.
        let rank = made.factors().map_or(0, |factors| factors.rank);
        let (view, light) = made.view_and_light(left.worst_image);
        let width = made.width as usize;
        let (row, column) = (left.worst_texel / width, left.worst_texel % width);
        // Tell rank and errors.
        Outcome::default()
            .line(format!(
                "rank {rank} per channel: {} images of {} × {} texels from {} eigentextures",
                made.image_count(),
                made.width,
                made.height,
                3 * rank
            ))
            .line(format!(
                "error {:.3} % of the root mean square of all values",
                100.0 * left.relative
            ))
            .line(format!(
                "worst image {:.3} % (view {view}, light {light}), worst texel {:.3} % (row {row}, \
                 column {column})",
                100.0 * left.worst_image_error,
                100.0 * left.worst_texel_error
            ))
            .figure("rank", rank)
            .figure("dtype", json!(made.dtype))
            .figure("relative_error", left.relative)
            .figure(
                "worst_image",
                json!({"image": left.worst_image, "view": view, "light": light,
                    "error": left.worst_image_error}),
            )
            .figure(
                "worst_texel",
                json!({"row": row, "column": column, "error": left.worst_texel_error}),
            )
            .figure("id", made.id.to_string())
            .wrote(&self.output)
            .next(next_textons(&self.output))
    }
}
