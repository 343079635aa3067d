//! Named sets of directions: what `--views` and `--lights` take, to what a sample stores.
//!
//! `12x5` is the grid of Tong 2002 §4 (azimuths × polar angles); `bonn81` and `bonn151` are the
//! rings of the Bonn gonioreflectometer (Sattler 2003) and of the UBO2014 dome; `fibonacci:N`
//! spreads N directions evenly in cos θ; `rings:…` and `FILE.csv` are the user's own.

use std::f64::consts::PI;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::btf::direction::{Direction, SAME_DIRECTION};
use crate::btf::import::light_positions;
use crate::btf::table::{Row, Table};
use crate::error::{Error, Result};
use crate::format::guard::guarded;
use crate::format::text;

/// The most directions a set may have.
const MOST: usize = 100_000;
/// The largest file of directions read, in bytes.
const LARGEST_FILE: u64 = 16 << 20;

/// Directions at one polar angle, equally spaced in azimuth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Polar angle in degrees, 0 to 90.
    pub theta_deg: f64,
    /// How many directions.
    pub count: usize,
    /// Azimuth of the first, in degrees.
    pub offset_deg: f64,
}

const fn ring(theta_deg: f64, count: usize, offset_deg: f64) -> Ring {
    Ring {
        theta_deg,
        count,
        offset_deg,
    }
}

/// θ outer, φ inner.
const TONG_12X5: [Ring; 5] = [
    ring(15.0, 12, 0.0),
    ring(30.0, 12, 0.0),
    ring(45.0, 12, 0.0),
    ring(60.0, 12, 0.0),
    ring(75.0, 12, 0.0),
];

const BONN_81: [Ring; 6] = [
    ring(0.0, 1, 0.0),
    ring(15.0, 6, 0.0),
    ring(30.0, 12, 0.0),
    ring(45.0, 18, 0.0),
    ring(60.0, 20, 0.0),
    ring(75.0, 24, 0.0),
];

const BONN_151: [Ring; 10] = [
    ring(0.0, 1, 0.0),
    ring(11.0, 6, 15.0),
    ring(23.5, 12, 0.0),
    ring(30.0, 12, 15.0),
    ring(37.5, 12, 0.0),
    ring(45.0, 18, 0.0),
    ring(52.5, 18, 7.5),
    ring(60.0, 24, 0.0),
    ring(67.5, 24, 7.5),
    ring(75.0, 24, 0.0),
];

/// A set of directions, by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum DirectionSet {
    /// `12x5`: θ = 15, 30 … 75° outer, φ = 0, 30 … 330° inner (Tong 2002 §4).
    #[default]
    Tong12x5,
    /// `bonn81`: the 81 directions of the Bonn gonioreflectometer.
    Bonn81,
    /// `bonn151`: the 151 directions of the UBO2014 dome.
    Bonn151,
    /// `fibonacci:N`: cos θ = 1 − (i + ½)/N, φ = i·π(3 − √5).
    Fibonacci(usize),
    /// `rings:θ:count[:offset],…`, angles in degrees.
    Rings(Vec<Ring>),
    /// `FILE.csv` with columns theta_deg and phi_deg, or the lights of a capture, `FILE.lp`.
    File(PathBuf),
}

impl DirectionSet {
    /// What `--views` and `--lights` take, for help texts and errors.
    pub const FORMS: &'static str =
        "12x5, bonn81, bonn151, fibonacci:N, rings:THETA:COUNT[:OFFSET],…, FILE.csv or FILE.lp";

    /// The file of a set that is the user's own.
    pub fn file(&self) -> Option<&PathBuf> {
        match self {
            Self::File(path) => Some(path),
            _ => None,
        }
    }

    /// The directions, in the set's order; reads the file of [`Self::File`].
    pub fn directions(&self) -> Result<Vec<Direction>> {
        Ok(match self {
            Self::Tong12x5 => on_rings(&TONG_12X5),
            Self::Bonn81 => on_rings(&BONN_81),
            Self::Bonn151 => on_rings(&BONN_151),
            Self::Fibonacci(count) => (0..*count).map(|i| fibonacci(i, *count)).collect(),
            Self::Rings(rings) => on_rings(rings),
            Self::File(path) => read_file(path)?,
        })
    }
}

/// The first direction that repeats an earlier one (closer than [`SAME_DIRECTION`]).
pub fn first_repeated(directions: &[Direction]) -> Option<usize> {
    (1..directions.len()).find(|&later| {
        directions[..later]
            .iter()
            .any(|earlier| earlier.angle_to(directions[later]) < SAME_DIRECTION)
    })
}

fn on_rings(rings: &[Ring]) -> Vec<Direction> {
    let on_ring = |ring: &Ring| {
        let ring = *ring;
        (0..ring.count).map(move |index| {
            let phi_deg = ring.offset_deg + 360.0 * index as f64 / ring.count as f64;
            from_degrees(ring.theta_deg, phi_deg)
        })
    };
    rings.iter().flat_map(on_ring).collect()
}

fn from_degrees(theta_deg: f64, phi_deg: f64) -> Direction {
    Direction::from_angles(theta_deg.to_radians(), phi_deg.to_radians())
}

/// A spherical Fibonacci lattice on the upper hemisphere, even in solid angle.
fn fibonacci(index: usize, count: usize) -> Direction {
    let cos = 1.0 - (index as f64 + 0.5) / count as f64;
    let phi = index as f64 * PI * (3.0 - 5.0_f64.sqrt());
    Direction::from_angles(cos.acos(), phi)
}

fn read_file(path: &Path) -> Result<Vec<Direction>> {
    guarded(path, || {
        let text = text::read(path, LARGEST_FILE)?.text;
        let is_capture = path
            .extension()
            .is_some_and(|end| end.eq_ignore_ascii_case("lp"));
        match is_capture {
            true => light_positions::directions(&text),
            false => parse_csv(&text),
        }
    })
}

/// The directions of a table with the columns theta_deg and phi_deg, among others.
fn parse_csv(text: &str) -> Result<Vec<Direction>> {
    let table = Table::parse(text)?;
    let [theta, phi] = table.find_all([&["theta_deg"], &["phi_deg"]])?;
    let read = |row: &Row| {
        let theta_deg = table.number(row, theta)?;
        check_theta(theta_deg).map_err(|expected| {
            let place = format!("line {}: theta_deg", row.line);
            Error::data(place, theta_deg.to_string()).expected(expected)
        })?;
        Ok(from_degrees(theta_deg, table.number(row, phi)?))
    };
    let directions: Vec<Direction> = table.rows.iter().map(read).collect::<Result<_>>()?;
    match directions.len() {
        0 => Err(Error::data("directions", "none").expected("at least 1 line")),
        1..=MOST => Ok(directions),
        count => Err(Error::data("directions", count.to_string()).expected(format!("≤ {MOST}"))),
    }
}

fn check_theta(theta_deg: f64) -> std::result::Result<(), &'static str> {
    match (0.0..=90.0).contains(&theta_deg) {
        true => Ok(()),
        false => Err("0 to 90 degrees: directions point away from the surface"),
    }
}

impl FromStr for DirectionSet {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "12x5" => return Ok(Self::Tong12x5),
            "bonn81" => return Ok(Self::Bonn81),
            "bonn151" => return Ok(Self::Bonn151),
            _ => {}
        }
        if let Some(count) = text.strip_prefix("fibonacci:") {
            return parse_count(count).map(Self::Fibonacci);
        }
        if let Some(rings) = text.strip_prefix("rings:") {
            return parse_rings(rings).map(Self::Rings);
        }
        let lower = text.to_ascii_lowercase();
        if lower.ends_with(".csv") || lower.ends_with(".lp") {
            return Ok(Self::File(PathBuf::from(text)));
        }
        Err(format!("not a set of directions; expected {}", Self::FORMS))
    }
}

fn parse_count(text: &str) -> std::result::Result<usize, String> {
    text.parse()
        .ok()
        .filter(|count| (1..=MOST).contains(count))
        .ok_or_else(|| format!("`{text}` is not a count of directions; expected 1 to {MOST}"))
}

fn parse_rings(text: &str) -> std::result::Result<Vec<Ring>, String> {
    let rings: std::result::Result<Vec<Ring>, _> = text.split(',').map(parse_ring).collect();
    let rings = rings?;
    match rings.iter().map(|ring| ring.count).sum::<usize>() {
        1..=MOST => Ok(rings),
        count => Err(format!("{count} directions; expected 1 to {MOST}")),
    }
}

fn parse_ring(text: &str) -> std::result::Result<Ring, String> {
    let form = || format!("ring `{text}`: expected THETA:COUNT[:OFFSET], as 45:12 or 45:12:15");
    let fields: Vec<&str> = text.split(':').collect();
    let number = |field: &str| field.parse().ok().filter(|v: &f64| v.is_finite());
    let (theta, count, offset) = match fields[..] {
        [theta, count] => (number(theta), parse_count(count), Some(0.0)),
        [theta, count, offset] => (number(theta), parse_count(count), number(offset)),
        _ => return Err(form()),
    };
    let (Some(theta_deg), Some(offset_deg)) = (theta, offset) else {
        return Err(form());
    };
    check_theta(theta_deg).map_err(|expected| format!("ring `{text}`: expected {expected}"))?;
    Ok(ring(theta_deg, count?, offset_deg))
}

impl fmt::Display for DirectionSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tong12x5 => f.write_str("12x5"),
            Self::Bonn81 => f.write_str("bonn81"),
            Self::Bonn151 => f.write_str("bonn151"),
            Self::Fibonacci(count) => write!(f, "fibonacci:{count}"),
            Self::Rings(rings) => {
                for (index, ring) in rings.iter().enumerate() {
                    f.write_str(if index == 0 { "rings:" } else { "," })?;
                    write!(f, "{}:{}", ring.theta_deg, ring.count)?;
                    if ring.offset_deg != 0.0 {
                        write!(f, ":{}", ring.offset_deg)?;
                    }
                }
                Ok(())
            }
            Self::File(path) => write!(f, "{}", path.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions(text: &str) -> Vec<Direction> {
        text.parse::<DirectionSet>().unwrap().directions().unwrap()
    }

    fn at(direction: Direction) -> (f64, f64) {
        (direction.theta().to_degrees(), direction.phi().to_degrees())
    }

    fn close(found: (f64, f64), wanted: (f64, f64)) -> bool {
        (found.0 - wanted.0).abs() < 1e-9 && (found.1 - wanted.1).abs() < 1e-9
    }

    #[test]
    fn the_named_sets_have_their_sizes_and_order() {
        let tong = directions("12x5");
        assert_eq!(tong.len(), 60);
        assert!(close(at(tong[13]), (30.0, 30.0)));
        let bonn = directions("bonn81");
        assert_eq!(bonn.len(), 81);
        // The file name of the published set puts view 8 at (30°, 30°).
        assert!(close(at(bonn[8]), (30.0, 30.0)));
        assert!(close(at(bonn[80]), (75.0, 345.0)));
        let dome = directions("bonn151");
        assert_eq!(dome.len(), 151);
        assert!(
            (dome[1].0 - glam::DVec3::new(0.184_307_3, 0.049_385, 0.981_627_2)).length() < 1e-6
        );
        assert!(close(at(dome[4]), (11.0, 195.0)));
        for set in [&tong, &bonn, &dome] {
            assert_eq!(first_repeated(set), None);
        }
    }

    #[test]
    fn fibonacci_is_even_in_solid_angle() {
        let set = directions("fibonacci:1000");
        // ∫ cos θ dω over the hemisphere is π; the mean direction has no side.
        let sum: glam::DVec3 = set.iter().map(|d| d.0).sum();
        assert!((sum.z * 2.0 * PI / 1000.0 - PI).abs() < 1e-9);
        assert!(sum.x.abs() < 2.0 && sum.y.abs() < 2.0);
        assert!((set[0].cos_theta() - (1.0 - 0.5 / 1000.0)).abs() < 1e-12);
    }

    #[test]
    fn rings_and_tables_are_the_users_own() {
        let set = directions("rings:0:1,40:4:10");
        assert_eq!(set.len(), 5);
        assert!(close(at(set[2]), (40.0, 100.0)));
        let text = "# mine\nindex,theta_deg , phi_deg\n0, 30, -90\n\n1,0,0\n";
        let table = parse_csv(text).unwrap();
        assert!(close(at(table[0]), (30.0, 270.0)));
        assert_eq!(table.len(), 2);
    }

    #[test]
    fn names_round_trip() {
        for name in [
            "12x5",
            "bonn81",
            "bonn151",
            "fibonacci:7",
            "rings:0:1,40.5:4:10",
            "my set.csv",
            "dome.lp",
        ] {
            let set: DirectionSet = name.parse().unwrap();
            assert_eq!(set.to_string(), name);
            assert_eq!(set.to_string().parse(), Ok(set));
        }
    }

    #[test]
    fn what_is_no_set_is_refused_with_what_would_do() {
        for (text, says) in [
            ("13x5", "bonn151"),
            ("fibonacci:0", "1 to 100000"),
            ("fibonacci:x", "`x`"),
            ("rings:95:4", "0 to 90"),
            ("rings:45", "THETA:COUNT"),
            ("rings:nan:4", "THETA:COUNT"),
            ("", "12x5"),
        ] {
            let error = text.parse::<DirectionSet>().unwrap_err();
            assert!(error.contains(says), "{text}: {error}");
        }
    }

    #[test]
    fn bad_tables_are_refused_by_line() {
        for (text, says) in [
            ("", "names of the columns"),
            ("theta,phi\n1,2\n", "theta_deg, phi_deg"),
            ("theta_deg,phi_deg\n", "none"),
            ("theta_deg,phi_deg\n10,0\n100,0", "line 3: theta_deg: 100"),
            ("theta_deg,phi_deg\n10", "line 2: phi_deg: ``"),
            ("theta_deg,phi_deg\n10,nan", "`nan`"),
        ] {
            let error = parse_csv(text).unwrap_err().to_string();
            assert!(error.contains(says), "{text:?}: {error}");
        }
        let missing = DirectionSet::File("no-such.csv".into());
        assert!(
            missing
                .directions()
                .unwrap_err()
                .to_string()
                .contains("no-such.csv")
        );
    }

    #[test]
    fn repeated_directions_are_found() {
        let mut set = directions("rings:30:3");
        set.push(Direction::from_angles(30.0_f64.to_radians() + 5e-5, 0.0));
        assert_eq!(first_repeated(&set), Some(3));
    }
}
