use proptest::prelude::*;

use super::*;
use crate::geometry::TriangleTest;
use crate::tree::Accuracy;

const WANTED: Wanted = Wanted {
    accuracy: Accuracy::Pairs(TriangleTest::F64),
    overlap_only: false,
    pairs: 17,
    costs: false,
    plan: Some(4),
};

/// Bytes on a multiple of 8, as the transport delivers them.
fn words(header: &JobHeader, records: &[ScenarioRecord], root_pairs: &[RootPair]) -> Vec<u64> {
    let mut words = bytemuck::cast_slice::<_, u64>(bytemuck::bytes_of(header)).to_vec();
    words.extend_from_slice(bytemuck::cast_slice(records));
    let pairs: Vec<u64> = root_pairs.iter().map(|&pair| bytemuck::cast(pair)).collect();
    words.extend(pairs);
    words
}

fn batch(scenarios: &[u32]) -> Vec<u64> {
    let records: Vec<_> =
        scenarios.iter().map(|&s| ScenarioRecord::new(s, Pose::IDENTITY, 0)).collect();
    words(&JobHeader::scenarios(7, [4, 5], records.len() as u32, false, WANTED), &records, &[])
}

/// Scenario 3 from two pairs of roots, scenario 4 from none, scenario 9 from one.
fn rooted_batch() -> Vec<u64> {
    let record = |s, count| ScenarioRecord::new(s, Pose::IDENTITY, count);
    let header = JobHeader::scenarios(7, [4, 5], 3, true, WANTED);
    words(&header, &[record(3, 2), record(4, 0), record(9, 1)], &[[1, 2], [1, 3], [8, 8]])
}

fn bytes(words: &[u64]) -> &[u8] {
    bytemuck::cast_slice(words)
}

fn with_header(change: impl FnOnce(&mut JobHeader)) -> Result<(), WireError> {
    let mut words = batch(&[3, 4]);
    change(bytemuck::from_bytes_mut(bytemuck::cast_slice_mut(&mut words[..7])));
    Job::parse(bytes(&words)).map(|_| ())
}

#[test]
fn a_batch_is_read_as_it_was_written() {
    let words = batch(&[3, 4, 9]);
    let Ok(Job::Scenarios(batch)) = Job::parse(bytes(&words)) else { panic!("not a batch") };
    assert_eq!((batch.task, batch.trees, batch.wanted), (7, [4, 5], WANTED));
    let scenarios: Vec<_> = batch.iter().map(|(s, roots)| (s.scenario, roots)).collect();
    assert_eq!(scenarios, [(3, None), (4, None), (9, None)]);
    assert!(batch.iter().all(|(s, _)| s.pose == Pose::IDENTITY));
}

#[test]
fn each_scenario_gets_its_own_root_pairs() {
    let words = rooted_batch();
    let Ok(Job::Scenarios(batch)) = Job::parse(bytes(&words)) else { panic!("not a batch") };
    let roots: Vec<_> = batch.iter().map(|(s, roots)| (s.scenario, roots.unwrap())).collect();
    assert_eq!(roots, [(3, &[[1, 2], [1, 3]][..]), (4, &[]), (9, &[[8, 8]])]);
    assert_eq!(Job::batch_bytes(3, 3), bytes(&words).len());
}

#[test]
fn messages_about_trees_are_read_as_they_were_written() {
    let with_body = |header: JobHeader| words(&header, &[], &[[6, 7]]);
    let body = bytemuck::bytes_of(&[6_u32, 7]);
    assert_eq!(
        Job::parse(bytes(&with_body(JobHeader::add_tree(3)))),
        Ok(Job::AddTree { tree: 3, body })
    );
    assert_eq!(
        Job::parse(bytes(&with_body(JobHeader::add_subtree(3)))),
        Ok(Job::AddSubtree { tree: 3, body })
    );
    let header = JobHeader::remove_tree(3);
    assert_eq!(Job::parse(bytemuck::bytes_of(&header)), Ok(Job::RemoveTree { tree: 3 }));
    assert!(Job::parse(bytes(&with_body(header))).is_err());
}

#[test]
fn a_plan_is_read_as_it_was_written_and_has_a_number() {
    let message = words(&JobHeader::plan(3), &[], &[[6, 7]]);
    let body = bytemuck::bytes_of(&[6_u32, 7]);
    assert_eq!(Job::parse(bytes(&message)), Ok(Job::Plan { number: 3, body }));
    let nameless = JobHeader { plan: 0, ..JobHeader::plan(3) };
    assert!(Job::parse(bytemuck::bytes_of(&nameless)).is_err());
}

#[test]
fn what_a_worker_is_to_fetch_is_read_as_it_was_written() {
    use crate::transport::peer::PeerName;
    let peer = PeerName::from_bytes([7; PeerName::BYTES]);
    let fetch = Fetch { root: 6, peer, patience: std::time::Duration::from_millis(250) };
    let body: [RootPair; 3] = bytemuck::cast(fetch.to_bytes());
    let mut message = words(&JobHeader::fetch_subtree(3), &[], &body);
    assert_eq!(Job::parse(bytes(&message)), Ok(Job::FetchSubtree { tree: 3, fetch }));
    for length in 0..message.len() * 8 {
        assert!(Job::parse(&bytes(&message)[..length]).is_err(), "{length} bytes");
    }
    message.push(0);
    assert!(Job::parse(bytes(&message)).is_err());
}

#[test]
fn terminate_and_serve_are_headers_alone() {
    for (header, job) in
        [(JobHeader::terminate(), Job::Terminate), (JobHeader::serve(), Job::Serve)]
    {
        assert_eq!(Job::parse(bytemuck::bytes_of(&header)), Ok(job));
        assert!(Job::parse(bytes(&words(&header, &[], &[[0, 0]]))).is_err());
        let of_tree = JobHeader { trees: [1, 0], ..header };
        assert!(Job::parse(bytemuck::bytes_of(&of_tree)).is_err());
    }
}

#[test]
fn every_truncation_and_every_extra_byte_is_refused() {
    for mut words in [batch(&[3, 4]), rooted_batch()] {
        for length in 0..words.len() * 8 {
            assert!(Job::parse(&bytes(&words)[..length]).is_err(), "{length} bytes");
        }
        words.push(0);
        assert!(matches!(Job::parse(bytes(&words)), Err(WireError::Length { .. })));
    }
}

#[test]
fn each_damaged_field_is_named() {
    assert_eq!(with_header(|h| h.magic = 1), Err(WireError::Magic(1)));
    assert_eq!(with_header(|h| h.version = 1), Err(WireError::Version(1)));
    assert_eq!(with_header(|h| h.kind = 99), Err(WireError::Kind(99)));
    assert!(matches!(with_header(|h| h.scenarios = 1), Err(WireError::Length { .. })));
    assert!(matches!(with_header(|h| h.scenarios = 3), Err(WireError::Truncated { .. })));
    assert!(matches!(with_header(|h| h.scenarios = u32::MAX), Err(WireError::Truncated { .. })));
    assert!(matches!(with_header(|h| h.overlap_only = 2), Err(WireError::Field { .. })));
    assert!(matches!(with_header(|h| h.send_costs = 2), Err(WireError::Field { .. })));
    assert!(matches!(with_header(|h| h.from_roots = 2), Err(WireError::Field { .. })));
    assert!(matches!(with_header(|h| h.accuracy = 99), Err(WireError::Field { .. })));
    assert!(matches!(with_header(|h| h.reserved = 1), Err(WireError::Field { .. })));
    for kind in [TERMINATE, ADD_TREE, ADD_SUBTREE, REMOVE_TREE, PLAN] {
        assert!(matches!(with_header(|h| h.kind = kind), Err(WireError::Field { .. })));
    }
}

#[test]
fn root_pairs_that_are_not_announced_are_refused() {
    let record = ScenarioRecord::new(3, Pose::IDENTITY, 1);
    let header = JobHeader::scenarios(7, [4, 5], 1, false, WANTED);
    let refused = Err(WireError::Field { field: "root pairs", value: 1 });
    assert_eq!(Job::parse(bytes(&words(&header, &[record], &[[0, 0]]))), refused);
}

#[test]
fn a_scenario_given_twice_is_refused() {
    assert_eq!(Job::parse(bytes(&batch(&[4, 4]))), Err(WireError::Order(4)));
    assert_eq!(Job::parse(bytes(&batch(&[4, 3]))), Err(WireError::Order(3)));
}

#[test]
fn a_pose_that_is_not_finite_is_refused() {
    let mut words = batch(&[3, 4]);
    *words.last_mut().unwrap() = f64::NAN.to_bits();
    assert_eq!(Job::parse(bytes(&words)), Err(WireError::Pose(4)));
}

#[test]
fn misaligned_bytes_are_refused() {
    let words = batch(&[3, 4]);
    let mut shifted = vec![0_u64; words.len() + 1];
    let target: &mut [u8] = bytemuck::cast_slice_mut(&mut shifted);
    target[4..4 + words.len() * 8].copy_from_slice(bytes(&words));
    let misaligned = &bytemuck::cast_slice::<u64, u8>(&shifted)[4..4 + words.len() * 8];
    assert_eq!(Job::parse(misaligned), Err(WireError::Alignment));
}

proptest! {
    #[test]
    fn damaged_bytes_never_panic_and_never_yield_more_than_they_hold(
        damage in prop::collection::vec((0_usize..48 * 8, any::<u8>()), 1..8),
        length in 0_usize..=48 * 8,
    ) {
        let mut words = rooted_batch();
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut words);
        for (at, value) in damage {
            bytes[at] = value;
        }
        if let Ok(Job::Scenarios(batch)) = Job::parse(&bytes[..length]) {
            let pairs = batch.iter().map(|(_, roots)| roots.map_or(0, <[_]>::len)).sum();
            prop_assert_eq!(Job::batch_bytes(batch.len(), pairs), length);
            let numbers: Vec<_> = batch.iter().map(|(s, _)| s.scenario).collect();
            prop_assert!(numbers.windows(2).all(|w| w[0] < w[1]));
        }
    }
}
