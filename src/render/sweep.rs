//! A sweep on disk: every frame as OpenEXR with its preview, one after the other, the next being
//! rendered while the last is written.
//!
//! A frame's preview is written before the frame itself, each under a temporary name first, so a
//! frame that is there is whole. Its header carries a hash of all that its pixels depend on, by
//! which a later run knows whether it can keep it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use crate::btf::sample::Sample;
use crate::error::{Error, Result};
use crate::format::exr::{self, Attribute, ExrImage};
use crate::format::id::ContentId;
use crate::format::image;
use crate::format::ours::{Format, check_replaceable};
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::origin::origin_text;
use crate::progress::Progress;
use crate::render::btf_lookup::BtfLookup;
use crate::render::cover::Cover;
use crate::render::fill::Fill;
use crate::render::frame::{Frame, LayerGroup};
use crate::render::front::Front;
use crate::render::light::Origin;
use crate::render::option_values::{Layer, Sweep};
use crate::render::options::{ImageOptions, RenderOptions};
use crate::render::parallax::{Decision, Parallax};
use crate::render::placement;
use crate::render::plan::{PlannedFrame, of_options, plan};
use crate::render::renderer::{RenderSettings, Renderer};
use crate::render::subject::Subject;
use crate::render::texel_table::MemoryBudget;
use crate::render::tone::{Tone, preview};

/// What a sweep is made from and where it goes.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// The sample.
    pub sample: &'a Sample,
    /// The decorated mesh.
    pub map: &'a SurfaceTextonMap,
    /// The id of the map's file.
    pub map_id: &'a ContentId,
    /// A plain colour below the texture, where it is transparent; `map_id` includes it.
    pub cover: Option<&'a Cover>,
    /// The folder of the frames; it exists.
    pub folder: &'a Path,
    /// Whether a map made for another sample of the same size will do.
    pub force: bool,
}

/// A frame's files.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameFile {
    /// The frame's number.
    pub number: u32,
    /// Light and camera in words.
    pub label: String,
    /// The frame.
    pub frame: PathBuf,
    /// Its preview.
    pub preview: PathBuf,
    /// Whether both were there when the run ended, made with the run's options.
    pub is_there: bool,
}

/// What a run did.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Frames made.
    pub rendered: usize,
    /// Frames kept from an earlier run.
    pub kept: usize,
    /// Frames of an earlier run, with other options, that were made again.
    pub replaced: usize,
    /// All frames of the sweep's range, those of other shards too.
    pub files: Vec<FrameFile>,
    /// Bytes of the sample laid out for shading; 0 when no frame was made.
    pub table_bytes: usize,
    /// Whether the table was mapped from disk.
    pub table_mapped: bool,
    /// The side of the mesh that is seen at azimuth 0, where that decides anything.
    pub front: Option<Front>,
    /// Whether views are blended with their parallax, and why; `None` when no frame was made.
    pub parallax: Option<Decision>,
}

/// Options that no pixel depends on.
const IDLE_OPTIONS: [&str; 9] = [
    "frames",
    "sweep-length",
    "sweep",
    "pattern",
    "skip-existing",
    "shard",
    "animation",
    "table-memory",
    "half",
];

/// The attribute that tells frames of other options apart.
const HASH: &str = "mesotex:hash";

/// Renders a sweep into a folder.
pub fn render(inputs: &Inputs, options: &RenderOptions, progress: Progress<'_>) -> Result<Report> {
    let map = inputs.map;
    let (subject, frames) = planned(inputs, options, progress)?;
    placement::check(&map.mesh, &subject.bounds, &frames, progress)
        .map_err(|error| of_options(options, "light", error))?;
    let job = Job {
        inputs,
        options,
        header_options: header_options(options)?,
        heights: heights_id(inputs.sample, options)?,
    };
    let mut report = Report {
        front: shows_front(options, &subject).then_some(subject.front),
        ..Report::default()
    };
    job.refuse_foreign_files(&frames)?;
    let wanted = job.choose(&frames, &mut report);
    job.warn_of_strangers(&frames, progress);
    if !wanted.is_empty() {
        job.run(&wanted, &mut report, progress)?;
    }
    report.files = frames.iter().map(|frame| job.file(frame)).collect();
    Ok(report)
}

/// Whether the front decides anything: it is where azimuths count from, but for a camera whose position is stated; and
/// what is up where a camera looks straight up or down.
fn shows_front(options: &RenderOptions, subject: &Subject<'_>) -> bool {
    let camera = &options.camera;
    let middle = (subject.bounds.centre + subject.origin).to_array();
    let target = camera.camera_target.map_or(middle, |target| target.0);
    camera.camera_position.is_none() || options.has_rows() || camera.looks_along_up(target)
}

/// Prepares a renderer and hands it over with the first frame of the plan; for callers that want
/// pixels or vertex colours in memory. Says too whether views are blended with their parallax.
pub fn with_renderer<R>(
    inputs: &Inputs,
    options: &RenderOptions,
    progress: Progress<'_>,
    work: impl FnOnce(&mut Renderer, &[PlannedFrame]) -> Result<R>,
) -> Result<(R, Decision)> {
    let (_, frames) = planned(inputs, options, progress)?;
    let (lookup, parallax) = lay_out(inputs, options, progress)?;
    let renderer = Renderer::new(inputs.map, &lookup, settings(options), progress)?;
    let mut renderer = renderer.over(inputs.cover);
    Ok((work(&mut renderer, &frames)?, parallax))
}

/// Checks that map, sample and options fit each other, and plans the frames.
fn planned<'a>(
    inputs: &Inputs<'a>,
    options: &RenderOptions,
    progress: Progress<'_>,
) -> Result<(Subject<'a>, Vec<PlannedFrame>)> {
    check_pair(inputs)?;
    check_fill(inputs, options)?;
    let map = inputs.map;
    let subject = Subject::new(&map.mesh, map.header.origin, options)?;
    let frames = plan(options, &subject, progress)?;
    Ok((subject, frames))
}

/// Refuses a map that was made for another sample.
fn check_pair(inputs: &Inputs) -> Result<()> {
    let grid = inputs.sample.grid();
    if inputs.map.header.exemplar != [grid.width, grid.height] {
        let [width, height] = inputs.map.header.exemplar;
        return Err(
            Error::data("map, exemplar", format!("{width} × {height} texels"))
                .expected(format!(
                    "{} × {}, as the sample has",
                    grid.width, grid.height
                ))
                .advice("render a map with the sample it was synthesized from"),
        );
    }
    let wanted = inputs.sample.id();
    crate::format::id::check_same(
        "map, sample id",
        &inputs.map.header.sample,
        wanted,
        inputs.force,
    )
}

/// Refuses fill light for scattered samples: their views have no lights of their own to sum over.
fn check_fill(inputs: &Inputs, options: &RenderOptions) -> Result<()> {
    match inputs.sample.description().pairs.is_some() && options.lights.fill > 0.0 {
        true => Err(Error::option(
            "fill",
            format!("{} for a sample of scattered pairs", options.lights.fill),
            "a sample whose every view has all lights; --environment works with this one",
        )),
        false => Ok(()),
    }
}

fn lay_out(
    inputs: &Inputs,
    options: &RenderOptions,
    progress: Progress<'_>,
) -> Result<(BtfLookup, Decision)> {
    let parallax = Decision::of(
        inputs.sample,
        options.image.parallax,
        options.image.weights,
        progress,
    )?;
    let budget = MemoryBudget {
        bytes: options.files.table_memory.saturating_mul(1 << 20),
        folder: inputs.folder.to_path_buf(),
    };
    let lookup = BtfLookup::new(
        inputs.sample,
        options.image.weights,
        options.image.texels(),
        options.image.uses_mip(),
        options.lights.fill > 0.0,
        &budget,
        progress,
    )?;
    let (views, lights) = lookup.counts();
    if views.min(lights) < 4 {
        progress.warn(format!(
            "the sample has {views} distinct views and {lights} distinct lights; with fewer than 4 \
             of either, frames change little when it moves"
        ));
    }
    let lookup = lookup.with_heights(parallax.heights.as_ref());
    Ok((lookup, parallax))
}

fn settings(options: &RenderOptions) -> RenderSettings {
    let any = |is: fn(&Layer) -> bool| options.files.layers.iter().any(is);
    RenderSettings {
        shading: options.image.shading,
        shadows: options.image.shadows,
        samples: options.image.samples,
        soft_rays: options.lights.shadow_rays,
        fill: (options.lights.fill > 0.0).then(|| Fill {
            radiance: options.lights.fill as f32,
            up: options.camera.up.vector(),
        }),
        ground: options.lights.ground.then(|| options.camera.up.vector()),
        geometry_layers: any(|layer| !matches!(layer, Layer::Rgba | Layer::Shadow | Layer::Weight)),
        extra_layers: any(|layer| matches!(layer, Layer::Shadow | Layer::Weight)),
    }
}

struct Job<'a> {
    inputs: &'a Inputs<'a>,
    options: &'a RenderOptions,
    /// What the frames' headers say of the options.
    header_options: String,
    /// The id of the sample's heights, where views may be blended over them.
    heights: Option<ContentId>,
}

/// A frame on its way to disk.
struct Finished {
    frame: Frame,
    attributes: BTreeMap<String, Attribute>,
    stem: PathBuf,
}

impl Job<'_> {
    /// The frames this run has to make.
    fn choose<'f>(&self, frames: &'f [PlannedFrame], report: &mut Report) -> Vec<&'f PlannedFrame> {
        let mine = |place: usize| {
            self.options
                .files
                .shard
                .is_none_or(|shard| shard.takes(place))
        };
        let mut wanted = Vec::new();
        for (place, frame) in frames.iter().enumerate() {
            if !mine(place) {
                continue;
            }
            if self.options.files.skip_existing {
                let file = self.file(frame);
                if file.is_there {
                    report.kept += 1;
                    continue;
                }
                report.replaced += usize::from(file.frame.exists());
            }
            wanted.push(frame);
        }
        wanted
    }

    fn file(&self, frame: &PlannedFrame) -> FrameFile {
        let stem = self.stem(frame);
        let (file, preview) = (with_ending(&stem, "exr"), with_ending(&stem, "png"));
        let hash = exr::read_text_attribute(&file, HASH);
        FrameFile {
            number: frame.number,
            label: frame.label.clone(),
            is_there: hash == Some(self.hash(frame)) && preview.is_file(),
            frame: file,
            preview,
        }
    }

    fn stem(&self, frame: &PlannedFrame) -> PathBuf {
        self.inputs
            .folder
            .join(self.options.files.pattern.stem(frame.number))
    }

    /// Refuses to write over files under the frames' names that are not of this program.
    fn refuse_foreign_files(&self, frames: &[PlannedFrame]) -> Result<()> {
        for stem in frames.iter().map(|frame| self.stem(frame)) {
            for (ending, format) in [("exr", Format::Frame), ("png", Format::Picture)] {
                check_replaceable(&with_ending(&stem, ending), format)?;
            }
        }
        Ok(())
    }

    /// Says so when the folder holds frames that this sweep will not replace.
    fn warn_of_strangers(&self, frames: &[PlannedFrame], progress: Progress<'_>) {
        let planned: std::collections::HashSet<PathBuf> = frames
            .iter()
            .map(|frame| with_ending(&self.stem(frame), "exr"))
            .collect();
        let entries = std::fs::read_dir(self.inputs.folder)
            .into_iter()
            .flatten()
            .flatten();
        let strangers = entries
            .map(|entry| entry.path())
            .filter(|path| path.extension().is_some_and(|ending| ending == "exr"))
            .filter(|path| !planned.contains(path))
            .count();
        if strangers > 0 {
            progress.warn(format!(
                "{} holds {strangers} frames that are not of this sweep; they stay as they are",
                self.inputs.folder.display()
            ));
        }
    }

    fn run(
        &self,
        wanted: &[&PlannedFrame],
        report: &mut Report,
        progress: Progress<'_>,
    ) -> Result<()> {
        // Lay out the sample, and prepare the surface.
        let (lookup, parallax) = lay_out(self.inputs, self.options, progress)?;
        report.parallax = Some(parallax);
        report.table_bytes = lookup.table.bytes();
        report.table_mapped = lookup.table.is_mapped();
        progress.begin("preparing the surface", 0);
        let renderer = Renderer::new(self.inputs.map, &lookup, settings(self.options), progress)?;
        let mut renderer = renderer.over(self.inputs.cover);
        progress.end();
        // Render each frame while the one before is written.
        progress.begin("frames", wanted.len() as u64);
        let mut waiting: Option<Finished> = None;
        for frame in wanted {
            let last = waiting.take();
            let (written, made) = rayon::join(
                || last.as_ref().map_or(Ok(()), |last| self.write(last)),
                || renderer.frame(&frame.view, &frame.lights),
            );
            written?;
            let made = made?;
            if last.is_some() {
                report.rendered += 1;
                progress.advance(1)?;
            }
            warn_if_dark(&made, frame, progress);
            waiting = Some(Finished {
                frame: made,
                attributes: self.attributes(frame),
                stem: self.stem(frame),
            });
        }
        // Write the last.
        if let Some(last) = waiting {
            self.write(&last)?;
            report.rendered += 1;
            progress.advance(1)?;
        }
        progress.end();
        Ok(())
    }

    fn write(&self, finished: &Finished) -> Result<()> {
        let Finished {
            frame,
            attributes,
            stem,
        } = finished;
        let tone = Tone {
            exposure: self.options.files.exposure,
            curve: self.options.files.tone,
            background: self.options.files.background,
        };
        let [width, height] = frame.size;
        let pixels = preview(&frame.rgba, tone);
        image::write_png(&with_ending(stem, "png"), width, height, &pixels)?;
        let groups: Vec<LayerGroup> = self
            .options
            .files
            .layers
            .iter()
            .map(|layer| group(*layer))
            .collect();
        let picture = ExrImage {
            size: frame.size,
            channels: frame.channels(&groups, self.options.files.float),
            attributes: attributes.clone(),
        };
        let path = with_ending(stem, "exr");
        let encoded = exr::encode(&picture, self.options.files.compression)
            .map_err(|error| error.in_file(&path))?;
        exr::write(&path, &encoded)
    }

    fn attributes(&self, frame: &PlannedFrame) -> BTreeMap<String, Attribute> {
        // Name what every frame has.
        let text = |value: String| Attribute::Text(value);
        let mut attributes = BTreeMap::from([
            (
                "worldToCamera".into(),
                Attribute::Matrix(frame.view.world_to_camera()),
            ),
            (
                "worldToNDC".into(),
                Attribute::Matrix(frame.view.world_to_ndc()),
            ),
            ("colorInteropID".into(), text("lin_rec709_scene".into())),
            ("frame".into(), Attribute::Int(frame.number as i32)),
            (
                "mesotex:sample".into(),
                text(self.inputs.sample.id().to_string()),
            ),
            ("mesotex:map".into(), text(self.inputs.map_id.to_string())),
            ("mesotex:options".into(), text(self.header_options.clone())),
            (
                "mesotex:seed".into(),
                text(self.inputs.map.header.seed.to_string()),
            ),
            (HASH.into(), text(self.hash(frame))),
        ]);
        // Name what some have.
        if let Some(heights) = &self.heights {
            attributes.insert("mesotex:heights".into(), text(heights.to_string()));
        }
        if let Some(key) = frame.lights.first() {
            let (name, vector) = match key.origin {
                Origin::Directional { towards } => ("lightDirection", towards),
                Origin::Point { position, .. } => ("lightPosition", position),
            };
            attributes.insert(name.into(), Attribute::Vector(vector.as_vec3().to_array()));
            attributes.insert("lightIrradiance".into(), Attribute::Float(key.luminance()));
        }
        if let Some(origin) = origin_text(self.inputs.map.header.origin) {
            attributes.insert("mesotex:origin".into(), text(origin));
        }
        if frame.lights.len() > 1 {
            attributes.insert(
                "mesotex:lights".into(),
                text(lights_as_json(frame).to_string()),
            );
        }
        attributes
    }

    /// All that a frame's pixels depend on.
    fn hash(&self, frame: &PlannedFrame) -> String {
        let mut hasher = blake3::Hasher::new();
        let parts = [
            env!("CARGO_PKG_VERSION").to_string(),
            self.header_options.clone(),
            self.inputs.sample.id().to_string(),
            self.inputs.map_id.to_string(),
            // Debug prints every number so that it reads back exactly.
            format!("{} {:?} {:?}", frame.number, frame.view, frame.lights),
        ];
        let heights = self.heights.iter().map(ToString::to_string);
        for part in parts.into_iter().chain(heights) {
            hasher.update(part.as_bytes());
            hasher.update(&[0]);
        }
        ContentId::of_hash(&hasher.finalize()).to_string()
    }
}

/// The id of a sample's heights, where frames may depend on them.
fn heights_id(sample: &Sample, options: &RenderOptions) -> Result<Option<ContentId>> {
    if options.image.parallax == Parallax::Off {
        return Ok(None);
    }
    let heights = sample.heights()?;
    Ok(heights.map(|map| ContentId::of_bytes(bytemuck::cast_slice(map.heights()))))
}

/// The options that pixels depend on, as JSON; files by the id of their content.
fn header_options(options: &RenderOptions) -> Result<String> {
    // What follows from other options stands as it was decided.
    let decided = RenderOptions {
        image: ImageOptions {
            texels: Some(options.image.texels()),
            ..options.image.clone()
        },
        ..options.clone()
    };
    let value =
        serde_json::to_value(decided).map_err(|error| Error::data("options", error.to_string()))?;
    let Value::Object(mut fields) = value else {
        return Err(Error::data("options", "no table of options"));
    };
    for idle in IDLE_OPTIONS {
        fields.remove(idle);
    }
    let sweep = match &options.sweep.kind {
        Sweep::File(path) => format!("csv {}", ContentId::of_file(path)?),
        named => named.to_string(),
    };
    fields.insert("sweep".into(), sweep.into());
    let files = [
        ("camera-path", &options.camera.camera_path),
        ("environment", &options.lights.environment),
    ];
    for (field, path) in files {
        if let Some(path) = path {
            fields.insert(field.into(), ContentId::of_file(path)?.to_string().into());
        }
    }
    Ok(Value::Object(sorted(fields)).to_string())
}

fn sorted(fields: Map<String, Value>) -> Map<String, Value> {
    let mut entries: Vec<_> = fields.into_iter().collect();
    entries.sort_by(|a, b| a.0.cmp(&b.0));
    entries.into_iter().collect()
}

fn lights_as_json(frame: &PlannedFrame) -> Value {
    let light = |light: &crate::render::light::Light| match light.origin {
        Origin::Directional { towards } => {
            json!({"direction": towards.to_array(), "irradiance": light.irradiance})
        }
        Origin::Point { position, .. } => {
            json!({"position": position.to_array(), "irradiance": light.irradiance})
        }
    };
    frame.lights.iter().map(light).collect()
}

fn group(layer: Layer) -> LayerGroup {
    match layer {
        Layer::Rgba => LayerGroup::Rgba,
        Layer::Depth => LayerGroup::Depth,
        Layer::Normal => LayerGroup::Normals,
        Layer::Uv => LayerGroup::Uv,
        Layer::Texton => LayerGroup::Texton,
        Layer::Shadow => LayerGroup::Shadow,
        Layer::Weight => LayerGroup::Weight,
    }
}

/// A path with an ending added; the frame's number is not taken for one.
fn with_ending(stem: &Path, ending: &str) -> PathBuf {
    let mut name = stem.as_os_str().to_os_string();
    name.push(".");
    name.push(ending);
    name.into()
}

/// Says so when nothing of a frame is seen or lit.
fn warn_if_dark(frame: &Frame, planned: &PlannedFrame, progress: Progress<'_>) {
    let mut covered = frame.rgba.iter().filter(|pixel| pixel[3] > 0.0).peekable();
    let number = planned.number;
    if covered.peek().is_none() {
        progress.warn(format!(
            "frame {number} shows nothing: the camera does not see the mesh"
        ));
    } else if covered.all(|pixel| pixel[..3] == [0.0; 3]) {
        progress.warn(format!(
            "frame {number} is black: the lights lie below the horizon of all that is seen, or are hidden"
        ));
    }
}
