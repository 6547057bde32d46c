//! Feasibility of equations in non-negative unknowns: phase one of the simplex method, with
//! Bland's rule against cycling (1977) and Edmonds' integer pivoting against fractions.

use bumper::geometry::Triangle;
use num_bigint::BigInt;

const ROWS: usize = 5;
const UNKNOWNS: usize = 6;
/// Coefficients and, last, the right-hand side.
type Row = [BigInt; UNKNOWNS + 1];

/// Are there l, m >= 0 with sum l = sum m = 1 and sum l_i a_i = sum m_j b_j?
pub fn common_convex_combination(a: &Triangle, b: &Triangle) -> bool {
    let row = |coefficients: [i32; 7]| coefficients.map(BigInt::from);
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let [a0, a1, a2] = a.map(|p| p[axis]);
        let [b0, b1, b2] = b.map(|p| p[axis]);
        integers([a0, a1, a2, -b0, -b1, -b2, 0.0])
    });
    feasible([row([1, 1, 1, 0, 0, 0, 1]), row([0, 0, 0, 1, 1, 1, 1]), x, y, z])
}

/// The numbers times one power of two.
fn integers(numbers: [f64; 7]) -> Row {
    let exponent = |x: f64| (x.to_bits() >> 52 & 0x7ff).max(1);
    let lowest = numbers.into_iter().filter(|&x| x != 0.0).map(exponent).min().unwrap_or(1);
    numbers.map(|x| {
        let hidden = if x.is_normal() { 1 << 52 } else { 0 };
        let magnitude = BigInt::from(x.to_bits() & ((1 << 52) - 1) | hidden);
        let aligned = if x == 0.0 { BigInt::ZERO } else { magnitude << (exponent(x) - lowest) };
        if x.is_sign_negative() { -aligned } else { aligned }
    })
}

/// Right-hand sides at least zero.
fn feasible(mut rows: [Row; ROWS]) -> bool {
    // An artificial unknown a row makes the first basis; their sum is to become zero.
    let mut costs: Row =
        std::array::from_fn(|column| -rows.iter().map(|row| &row[column]).sum::<BigInt>());
    let mut basis: [usize; ROWS] = std::array::from_fn(|row| UNKNOWNS + row);
    let mut denominator = BigInt::from(1);
    while let Some(entering) = (0..UNKNOWNS).find(|&column| costs[column] < BigInt::ZERO) {
        let leaving = leaving_row(&rows, &basis, entering);
        let pivot_row = rows[leaving].clone();
        let pivot = &pivot_row[entering];
        let others = rows.iter_mut().enumerate().filter(|(row, _)| *row != leaving);
        for row in others.map(|(_, row)| row).chain([&mut costs]) {
            let factor = row[entering].clone();
            for (value, pivot_value) in row.iter_mut().zip(&pivot_row) {
                *value = (&*value * pivot - &factor * pivot_value) / &denominator;
            }
        }
        denominator = pivot.clone();
        basis[leaving] = entering;
    }
    costs[UNKNOWNS] == BigInt::ZERO
}

/// The row that first forbids the entering unknown to grow; of several, that of the first unknown.
fn leaving_row(rows: &[Row; ROWS], basis: &[usize; ROWS], entering: usize) -> usize {
    let limiting = (0..ROWS).filter(|&row| rows[row][entering] > BigInt::ZERO);
    let order = |&r: &usize, &s: &usize| {
        let left = &rows[r][UNKNOWNS] * &rows[s][entering];
        let right = &rows[s][UNKNOWNS] * &rows[r][entering];
        left.cmp(&right).then(basis[r].cmp(&basis[s]))
    };
    limiting.min_by(order).expect("a sum of non-negative unknowns has a least value")
}
