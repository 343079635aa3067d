//! The square window of texels round a texel (Tong 2002 §5.2), row by row from the top left: the order in
//! which the stencils of a mesh hold their samples.
//!
//! In: a list of offsets that should be a [square window](crate::neighborhood::square_window). Out: what is wrong.

use crate::error::{Error, Result};

/// Refuses a list of offsets that is no square window of odd width; `field` names the list.
pub fn check_square(field: &str, offsets: &[[i32; 2]]) -> Result<()> {
    let width = offsets.len().isqrt();
    if width * width != offsets.len() || width.is_multiple_of(2) {
        return Err(Error::data(field, format!("{} offsets", offsets.len()))
            .expected("a square of odd width, row by row: 1, 9, 25 or 49 offsets and so on"));
    }
    let half = (width / 2) as i64;
    for (at, &[drow, dcol]) in offsets.iter().enumerate() {
        let expected = [at / width, at % width].map(|place| place as i64 - half);
        if [drow, dcol].map(i64::from) != expected {
            let found = format!("{:?}", [drow, dcol]);
            return Err(
                Error::data(format!("{field}[{at}]"), found).expected(format!(
                    "{expected:?}: the square of width {width}, row by row from the top left"
                )),
            );
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighborhood::square_window;

    #[test]
    fn square_windows_are_accepted() {
        for width in [1, 3, 7, 255] {
            check_square("offsets", &square_window(width)).unwrap();
        }
    }

    #[test]
    fn other_lists_are_refused_by_place() {
        let refused =
            |offsets: &[[i32; 2]]| check_square("offsets", offsets).unwrap_err().to_string();
        let square = square_window(3);
        let mut columns = square.clone();
        columns.iter_mut().for_each(|offset| offset.reverse());
        let text = refused(&columns);
        assert!(
            text.contains("offsets[1]: [0, -1]; expected [-1, 0]"),
            "{text}"
        );
        let upwards: Vec<_> = square.iter().rev().copied().collect();
        assert!(refused(&upwards).contains("offsets[0]: [1, 1]; expected [-1, -1]"));
        for step in [i32::MIN, i32::MAX] {
            let mut far = square.clone();
            far[8] = [step, 1];
            assert!(refused(&far).contains("offsets[8]"));
        }
        // Round, even, and not centred.
        let round: Vec<_> = square.iter().copied().filter(|[r, c]| r * c == 0).collect();
        assert!(refused(&round).contains("offsets: 5 offsets; expected a square of odd width"));
        assert!(refused(&square[..4]).contains("4 offsets"));
        assert!(refused(&[]).contains("0 offsets"));
        assert!(refused(&[[0, 1]]).contains("offsets[0]: [0, 1]; expected [0, 0]"));
    }
}
