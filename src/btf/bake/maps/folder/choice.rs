//! One file per role: the best of those that fit, where one is clearly better; else both are named.

use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::btf::bake::maps::folder::listing::precision;
use crate::btf::bake::maps::folder::names::{Word, is_format, resolution, variant};
use crate::btf::bake::maps::folder::roles::{Role, Told};
use crate::btf::bake::maps::set::FileUse;
use crate::error::{Error, Result};

/// An image with what its name says.
pub(super) struct Candidate {
    file: PathBuf,
    told: Option<Told>,
    /// The name without what tells sizes, formats and variants apart.
    identity: String,
    /// Texels along a side as its name says, 0 if it does not.
    resolution: u32,
    /// The number of a variant.
    variant: u32,
    /// Whether its name says 16 or 32 bits.
    many_bits: bool,
    /// Whether its name is the asset's and nothing more.
    is_nameless: bool,
}

impl Candidate {
    pub(super) fn new(file: &Path, words: &[Word], own: Range<usize>, told: Option<Told>) -> Self {
        // Take the words that name the material.
        let says_size = |word: &Word| resolution(&word.text).is_some() || is_format(&word.text);
        let after = told.map_or(words.len(), |told| told.at + 1);
        let bare = |(at, word): (usize, &Word)| {
            let text = word.text.as_str();
            let is_variant = at >= after && variant(text).is_some();
            let skipped = resolution(text).is_some() || is_format(text) || is_variant;
            let text = match told.is_some_and(|told| told.at == at) {
                true => text.trim_end_matches(|c: char| c.is_ascii_digit()),
                false => text,
            };
            (!skipped).then(|| text.to_owned())
        };
        let identity: Vec<String> = words.iter().enumerate().filter_map(bare).collect();
        // Tell numbers of bits from numbers of variants.
        let number_of = |word: &Word| {
            let digits = word.text.trim_start_matches(|c: char| !c.is_ascii_digit());
            digits.parse().unwrap_or(0)
        };
        let number = told.map_or(0, |told| number_of(&words[told.at]));
        let many_bits = number == 16 || number == 32;
        let of_role = if many_bits { 0 } else { number };
        Self {
            file: file.to_path_buf(),
            identity: identity.join(" "),
            resolution: words
                .iter()
                .filter_map(|word| resolution(&word.text))
                .max()
                .unwrap_or(0),
            variant: words
                .iter()
                .skip(after)
                .filter_map(|word| variant(&word.text))
                .next()
                .unwrap_or(of_role),
            many_bits,
            is_nameless: words[own].iter().all(says_size),
            told,
        }
    }

    /// Candidates of one identity, the best first.
    fn order(&self) -> impl Ord + use<> {
        (
            self.variant,
            std::cmp::Reverse(self.resolution),
            !self.many_bits,
            precision(&self.file),
            self.file.clone(),
        )
    }

    /// Why another file of the same role goes first.
    fn inferior_to(&self, best: &Self) -> String {
        let than = best.file.display();
        if self.told.map(|told| told.rank) != best.told.map(|told| told.rank) {
            format!("the name of {than} is more specific")
        } else if self.variant != best.variant {
            format!("another variant; {than} is the first")
        } else if self.resolution != best.resolution {
            format!("{than} is larger")
        } else {
            format!("{than} is more precise")
        }
    }
}

/// The images of a folder while their roles are given out.
pub(super) struct Ranking {
    candidates: Vec<Candidate>,
    /// What was decided of each.
    decided: Vec<Option<(bool, String)>>,
}

impl Ranking {
    pub(super) fn new(candidates: Vec<Candidate>) -> Self {
        let decided = candidates.iter().map(|_| None).collect();
        Self {
            candidates,
            decided,
        }
    }

    /// Takes the file of a role, used as `what`; says which others could have played it.
    pub(super) fn take(
        &mut self,
        what: &str,
        fits: impl Fn(&Told) -> bool,
    ) -> Result<Option<PathBuf>> {
        Ok(self.take_told(what, fits)?.map(|(file, _)| file))
    }

    /// The same, with what the name says.
    pub(super) fn take_told(
        &mut self,
        what: &str,
        fits: impl Fn(&Told) -> bool,
    ) -> Result<Option<(PathBuf, Told)>> {
        let told_of = |at: usize| self.candidates[at].told.filter(|told| fits(told));
        let mut fitting: Vec<(usize, Told)> = (0..self.candidates.len())
            .filter(|&at| self.decided[at].is_none())
            .filter_map(|at| Some((at, told_of(at)?)))
            .collect();
        fitting.sort_by_key(|&(at, told)| (told.rank, self.candidates[at].order()));
        let Some(&(best, told)) = fitting.first() else {
            return Ok(None);
        };
        let rival = fitting.iter().find(|&&(at, other)| {
            other.rank == told.rank
                && self.candidates[at].identity != self.candidates[best].identity
        });
        if let Some(&(other, _)) = rival {
            return Err(self.two_fit(what, best, other));
        }
        self.decided[best] = Some((true, what.to_owned()));
        for &(at, _) in &fitting[1..] {
            let why = self.candidates[at].inferior_to(&self.candidates[best]);
            self.decided[at] = Some((false, why));
        }
        Ok(Some((self.candidates[best].file.clone(), told)))
    }

    fn two_fit(&self, what: &str, one: usize, other: usize) -> Error {
        let name = |at: usize| self.candidates[at].file.display();
        let what = what.split([',', '(', '=']).next().unwrap_or(what).trim();
        Error::data(
            "folder",
            format!("both {} and {} fit as its {what} map", name(one), name(other)),
        )
        .expected("the maps of one material, one file for each")
        .advice(
            "move the files of other materials to folders of their own, or write a material.toml that names \
             the maps",
        )
    }

    /// Says why files that are not taken yet are not used.
    pub(super) fn pass_over(&mut self, why: &str, is: impl Fn(&Told) -> bool) {
        for (candidate, decided) in self.candidates.iter().zip(&mut self.decided) {
            if decided.is_none() && candidate.told.as_ref().is_some_and(&is) {
                *decided = Some((false, why.to_owned()));
            }
        }
    }

    /// Says more of what a file is used as.
    pub(super) fn describe(&mut self, file: &Path, what: String) {
        let at = self
            .candidates
            .iter()
            .position(|candidate| candidate.file == file);
        if let Some(Some((true, said))) = at.map(|at| &mut self.decided[at]) {
            *said = what;
        }
    }

    /// Files with what their names say they show.
    pub(super) fn known(&self) -> Vec<String> {
        let known = |candidate: &Candidate| {
            let role = candidate.told?.role.name();
            Some(format!("{} ({role})", candidate.file.display()))
        };
        self.candidates.iter().filter_map(known).collect()
    }

    /// What became of every file.
    pub(super) fn into_uses(self) -> Vec<FileUse> {
        let decisions = self.candidates.into_iter().zip(self.decided);
        decisions
            .map(|(candidate, decided)| use_of(candidate, decided))
            .collect()
    }
}

fn use_of(candidate: Candidate, decided: Option<(bool, String)>) -> FileUse {
    let role = candidate.told.map(|told| told.role);
    let (used, why) = decided.unwrap_or_else(|| {
        let why = match role {
            Some(Role::Other(other)) => other.why,
            Some(_) => "the folder is not used",
            None if candidate.is_nameless => {
                "its name is the asset's alone: it seems to be a preview"
            }
            None => "its name does not state what it shows",
        };
        (false, why.to_owned())
    });
    FileUse {
        file: candidate.file,
        role: role.map_or("unknown", Role::name).to_owned(),
        used,
        why,
    }
}

/// Whose way of naming files it is, where names show it.
pub(super) fn naming(images: &[PathBuf]) -> Option<&'static str> {
    let stems = images.iter().filter_map(|file| file.file_stem()?.to_str());
    let mut styles = stems.filter_map(style);
    styles.next()
}

/// The library whose way of naming a stem follows; only what others do not do counts.
fn style(stem: &str) -> Option<&'static str> {
    let parts: Vec<&str> = stem.split('_').collect();
    let (first, rest) = parts.split_first()?;
    let last = rest.last()?;
    let has = |words: &[&str]| rest.iter().any(|part| words.contains(part));
    let is_small = |text: &str| !text.chars().any(char::is_uppercase);
    let has_size = rest.iter().any(|part| is_size(part));
    Some(match () {
        () if stem.contains("K-JPG_") || stem.contains("K-PNG_") => "ambientCG",
        () if *first == "Poliigon" => "Poliigon",
        () if has_size && has(&["COL", "NRM", "NRM16", "REFL", "DISP", "DISP16", "GLOSS"]) => {
            "Poliigon"
        }
        () if is_size(last) && has(&["diff", "nor", "arm", "rough"]) => "Poly Haven",
        () if has(&["LOD0"]) || (has(&["2K", "4K", "8K"]) && is_small(first) && !is_size(last)) => {
            "Megascans"
        }
        () if *first == "T" => "Unreal",
        () => return None,
    })
}

fn is_size(part: &str) -> bool {
    let small = part.to_lowercase();
    small.ends_with('k') && resolution(&small).is_some()
}
