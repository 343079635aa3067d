//! From options to frames: which camera and which lights each frame has.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::format::image::FloatImage;
use crate::progress::Progress;
use crate::render::azimuth::AzimuthFrame;
use crate::render::camera::View;
use crate::render::camera_plan::CameraPlan;
use crate::render::environment;
use crate::render::frame_range::FrameRange;
use crate::render::light::{Light, Origin};
use crate::render::option_values::{LightSpec, Sweep};
use crate::render::options::RenderOptions;
use crate::render::path_file::{self, Row};
use crate::render::subject::Subject;

/// One frame to make.
#[derive(Clone, Debug)]
pub struct PlannedFrame {
    /// Its number, from 1.
    pub number: u32,
    /// Camera and image.
    pub view: View,
    /// All lights; the first is the key light.
    pub lights: Vec<Light>,
    /// Camera and key light in words, for labels under pictures.
    pub label: String,
}

/// Frames of a sweep when nothing says how many.
const DEFAULT_SWEEP: u32 = 24;

/// The numbers of the frames that a sweep has.
pub fn frame_range(options: &RenderOptions) -> Result<FrameRange> {
    Ok(range_of(options, read_rows(options)?.len() as u32))
}

fn range_of(options: &RenderOptions, rows: u32) -> FrameRange {
    options.sweep.frames.unwrap_or_else(|| {
        FrameRange::count(match (&options.sweep.kind, rows) {
            (Sweep::None, 0) => 1,
            (_, 0) => options.sweep.sweep_length.unwrap_or(DEFAULT_SWEEP),
            (_, rows) => rows,
        })
    })
}

/// Works out the frames of a sweep round a mesh.
///
/// Positions that options and files name are in the coordinates of the mesh's file. Frames count from the
/// subject's origin, as the map does. `progress` receives warnings about the
/// environment image.
pub fn plan(
    options: &RenderOptions,
    subject: &Subject<'_>,
    progress: Progress<'_>,
) -> Result<Vec<PlannedFrame>> {
    options.validate()?;
    let rows = read_rows(options)?;
    let planner = Planner::new(options, subject, &rows, progress)?;
    let range = range_of(options, rows.len() as u32);
    let length = planner.length(range)?;
    options
        .files
        .pattern
        .check(range.numbers().count(), range.last())?;
    let first = planner.moment(1, length, None)?;
    let towards = first.view.camera.position - first.view.camera.target;
    let azimuths = planner.cameras.azimuths().turned_towards(towards);
    range
        .numbers()
        .map(|number| {
            let moment = planner.moment(number, length, Some(&azimuths))?;
            Ok(PlannedFrame {
                number,
                label: planner.label(&moment, &azimuths),
                view: moment.view,
                lights: moment.lights,
            })
        })
        .collect()
}

struct Planner<'a> {
    options: &'a RenderOptions,
    subject: &'a Subject<'a>,
    rows: &'a [Row],
    cameras: CameraPlan<'a>,
    environment: Option<FloatImage>,
}

struct Moment {
    view: View,
    lights: Vec<Light>,
}

impl<'a> Planner<'a> {
    fn new(
        options: &'a RenderOptions,
        subject: &'a Subject<'a>,
        rows: &'a [Row],
        progress: Progress<'_>,
    ) -> Result<Self> {
        let environment = match &options.lights.environment {
            Some(path) => Some(environment::read(path, options, progress)?),
            None => None,
        };
        Ok(Self {
            options,
            subject,
            rows,
            cameras: CameraPlan::new(options, subject, rows),
            environment,
        })
    }

    /// Frames of the whole sweep.
    fn length(&self, range: FrameRange) -> Result<u32> {
        let rows = self.rows.len() as u32;
        if rows > 0 && range.last() > rows {
            return Err(Error::option(
                "frames",
                range.to_string(),
                format!("at most the {rows} rows of the file"),
            ));
        }
        let length = self.options.sweep.sweep_length.unwrap_or(range.last());
        if length < range.last() {
            return Err(Error::option(
                "sweep-length",
                length.to_string(),
                format!("at least the last frame, {}", range.last()),
            ));
        }
        Ok(length)
    }

    /// Camera and lights of a frame; without azimuths, the camera alone counts.
    fn moment(&self, number: u32, length: u32, azimuths: Option<&AzimuthFrame>) -> Result<Moment> {
        let row = self.row(number, length);
        let in_frame = |error: Error| match error {
            Error::Data(mut fault) => {
                fault.place = format!("frame {number}, {}", fault.place);
                Error::Data(fault)
            }
            other => other,
        };
        let camera = self.cameras.camera(&row);
        let view = View::new(camera, self.options.image.size.0)
            .map_err(in_frame)
            .map_err(|error| of_options(self.options, "camera-position", error))?;
        let lights = match azimuths {
            Some(azimuths) => self.lights(&row, azimuths).map_err(in_frame)?,
            None => Vec::new(),
        };
        Ok(Moment { view, lights })
    }

    /// What the sweep says of a frame.
    fn row(&self, number: u32, length: u32) -> Row {
        // Take what the path file says.
        let from_file = self
            .rows
            .get(number as usize - 1)
            .copied()
            .unwrap_or_default();
        let options = self.options;
        // Find the span of the swept angle.
        let (from, to) = match options.sweep.kind {
            Sweep::None | Sweep::File(_) => return from_file,
            Sweep::LightAzimuth => turn(options, options.lights.light_azimuth),
            Sweep::ViewOrbit => turn(options, options.camera.camera_azimuth),
            Sweep::LightElevation => span(options, 0.0, 180.0),
            Sweep::LightSpiral => span(options, 90.0, 10.0),
        };
        // Go an equal part of it per frame; a closed turn does not repeat its first.
        let is_loop = (to - from).rem_euclid(360.0) == 0.0;
        let steps = if is_loop { length } else { (length - 1).max(1) };
        let fraction = f64::from(number - 1) / f64::from(steps);
        let angle = from + (to - from) * fraction;
        // Set what is swept.
        let mut swept = Row::default();
        match options.sweep.kind {
            Sweep::LightAzimuth => swept.light_azimuth = Some(angle),
            Sweep::LightElevation => swept.light_elevation = Some(angle),
            Sweep::ViewOrbit => swept.camera_azimuth = Some(angle),
            _ => {
                let turned = 360.0 * options.sweep.turns * fraction;
                swept.light_azimuth = Some(options.lights.light_azimuth + turned);
                swept.light_elevation = Some(angle);
            }
        }
        from_file.overlaid(swept)
    }

    fn lights(&self, row: &Row, azimuths: &AzimuthFrame) -> Result<Vec<Light>> {
        let options = self.options;
        let mut specs = options.lights.light.clone();
        if specs.is_empty() && (self.environment.is_none() || row.light.is_some()) {
            specs.push(LightSpec::Sun {
                azimuth: options.lights.light_azimuth,
                elevation: options.lights.light_elevation,
                irradiance: None,
            });
        }
        if let Some(key) = specs.first_mut() {
            move_key_light(key, row);
        }
        let mut lights: Vec<Light> = specs
            .iter()
            .map(|spec| self.light(spec, azimuths))
            .collect::<Result<_>>()?;
        if let Some(image) = &self.environment {
            lights.extend(self.environment_lights(image, row, azimuths, lights.is_empty())?);
        }
        Ok(lights)
    }

    fn light(&self, spec: &LightSpec, azimuths: &AzimuthFrame) -> Result<Light> {
        // Place the light.
        let (origin, irradiance) = match *spec {
            LightSpec::Sun {
                azimuth,
                elevation,
                irradiance,
            } => {
                let towards = azimuths.direction(azimuth.to_radians(), elevation.to_radians());
                (Origin::Directional { towards }, irradiance)
            }
            LightSpec::Point {
                position,
                irradiance,
            } => {
                let position = DVec3::from_array(position) - self.subject.origin;
                let reference = self.subject.bounds.centre;
                if (position - reference).length() < 1e-6 * self.subject.bounds.radius {
                    let fault =
                        Error::data("point light", format!("{}", position + self.subject.origin))
                            .expected("a place outside the surface, not the mesh's centre");
                    return Err(of_options(self.options, "light", fault));
                }
                let origin = Origin::Point {
                    position,
                    reference,
                };
                (origin, irradiance)
            }
        };
        Ok(Light {
            origin,
            irradiance: [irradiance.unwrap_or(self.options.lights.irradiance) as f32; 3],
            angular_radius: self.options.lights.light_radius.to_radians(),
        })
    }

    fn environment_lights(
        &self,
        image: &FloatImage,
        row: &Row,
        azimuths: &AzimuthFrame,
        is_alone: bool,
    ) -> Result<Vec<Light>> {
        let options = self.options;
        let mut azimuth = options.lights.environment_azimuth;
        if is_alone {
            if row.light_elevation.is_some() {
                return Err(Error::option(
                    "sweep",
                    format!("{} with an environment alone", options.sweep.kind),
                    "light-azimuth, which turns the environment, or a --light to move",
                ));
            }
            azimuth += row
                .light_azimuth
                .map_or(0.0, |to| to - options.lights.light_azimuth);
        }
        let count = options.lights.environment_lights as usize;
        let scale = options.lights.environment_scale;
        let mut lights = environment::lights(image, azimuths, count, scale, azimuth.to_radians())?;
        for light in &mut lights {
            light.angular_radius = options.lights.light_radius.to_radians();
        }
        Ok(lights)
    }

    /// Camera and key light of a moment, in whole tenths of degrees.
    fn label(&self, moment: &Moment, azimuths: &AzimuthFrame) -> String {
        let camera = &moment.view.camera;
        let (azimuth, elevation) = azimuths.angles(camera.position - camera.target);
        let view = format!("view {}° {}°", degrees(azimuth), degrees(elevation));
        let Some(key) = moment.lights.first() else {
            return view;
        };
        let towards = match key.origin {
            Origin::Directional { towards } => towards,
            Origin::Point { position, .. } => position - self.subject.bounds.centre,
        };
        let (azimuth, elevation) = azimuths.angles(towards);
        format!(
            "light {}° {}°  {view}",
            degrees(azimuth),
            degrees(elevation)
        )
    }
}

fn degrees(radians: f64) -> String {
    let tenths = (radians.to_degrees() * 10.0).round() / 10.0;
    // No "-0" and no full turn.
    format!("{}", if tenths == 360.0 { 0.0 } else { tenths + 0.0 })
}

fn read_rows(options: &RenderOptions) -> Result<Vec<Row>> {
    let sweep = match &options.sweep.kind {
        Sweep::File(path) => path_file::read(path)?,
        _ => Vec::new(),
    };
    let Some(path) = &options.camera.camera_path else {
        return Ok(sweep);
    };
    let cameras = path_file::read(path)?;
    if sweep.is_empty() {
        return Ok(cameras);
    }
    if sweep.len() != cameras.len() {
        return Err(Error::data("rows", cameras.len().to_string())
            .expected(format!("{}, as the sweep's file has", sweep.len()))
            .in_file(path));
    }
    Ok(sweep
        .iter()
        .zip(cameras)
        .map(|(row, camera)| row.overlaid(camera))
        .collect())
}

/// From where to where an angle that goes round runs.
fn turn(options: &RenderOptions, start: f64) -> (f64, f64) {
    let from = options.sweep.sweep_from.unwrap_or(start);
    (from, options.sweep.sweep_to.unwrap_or(from + 360.0))
}

fn span(options: &RenderOptions, from: f64, to: f64) -> (f64, f64) {
    (
        options.sweep.sweep_from.unwrap_or(from),
        options.sweep.sweep_to.unwrap_or(to),
    )
}

/// A fault of a camera or a light is the option's where no file of rows moves them.
pub(super) fn of_options(options: &RenderOptions, option: &str, error: Error) -> Error {
    let from_file =
        matches!(options.sweep.kind, Sweep::File(_)) || options.camera.camera_path.is_some();
    match error {
        Error::Data(fault) if !from_file => Error::option(
            option,
            format!("{}: {}", fault.place, fault.found),
            fault.expected,
        ),
        other => other,
    }
}

fn move_key_light(key: &mut LightSpec, row: &Row) {
    if let Some(to) = row.light {
        let (LightSpec::Sun { irradiance, .. } | LightSpec::Point { irradiance, .. }) = *key;
        *key = LightSpec::Point {
            position: to,
            irradiance,
        };
    }
    if let LightSpec::Sun {
        azimuth, elevation, ..
    } = key
    {
        *azimuth = row.light_azimuth.unwrap_or(*azimuth);
        *elevation = row.light_elevation.unwrap_or(*elevation);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::triangle_mesh::TriangleMesh;
    use crate::render::option_values::Point;
    use crate::render::options::{CameraOptions, LightOptions, SweepOptions};

    /// The plan for an octahedron of radius 1.
    fn planned(options: &RenderOptions) -> Result<Vec<PlannedFrame>> {
        let corners = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis.as_vec3());
        let [x, y, z] = corners;
        let mesh = TriangleMesh {
            positions: vec![x, -x, y, -y, z, -z],
            triangles: (0..8)
                .map(|k| [k & 1, 2 + (k >> 1 & 1), 4 + (k >> 2)])
                .collect(),
        };
        let subject = Subject::new(&mesh, DVec3::ZERO, options)?;
        plan(options, &subject, Progress::silent())
    }

    fn towards(frame: &PlannedFrame) -> DVec3 {
        match frame.lights[0].origin {
            Origin::Directional { towards } => towards,
            Origin::Point { position, .. } => position.normalize(),
        }
    }

    #[test]
    fn azimuth_sweeps_start_at_the_camera_and_turn_counter_clockwise() {
        let options = RenderOptions {
            sweep: SweepOptions {
                kind: Sweep::LightAzimuth,
                frames: Some(FrameRange::count(4)),
                ..SweepOptions::default()
            },
            lights: LightOptions {
                light_azimuth: 0.0,
                light_elevation: 0.0,
                ..LightOptions::default()
            },
            camera: CameraOptions {
                camera_azimuth: 90.0,
                ..CameraOptions::default()
            },
            ..RenderOptions::default()
        };
        let frames = planned(&options).unwrap();
        // The camera stands at +x; seen from above, counter-clockwise from +x comes −z.
        for (frame, wanted) in frames
            .iter()
            .zip([DVec3::X, -DVec3::Z, -DVec3::X, DVec3::Z])
        {
            assert!(
                (towards(frame) - wanted).length() < 1e-12,
                "{}",
                frame.number
            );
        }
    }

    #[test]
    fn a_part_of_a_sweep_is_the_sweep_there() {
        let whole = RenderOptions {
            sweep: SweepOptions {
                kind: Sweep::LightSpiral,
                frames: Some(FrameRange::count(12)),
                ..SweepOptions::default()
            },
            ..RenderOptions::default()
        };
        let part = RenderOptions {
            sweep: SweepOptions {
                frames: Some("3-12x4".parse().unwrap()),
                ..whole.sweep.clone()
            },
            ..whole.clone()
        };
        let (whole, part) = (planned(&whole).unwrap(), planned(&part).unwrap());
        assert_eq!(part.len(), 3);
        for frame in &part {
            let same = &whole[frame.number as usize - 1];
            assert_eq!(same.lights, frame.lights);
        }
    }

    #[test]
    fn elevations_rise_and_set() {
        let options = RenderOptions {
            sweep: SweepOptions {
                kind: Sweep::LightElevation,
                frames: Some(FrameRange::count(3)),
                ..SweepOptions::default()
            },
            lights: LightOptions {
                light_azimuth: 0.0,
                ..LightOptions::default()
            },
            ..RenderOptions::default()
        };
        let frames = planned(&options).unwrap();
        for (frame, wanted) in frames.iter().zip([DVec3::Z, DVec3::Y, -DVec3::Z]) {
            assert!((towards(frame) - wanted).length() < 1e-12);
        }
    }

    #[test]
    fn orbits_carry_a_given_camera_round_its_target() {
        let options = RenderOptions {
            sweep: SweepOptions {
                kind: Sweep::ViewOrbit,
                frames: Some(FrameRange::count(4)),
                ..SweepOptions::default()
            },
            camera: CameraOptions {
                camera_position: Some(Point([0.0, 1.0, 3.0])),
                ..CameraOptions::default()
            },
            ..RenderOptions::default()
        };
        let frames = planned(&options).unwrap();
        let wanted = [
            [0.0, 1.0, 3.0],
            [3.0, 1.0, 0.0],
            [0.0, 1.0, -3.0],
            [-3.0, 1.0, 0.0],
        ];
        for (frame, wanted) in frames.iter().zip(wanted) {
            let position = frame.view.camera.position;
            assert!(
                (position - DVec3::from_array(wanted)).length() < 1e-9,
                "{position}"
            );
            // The light stands still.
            assert_eq!(frame.lights, frames[0].lights);
        }
    }

    #[test]
    fn impossible_plans_are_refused() {
        let refused = |options: RenderOptions| planned(&options).unwrap_err().to_string();
        let short = RenderOptions {
            sweep: SweepOptions {
                kind: Sweep::ViewOrbit,
                frames: Some("5-9".parse().unwrap()),
                sweep_length: Some(6),
                ..SweepOptions::default()
            },
            ..RenderOptions::default()
        };
        assert!(refused(short).contains("--sweep-length"));
        let many = RenderOptions {
            sweep: SweepOptions {
                frames: Some(FrameRange::count(20_000)),
                ..SweepOptions::default()
            },
            ..RenderOptions::default()
        };
        assert!(refused(many).contains("--pattern"));
        let inside = RenderOptions {
            lights: LightOptions {
                light: vec!["point:0,0,0".parse().unwrap()],
                ..LightOptions::default()
            },
            ..RenderOptions::default()
        };
        let error = refused(inside);
        assert!(
            error.starts_with("--light") && error.contains("point light"),
            "{error}"
        );
    }
}
