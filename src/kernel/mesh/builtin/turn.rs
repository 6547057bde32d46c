use std::f64::consts::FRAC_PI_2;

/// Cosine and sine of a fraction of a full turn, the same bits on every machine: the `sin` and
/// `cos` of the platform differ in the last bit between C libraries, so this uses only operations
/// that IEEE 754 specifies exactly. Taylor on [-pi/4, pi/4]; the first term left out is below 1e-17.
pub(super) fn turn(fraction: f64) -> [f64; 2] {
    let quarters = fraction * 4.0;
    let nearest = quarters.round();
    let x = (quarters - nearest) * FRAC_PI_2;
    let square = x * x;
    let cos = series(square, [2.0, 12.0, 30.0, 56.0, 90.0, 132.0, 182.0, 240.0]);
    let sin = x * series(square, [6.0, 20.0, 42.0, 72.0, 110.0, 156.0, 210.0, 272.0]);
    match nearest as i64 & 3 {
        0 => [cos, sin],
        1 => [-sin, cos],
        2 => [-cos, -sin],
        _ => [sin, -cos],
    }
}

/// 1 - s/d0 (1 - s/d1 (1 - ...)): the alternating series whose terms grow by s/d.
fn series(square: f64, divisors: [f64; 8]) -> f64 {
    divisors.iter().rev().fold(1.0, |rest, divisor| 1.0 - square / divisor * rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_agrees_with_the_platform_to_rounding() {
        for step in -400..400 {
            let fraction = f64::from(step) / 173.0;
            let (sin, cos) = (fraction * std::f64::consts::TAU).sin_cos();
            let ours = turn(fraction);
            assert!((ours[0] - cos).abs() < 1e-14 && (ours[1] - sin).abs() < 1e-14, "{fraction}");
        }
    }

    #[test]
    fn quarter_turns_are_exact() {
        assert_eq!(
            [0.0, 0.25, 0.5, 0.75].map(|t| turn(t).map(|c| c + 0.0)),
            [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]
        );
    }
}
