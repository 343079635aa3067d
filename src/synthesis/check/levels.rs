//! How many levels of a sample the windows of a method fit, and what is said where they do not.

use crate::error::{Error, Result};
use crate::exemplar::space::Space;

/// How many of the finest levels are no narrower than the windows on them; `width` is that of the windows on a level.
pub fn fitting(space: &Space, levels: usize, width: impl Fn(usize) -> u32) -> usize {
    let levels = 0..levels.min(space.levels.len());
    let fits = |&level: &usize| width(level) <= shorter_side(space, level);
    levels.take_while(fits).count()
}

/// The levels that were asked for, else `default`; refused where there are fewer than `most`.
pub fn asked_or(most: usize, asked: Option<u32>, default: usize) -> Result<usize> {
    if most == 0 {
        return Err(Error::data("space", "no level").expected("one or more"));
    }
    let levels = asked.map_or(default, |levels| levels as usize);
    if levels <= most {
        return Ok(levels);
    }
    Err(Error::option(
        "levels",
        format!("{levels}, but the sample has {most}"),
        format!(
            "at most {most}, or a space of {levels} levels (textons --levels {levels}, exemplar --levels {levels})"
        ),
    ))
}

/// Refuses windows of an option that are wider than the first level that they do not fit.
pub fn too_wide(option: &'static str, width: u32, space: &Space, fitting: usize) -> Error {
    let most = shorter_side(space, fitting);
    Error::option(
        option,
        wide_on(space, fitting, width),
        at_most(most, fitting),
    )
}

/// Says how wide windows are, and the level that they do not fit.
pub fn wide_on(space: &Space, level: usize, width: u32) -> String {
    let grid = space.levels[level].grid;
    format!(
        "{width} texels wide on the sample's level {level} of {}×{}",
        grid.width, grid.height
    )
}

/// Says which values fit one level more, or how many levels the present one fits.
pub fn at_most(most: u32, fitting: usize) -> String {
    match fitting {
        0 => format!("at most {most}"),
        _ => format!("at most {most}, or --levels {fitting}"),
    }
}

/// The shorter side of a level.
pub fn shorter_side(space: &Space, level: usize) -> u32 {
    let grid = space.levels[level].grid;
    grid.width.min(grid.height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthesis::tests::fixtures;

    #[test]
    fn levels_are_counted_up_to_the_first_that_is_too_narrow() {
        let (space, _) = fixtures::random_exemplar(1, 16, 2, true);
        assert_eq!(fitting(&space, 2, |_| 8), 2);
        assert_eq!(fitting(&space, 1, |_| 8), 1);
        assert_eq!(fitting(&space, 2, |level| [16, 9][level]), 1);
        assert_eq!(fitting(&space, 9, |_| 1), 2);
        assert_eq!(fitting(&space, 2, |_| 17), 0);
    }

    #[test]
    fn more_levels_than_there_are_are_refused() {
        assert_eq!(asked_or(3, None, 2).unwrap(), 2);
        assert_eq!(asked_or(3, Some(3), 2).unwrap(), 3);
        let text = asked_or(3, Some(4), 2).unwrap_err().to_string();
        assert!(text.contains("--levels: 4, but the sample has 3"), "{text}");
        let text = asked_or(0, Some(1), 1).unwrap_err().to_string();
        assert!(text.contains("space: no level"), "{text}");
    }

    #[test]
    fn windows_that_are_too_wide_are_told_with_what_fits() {
        let (space, _) = fixtures::random_exemplar(1, 16, 2, true);
        let text = too_wide("window", 9, &space, 1).to_string();
        assert!(
            text.contains("--window: 9 texels wide on the sample's level 1 of 8×8"),
            "{text}"
        );
        assert!(text.contains("at most 8, or --levels 1"), "{text}");
        assert!(!at_most(8, 0).contains("--levels"));
    }
}
