//! Finds the client that suits a scenario best (section 6.5 of the paper).

/// An unclaimed client, as the matchmaker sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Candidate {
    pub client: usize,
    /// Sum of products of the scenario's and the client's vectors, over both trees.
    pub score: u64,
    /// Scenarios in its buffer.
    pub load: usize,
}

/// The highest score; ties go to the smaller load, then to the first, so that runs repeat.
pub fn best_match(candidates: impl Iterator<Item = Candidate>) -> Option<usize> {
    let rank = |c: &Candidate| (std::cmp::Reverse(c.score), c.load, c.client);
    candidates.min_by_key(rank).map(|candidate| candidate.client)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn best(candidates: &[(u64, usize)]) -> Option<usize> {
        let with_index = candidates.iter().enumerate();
        best_match(with_index.map(|(client, &(score, load))| Candidate { client, score, load }))
    }

    #[test]
    fn the_highest_score_wins_and_ties_go_by_load_then_index() {
        assert_eq!(best(&[]), None);
        assert_eq!(best(&[(3, 0), (9, 19), (4, 0)]), Some(1));
        assert_eq!(best(&[(9, 5), (9, 4), (9, 6)]), Some(1));
        assert_eq!(best(&[(0, 2), (0, 2)]), Some(0));
    }
}
