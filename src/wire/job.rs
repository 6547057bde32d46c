//! From a local client to its remote client.
//!
//! The paper's message types (section 6.4.4): a scenario batch is the whole task, so its end needs
//! no message of its own; trees are not sent as messages but published by the transport.

use bytemuck::{Pod, Zeroable};

use super::{VERSION, WireError, ascending, flag, records, split_header, zero};
use crate::geometry::Pose;

const MAGIC: u32 = u32::from_le_bytes(*b"bJOB");
const SCENARIOS: u16 = 1;
const TERMINATE: u16 = 2;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct JobHeader {
    magic: u32,
    version: u16,
    kind: u16,
    task: u64,
    /// Number of [`ScenarioRecord`]s that follow.
    scenarios: u32,
    /// 1: answers carry their pairs.
    send_pairs: u32,
    reserved: [u32; 2],
}

/// One work unit.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ScenarioRecord {
    pub scenario: u32,
    reserved: u32,
    pub pose: Pose,
}

const _: () = assert!(size_of::<JobHeader>() == 32 && align_of::<JobHeader>() == 8);
const _: () = assert!(size_of::<ScenarioRecord>() == 104 && align_of::<ScenarioRecord>() == 8);

impl ScenarioRecord {
    pub fn new(scenario: u32, pose: Pose) -> Self {
        Self { scenario, reserved: 0, pose }
    }
}

impl JobHeader {
    pub fn scenarios(task: u64, scenarios: u32, send_pairs: bool) -> Self {
        Self { task, scenarios, send_pairs: send_pairs.into(), ..Self::of_kind(SCENARIOS) }
    }

    pub fn terminate() -> Self {
        Self::of_kind(TERMINATE)
    }

    fn of_kind(kind: u16) -> Self {
        Self { magic: MAGIC, version: VERSION, kind, ..Self::zeroed() }
    }
}

/// A validated message to a worker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Job<'a> {
    /// Scenario numbers ascend, poses are finite.
    Scenarios {
        task: u64,
        send_pairs: bool,
        scenarios: &'a [ScenarioRecord],
    },
    Terminate,
}

impl<'a> Job<'a> {
    /// Bytes of a batch of `scenarios`.
    pub fn batch_bytes(scenarios: u32) -> usize {
        size_of::<JobHeader>() + scenarios as usize * size_of::<ScenarioRecord>()
    }

    pub fn parse(bytes: &'a [u8]) -> Result<Self, WireError> {
        let (header, rest) = split_header::<JobHeader>(bytes)?;
        if header.magic != MAGIC {
            return Err(WireError::Magic(header.magic));
        }
        if header.version != VERSION {
            return Err(WireError::Version(header.version));
        }
        zero("reserved word", header.reserved[0] | header.reserved[1])?;
        let send_pairs = flag("send_pairs", header.send_pairs)?;
        let scenarios = records::<ScenarioRecord>(rest, header.scenarios)?;
        match header.kind {
            SCENARIOS => {
                validate(scenarios)?;
                Ok(Self::Scenarios { task: header.task, send_pairs, scenarios })
            }
            TERMINATE => zero("scenario count", header.scenarios).map(|()| Self::Terminate),
            kind => Err(WireError::Kind(kind)),
        }
    }
}

fn validate(scenarios: &[ScenarioRecord]) -> Result<(), WireError> {
    ascending(scenarios.iter().map(|s| s.scenario))?;
    for record in scenarios {
        zero("reserved word", record.reserved)?;
        let numbers = record.pose.rotation.iter().chain(&record.pose.translation);
        if !numbers.into_iter().all(|n| n.is_finite()) {
            return Err(WireError::Pose(record.scenario));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Bytes on a multiple of 8, as the transport delivers them.
    fn batch(scenarios: &[u32]) -> Vec<u64> {
        let records: Vec<_> =
            scenarios.iter().map(|&s| ScenarioRecord::new(s, Pose::IDENTITY)).collect();
        let header = JobHeader::scenarios(7, records.len() as u32, true);
        let mut words = bytemuck::cast_slice::<_, u64>(bytemuck::bytes_of(&header)).to_vec();
        words.extend_from_slice(bytemuck::cast_slice(&records));
        words
    }

    fn bytes(words: &[u64]) -> &[u8] {
        bytemuck::cast_slice(words)
    }

    fn with_header(change: impl FnOnce(&mut JobHeader)) -> Result<(), WireError> {
        let mut words = batch(&[3, 4]);
        change(bytemuck::from_bytes_mut(bytemuck::cast_slice_mut(&mut words[..4])));
        Job::parse(bytes(&words)).map(|_| ())
    }

    #[test]
    fn a_batch_is_read_as_it_was_written() {
        let words = batch(&[3, 4, 9]);
        let Ok(Job::Scenarios { task: 7, send_pairs: true, scenarios }) = Job::parse(bytes(&words))
        else {
            panic!("not a batch");
        };
        assert_eq!(scenarios.iter().map(|s| s.scenario).collect::<Vec<_>>(), [3, 4, 9]);
        assert_eq!(scenarios[1].pose, Pose::IDENTITY);
    }

    #[test]
    fn terminate_is_a_header_alone() {
        let header = JobHeader::terminate();
        assert_eq!(Job::parse(bytemuck::bytes_of(&header)), Ok(Job::Terminate));
    }

    #[test]
    fn every_truncation_and_every_extra_byte_is_refused() {
        let mut words = batch(&[3, 4]);
        for length in 0..words.len() * 8 {
            assert!(Job::parse(&bytes(&words)[..length]).is_err(), "{length} bytes");
        }
        words.push(0);
        let described = 2 * size_of::<ScenarioRecord>();
        let refused = Err(WireError::Length { found: described + 8, described });
        assert_eq!(Job::parse(bytes(&words)), refused);
    }

    #[test]
    fn each_damaged_field_is_named() {
        assert_eq!(with_header(|h| h.magic = 1), Err(WireError::Magic(1)));
        assert_eq!(with_header(|h| h.version = 2), Err(WireError::Version(2)));
        assert_eq!(with_header(|h| h.kind = 9), Err(WireError::Kind(9)));
        assert!(matches!(with_header(|h| h.scenarios = 3), Err(WireError::Length { .. })));
        assert!(matches!(with_header(|h| h.scenarios = u32::MAX), Err(WireError::Length { .. })));
        assert!(matches!(with_header(|h| h.send_pairs = 2), Err(WireError::Field { .. })));
        assert!(matches!(with_header(|h| h.reserved[1] = 1), Err(WireError::Field { .. })));
        assert!(matches!(with_header(|h| h.kind = TERMINATE), Err(WireError::Field { .. })));
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
            damage in prop::collection::vec((0_usize..30 * 8, any::<u8>()), 1..8),
            length in 0_usize..=30 * 8,
        ) {
            let mut words = batch(&[3, 4]);
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut words);
            for (at, value) in damage {
                bytes[at] = value;
            }
            if let Ok(Job::Scenarios { scenarios, .. }) = Job::parse(&bytes[..length]) {
                prop_assert_eq!(Job::batch_bytes(scenarios.len() as u32), length);
                prop_assert!(scenarios.windows(2).all(|w| w[0].scenario < w[1].scenario));
            }
        }
    }
}
