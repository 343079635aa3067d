//! The text that a `.btf` file begins with: which format follows, and which optional parts it has.

use crate::error::{Error, Result};

/// How a file keeps its images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Decorrelated full matrix factorization: one pair of factors per colour channel.
    Dfmf,
    /// Full matrix factorization: one pair of factors for all channels.
    Fmf,
    /// Per-view factorization: a principal component analysis per view.
    Pvf,
    /// Bidirectional image: all numbers, texel by texel.
    Bdi,
}

impl Format {
    /// Its name, as the format's authors have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dfmf => "DFMF",
            Self::Fmf => "FMF",
            Self::Pvf => "PVF",
            Self::Bdi => "BDI",
        }
    }
}

/// A signature and what it says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signature {
    /// The bytes.
    pub text: &'static str,
    /// What follows.
    pub format: Format,
    /// Whether rotations into local frames follow the size.
    pub has_rotations: bool,
    /// Whether an FMF has a second header.
    pub has_extra_header: bool,
}

const fn signature(
    text: &'static str,
    format: Format,
    has_rotations: bool,
    has_extra_header: bool,
) -> Signature {
    Signature {
        text,
        format,
        has_rotations,
        has_extra_header,
    }
}

/// All signatures: those of btflib, and two that btf.hh reads besides (without the last R).
pub const SIGNATURES: [Signature; 9] = [
    signature("!DFMF08FCR", Format::Dfmf, true, false),
    signature("!DFMF08FC", Format::Dfmf, false, false),
    signature("!FMF12FCER", Format::Fmf, true, true),
    signature("!FMF12FCE", Format::Fmf, false, true),
    signature("!FMF06FCR", Format::Fmf, true, false),
    signature("!FMF06FC", Format::Fmf, false, false),
    signature("!PVF06FCR", Format::Pvf, true, false),
    signature("!PVF06FC", Format::Pvf, false, false),
    signature("!BDIF06R2!", Format::Bdi, true, false),
];

/// Bytes of the longest signature.
pub const LONGEST: usize = 10;

impl Signature {
    /// The longest signature that `start` begins with.
    pub fn of(start: &[u8]) -> Result<Self> {
        Self::all_of(start).map(|all| all[0])
    }

    /// All signatures that `start` begins with, the longest first. There are two where the last letter of the longer
    /// one may as well be the first byte of the header's size.
    pub(super) fn all_of(start: &[u8]) -> Result<Vec<Self>> {
        let begins = |signature: &Self| start.starts_with(signature.text.as_bytes());
        let mut all: Vec<Self> = SIGNATURES.into_iter().filter(begins).collect();
        all.sort_by_key(|signature| std::cmp::Reverse(signature.text.len()));
        if all.is_empty() {
            let shown = &start[..start.len().min(LONGEST)];
            let known = SIGNATURES.map(|signature| signature.text).join(", ");
            return Err(
                Error::data("signature", format!("`{}`", shown.escape_ascii()))
                    .expected(format!("one of {known}")),
            );
        }
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_match_counts() {
        let of = |start: &[u8]| Signature::of(start).unwrap();
        assert_eq!(of(b"!FMF06FCRxx").text, "!FMF06FCR");
        assert_eq!(of(b"!FMF06FC\x08\x01").text, "!FMF06FC");
        assert!(of(b"!FMF12FCER").has_extra_header);
        assert!(of(b"!BDIF06R2!").has_rotations);
        let text = Signature::of(b"!XYZ").unwrap_err().to_string();
        assert!(
            text.contains("`!XYZ`") && text.contains("!PVF06FC"),
            "{text}"
        );
    }

    #[test]
    fn no_signature_is_longer_than_said() {
        let longest = SIGNATURES
            .iter()
            .map(|signature| signature.text.len())
            .max();
        assert_eq!(longest, Some(LONGEST));
    }
}
