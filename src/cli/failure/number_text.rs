//! Why a text is no number, and how the number that was meant is written.

use std::num::{IntErrorKind, ParseFloatError, ParseIntError};

use std::error::Error;

/// What to say of a value that a number's parser refused; `None` for other faults.
pub(super) fn explain(value: &str, fault: &(dyn Error + 'static)) -> Option<String> {
    if let Some(fault) = fault.downcast_ref::<ParseIntError>() {
        return Some(match fault.kind() {
            IntErrorKind::PosOverflow | IntErrorKind::NegOverflow => "a smaller number".into(),
            _ => format!("a whole number{}", written_out(value)),
        });
    }
    fault
        .downcast_ref::<ParseFloatError>()
        .map(|_| format!("a number{}", with_point(value)))
}

/// `, written 50000` for `50k`, and the like.
fn written_out(value: &str) -> String {
    let plain: String = value
        .chars()
        .filter(|c| !matches!(c, ',' | '_' | '\'' | ' '))
        .collect();
    let (digits, zeros) = match plain.char_indices().last() {
        Some((at, 'k' | 'K')) => (&plain[..at], 3),
        Some((at, 'm' | 'M')) => (&plain[..at], 6),
        _ => (plain.as_str(), 0),
    };
    let number = digits.parse::<f64>().ok().map(|n| n * 10f64.powi(zeros));
    match number.filter(|n| n.fract() == 0.0 && (0.0..1e15).contains(n)) {
        Some(number) => format!(", written {number}"),
        None => String::new(),
    }
}

fn with_point(value: &str) -> String {
    let pointed = value.replace(',', ".");
    match pointed.parse::<f64>() {
        Ok(_) => format!(", written {pointed}"),
        Err(_) => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_shown_as_it_is_written() {
        let whole = |text: &str| explain(text, &text.parse::<u32>().unwrap_err()).unwrap();
        assert_eq!(whole("50k"), "a whole number, written 50000");
        assert_eq!(whole("1.5M"), "a whole number, written 1500000");
        assert_eq!(whole("1,000"), "a whole number, written 1000");
        assert_eq!(whole("64x64"), "a whole number");
        assert_eq!(whole("99999999999"), "a smaller number");
        let real = |text: &str| explain(text, &text.parse::<f64>().unwrap_err()).unwrap();
        assert_eq!(real("0,5"), "a number, written 0.5");
        assert_eq!(real("half"), "a number");
    }
}
