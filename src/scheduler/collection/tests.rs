use super::*;
use crate::mesh::TriangleMesh;
use crate::scene::MatchRule;
use crate::scheduler::assignment::BufferLimits;
use crate::scheduler::local_client::{Analysis, LocalClient, SubtreeBytes};
use crate::scheduler::matchmaker::Matchmaker;
use crate::scheduler::node::Nodes;
use crate::tree::{Accuracy, BuildOptions, TreeImage, TreeKind, build};
use crate::wire::ReplyHeader;

const NOTHING: Wanted =
    Wanted { accuracy: Accuracy::EXACT, overlap_only: false, pairs: 0, costs: false, plan: None };
const PAIRS: Wanted = Wanted { pairs: Wanted::ALL_PAIRS, ..NOTHING };
/// Numbers of the trees.
const TREES: [u32; 2] = [7, 8];

/// Of ten triangles.
fn tree() -> TreeImage {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].to_vec();
    let mesh = TriangleMesh::new(corners, vec![[0, 1, 2]; 10]).unwrap();
    build(&mesh, BuildOptions { kind: TreeKind::Obb })
}

const NO_SUBTREES: SubtreeBytes = [Vec::new(), Vec::new()];

/// Two clients; scenarios 0 and 1 are task 0 of the first, 2 and 3 task 1 of the second.
fn two_tasks(wanted: Wanted) -> (Collection, Assignment) {
    let clients = vec![LocalClient::default(), LocalClient::default()];
    let limits = BufferLimits { scenarios: 2, bytes: u64::MAX };
    let matchmaker = Matchmaker::new(MatchRule::Best, 2, 0);
    let mut assignment =
        Assignment::new(clients, Nodes::private(2), 100, limits, matchmaker, NO_SUBTREES);
    let tree = tree();
    let views = [tree.view(), tree.view()];
    let mut collection = Collection::new(2, TREES, views, wanted, Layout::default());
    for client in [0, 1] {
        let ready = parts::<u8>(&ReplyHeader::ready(), &[]);
        assert_eq!(collection.take(client, &ready, &mut assignment), Ok(Said::Ready));
        for _ in 0..2 {
            let scenario = assignment.next_scenario().unwrap();
            assert_eq!(
                assignment.assign(scenario, Analysis::default()).map(|choice| choice.client),
                Some(client)
            );
        }
        assert_eq!(assignment.take_task().unwrap().0, client);
    }
    (collection, assignment)
}

fn parts<R: bytemuck::NoUninit>(header: &ReplyHeader, records: &[R]) -> Vec<u8> {
    [bytemuck::bytes_of(header), bytemuck::cast_slice(records)].concat()
}

/// Each record brings `words_here` pairs (scenario, running number).
fn reply(task: u64, last: bool, records: &[AnswerRecord]) -> Vec<u8> {
    let pairs: Vec<Pair> = records
        .iter()
        .flat_map(|r| (r.first_word..r.first_word + r.words_here).map(|n| [r.scenario, n]))
        .collect();
    let header = ReplyHeader::answers(task, records.len() as u32, pairs.len() as u32, last);
    [parts(&header, records), bytemuck::cast_slice(&pairs).to_vec()].concat()
}

fn part(scenario: u32, count: u32, first: u32, here: u32) -> AnswerRecord {
    let pairs: Vec<Pair> = (0..count).map(|n| [scenario, n]).collect();
    let mut record = AnswerRecord::answered(scenario, count, pairs_fnv1a64(&pairs), 8);
    record.words = if here == 0 && first == 0 { 0 } else { count };
    (record.first_word, record.words_here) = (first, here);
    record
}

#[test]
fn pairs_that_come_in_parts_are_joined() {
    let (mut collection, mut assignment) = two_tasks(PAIRS);
    let mut take = |client, message: &[u8]| collection.take(client, message, &mut assignment);
    take(0, &reply(0, false, &[part(0, 1, 0, 1), part(1, 5, 0, 2)])).unwrap();
    take(1, &reply(1, true, &[part(2, 0, 0, 0), part(3, 1, 0, 1)])).unwrap();
    take(0, &reply(0, false, &[part(1, 5, 2, 1)])).unwrap();
    take(0, &reply(0, true, &[part(1, 5, 3, 2)])).unwrap();
    let delivered: Vec<_> = std::iter::from_fn(|| collection.pop()).collect();
    let counts: Vec<_> = delivered
        .iter()
        .map(|(scenario, outcome)| match outcome {
            Outcome::Answered { client, pairs, .. } => (*scenario, *client, pairs.len()),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(counts, [(0, 0, 1), (1, 0, 5), (2, 1, 0), (3, 1, 1)]);
}

#[test]
fn a_dead_clients_parts_are_forgotten_and_its_scenario_answered_anew() {
    let (mut collection, mut assignment) = two_tasks(PAIRS);
    collection.take(0, &reply(0, false, &[part(0, 4, 0, 3)]), &mut assignment).unwrap();
    assignment.client_died(0, None);
    collection.client_died(0);
    assert_eq!(assignment.next_scenario(), Some(0));
    for scenario in [0, 1] {
        assert_eq!(
            assignment.assign(scenario, Analysis::default()).map(|choice| choice.client),
            Some(1)
        );
    }
    let (client, task) = assignment.take_task().unwrap();
    assert_eq!((client, task.number), (1, 2));
    collection
        .take(1, &reply(1, true, &[part(2, 0, 0, 0), part(3, 0, 0, 0)]), &mut assignment)
        .unwrap();
    let answers = [part(0, 4, 0, 4), part(1, 0, 0, 0)];
    collection.take(1, &reply(2, true, &answers), &mut assignment).unwrap();
    assert_eq!(std::iter::from_fn(|| collection.pop()).count(), 4);
}

#[test]
fn an_overflow_ends_the_giving_out_and_comes_in_its_turn() {
    let (mut collection, mut assignment) = two_tasks(NOTHING);
    let overflow = [part(2, 1, 0, 0), AnswerRecord::overflow(3, (9, 1), 0)];
    collection.take(1, &reply(1, true, &overflow), &mut assignment).unwrap();
    assert_eq!(assignment.next_scenario(), None);
    assert_eq!(collection.pop(), None);
    let answers = [part(0, 1, 0, 0), part(1, 1, 0, 0)];
    collection.take(0, &reply(0, true, &answers), &mut assignment).unwrap();
    let last = std::iter::from_fn(|| collection.pop()).last();
    assert_eq!(last, Some((3, Outcome::Overflow { triangle: 9, corner: 1 })));
}

#[test]
fn replies_that_nobody_asked_for_are_refused() {
    let refusal = |message: &[u8]| {
        let (mut collection, mut assignment) = two_tasks(PAIRS);
        collection.take(0, message, &mut assignment).unwrap_err()
    };
    assert!(matches!(refusal(&[0; 8]), BadReply::Wire(_)));
    let other_tree = TreeRecord::new(TREES[1], 1);
    assert_eq!(refusal(&parts(&ReplyHeader::tree(), &[other_tree])), BadReply::Tree(TREES[1]));
    let lacking = parts(&ReplyHeader::not_fetched(), &[SubtreeRecord { tree: 3, root: 0 }]);
    assert_eq!(refusal(&lacking), BadReply::UnknownTree(3));
    let ready_again = refusal(&parts::<u8>(&ReplyHeader::ready(), &[]));
    assert_eq!(ready_again, BadReply::Unexpected(Unexpected::Ready));
    let not_given = refusal(&reply(0, false, &[part(2, 0, 0, 0)]));
    assert_eq!(not_given, BadReply::Unexpected(Unexpected::Scenario(2)));
    let others_task = refusal(&reply(1, false, &[part(2, 0, 0, 0)]));
    assert!(matches!(others_task, BadReply::Unexpected(Unexpected::Task { found: 1, .. })));
    let unfinished = refusal(&reply(0, true, &[part(0, 0, 0, 0)]));
    assert!(matches!(unfinished, BadReply::Unexpected(Unexpected::Unanswered { .. })));
    assert_eq!(refusal(&reply(0, false, &[part(0, 3, 1, 2)])), BadReply::Pairs(0));
    let interleaved = [part(0, 3, 0, 2), part(1, 3, 0, 3)];
    assert_eq!(refusal(&reply(0, false, &interleaved)), BadReply::Pairs(1));
    assert_eq!(refusal(&reply(0, false, &[part(0, 11, 0, 11)])), BadReply::WrongPairs(0));
    let mut wrong_hash = part(0, 3, 0, 3);
    wrong_hash.pairs_fnv1a64 ^= 1;
    assert_eq!(refusal(&reply(0, false, &[wrong_hash])), BadReply::Hash(0));
    let mut twice = reply(0, false, &[part(0, 2, 0, 2)]);
    let last_pair = twice.len() - size_of::<Pair>();
    twice.copy_within(last_pair - size_of::<Pair>()..last_pair, last_pair);
    assert_eq!(refusal(&twice), BadReply::WrongPairs(0));
}

#[test]
fn trees_of_the_run_and_of_earlier_runs_are_taken_note_of() {
    let (mut collection, mut assignment) = two_tasks(PAIRS);
    for (tree, hash) in [(TREES[0], tree().view().hash()), (3, 77)] {
        let message = parts(&ReplyHeader::tree(), &[TreeRecord::new(tree, hash)]);
        assert_eq!(collection.take(0, &message, &mut assignment), Ok(Said::Tree));
    }
}

#[test]
fn what_workers_say_of_subtrees_is_passed_on_by_the_side_of_the_tree() {
    let (mut collection, mut assignment) = two_tasks(NOTHING);
    let record = SubtreeRecord { tree: TREES[1], root: 5 };
    let lacking = parts(&ReplyHeader::not_fetched(), &[record]);
    let said = collection.take(0, &lacking, &mut assignment);
    assert_eq!(said, Ok(Said::NotFetched { tree: 1, root: 5 }));
    let name = PeerName::from_bytes([3; PeerName::BYTES]);
    let serves = parts(&ReplyHeader::serves(), &[name.to_bytes()]);
    assert_eq!(collection.take(0, &serves, &mut assignment), Ok(Said::Serves(name)));
}

#[test]
fn a_scenario_that_is_set_aside_comes_in_its_turn() {
    let (mut collection, mut assignment) = two_tasks(NOTHING);
    collection.set_aside(1);
    assert_eq!(collection.pop(), None);
    collection.take(0, &reply(0, false, &[part(0, 1, 0, 0)]), &mut assignment).unwrap();
    let delivered: Vec<_> = std::iter::from_fn(|| collection.pop()).collect();
    assert_eq!(delivered[1], (1, Outcome::SetAside));
}

#[test]
fn pairs_that_nobody_asked_for_are_refused() {
    let (mut collection, mut assignment) = two_tasks(NOTHING);
    let refused = collection.take(0, &reply(0, false, &[part(0, 1, 0, 1)]), &mut assignment);
    assert_eq!(refused, Err(BadReply::Effects { scenario: 0, source: NotLaidOut }));
}

#[test]
fn costs_come_if_and_only_if_they_were_asked_for() {
    let wanted = Wanted { costs: true, ..NOTHING };
    let cost = CostRecord { descent_ns: 7, ..Default::default() };
    let header = ReplyHeader::answers(0, 1, 0, false).with_costs(true);
    let costly = [parts(&header, &[part(0, 1, 0, 0)]), bytemuck::bytes_of(&cost).to_vec()];
    let (costly, plain) = (costly.concat(), reply(0, false, &[part(0, 1, 0, 0)]));

    let (mut collection, mut assignment) = two_tasks(wanted);
    collection.take(0, &costly, &mut assignment).unwrap();
    let Some((0, Outcome::Answered { cost: taken, .. })) = collection.pop() else { panic!() };
    assert_eq!(taken, Some(cost));
    for (wanted, message) in [(wanted, plain), (NOTHING, costly)] {
        let (mut collection, mut assignment) = two_tasks(wanted);
        let refused = collection.take(0, &message, &mut assignment);
        assert_eq!(refused, Err(BadReply::Cost(0)));
    }
}
