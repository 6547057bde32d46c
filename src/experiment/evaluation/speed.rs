//! How fast a cluster of unequal cores is, and how fast it could be (section 7.1 of the paper).

/// Cores of one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cores {
    pub count: u32,
    /// That one of them takes for all scenarios, alone.
    pub serial_s: f64,
}

/// (n1 t1 + n2 t2) / (n1 + n2): what a speedup is over.
pub fn weighted_serial_s(cores: &[Cores]) -> f64 {
    let total: f64 = cores.iter().map(|kind| f64::from(kind.count) * kind.serial_s).sum();
    total / cores.iter().map(|kind| f64::from(kind.count)).sum::<f64>()
}

/// n1 + n2 t1 / t2: how many cores that take `serial_s` these are worth.
pub fn best_possible(serial_s: f64, cores: &[Cores]) -> f64 {
    cores.iter().map(|kind| f64::from(kind.count) * serial_s / kind.serial_s).sum()
}

/// What is shown of the samples of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// The paper's: "each result represents an average of three samples" (section 7).
    pub mean: f64,
    pub least: f64,
    pub most: f64,
}

impl Spread {
    /// `None` without samples.
    pub fn of(samples: &[f64]) -> Option<Self> {
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        let least = samples.iter().copied().reduce(f64::min)?;
        let most = samples.iter().copied().reduce(f64::max)?;
        Some(Self { mean, least, most })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Those of the paper's cluster.
    fn cluster(count: [u32; 2], serial_s: [f64; 2]) -> [Cores; 2] {
        [0, 1].map(|kind| Cores { count: count[kind], serial_s: serial_s[kind] })
    }

    #[test]
    fn serial_times_are_weighted_as_in_tables_2_and_3() {
        let rows = [
            ([281.0, 452.0], 330.0),
            ([597.0, 953.0], 698.0),
            ([1313.0, 2091.0], 1535.0),
            ([1961.0, 3127.0], 2294.0),
            ([2679.0, 4268.0], 3133.0),
            ([326.0, 532.0], 385.0),
            ([642.0, 1045.0], 757.0),
            ([969.0, 1580.0], 1144.0),
            ([1308.0, 2132.0], 1544.0),
            ([1618.0, 2636.0], 1909.0),
        ];
        for (serial_s, weighted) in rows {
            let ours = weighted_serial_s(&cluster([20, 8], serial_s));
            assert!((ours - weighted).abs() < 1.0, "{ours} where the paper has {weighted}");
        }
    }

    #[test]
    fn the_bound_is_that_of_table_4() {
        for (count, weighted) in
            [([12, 0], 12.0), ([16, 0], 16.0), ([16, 6], 19.8), ([20, 8], 25.0)]
        {
            let ours = best_possible(2679.0, &cluster(count, [2679.0, 4268.0]));
            assert_eq!(format!("{ours:.1}"), format!("{weighted:.1}"));
        }
    }

    #[test]
    fn a_point_is_the_mean_between_the_least_and_the_most() {
        let spread = Spread::of(&[3.0, 1.0, 5.0]).unwrap();
        assert_eq!(spread, Spread { mean: 3.0, least: 1.0, most: 5.0 });
        assert_eq!(Spread::of(&[]), None);
    }
}
