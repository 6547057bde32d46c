//! Finds a client for a scenario (section 6.5 of the paper), by one of the rules that its
//! evaluation compares (section 7).

use crate::scene::MatchRule;
use crate::scene::random::Draw;

/// An unclaimed client, as the matchmaker sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Candidate {
    pub client: usize,
    /// Sum of products of the scenario's and the client's vectors, over both trees.
    pub score: u64,
    /// Scenarios in its buffer, less than what fills it.
    pub load: usize,
}

#[derive(Debug)]
pub struct Matchmaker {
    rule: MatchRule,
    /// q: scenarios that fill a buffer.
    full: usize,
    draw: Draw,
}

impl Matchmaker {
    /// `seed` matters to [`MatchRule::Random`] alone.
    pub fn new(rule: MatchRule, full: usize, seed: u64) -> Self {
        Self { rule, full, draw: Draw::of_scenario(seed, u32::MAX) }
    }

    pub fn rule(&self) -> MatchRule {
        self.rule
    }

    /// `None` if there are no candidates.
    pub fn pick(&mut self, candidates: &[Candidate]) -> Option<usize> {
        let by_load = |c: &&Candidate| (c.load, c.client);
        let best = |value: &dyn Fn(&Candidate) -> u128| {
            candidates.iter().min_by_key(|c| (std::cmp::Reverse(value(c)), by_load(c)))
        };
        let chosen = match self.rule {
            MatchRule::Best => best(&|c| c.score.into()),
            MatchRule::Lowest => best(&|c| u128::MAX - u128::from(c.score)),
            MatchRule::BestLoad => {
                // score (1 - load / q), in whole numbers.
                best(&|c| u128::from(c.score) * self.full.saturating_sub(c.load) as u128)
            }
            MatchRule::Random => match candidates.len() as u64 {
                0 => None,
                count => candidates.get(self.draw.below(count) as usize),
            },
        };
        chosen.map(|candidate| candidate.client)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of (score, load), with q = 20.
    fn pick(rule: MatchRule, candidates: &[(u64, usize)]) -> Option<usize> {
        let with_index = candidates.iter().enumerate();
        let candidates: Vec<_> =
            with_index.map(|(client, &(score, load))| Candidate { client, score, load }).collect();
        Matchmaker::new(rule, 20, 1).pick(&candidates)
    }

    #[test]
    fn nobody_is_picked_where_nobody_is() {
        for rule in MatchRule::ALL {
            assert_eq!(pick(rule, &[]), None);
        }
    }

    #[test]
    fn the_best_match_has_the_highest_score_and_ties_go_by_load_then_index() {
        assert_eq!(pick(MatchRule::Best, &[(3, 0), (9, 19), (4, 0)]), Some(1));
        assert_eq!(pick(MatchRule::Best, &[(9, 5), (9, 4), (9, 6)]), Some(1));
        assert_eq!(pick(MatchRule::Best, &[(0, 2), (0, 2)]), Some(0));
    }

    #[test]
    fn the_lowest_match_has_the_lowest_score_and_ties_go_by_load_then_index() {
        assert_eq!(pick(MatchRule::Lowest, &[(3, 0), (9, 19), (2, 9)]), Some(2));
        assert_eq!(pick(MatchRule::Lowest, &[(9, 5), (9, 4), (9, 6)]), Some(1));
        assert_eq!(pick(MatchRule::Lowest, &[(0, 2), (0, 2)]), Some(0));
    }

    #[test]
    fn a_full_client_is_passed_over_for_an_emptier_one_that_matches_nearly_as_well() {
        let candidates = [(100, 15), (90, 5)];
        assert_eq!(pick(MatchRule::Best, &candidates), Some(0));
        assert_eq!(pick(MatchRule::BestLoad, &candidates), Some(1));
        assert_eq!(pick(MatchRule::BestLoad, &[(1000, 15), (90, 5)]), Some(0));
        assert_eq!(pick(MatchRule::BestLoad, &[(u64::MAX, 0), (u64::MAX, 1)]), Some(0));
    }

    #[test]
    fn the_random_match_repeats_with_its_seed_and_takes_everybody_about_equally_often() {
        let candidates =
            [0, 1, 2].map(|client| Candidate { client, score: 9 - client as u64, load: 0 });
        let run = |seed| {
            let mut matchmaker = Matchmaker::new(MatchRule::Random, 20, seed);
            (0..3000).map(|_| matchmaker.pick(&candidates).unwrap()).collect::<Vec<_>>()
        };
        assert_eq!(run(7), run(7));
        assert_ne!(run(7), run(8));
        for client in 0..3 {
            let count = run(7).iter().filter(|&&picked| picked == client).count();
            assert!((900..1100).contains(&count), "client {client} was picked {count} times");
        }
    }
}
