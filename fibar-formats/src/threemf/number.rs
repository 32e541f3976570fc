//! The simple types of the schema, read to the letter.

/// `ST_Number`: a decimal number with a point, without blanks inside; never infinite or NaN.
pub fn number(text: &str) -> Option<f64> {
    let text = text.trim_ascii();
    let is_part = |byte: u8| byte.is_ascii_digit() || b"+-.eE".contains(&byte);
    let ends_well = text.bytes().last().is_some_and(|byte| byte.is_ascii_digit());
    // `1.` and `1.e5` are no numbers here, `.5` is.
    let is_number = ends_well && text.bytes().all(is_part) && !text.contains(".e") && !text.contains(".E");
    text.parse().ok().filter(|value: &f64| is_number && value.is_finite())
}

/// `ST_ResourceID`: from 1 to 2³¹ − 1.
pub fn id(text: &str) -> Option<u32> {
    index(text).filter(|&id| id > 0)
}

/// `ST_ResourceIndex`: from 0 to 2³¹ − 1.
pub fn index(text: &str) -> Option<u32> {
    let text = text.trim_ascii();
    let digits = text.strip_prefix('+').unwrap_or(text);
    if digits.is_empty() || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    digits.parse().ok().filter(|&index: &u32| index < 1 << 31)
}

/// `ST_Matrix3D`: twelve numbers, by rows; the last row is the shift.
pub fn matrix(text: &str) -> Option<[f64; 12]> {
    let numbers: Option<Vec<f64>> = text.split_ascii_whitespace().map(number).collect();
    numbers?.try_into().ok()
}

/// `ST_ColorValue`: red, green, blue and opacity from 0 to 1, sRGB.
pub fn colour(text: &str) -> Option<[f64; 4]> {
    let digits = text.trim_ascii().strip_prefix('#')?;
    if !matches!(digits.len(), 6 | 8) || !digits.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        return None;
    }
    let channel =
        |k: usize| digits.get(2 * k..2 * k + 2).map_or(Ok(255), |pair| u8::from_str_radix(pair, 16));
    let [r, g, b, a] =
        [channel(0), channel(1), channel(2), channel(3)].map(|c| c.map(|c| f64::from(c) / 255.0));
    Some([r.ok()?, g.ok()?, b.ok()?, a.ok()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_schema() {
        let check = |text: &str, expected: Option<f64>| assert_eq!(number(text), expected, "{text:?}");
        check("1", Some(1.0));
        check(" -1.5e-3 ", Some(-1.5e-3));
        check("+.5", Some(0.5));
        check("1.", None);
        check("1.e5", None);
        check("1,5", None);
        check("1 5", None);
        check("nan", None);
        check("inf", None);
        check("1e999", None);
        check("0x1", None);
        check("", None);
    }

    #[test]
    fn ids_and_indices_have_their_ranges() {
        assert_eq!(
            (id("0"), id("1"), id("2147483647"), id("2147483648")),
            (None, Some(1), Some(2147483647), None)
        );
        assert_eq!((index("0"), index("-1"), index("1.0"), index("+7")), (Some(0), None, None, Some(7)));
    }

    #[test]
    fn colours_have_six_or_eight_digits() {
        assert_eq!(colour("#FF0000"), Some([1.0, 0.0, 0.0, 1.0]));
        assert_eq!(colour("#00ff0033"), Some([0.0, 1.0, 0.0, 0.2]));
        for bad in ["FF0000", "#FF00", "#GG0000", "#FF00001", "red", "#é000é"] {
            assert_eq!(colour(bad), None, "{bad}");
        }
    }
}
