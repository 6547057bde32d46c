//! Polynomials in t on [0, 1] with integer coefficients: signs at their own and at others' roots.
//!
//! The coefficient c_i is that of (1-t)^(n-i) t^i (scaled Bernstein basis; Farouki & Rajan 1988). With
//! s = t / (1-t) these are the coefficients of powers of s, so that products, division and the rule
//! of signs are those of plain polynomials in s, and times within (0, 1) are all s > 0.

use std::cmp::Ordering;
use std::ops::{Add, Mul, Sub};

use num_bigint::BigInt;

#[derive(Clone, Debug)]
pub struct Polynomial(Vec<BigInt>);

impl Polynomial {
    /// From `start` at t = 0 to `end` at t = 1.
    pub fn linear(start: BigInt, end: BigInt) -> Self {
        Self(vec![start, end])
    }

    pub fn is_zero(&self) -> bool {
        self.0.iter().all(|c| *c == BigInt::ZERO)
    }

    pub fn sign_at_start(&self) -> Ordering {
        self.0.first().map_or(Ordering::Equal, sign)
    }

    pub fn sign_at_end(&self) -> Ordering {
        self.0.last().map_or(Ordering::Equal, sign)
    }

    /// By Horner's rule.
    fn sign_at(&self, time: &Time) -> Ordering {
        let (before, after) = (time.before(), &time.steps);
        let (mut value, mut power) = (BigInt::ZERO, BigInt::from(1));
        for coefficient in self.0.iter().rev() {
            value = value * after + coefficient * &power;
            power *= &before;
        }
        sign(&value)
    }

    /// On a part of [0, 1], stretched to the whole: with 1-t and t replaced by their forms there.
    fn within(&self, Part { from }: &Part) -> Self {
        let to = from.next();
        let before = Self::linear(from.before(), to.before());
        let after = Self::linear(from.steps.clone(), to.steps);
        let mut coefficients = self.0.iter().rev();
        let mut value = Self(coefficients.next().cloned().into_iter().collect());
        let mut power = Self(vec![BigInt::from(1)]);
        for coefficient in coefficients {
            power = &power * &before;
            let term = Self(power.0.iter().map(|c| c * coefficient).collect());
            value = &(&value * &after) + &term;
        }
        value
    }

    /// Of signs, from one coefficient to the next that is not zero: the number of roots within
    /// (0, 1), or more by an even number (Descartes).
    fn sign_changes(&self) -> usize {
        let signs: Vec<Ordering> = self.0.iter().map(sign).filter(|s| s.is_ne()).collect();
        signs.windows(2).filter(|pair| pair[0] != pair[1]).count()
    }

    /// Right after t = 0.
    fn first_sign(&self) -> Ordering {
        self.0.iter().map(sign).find(|s| s.is_ne()).unwrap_or(Ordering::Equal)
    }

    /// Without its roots at the ends.
    fn inner(&self) -> Self {
        let nonzero = |c: &BigInt| *c != BigInt::ZERO;
        let first = self.0.iter().position(nonzero).unwrap_or(self.0.len());
        let last = self.0.iter().rposition(nonzero).map_or(first, |last| last + 1);
        Self(self.0[first..last].to_vec())
    }

    /// By s.
    fn derivative(&self) -> Self {
        Self((0u32..).zip(&self.0).skip(1).map(|(i, c)| c * i).collect())
    }

    /// Quotient and remainder of a multiple of this. `divisor`'s last coefficient is not zero.
    fn divided_by(&self, Self(divisor): &Self) -> (Self, Self) {
        let lead = divisor.last().expect("the divisor is not zero");
        let (mut quotient, mut rest) = (Vec::new(), self.0.clone());
        while rest.len() >= divisor.len() {
            let factor = rest.pop().expect("it is longer than nothing");
            let shift = rest.len() + 1 - divisor.len();
            for c in quotient.iter_mut().chain(&mut rest) {
                *c *= lead;
            }
            for (c, d) in rest[shift..].iter_mut().zip(divisor) {
                *c -= d * &factor;
            }
            quotient.push(factor);
        }
        quotient.reverse();
        while rest.last().is_some_and(|c| *c == BigInt::ZERO) {
            rest.pop();
        }
        (Self(quotient), Self(rest))
    }

    /// Has the roots within (0, 1) that both have. Neither is zero.
    fn common(&self, other: &Self) -> Self {
        let (mut a, mut b) = (self.inner(), other.inner());
        while !b.0.is_empty() {
            (a, b) = (b.clone(), a.divided_by(&b).1);
        }
        a
    }

    /// The roots within (0, 1), each once, in no order (Collins & Akritas 1976).
    pub fn roots(&self) -> Vec<Root> {
        let inner = self.inner();
        // A single change of signs is a simple root, none is none.
        let simple = if inner.sign_changes() < 2 {
            inner
        } else {
            inner.divided_by(&inner.common(&inner.derivative())).0
        };
        let (mut roots, mut parts) = (Vec::new(), vec![Part::whole()]);
        while let Some(part) = parts.pop() {
            let within = simple.within(&part);
            match within.sign_changes() {
                0 => {}
                1 => {
                    let (polynomial, sign_before) = (simple.clone(), within.first_sign());
                    let place = Place::Within(part);
                    roots.push(Root { polynomial, sign_before, place });
                }
                _ => {
                    let [left, right] = part.halves();
                    if simple.sign_at(&right.from).is_eq() {
                        let place = Place::At(right.from.clone());
                        let (polynomial, sign_before) = (simple.clone(), Ordering::Equal);
                        roots.push(Root { polynomial, sign_before, place });
                    }
                    parts.extend([left, right]);
                }
            }
        }
        roots
    }
}

/// The time steps / 2^halvings.
#[derive(Clone, Debug)]
struct Time {
    steps: BigInt,
    halvings: u32,
}

impl Time {
    /// The steps that are left to t = 1.
    fn before(&self) -> BigInt {
        (BigInt::from(1) << self.halvings) - &self.steps
    }

    fn next(&self) -> Self {
        Self { steps: &self.steps + 1, halvings: self.halvings }
    }

    /// Rounded down.
    fn to_f64(&self) -> f64 {
        const DIGITS: u32 = f64::MANTISSA_DIGITS;
        let shift = DIGITS.saturating_sub(self.halvings);
        let steps = (&self.steps << shift) >> self.halvings.saturating_sub(DIGITS);
        let steps = u64::try_from(steps).expect("a time is within [0, 1]");
        // Exact: neither has more digits than an f64.
        steps as f64 / (1_u64 << DIGITS) as f64
    }
}

/// One step from here.
#[derive(Clone, Debug)]
struct Part {
    from: Time,
}

impl Part {
    fn whole() -> Self {
        Self { from: Time { steps: BigInt::ZERO, halvings: 0 } }
    }

    fn halves(&self) -> [Self; 2] {
        let Time { steps, halvings } = &self.from;
        let left = Time { steps: steps << 1, halvings: halvings + 1 };
        let right = left.next();
        [Self { from: left }, Self { from: right }]
    }
}

/// A root within (0, 1).
#[derive(Clone, Debug)]
pub struct Root {
    /// Of which it is a simple root.
    polynomial: Polynomial,
    /// At the start of the part that has the root.
    sign_before: Ordering,
    place: Place,
}

#[derive(Clone, Debug)]
enum Place {
    At(Time),
    /// The only one strictly within this.
    Within(Part),
}

impl Root {
    /// The sign of another polynomial at this root.
    pub fn sign_of(&mut self, other: &Polynomial) -> Ordering {
        // Each is cheaper than to look at the other polynomial again.
        const HALVINGS: u32 = 8;
        let mut common = None;
        loop {
            let part = match &self.place {
                Place::At(time) => return other.sign_at(time),
                Place::Within(part) => part,
            };
            let within = other.within(part);
            if within.sign_changes() == 0 {
                return within.first_sign();
            }
            // It divides ours, which has one simple root here.
            let common = common.get_or_insert_with(|| self.polynomial.common(other));
            if common.within(part).sign_changes() % 2 == 1 {
                return Ordering::Equal;
            }
            (0..HALVINGS).for_each(|_| self.halve());
        }
    }

    fn halve(&mut self) {
        let Place::Within(part) = &self.place else { return };
        let [left, right] = part.halves();
        self.place = match self.polynomial.sign_at(&right.from) {
            Ordering::Equal => Place::At(right.from),
            sign if sign == self.sign_before => Place::Within(right),
            _ => Place::Within(left),
        };
    }

    /// Finds it as closely as that, or 2^-53.
    pub fn refine(&mut self, tolerance: f64) {
        while let [from, to] = self.bounds()
            && to - from > tolerance.max(f64::EPSILON / 2.0)
        {
            self.halve();
        }
    }

    /// An interval that contains it.
    pub fn bounds(&self) -> [f64; 2] {
        match &self.place {
            // A time with more digits than an f64 lies between two of them.
            Place::At(time) if time.halvings <= f64::MANTISSA_DIGITS => [time.to_f64(); 2],
            Place::At(from) | Place::Within(Part { from }) => {
                let from_below = from.to_f64();
                let to = from.next().to_f64();
                let exact = from.halvings <= f64::MANTISSA_DIGITS;
                [from_below, if exact { to } else { from_below + f64::EPSILON / 2.0 }]
            }
        }
    }
}

fn sign(integer: &BigInt) -> Ordering {
    integer.cmp(&BigInt::ZERO)
}

impl Mul for &Polynomial {
    type Output = Polynomial;

    fn mul(self, other: Self) -> Polynomial {
        let mut product = vec![BigInt::ZERO; self.0.len() + other.0.len() - 1];
        for (i, a) in self.0.iter().enumerate() {
            for (c, b) in product[i..].iter_mut().zip(&other.0) {
                *c += a * b;
            }
        }
        Polynomial(product)
    }
}

/// Of the same degree.
impl Add for &Polynomial {
    type Output = Polynomial;

    fn add(self, other: Self) -> Polynomial {
        Polynomial(self.0.iter().zip(&other.0).map(|(a, b)| a + b).collect())
    }
}

/// Of the same degree.
impl Sub for &Polynomial {
    type Output = Polynomial;

    fn sub(self, other: Self) -> Polynomial {
        Polynomial(self.0.iter().zip(&other.0).map(|(a, b)| a - b).collect())
    }
}
