//! What every map says of how it was made, and the comment lines of a PLY that say so.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::ours::MESH_MARK;
use crate::format::polygon_mesh::{FARTHEST, parse_origin};
use crate::mesh::origin::origin_comment;

/// The longest side of a sample, in texels: texels are counted in 32 bits.
pub(super) const LONGEST: u32 = 65535;
/// The method of a map that states none.
const DEFAULT_METHOD: &str = "k-coherence";

/// What a map was made from, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct MapHeader {
    /// Columns and rows of the sample.
    pub exemplar: [u32; 2],
    /// Mesh units that a texel of the sample's finest level covers where the scale is 1.
    pub texel: f64,
    /// What the positions count from, in the coordinates of the mesh's file; zero for a mesh near zero.
    pub origin: DVec3,
    /// The seed it was synthesized with.
    pub seed: u64,
    /// The method it was synthesized by, as `--method` names it.
    pub method: String,
    /// The rounds of polish that ended it.
    pub polish: u32,
    /// The id of the sample.
    pub sample: ContentId,
    /// The id of the space it was synthesized from.
    pub space: ContentId,
}

impl MapHeader {
    /// The lines, those that only some maps have, `more`, among them.
    pub(super) fn comments(&self, more: &[String]) -> Vec<String> {
        let [width, height] = self.exemplar;
        let mut comments = vec![MESH_MARK.into(), format!("exemplar {width} {height}")];
        comments.extend_from_slice(more);
        comments.extend([
            format!("texel {}", self.texel),
            format!("seed {}", self.seed),
            format!("method {}", self.method),
        ]);
        if self.polish > 0 {
            comments.push(format!("polish {}", self.polish));
        }
        comments.extend(origin_comment(self.origin));
        comments.push(format!("sample {}", self.sample));
        comments.push(format!("space {}", self.space));
        comments
    }

    /// Reads the lines and checks them.
    pub(super) fn parse(comments: &[String]) -> Result<Self> {
        // Find the value of a comment.
        let optional = |key: &str| {
            let mut lines = comments.iter();
            lines.find_map(|line| line.strip_prefix(key)?.strip_prefix(' '))
        };
        let word = |key: &str| -> Result<&str> {
            optional(key).ok_or_else(|| {
                Error::data("header", format!("no line `comment {key} …`"))
                    .expected("a surface texton map made by `mesotex synth`")
            })
        };
        // Check the version and the sizes.
        let version = word("mesotex")?;
        if version != "1" {
            return Err(bad_comment("mesotex", version, "1"));
        }
        let sides = word("exemplar")?;
        let numbers: Vec<u32> = sides
            .split(' ')
            .filter_map(|side| side.parse().ok())
            .collect();
        let exemplar = match numbers[..] {
            [width, height]
                if (1..=LONGEST).contains(&width) && (1..=LONGEST).contains(&height) =>
            {
                [width, height]
            }
            _ => return Err(bad_comment("exemplar", sides, "two sides, 1 to 65535")),
        };
        let texel: f64 = parse_comment("texel", word("texel")?, "a number above 0")?;
        if !(1.0 / FARTHEST..=FARTHEST).contains(&texel) {
            return Err(bad_comment(
                "texel",
                word("texel")?,
                "a number from 1e-15 to 1e15",
            ));
        }
        // Read the rest.
        let id = |key| -> Result<ContentId> {
            let text = word(key)?;
            ContentId::parse(text).ok_or_else(|| bad_comment(key, text, "32 hex digits"))
        };
        Ok(Self {
            exemplar,
            texel,
            origin: match optional("origin") {
                Some(text) => DVec3::from_array(parse_origin(text)?),
                None => DVec3::ZERO,
            },
            seed: parse_comment("seed", word("seed")?, "a whole number")?,
            method: method_of(comments)?,
            polish: match optional("polish") {
                Some(text) => parse_comment("polish", text, "a whole number")?,
                None => 0,
            },
            sample: id("sample")?,
            space: id("space")?,
        })
    }
}

/// The method's name; maps of earlier versions state none.
fn method_of(comments: &[String]) -> Result<String> {
    let stated = comments
        .iter()
        .find_map(|line| line.strip_prefix("method "));
    let Some(name) = stated else {
        return Ok(DEFAULT_METHOD.into());
    };
    match is_method_name(name) {
        true => Ok(name.into()),
        false => Err(bad_comment(
            "method",
            name,
            "a name of small letters and hyphens",
        )),
    }
}

/// Whether a text can be the name of a method: up to 64 small letters, digits and hyphens.
pub(super) fn is_method_name(name: &str) -> bool {
    let is_sign = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    (1..=64).contains(&name.len()) && name.chars().all(is_sign)
}

fn parse_comment<T: std::str::FromStr>(key: &str, text: &str, expected: &str) -> Result<T> {
    text.parse().map_err(|_| bad_comment(key, text, expected))
}

/// A line that says what it cannot say.
pub(super) fn bad_comment(key: &str, found: &str, expected: &str) -> Error {
    Error::data(format!("comment {key}"), format!("`{found}`")).expected(expected)
}
