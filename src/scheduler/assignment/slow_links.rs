//! Nodes behind links of any speed, in a little simulation of its own: a link sends what tasks need in
//! their order, a worker answers scenario after scenario, a worker that dies is replaced or not.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::time::Duration;

use proptest::prelude::*;

use super::super::local_client::Buffered;
use super::super::pace::Nanoseconds;
use super::*;
use crate::scene::MatchRule;

#[derive(Clone, Debug)]
struct World {
    /// Of a subtree over the link of each node; of the first nothing, as it is the master's.
    link: Vec<Nanoseconds>,
    /// The node of each worker, and what a scenario takes there.
    workers: Vec<(usize, Nanoseconds)>,
    scenarios: u32,
    /// Scenario s needs the fixed tree's subtree s, modulo so many.
    subtrees: u32,
    q: u32,
    rule: MatchRule,
    holds_back: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Event {
    /// Of the worker that came there as so many others had died.
    Answers {
        client: usize,
        life: u32,
        task: u64,
        scenario: u32,
        is_last: bool,
    },
    Dies(usize),
    Comes(usize),
}

struct Running {
    world: World,
    assignment: Assignment,
    now: Nanoseconds,
    events: BinaryHeap<Reverse<(Nanoseconds, Event)>>,
    link_free: Vec<Nanoseconds>,
    worker_free: Vec<Nanoseconds>,
    lives: Vec<u32>,
    answers: Vec<u32>,
    /// Nodes of which a task was answered.
    is_known: Vec<bool>,
}

impl Running {
    fn new(world: World) -> Self {
        let of: Vec<_> = world.workers.iter().map(|&(node, _)| node).collect();
        let mut clients: Vec<_> = of.iter().map(|_| LocalClient::default()).collect();
        clients.iter_mut().for_each(|client| client.ready().unwrap());
        let mut nodes = Nodes::shared(of);
        nodes.all_mut()[0].give_all([world.subtrees as usize, 0]);
        let limits = BufferLimits { scenarios: world.q, bytes: u64::MAX };
        let matchmaker = Matchmaker::new(world.rule, world.q as usize, 1);
        let bytes = [vec![1; world.subtrees as usize], Vec::new()];
        let has_link = |node: usize| world.holds_back && node > 0;
        let assignment =
            Assignment::new(clients, nodes, world.scenarios, limits, matchmaker, bytes)
                .holding_back(has_link);
        Self {
            assignment,
            now: 0,
            events: BinaryHeap::new(),
            link_free: vec![0; world.link.len()],
            worker_free: vec![0; world.workers.len()],
            lives: vec![0; world.workers.len()],
            answers: vec![0; world.scenarios as usize],
            is_known: vec![false; world.link.len()],
            world,
        }
    }

    fn give_work(&mut self) {
        self.assignment.now_is(Duration::from_nanos(self.now));
        while let Some(scenario) = self.assignment.next_scenario() {
            if !self.assignment.can_assign() {
                break;
            }
            let root = [(scenario % self.world.subtrees, 1)];
            let indicators = [TreeIndicator::of(root.into_iter()), TreeIndicator::default()];
            let analysis = Analysis { indicators, root_pairs: Vec::new() };
            self.assignment.assign(scenario, analysis).expect("somebody takes it");
            self.send_tasks();
        }
        self.send_tasks();
    }

    fn send_tasks(&mut self) {
        while let Some((client, task)) = self.assignment.take_task() {
            let (node, work) = self.world.workers[client];
            let link = &mut self.link_free[node];
            *link = self.now.max(*link) + task.subtrees[0].len() as u64 * self.world.link[node];
            let free = &mut self.worker_free[client];
            *free = (*free).max(*link);
            let last = task.batch.last().expect("no task is empty").scenario;
            for Buffered { scenario, .. } in &task.batch {
                *free += work;
                let (life, task, is_last) = (self.lives[client], task.number, *scenario == last);
                let answers = Event::Answers { client, life, task, scenario: *scenario, is_last };
                self.events.push(Reverse((*free, answers)));
            }
        }
    }

    fn happens(&mut self, event: Event) {
        match event {
            Event::Answers { client, life, task, scenario, is_last } => {
                if self.lives[client] != life {
                    return;
                }
                self.answers[scenario as usize] += 1;
                self.assignment.change(client, |state| state.answered(task, scenario)).unwrap();
                if is_last {
                    self.is_known[self.world.workers[client].0] = true;
                    self.assignment.change(client, |state| state.end_task(task)).unwrap();
                }
            }
            Event::Dies(client) if self.assignment.clients()[client].is_alive() => {
                self.lives[client] += 1;
                assert_eq!(self.assignment.client_died(client, None), None);
            }
            Event::Comes(client) if !self.assignment.clients()[client].is_alive() => {
                self.worker_free[client] = self.now;
                self.assignment.restart(client);
                self.assignment.change(client, LocalClient::ready).unwrap();
            }
            Event::Dies(_) | Event::Comes(_) => {}
        }
        let delivered = self.answers.iter().take_while(|&&count| count == 1).count();
        self.assignment.delivered(delivered as u32);
    }

    /// Up to the last answer, which comes as long as somebody lives.
    fn run(mut self) -> Nanoseconds {
        self.give_work();
        let mut last = 0;
        while let Some(Reverse((at, event))) = self.events.pop() {
            self.now = at;
            self.assignment.now_is(Duration::from_nanos(at));
            let before: u32 = self.answers.iter().sum();
            self.happens(event);
            if self.answers.iter().sum::<u32>() > before {
                last = at;
            }
            self.give_work();
            if self.world.holds_back {
                self.nobody_is_given_more_than_the_trial_of_an_unknown_link();
            }
        }
        if self.assignment.is_anyone_alive() {
            assert!(self.answers.iter().all(|&count| count == 1), "{:?}", self.answers);
        }
        last
    }

    /// Nothing has come back over it.
    fn nobody_is_given_more_than_the_trial_of_an_unknown_link(&self) {
        for node in (1..self.is_known.len()).filter(|&node| !self.is_known[node]) {
            let clients = self.assignment.clients().iter().zip(&self.world.workers);
            let of_node = clients.filter(|(_, worker)| worker.0 == node);
            let given: usize = of_node.map(|(client, _)| client.unanswered()).sum();
            assert!(given <= 1, "{given} scenarios");
        }
    }
}

fn any_world() -> impl Strategy<Value = World> {
    let link = prop::sample::select(vec![0, 1_000, 1_000_000, 1_000_000_000]);
    let links = prop::collection::vec(link, 1..4);
    let work = prop::collection::vec(1_000_u64..2_000_000, 4..9);
    let rules = prop::sample::select(MatchRule::ALL.to_vec());
    let numbers = (1_u32..400, 1_u32..60, 1_u32..21);
    (links, work, numbers, rules).prop_map(|(links, work, numbers, rule)| {
        let (scenarios, subtrees, q) = numbers;
        let link: Vec<_> = [0].into_iter().chain(links).collect();
        let nodes = link.len();
        let workers = work.iter().enumerate().map(|(n, &work)| (n % nodes, work)).collect();
        World { link, workers, scenarios, subtrees, q, rule, holds_back: true }
    })
}

/// The master's node and one behind a link, all of whose workers are equally fast.
#[derive(Clone, Debug)]
struct Pair {
    near: usize,
    far: usize,
    work: Nanoseconds,
    scenarios: u32,
    q: u32,
    rule: MatchRule,
}

impl Pair {
    /// With the other node behind such a link, or without it.
    fn run(&self, link: Option<Nanoseconds>) -> Nanoseconds {
        let far = if link.is_some() { self.far } else { 0 };
        let mut running = Running::new(World {
            link: [0].into_iter().chain(link).collect(),
            workers: [vec![(0, self.work); self.near], vec![(1, self.work); far]].concat(),
            scenarios: self.scenarios,
            // None is needed twice.
            subtrees: self.scenarios,
            q: self.q,
            rule: self.rule,
            holds_back: true,
        });
        // However many results wait for the one that comes over the link.
        running.assignment.ahead = u32::MAX;
        running.run()
    }
}

fn any_pair_of_nodes() -> impl Strategy<Value = Pair> {
    let workers = (1_usize..4, 1_usize..4);
    let numbers = (100_000_u64..2_000_000, 100_u32..600, 1_u32..21);
    let rules = prop::sample::select(MatchRule::ALL.to_vec());
    (workers, numbers, rules).prop_map(|((near, far), (work, scenarios, q), rule)| Pair {
        near,
        far,
        work,
        scenarios,
        q,
        rule,
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_scenario_is_answered_once_whoever_is_held_dies_or_comes(
        world in any_world(),
        turns in prop::collection::vec((0_u64..300_000_000, 0_usize..9, any::<bool>()), 0..30),
    ) {
        let clients = world.workers.len();
        let mut running = Running::new(world);
        for (at, client, dies) in turns {
            let client = client % clients;
            let turn = if dies { Event::Dies(client) } else { Event::Comes(client) };
            running.events.push(Reverse((at, turn)));
        }
        running.run();
    }

    /// One scenario over it is what it costs to find that out.
    #[test]
    fn a_link_that_is_worth_nothing_costs_one_scenario_over_it_at_most(
        pair in any_pair_of_nodes(),
        times in 1.0_f64..100.0,
    ) {
        let alone = pair.run(None);
        let link = (alone as f64 * times) as Nanoseconds;
        let both = pair.run(Some(link));
        prop_assert!(both <= alone + link + pair.work, "{both} ns, and {alone} without the other node");
    }

    /// What is expected of a link after few scenarios is not quite what comes.
    #[test]
    fn no_link_makes_a_run_longer_by_much_more_than_one_scenario_over_it(
        pair in any_pair_of_nodes(),
        link in (4.0_f64..10.0).prop_map(|digits| 10_f64.powf(digits) as Nanoseconds),
    ) {
        let [alone, both] = [pair.run(None), pair.run(Some(link))];
        let most = alone / 4 * 5 + link + pair.work;
        prop_assert!(both <= most, "{both} ns, and {alone} without the other node");
    }
}

#[test]
fn without_holding_back_a_slow_link_takes_as_long_as_full_buffers_do() {
    let world = |holds_back| World {
        link: vec![0, 1_000_000_000],
        workers: vec![(0, 1_000_000), (1, 1_000_000)],
        scenarios: 1000,
        subtrees: 1000,
        q: 20,
        rule: MatchRule::Best,
        holds_back,
    };
    assert!(Running::new(world(false)).run() > 20_000_000_000);
    assert!(Running::new(world(true)).run() < 2_000_000_000);
}
