//! Finds a client for a scenario (section 6.5 of the paper), by one of the rules that its
//! evaluation compares (section 7).

use super::takers::Takers;
use crate::scene::MatchRule;
use crate::scene::random::Draw;

/// Who gets a scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    pub client: usize,
    /// Nodes whose score had to be known.
    pub scored: usize,
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

    /// `None` if there are no takers. `score` is of a client: the sum of products of the scenario's and
    /// its node's vectors, over both trees, which is `highest` at most.
    ///
    /// Of equals the emptiest buffer is chosen, then the lowest number. So clients are looked at in that
    /// order, and as soon as no other can be worth more, the choice is made.
    pub fn pick(
        &mut self,
        takers: &Takers,
        highest: u64,
        score: impl Fn(usize) -> u64,
    ) -> Option<Choice> {
        if self.rule == MatchRule::Random {
            let nth = self.draw.below(takers.count().max(1) as u64);
            return takers.nth(nth as usize).map(|client| Choice { client, scored: 0 });
        }
        let ideal = if self.rule == MatchRule::Lowest { 0 } else { highest };
        let (mut best, mut scored) = (None, 0);
        for (load, client) in takers.emptiest() {
            if best.is_some_and(|(most, _)| most >= self.worth(ideal, load)) {
                break;
            }
            let worth = self.worth(score(client), load);
            scored += 1;
            if best.is_none_or(|(most, _)| worth > most) {
                best = Some((worth, client));
            }
        }
        best.map(|(_, client)| Choice { client, scored })
    }

    /// Of a client by its score and by the scenarios in its buffer. It never grows with the latter.
    fn worth(&self, score: u64, load: usize) -> u128 {
        match self.rule {
            MatchRule::Best => score.into(),
            MatchRule::Lowest => u128::MAX - u128::from(score),
            // score (1 - load / q), in whole numbers.
            MatchRule::BestLoad => u128::from(score) * self.full.saturating_sub(load) as u128,
            MatchRule::Random => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::takers::{Standing, Unclaimed};
    use super::*;

    /// Clients with so much in their buffers, each on the node of this number.
    fn unclaimed(clients: &[(usize, usize)]) -> Unclaimed {
        let mut unclaimed = Unclaimed::new(clients.len(), clients.len());
        for (client, &(node, load)) in clients.iter().enumerate() {
            unclaimed.file(client, node, Some(Standing { tasks: 0, load }));
        }
        unclaimed
    }

    /// Of (score, load), with q = 20.
    fn pick(rule: MatchRule, candidates: &[(u64, usize)]) -> Option<usize> {
        let of_node = candidates.iter().enumerate().map(|(n, &(_, load))| (n, load));
        let unclaimed = unclaimed(&of_node.collect::<Vec<_>>());
        let highest = candidates.iter().map(|&(score, _)| score).max()?;
        let choice = Matchmaker::new(rule, 20, 1)
            .pick(unclaimed.takers()?, highest, |client| candidates[client].0);
        choice.map(|choice| choice.client)
    }

    /// A look at every client, of (score, load), in the order of their numbers.
    fn plain(rule: MatchRule, q: usize, draw: &mut Draw, clients: &[(u64, usize)]) -> usize {
        let best = |value: &dyn Fn(u64, usize) -> u128| {
            let by = |&n: &usize| {
                let (score, load) = clients[n];
                (std::cmp::Reverse(value(score, load)), load, n)
            };
            (0..clients.len()).min_by_key(by).unwrap()
        };
        match rule {
            MatchRule::Best => best(&|score, _| score.into()),
            MatchRule::Lowest => best(&|score, _| u128::MAX - u128::from(score)),
            MatchRule::BestLoad => {
                best(&|score, load| u128::from(score) * q.saturating_sub(load) as u128)
            }
            MatchRule::Random => draw.below(clients.len() as u64) as usize,
        }
    }

    proptest! {
        #[test]
        fn the_choice_is_that_of_a_look_at_every_client(
            rule in prop::sample::select(MatchRule::ALL.to_vec()),
            q in 1_usize..5,
            scores in prop::collection::vec(0_u64..6, 1..20),
            more in 0_u64..3,
            clients in prop::collection::vec((0_usize..20, 0_usize..6), 20..60),
            seed in any::<u64>(),
        ) {
            let clients: Vec<_> =
                clients.iter().map(|&(node, load)| (node % scores.len(), load)).collect();
            let seen: Vec<_> = clients.iter().map(|&(node, load)| (scores[node], load)).collect();
            let unclaimed = unclaimed(&clients);
            // Nobody need have all.
            let highest = scores.iter().max().unwrap() + more;
            let mut matchmaker = Matchmaker::new(rule, q, seed);
            let mut draw = Draw::of_scenario(seed, u32::MAX);
            for _ in 0..3 {
                let takers = unclaimed.takers().unwrap();
                let choice = matchmaker.pick(takers, highest, |client| seen[client].0).unwrap();
                prop_assert_eq!(choice.client, plain(rule, q, &mut draw, &seen));
                prop_assert!(choice.scored <= scores.len());
            }
        }
    }

    #[test]
    fn who_has_all_is_chosen_without_a_look_at_fuller_buffers() {
        let unclaimed = unclaimed(&[(0, 3), (1, 1), (2, 2), (3, 0)]);
        let pick = |scores: [u64; 4]| {
            let mut matchmaker = Matchmaker::new(MatchRule::Best, 20, 1);
            matchmaker.pick(unclaimed.takers().unwrap(), 9, |client| scores[client]).unwrap()
        };
        assert_eq!(pick([9, 9, 9, 8]), Choice { client: 1, scored: 2 });
        assert_eq!(pick([8, 8, 8, 8]), Choice { client: 3, scored: 4 });
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
        let unclaimed = unclaimed(&[(0, 0), (1, 0), (2, 0)]);
        let run = |seed| {
            let mut matchmaker = Matchmaker::new(MatchRule::Random, 20, seed);
            let mut pick = || matchmaker.pick(unclaimed.takers().unwrap(), 9, |_| 0).unwrap();
            (0..3000).map(|_| pick().client).collect::<Vec<_>>()
        };
        assert_eq!(run(7), run(7));
        assert_ne!(run(7), run(8));
        for client in 0..3 {
            let count = run(7).iter().filter(|&&picked| picked == client).count();
            assert!((900..1100).contains(&count), "client {client} was picked {count} times");
        }
    }
}
