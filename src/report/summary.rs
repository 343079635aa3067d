//! The page of `mesotex report`: everything that was made, chapter by chapter.

use serde::Serialize;
use serde_json::{Value, json};

use crate::btf::sample::Sample;
use crate::error::Result;
use crate::progress::Progress;
use crate::report::embedded::Embedded;
use crate::report::numbers;
use crate::report::page::{STYLE, bundle, filled, json};
use crate::report::view_factors::{Limits, view_factors};
use crate::report::viewer::sample_description;
use crate::synthesis::quality::figures::QualityFigure;

/// The error that factors of the sample may leave, and their most bytes.
const ERROR: f64 = 0.05;
const MOST_BYTES: usize = 6_000_000;
/// Texels of an image that is shown.
const MOST_TEXELS: u64 = 128 * 128;

const MODULES: [&str; 5] = [
    include_str!("web/numbers.js"),
    include_str!("web/sample.js"),
    include_str!("web/dome.js"),
    include_str!("web/player.js"),
    include_str!("web/report.js"),
];

/// A line of a table.
#[derive(Clone, Debug, Serialize)]
pub struct Fact {
    /// What it is.
    pub name: String,
    /// What was found.
    pub value: String,
}

/// One chapter.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Chapter {
    /// What is known.
    pub facts: Vec<Fact>,
    /// What is seen.
    pub pictures: Vec<Embedded>,
    /// What is not there, and how to have it.
    pub notes: Vec<String>,
}

impl Chapter {
    /// Adds a line.
    pub fn fact(&mut self, name: &str, value: impl ToString) {
        self.facts.push(Fact {
            name: name.into(),
            value: value.to_string(),
        });
    }

    /// Says what is not there.
    pub fn note(&mut self, text: impl Into<String>) {
        self.notes.push(text.into());
    }
}

/// Frames of one sequence.
#[derive(Clone, Debug, Serialize)]
pub struct Sequence {
    /// The name of its folder.
    pub name: String,
    /// `data:` addresses.
    pub frames: Vec<String>,
    /// What each shows.
    pub names: Vec<String>,
}

/// A stage that was run.
#[derive(Clone, Debug, Serialize)]
pub struct StageFacts {
    /// The command.
    pub name: String,
    /// How long it took, where it is known.
    pub seconds: String,
    /// Its command line.
    pub command: String,
    /// What it wrote.
    pub outputs: Vec<OutputFacts>,
}

/// A file that a stage wrote.
#[derive(Clone, Debug, Serialize)]
pub struct OutputFacts {
    /// Where.
    pub path: String,
    /// The id of its content.
    pub id: String,
}

/// All chapters of a report.
#[derive(Debug, Default)]
pub struct Summary {
    /// What the page is called.
    pub title: String,
    /// The sample.
    pub sample: Chapter,
    /// Its vocabulary.
    pub textons: Chapter,
    /// The mesh, its field and its pyramid.
    pub mesh: Chapter,
    /// The map.
    pub map: Chapter,
    /// Its quality.
    pub figures: Vec<QualityFigure>,
    /// Frames.
    pub sequences: Vec<Sequence>,
    /// What is not there of frames.
    pub frame_notes: Vec<String>,
    /// What was run.
    pub stages: Vec<StageFacts>,
    /// What is not known of it.
    pub stage_notes: Vec<String>,
}

impl Summary {
    /// The page; with a sample, its images are on it.
    pub fn page(&self, sample: Option<&Sample>, progress: Progress<'_>) -> Result<String> {
        // Pack the sample's images.
        let shown = sample
            .map(|sample| ShownSample::new(sample, progress))
            .transpose()?;
        let mut of_sample = json!(self.sample);
        if let Some(shown) = &shown {
            of_sample["packed"] = json!(shown.packed);
            of_sample["error"] = json!(format!("{:.1} %", 100.0 * shown.error));
        }
        // Describe the sequences.
        let sequences: Vec<Value> = self
            .sequences
            .iter()
            .map(|sequence| {
                json!({
                    "name": sequence.name,
                    "first": sequence.frames.first(),
                    "last": sequence.frames.len().saturating_sub(1),
                })
            })
            .collect();
        let description = json!({
            "sample": shown.as_ref().map(|shown| &shown.description),
            "sequences": self.sequences,
        });
        // Fill the template.
        filled(
            include_str!("web/report.html"),
            json!({
                "title": self.title,
                "version": env!("CARGO_PKG_VERSION"),
                "style": STYLE,
                "sample": of_sample,
                "textons": self.textons,
                "mesh": self.mesh,
                "map": self.map,
                "figures": self.figures,
                "frames": {"sequences": sequences, "notes": self.frame_notes},
                "stages": {"list": self.stages, "notes": self.stage_notes},
                "description": json(&description)?,
                "script": bundle(&MODULES),
            }),
        )
    }
}

/// A sample as the page shows it.
struct ShownSample {
    description: Value,
    packed: String,
    error: f64,
}

impl ShownSample {
    fn new(sample: &Sample, progress: Progress<'_>) -> Result<Self> {
        let limits = Limits {
            error: ERROR,
            bytes: MOST_BYTES,
            texels: MOST_TEXELS * sample.image_count() as u64,
        };
        let factors = view_factors(sample, &limits, progress)?;
        Ok(Self {
            description: sample_description(sample, &factors),
            packed: numbers::base64(&factors.packed),
            error: factors.error,
        })
    }
}
