//! The size line of ATRIUM's Radiance files: it names columns first, but the pixels come in rows.
//!
//! By the format `+X 256 -Y 256` means columns from the left, each from the top. The pixels of these files are
//! rows from the bottom. Public readers of the set overwrite the line and turn the rows round.

use clap::ValueEnum;
use serde::Serialize;

/// How the size line of Radiance files in sets of Bonn is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum SizeLine {
    /// `+X W -Y H` as rows from the bottom, as in ATRIUM; all others as stated.
    #[default]
    Auto,
    /// As stated.
    Stated,
}

/// The longest header that is looked through, in bytes.
const LONGEST_HEADER: usize = 64 << 10;

/// A file with its size line put right; `None` where there is nothing to put right.
pub(super) fn corrected(file: &[u8]) -> Option<Vec<u8>> {
    if !file.starts_with(b"#?") {
        return None;
    }
    let head = &file[..file.len().min(LONGEST_HEADER)];
    let begin = head.windows(2).position(|pair| pair == b"\n\n")? + 2;
    let length = head[begin..].iter().position(|&byte| byte == b'\n')?;
    let line = std::str::from_utf8(&head[begin..begin + length]).ok()?;
    let words: Vec<&str> = line.split_whitespace().collect();
    let ["+X", width, "-Y", height] = words[..] else {
        return None;
    };
    let sound = format!("+Y {height} +X {width}");
    let (before, after) = (&file[..begin], &file[begin + length..]);
    Some([before, sound.as_bytes(), after].concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_faulty_line_is_put_right() {
        let file = |line: &str| {
            format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{line}\n\x01\x02").into_bytes()
        };
        assert_eq!(
            corrected(&file("+X 256 -Y 128")),
            Some(file("+Y 128 +X 256"))
        );
        for line in ["-Y 128 +X 256", "-X 256 -Y 128", "+X 256", ""] {
            assert_eq!(corrected(&file(line)), None, "{line}");
        }
        assert_eq!(corrected(b"\x89PNG"), None);
        assert_eq!(corrected(b"#?RADIANCE"), None);
    }
}
