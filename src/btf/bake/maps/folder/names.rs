//! The words of a file's name, and which of them are its own: the name of the asset is what the files
//! of a folder share.

use std::ops::Range;
use std::path::Path;

/// A word of a name, in lower case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Word {
    pub(super) text: String,
    /// Whether it follows the word before without a separator, as in `BaseColor`.
    pub(super) glued: bool,
}

/// The words of a file's stem: cut at separators and where capitals begin a word.
pub(super) fn words_of(file: &Path) -> Vec<Word> {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    stem.split(|c: char| !c.is_alphanumeric())
        .filter(|part| !part.is_empty())
        .flat_map(cut_at_capitals)
        .collect()
}

fn cut_at_capitals(part: &str) -> Vec<Word> {
    let letters: Vec<char> = part.chars().collect();
    let begins_word = |at: usize| {
        let (before, here, after) = (letters[at - 1], letters[at], letters.get(at + 1));
        let small_follows = after.is_some_and(|c| c.is_lowercase());
        here.is_uppercase() && (before.is_lowercase() || small_follows)
    };
    let mut words = vec![String::new()];
    for (at, letter) in letters.iter().enumerate() {
        if at > 0 && begins_word(at) {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut() {
            word.extend(letter.to_lowercase());
        }
    }
    let glue = |(place, text)| Word {
        text,
        glued: place > 0,
    };
    words.into_iter().enumerate().map(glue).collect()
}

/// Texels along a side, where a word says so: `2k`, `2048`, `2048x2048`.
pub(super) fn resolution(word: &str) -> Option<u32> {
    if let Some(thousands) = word.strip_suffix('k') {
        let thousands: u32 = thousands.parse().ok()?;
        return (1..=64).contains(&thousands).then_some(thousands * 1024);
    }
    let side = word.split('x').next()?;
    let texels: u32 = side.parse().ok()?;
    let is_side = texels.is_power_of_two() && (128..=65_536).contains(&texels);
    is_side.then_some(texels)
}

/// Whether a word names an image format.
pub(super) fn is_format(word: &str) -> bool {
    [
        "jpg", "jpeg", "png", "exr", "tif", "tiff", "hdr", "bmp", "tga",
    ]
    .contains(&word)
}

/// The number of a variant that a word stands for: `2`, `02`, `var2`, `v2`, `lod0`.
pub(super) fn variant(word: &str) -> Option<u32> {
    let digits = ["var", "v", "lod", ""]
        .iter()
        .find_map(|head| word.strip_prefix(head).filter(|rest| !rest.is_empty()))?;
    let is_number = digits.len() <= 3 && digits.bytes().all(|b| b.is_ascii_digit());
    is_number.then(|| digits.parse().ok()).flatten()
}

/// Which words of each name are its own. `tells` says whether a name with these own words names a role.
///
/// What all names begin with, or three and more of them, is the asset's name; so is what all end with.
/// A name is shortened only as far as some name of its group still names a role.
pub(super) fn own_words(
    names: &[Vec<Word>],
    tells: impl Fn(usize, Range<usize>) -> bool,
) -> Vec<Range<usize>> {
    let ends = without_shared_end(names);
    let mut own: Vec<Range<usize>> = ends.iter().map(|&end| 0..end).collect();
    if !(0..names.len()).any(|name| tells(name, own[name].clone())) {
        own = names.iter().map(|words| 0..words.len()).collect();
    }
    for group in groups(names) {
        let shared = shared_start(names, &group);
        let start = (0..=shared).rev().find(|&start| {
            let cut = |name: usize| start.min(own[name].end)..own[name].end;
            group.iter().any(|&name| tells(name, cut(name)))
        });
        for &name in &group {
            own[name].start = start.unwrap_or(0).min(own[name].end);
        }
    }
    own
}

/// Names that begin with the same word: all of them, or three and more.
fn groups(names: &[Vec<Word>]) -> Vec<Vec<usize>> {
    let first = |name: usize| names[name].first().map(|word| word.text.as_str());
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for name in 0..names.len() {
        match groups
            .iter_mut()
            .find(|group| first(group[0]) == first(name))
        {
            Some(group) => group.push(name),
            None => groups.push(vec![name]),
        }
    }
    groups.retain(|group| group.len() >= 2 && (group.len() == names.len() || group.len() >= 3));
    groups
}

/// How many words a group of names begins with alike.
fn shared_start(names: &[Vec<Word>], group: &[usize]) -> usize {
    let first = &names[group[0]];
    let alike = |at: usize| {
        let same = |&name: &usize| names[name].get(at).map(|w| &w.text) == Some(&first[at].text);
        group.iter().all(same)
    };
    (0..first.len()).take_while(|&at| alike(at)).count()
}

/// Where each name ends without the words that all names end with.
fn without_shared_end(names: &[Vec<Word>]) -> Vec<usize> {
    let whole: Vec<usize> = names.iter().map(Vec::len).collect();
    let shortest = whole.iter().copied().min().unwrap_or(0);
    if names.len() < 2 {
        return whole;
    }
    let from_end = |name: &Vec<Word>, back: usize| name[name.len() - 1 - back].text.clone();
    let alike = |back: usize| {
        let wanted = from_end(&names[0], back);
        names.iter().all(|name| from_end(name, back) == wanted)
    };
    let shared = (0..shortest).take_while(|&back| alike(back)).count();
    whole.iter().map(|length| length - shared).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(name: &str) -> Vec<String> {
        let words = words_of(Path::new(name));
        words.into_iter().map(|word| word.text).collect()
    }

    #[test]
    fn names_are_cut_at_separators_and_capitals() {
        for (name, words) in [
            ("rusty_metal_02_nor_gl_1k.exr", "rusty metal 02 nor gl 1k"),
            (
                "Metal032_2K-JPG_AmbientOcclusion.jpg",
                "metal032 2k jpg ambient occlusion",
            ),
            ("NormalGL.png", "normal gl"),
            ("Wood044_DISP16_3K.tif", "wood044 disp16 3k"),
            ("AOMap2Rough.png", "ao map2 rough"),
            ("Rusty Metal-normal.ogl.png", "rusty metal normal ogl"),
        ] {
            assert_eq!(texts(name).join(" "), words, "{name}");
        }
        let words = words_of(Path::new("x_BaseColor.png"));
        assert!(!words[1].glued && words[2].glued);
    }

    #[test]
    fn resolutions_and_variants_are_numbers() {
        assert_eq!(resolution("2k"), Some(2048));
        assert_eq!(resolution("4096"), Some(4096));
        assert_eq!(resolution("1024x1024"), Some(1024));
        assert_eq!(resolution("032"), None);
        assert_eq!(resolution("metal"), None);
        assert_eq!(variant("var2"), Some(2));
        assert_eq!(variant("lod0"), Some(0));
        assert_eq!(variant("01"), Some(1));
        assert_eq!(variant("vase"), None);
        assert_eq!(variant("2048"), None);
    }

    #[test]
    fn the_name_of_the_asset_is_what_files_share() {
        let own = |names: &[&str], role: &str| {
            let names: Vec<Vec<Word>> =
                names.iter().map(|name| words_of(Path::new(name))).collect();
            let tells = |name: usize, range: Range<usize>| {
                names[name][range].iter().any(|word| word.text == role)
            };
            own_words(&names, tells)
                .into_iter()
                .zip(&names)
                .map(|(range, words)| {
                    let texts: Vec<&str> = words[range].iter().map(|w| w.text.as_str()).collect();
                    texts.join(" ")
                })
                .collect::<Vec<_>>()
        };
        assert_eq!(
            own(
                &["rusty_metal_ao_1k.png", "rusty_metal_disp_1k.png"],
                "disp"
            ),
            ["ao", "disp"]
        );
        assert_eq!(
            own(&["disp_rusty_metal.png", "ao_rusty_metal.png"], "disp"),
            ["disp", "ao"]
        );
        // Files that differ in their size alone keep the word that says what they are.
        assert_eq!(
            own(&["bark_disp_1k.png", "bark_disp_2k.png"], "disp"),
            ["disp 1k", "disp 2k"]
        );
        assert_eq!(
            own(&["a_disp.png", "b_disp.png"], "disp"),
            ["a disp", "b disp"]
        );
    }
}
