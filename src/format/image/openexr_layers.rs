//! Which channels of an OpenEXR file are the picture.
//!
//! Channels are grouped by part and by what stands before the last point of their names. A group is colour
//! when it has R, G and B, or Y (with RY and BY: luminance and chroma). Depth, normals, positions, alpha,
//! coverage and ids are never taken for grey. Where several groups are colour, the one without a layer's
//! name is the picture, as viewers have it; else the caller must name one.

use exr::meta::MetaData;
use exr::meta::attribute::SampleType;

use crate::error::{Error, Result};
use crate::format::image::options::{Purpose, ReadOptions, SourceEncoding};

/// Words of layers and channels that hold no colour.
const NO_COLOR: [&str; 31] = [
    "a", "alpha", "ar", "ag", "ab", "z", "zback", "depth", "n", "normal", "normals", "nn", "p",
    "pos", "position", "pref", "point", "uv", "u", "v", "st", "motion", "velocity", "vector", "id",
    "index", "mask", "coverage", "texton", "w", "variance",
];

/// What a group of channels is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// R, G, B.
    Rgb,
    /// Y, RY, BY.
    LuminanceChroma,
    /// Y alone.
    Luminance,
    /// X, Y, Z: directions or places.
    Vector,
    /// R and G, or X and Y: directions without their third number.
    Pair,
    /// One channel of another name.
    Single,
}

/// Channels that belong together.
#[derive(Clone, Debug)]
struct Group {
    part: usize,
    /// What stands before the last point of the channels' names; empty: the layer without a name.
    prefix: String,
    kind: Kind,
    /// Indices into the part's channels, in the order in which they are wanted.
    channels: Vec<usize>,
    alpha: Option<usize>,
    /// Whether it may be taken for colour without being named.
    is_color: bool,
}

/// The channels that are read.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Choice {
    pub(super) part: usize,
    pub(super) kind: Kind,
    pub(super) channels: Vec<usize>,
    pub(super) alpha: Option<usize>,
    /// Whether the caller's name led to it.
    pub(super) was_named: bool,
}

/// A part, as far as layers matter.
#[derive(Clone, Debug)]
struct Part {
    name: String,
    view: String,
    channels: Vec<(String, SampleType)>,
    is_deep: bool,
}

/// All parts and groups of a file.
pub(super) struct Layers {
    parts: Vec<Part>,
    groups: Vec<Group>,
}

impl Layers {
    pub(super) fn of(meta: &MetaData) -> Self {
        let parts: Vec<Part> = meta
            .headers
            .iter()
            .map(|header| {
                let text = |text: &Option<exr::meta::attribute::Text>| {
                    text.as_ref().map(ToString::to_string).unwrap_or_default()
                };
                let channels = header.channels.list.iter();
                Part {
                    name: text(&header.own_attributes.layer_name),
                    view: text(&header.own_attributes.view_name),
                    channels: channels
                        .map(|c| (c.name.to_string(), c.sample_type))
                        .collect(),
                    is_deep: header.deep,
                }
            })
            .collect();
        let flat = parts.iter().enumerate().filter(|(_, part)| !part.is_deep);
        let groups = flat.flat_map(|(index, part)| groups(index, part)).collect();
        Self { parts, groups }
    }

    /// The names of a part's layers.
    pub(super) fn names(&self, part: usize) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for group in self.groups.iter().filter(|group| group.part == part) {
            let name = self.name(group);
            if !name.is_empty() && !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// The channels to read, or an error that lists what there is.
    pub(super) fn choose(&self, options: &ReadOptions) -> Result<Choice> {
        if self.parts.iter().all(|part| part.is_deep) {
            return Err(
                Error::data("OpenEXR", "deep data: lists of samples in place of pixels")
                    .expected("a flat image")
                    .advice("flatten it, as with oiiotool IN.exr --flatten -o OUT.exr"),
            );
        }
        if let Some(name) = &options.layer
            && let Some(choice) = self.named(name, options)?
        {
            return Ok(choice);
        }
        self.found(options)
    }

    /// The group that a caller named. `None` where the file has no layers to name.
    fn named(&self, name: &str, options: &ReadOptions) -> Result<Option<Choice>> {
        let is_meant = |group: &&Group| {
            let part = &self.parts[group.part];
            let names = [&group.prefix, &part.name, &part.view, &self.name(group)];
            group.kind != Kind::Single && names.into_iter().any(|known| known == name)
        };
        let mut meant: Vec<&Group> = self.groups.iter().filter(is_meant).collect();
        if meant.len() > 1 {
            meant.retain(|group| group.is_color || options.purpose == Purpose::Data);
        }
        match meant[..] {
            [only] => return Ok(Some(only.choice(true))),
            [] => {}
            _ => {
                let text = format!("`{name}` is the name of {} layers", meant.len());
                return Err(self.undecided(text, options));
            }
        }
        if let Some(choice) = self.named_channel(name) {
            return Ok(Some(choice));
        }
        let plain = |group: &Group| group.prefix.is_empty();
        match self.parts.len() == 1 && self.groups.iter().all(plain) {
            true => Ok(None),
            false => Err(self.undecided(format!("no layer `{name}`"), options)),
        }
    }

    /// A single channel by its full name, or the only channel of a part or layer of that name.
    fn named_channel(&self, name: &str) -> Option<Choice> {
        let flat = self
            .parts
            .iter()
            .enumerate()
            .filter(|(_, part)| !part.is_deep);
        let mut found = flat.flat_map(|(index, part)| {
            let alone = part.channels.len() == 1 && part.name == name;
            let channels = part.channels.iter().enumerate();
            channels
                .filter(move |(_, (channel, _))| {
                    alone || channel == name || format!("{}/{channel}", part.name) == name
                })
                .map(move |(channel, _)| Choice {
                    part: index,
                    kind: Kind::Single,
                    channels: vec![channel],
                    alpha: None,
                    was_named: true,
                })
        });
        let first = found.next();
        first.filter(|_| found.next().is_none())
    }

    /// The group that is the picture where nobody named one.
    fn found(&self, options: &ReadOptions) -> Result<Choice> {
        let is_candidate = |group: &&Group| match options.purpose {
            Purpose::Color if options.encoding == SourceEncoding::Xyz => {
                group.kind == Kind::Vector || group.is_color && group.kind == Kind::Rgb
            }
            Purpose::Color => group.is_color && !matches!(group.kind, Kind::Single | Kind::Pair),
            Purpose::Data => group.kind != Kind::Single,
        };
        let candidates: Vec<&Group> = self.groups.iter().filter(is_candidate).collect();
        if let [only] = candidates[..] {
            return Ok(only.choice(false));
        }
        let root: Vec<&&Group> = candidates.iter().filter(|g| g.prefix.is_empty()).collect();
        if let ([only], 1) = (&root[..], self.parts.len()) {
            return Ok(only.choice(false));
        }
        if candidates.is_empty()
            && let Some(single) = self.single(options.purpose)
        {
            return Ok(single.choice(false));
        }
        let text = match candidates.len() {
            0 => "no channels that are clearly an image".to_string(),
            several => format!("{several} layers that may be the image"),
        };
        Err(self.undecided(text, options))
    }

    /// The one channel beside alpha.
    fn single(&self, purpose: Purpose) -> Option<&Group> {
        let is_alpha = |group: &Group| {
            let (name, _) = &self.parts[group.part].channels[group.channels[0]];
            matches!(name.as_str(), "A" | "alpha" | "Alpha")
        };
        let mut others = self.groups.iter().filter(|group| !is_alpha(group));
        let first = others.next()?;
        let is_only = others.next().is_none();
        (is_only && (first.is_color || purpose == Purpose::Data)).then_some(first)
    }

    /// What a caller types to get a group.
    fn name(&self, group: &Group) -> String {
        let part = &self.parts[group.part].name;
        match (self.parts.len(), group.prefix.as_str()) {
            (1, prefix) => prefix.to_owned(),
            (_, "") => part.clone(),
            (_, prefix) if prefix == part || part.is_empty() => prefix.to_owned(),
            (_, prefix) => format!("{part}/{prefix}"),
        }
    }

    fn undecided(&self, found: String, options: &ReadOptions) -> Error {
        let parts: Vec<String> = self.parts.iter().enumerate().map(described).collect();
        let names: Vec<String> = (0..self.parts.len()).flat_map(|p| self.names(p)).collect();
        let advice = match (options.flags.layer, names.is_empty()) {
            ("", _) => "save the image as R, G and B of a file of its own".to_string(),
            (flag, true) => format!("name a channel: {flag} NAME"),
            (flag, false) => format!("name a layer or a channel: {flag} {}", names.join(" or ")),
        };
        Error::data("layers", format!("{found} among {}", parts.join("; ")))
            .expected("one layer with R, G and B, or Y")
            .advice(advice)
    }
}

impl Group {
    fn choice(&self, was_named: bool) -> Choice {
        Choice {
            part: self.part,
            kind: self.kind,
            channels: self.channels.clone(),
            alpha: self.alpha,
            was_named,
        }
    }
}

fn described((index, part): (usize, &Part)) -> String {
    let names: Vec<&str> = part
        .channels
        .iter()
        .map(|(name, _)| name.as_str())
        .collect();
    let deep = if part.is_deep { " (deep)" } else { "" };
    match part.name.as_str() {
        "" => format!("part {}{deep}: {}", index + 1, names.join(", ")),
        name => format!("part `{name}`{deep}: {}", names.join(", ")),
    }
}

/// A channel's layer and its name in it.
fn split(name: &str) -> (&str, &str) {
    name.rsplit_once('.').unwrap_or(("", name))
}

/// The groups of a part, in the order of its channels.
fn groups(part_index: usize, part: &Part) -> Vec<Group> {
    let mut prefixes: Vec<&str> = Vec::new();
    for (name, _) in &part.channels {
        if !prefixes.contains(&split(name).0) {
            prefixes.push(split(name).0);
        }
    }
    prefixes
        .into_iter()
        .flat_map(|prefix| groups_of_layer(part_index, part, prefix))
        .collect()
}

fn groups_of_layer(part_index: usize, part: &Part, prefix: &str) -> Vec<Group> {
    // Find the channels of the layer by their names.
    let members: Vec<usize> = (0..part.channels.len())
        .filter(|&index| split(&part.channels[index].0).0 == prefix)
        .collect();
    let find = |names: &[&str]| {
        let is_it = |&&index: &&usize| {
            let base = split(&part.channels[index].0).1;
            names.iter().any(|name| base.eq_ignore_ascii_case(name))
        };
        members.iter().find(is_it).copied()
    };
    // Say whether a group of them is a colour.
    let group = |kind: Kind, channels: Vec<usize>| {
        let floats = channels
            .iter()
            .all(|&c| part.channels[c].1 != SampleType::U32);
        let base = channels
            .first()
            .map_or("", |&c| split(&part.channels[c].0).1);
        let other = says_no_color(prefix) || kind == Kind::Single && says_no_color(base);
        let is_color = floats && !matches!(kind, Kind::Vector | Kind::Pair) && !other;
        Group {
            part: part_index,
            prefix: prefix.to_owned(),
            kind,
            alpha: find(&["A", "alpha"]).filter(|alpha| !channels.contains(alpha)),
            channels,
            is_color,
        }
    };
    // Take R, G, B or two of them.
    let rgb = [
        find(&["R", "red"]),
        find(&["G", "green"]),
        find(&["B", "blue"]),
    ];
    match rgb {
        [Some(red), Some(green), Some(blue)] => {
            return vec![group(Kind::Rgb, vec![red, green, blue])];
        }
        [Some(red), Some(green), None] => return vec![group(Kind::Pair, vec![red, green])],
        _ => {}
    }
    // Take X, Y, Z or luminance.
    match (find(&["X"]), find(&["Y"]), find(&["Z"])) {
        (Some(x), Some(y), Some(z)) => return vec![group(Kind::Vector, vec![x, y, z])],
        (Some(x), Some(y), None) => return vec![group(Kind::Pair, vec![x, y])],
        (None, Some(y), _) => {
            return vec![match (find(&["RY"]), find(&["BY"])) {
                (Some(ry), Some(by)) => group(Kind::LuminanceChroma, vec![y, ry, by]),
                _ => group(Kind::Luminance, vec![y]),
            }];
        }
        _ => {}
    }
    // Take every other channel by itself.
    let single = |index: usize| Group {
        alpha: None,
        ..group(Kind::Single, vec![index])
    };
    members.iter().map(|&index| single(index)).collect()
}

/// Whether a layer's or channel's name says that it holds something other than colour.
fn says_no_color(name: &str) -> bool {
    let lower = name.to_ascii_lowercase();
    let mut words = lower.split(|c: char| !c.is_ascii_alphanumeric());
    let last = words.next_back().unwrap_or_default();
    let trimmed = last.trim_end_matches(|c: char| c.is_ascii_digit());
    lower.contains("crypto") || NO_COLOR.contains(&last) || NO_COLOR.contains(&trimmed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(parts: &[(&str, &[&str])]) -> Layers {
        let parts: Vec<Part> = parts
            .iter()
            .map(|(name, channels)| Part {
                name: (*name).into(),
                view: String::new(),
                channels: channels
                    .iter()
                    .map(|c| ((*c).to_string(), SampleType::F16))
                    .collect(),
                is_deep: false,
            })
            .collect();
        let groups = parts
            .iter()
            .enumerate()
            .flat_map(|(i, part)| groups(i, part))
            .collect();
        Layers { parts, groups }
    }

    fn chosen(layers: &Layers, options: &ReadOptions) -> Vec<String> {
        let choice = layers.choose(options).unwrap();
        let channels = &layers.parts[choice.part].channels;
        choice
            .channels
            .iter()
            .map(|&c| channels[c].0.clone())
            .collect()
    }

    fn refused(layers: &Layers, options: &ReadOptions) -> String {
        layers.choose(options).unwrap_err().to_string()
    }

    fn named(name: &str) -> ReadOptions {
        ReadOptions {
            layer: Some(name.into()),
            ..ReadOptions::default()
        }
    }

    #[test]
    fn the_picture_is_found_among_other_things() {
        let any = ReadOptions::default();
        let frame = file(&[(
            "",
            &["A", "B", "G", "N.X", "N.Y", "N.Z", "R", "Z", "texton.I"],
        )]);
        assert_eq!(chosen(&frame, &any), ["R", "G", "B"]);
        let depth_first = file(&[("depth", &["Z"]), ("rgb", &["B", "G", "R"])]);
        assert_eq!(chosen(&depth_first, &any), ["R", "G", "B"]);
        let blender = [
            "View.Combined.B",
            "View.Combined.G",
            "View.Combined.R",
            "View.Depth.Z",
        ];
        assert_eq!(chosen(&file(&[("", &blender)]), &any)[0], "View.Combined.R");
        let grey = file(&[("", &["A", "Y"])]);
        assert_eq!(chosen(&grey, &any), ["Y"]);
        assert_eq!(grey.choose(&any).unwrap().alpha, Some(0));
        assert_eq!(
            chosen(&file(&[("", &["displacement"])]), &any),
            ["displacement"]
        );
    }

    #[test]
    fn what_is_no_colour_is_not_taken_for_grey() {
        let any = ReadOptions::default();
        for channels in [
            &["Z"][..],
            &["A"],
            &["N.X", "N.Y", "N.Z"],
            &["object.id"],
            &["uv.U", "uv.V"],
            &["R", "G"],
            &["CryptoObject00.R", "CryptoObject00.G", "CryptoObject00.B"],
        ] {
            let message = refused(&file(&[("", channels)]), &any);
            assert!(message.contains(channels[0]), "{message}");
        }
        let height = ReadOptions::data();
        assert_eq!(chosen(&file(&[("", &["Z"])]), &height), ["Z"]);
        assert_eq!(
            chosen(&file(&[("", &["N.X", "N.Y", "N.Z"])]), &height)[2],
            "N.Z"
        );
        assert_eq!(chosen(&file(&[("", &["G", "R"])]), &height), ["R", "G"]);
    }

    #[test]
    fn a_choice_is_asked_for_and_taken_by_name() {
        let layers = file(&[(
            "",
            &[
                "diffuse.B",
                "diffuse.G",
                "diffuse.R",
                "gloss.B",
                "gloss.G",
                "gloss.R",
                "gloss.a1",
            ],
        )]);
        let mut options = ReadOptions::default();
        options.flags.layer = "--layer";
        let message = refused(&layers, &options);
        assert!(message.contains("--layer diffuse or gloss"), "{message}");
        assert_eq!(chosen(&layers, &named("gloss"))[0], "gloss.R");
        assert_eq!(chosen(&layers, &named("diffuse.G")), ["diffuse.G"]);
        assert!(refused(&layers, &named("glass")).contains("no layer `glass`"));
        let parts = file(&[
            ("left", &["B", "G", "R"]),
            ("right", &["B", "G", "R", "x.Y"]),
        ]);
        assert!(refused(&parts, &options).contains("part `left`"));
        assert_eq!(parts.choose(&named("left")).unwrap().part, 0);
        assert_eq!(chosen(&parts, &named("right/x")), ["x.Y"]);
        assert!(refused(&parts, &named("right")).contains("2 layers"));
        // A plain file has nothing to name.
        let plain = file(&[("", &["B", "G", "R"])]);
        assert!(!plain.choose(&named("diffuse")).unwrap().was_named);
    }
}
