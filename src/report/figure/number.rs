//! Numbers as people read them.

/// Whole numbers as they are, others with four digits: `1,000`, `0.25`, `2×10⁻⁶` where zeros would
/// have to be counted.
pub fn number(value: f64) -> String {
    let size = value.abs();
    let sign = if value < 0.0 { "-" } else { "" };
    if size.fract() == 0.0 && size < 1e15 {
        format!("{sign}{}", grouped(size as u64))
    } else if !value.is_finite() {
        value.to_string()
    } else if (1e-3..1e6).contains(&size) {
        let decimals = (DIGITS - 1 - size.log10().floor() as i32).max(0);
        let text = trimmed(format!("{size:.0$}", decimals as usize));
        let whole = text.split('.').next().unwrap_or_default();
        let thousands = whole.parse().map_or_else(|_| whole.to_owned(), grouped);
        format!("{sign}{thousands}{}", &text[whole.len()..])
    } else {
        scientific(value)
    }
}

const DIGITS: i32 = 4;

/// As [`number`], and short however great.
pub(super) fn tick(value: f64) -> String {
    if value.abs() < 1e6 { number(value) } else { scientific(value) }
}

fn scientific(value: f64) -> String {
    let text = format!("{value:.2e}");
    let (mantissa, exponent) = text.split_once('e').expect("it was asked for");
    let power = format!("10{}", exponent.chars().map(superscript).collect::<String>());
    match trimmed(mantissa.to_owned()).as_str() {
        "1" => power,
        "-1" => format!("-{power}"),
        mantissa => format!("{mantissa}×{power}"),
    }
}

fn superscript(digit: char) -> char {
    match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' | '4'..='9' => char::from_u32(0x2070 + digit as u32 - '0' as u32).unwrap_or(digit),
        other => other,
    }
}

/// Without zeros behind the point.
fn trimmed(text: String) -> String {
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// 1234567 as `1,234,567`.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{grouped, number, tick};

    #[test]
    fn numbers_are_short_and_never_ambiguous() {
        let cases = [
            (0.0, "0"),
            (-0.0, "0"),
            (0.1 + 0.2, "0.3"),
            (1234.56, "1,235"),
            (46.6667, "46.67"),
            (0.0123456, "0.01235"),
            (67_108_864.0, "67,108,864"),
            (100.0, "100"),
            (999_999.0, "999,999"),
            (99.99999, "100"),
            (999_999.7, "1,000,000"),
            (-2500.0, "-2,500"),
            (0.001, "0.001"),
            (2.5e6 + 0.5, "2.5×10⁶"),
            (2.5e-7, "2.5×10⁻⁷"),
            (6.022e23, "6.02×10²³"),
            (f64::INFINITY, "inf"),
        ];
        for (value, expected) in cases {
            assert_eq!(number(value), expected);
        }
        assert_eq!([1e5, 1e6, -2e7].map(tick), ["100,000", "10⁶", "-2×10⁷"]);
    }

    #[test]
    fn thousands_are_set_apart() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1000), "1,000");
        assert_eq!(grouped(1_234_567), "1,234,567");
    }
}
