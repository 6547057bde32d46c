//! From a remote client to its local client.

use bytemuck::{Pod, Zeroable};

use super::{VERSION, WireError, ascending, flag, records, split_header, split_records, zero};
use crate::transport::peer::PeerName;
use crate::tree::Counts;

const MAGIC: u32 = u32::from_le_bytes(*b"bANS");
const READY: u16 = 1;
const ANSWERS: u16 = 2;
const TREE: u16 = 3;
const SERVES: u16 = 4;
const NOT_FETCHED: u16 = 5;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ReplyHeader {
    magic: u32,
    version: u16,
    kind: u16,
    task: u64,
    /// Number of [`AnswerRecord`]s that follow.
    answers: u32,
    /// Number of words after the records.
    words: u32,
    /// 1: this message ends the task.
    last: u32,
    /// 1: after the records, and before the words, there is a [`CostRecord`] for each of them.
    costs: u32,
}

/// A tree that a worker has taken and validated.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct TreeRecord {
    pub tree: u32,
    reserved: u32,
    /// [`crate::tree::TreeView::hash`]
    pub hash: u64,
}

impl TreeRecord {
    pub fn new(tree: u32, hash: u64) -> Self {
        Self { tree, reserved: 0, hash }
    }
}

/// A subtree that a worker could not fetch.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct SubtreeRecord {
    pub tree: u32,
    pub root: u32,
}

/// The answer to one scenario, or, if its words do not fit into one message, a part of it.
///
/// Its words, of eight bytes each, are the pairs that are sent, and then what effects say.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct AnswerRecord {
    pub scenario: u32,
    status: u32,
    /// Of the whole scenario, as is their hash, however many are sent.
    pub pair_count: u32,
    /// Overflow only: the corner of the moving mesh, three to a triangle.
    corner: u32,
    /// Of the whole scenario.
    pub words: u32,
    /// The scenario's words that earlier messages carried.
    pub first_word: u32,
    /// The scenario's words in this message.
    pub words_here: u32,
    reserved: u32,
    pub pairs_fnv1a64: u64,
    pub compute_ns: u64,
}

/// What one scenario took: N_b and N_p of the paper's cost equation, and its T_total (section 3).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct CostRecord {
    pub counts: Counts,
    /// Processor time of the descent alone, in nanoseconds: without sorting and hashing its pairs,
    /// and without what else ran on the core meanwhile.
    pub descent_ns: u64,
}

const _: () = assert!(size_of::<CostRecord>() == 32 && align_of::<CostRecord>() == 8);
const _: () = assert!(size_of::<ReplyHeader>() == 32 && align_of::<ReplyHeader>() == 8);
const _: () = assert!(size_of::<TreeRecord>() == 16 && align_of::<TreeRecord>() == 8);
const _: () = assert!(size_of::<SubtreeRecord>() == 8);
const _: () = assert!(size_of::<AnswerRecord>() == 48 && align_of::<AnswerRecord>() == 8);

const ANSWERED: u32 = 0;
const OVERFLOW: u32 = 1;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnswerStatus {
    Answered,
    /// The pose takes this corner (0, 1 or 2) of a triangle of the moving mesh out of the range of
    /// 64-bit numbers.
    Overflow {
        triangle: u32,
        corner: u32,
    },
}

impl AnswerRecord {
    /// An answer without its words: `words_here` is 0.
    pub fn answered(scenario: u32, pair_count: u32, pairs_fnv1a64: u64, compute_ns: u64) -> Self {
        Self { scenario, pair_count, pairs_fnv1a64, compute_ns, ..Self::zeroed() }
    }

    /// `triangle` as numbered in a mesh, which has fewer than 2^30.
    pub fn overflow(scenario: u32, (triangle, corner): (u32, u32), compute_ns: u64) -> Self {
        let corner = 3 * triangle + corner;
        Self { scenario, status: OVERFLOW, corner, compute_ns, ..Self::zeroed() }
    }

    pub fn status(&self) -> AnswerStatus {
        match self.status {
            ANSWERED => AnswerStatus::Answered,
            _ => AnswerStatus::Overflow { triangle: self.corner / 3, corner: self.corner % 3 },
        }
    }

    fn validate(&self) -> Result<(), WireError> {
        let refuse = |what| Err(WireError::Answer { scenario: self.scenario, what });
        match self.status {
            _ if self.reserved != 0 => refuse("its reserved word is not zero"),
            ANSWERED if self.corner != 0 => refuse("answered, and names an overflowing corner"),
            ANSWERED => match self.first_word.checked_add(self.words_here) {
                Some(end) if end <= self.words => Ok(()),
                _ => refuse("carries more words than it counts"),
            },
            OVERFLOW if self.pair_count | self.words | self.first_word | self.words_here != 0 => {
                refuse("overflowed and says more all the same")
            }
            OVERFLOW => Ok(()),
            _ => refuse("its status is unknown"),
        }
    }
}

impl ReplyHeader {
    pub fn ready() -> Self {
        Self { magic: MAGIC, version: VERSION, kind: READY, ..Self::zeroed() }
    }

    pub fn answers(task: u64, answers: u32, words: u32, last: bool) -> Self {
        Self { kind: ANSWERS, task, answers, words, last: last.into(), ..Self::ready() }
    }

    /// Of a message with one [`TreeRecord`].
    pub fn tree() -> Self {
        Self { kind: TREE, ..Self::ready() }
    }

    /// Of a message with the bytes of a [`PeerName`].
    pub fn serves() -> Self {
        Self { kind: SERVES, ..Self::ready() }
    }

    /// Of a message with one [`SubtreeRecord`].
    pub fn not_fetched() -> Self {
        Self { kind: NOT_FETCHED, ..Self::ready() }
    }

    pub fn with_costs(self, costs: bool) -> Self {
        Self { costs: costs.into(), ..self }
    }
}

/// A validated message from a worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reply<'a> {
    Ready,
    /// It has taken a tree.
    Tree(TreeRecord),
    /// Others can fetch subtrees from it, by this name.
    Serves(PeerName),
    /// The master has to send this subtree itself.
    NotFetched(SubtreeRecord),
    /// Scenario numbers ascend; `costs` are those of all answers, or none; `words` are those of all
    /// answers, one after the other.
    Answers {
        task: u64,
        last: bool,
        answers: &'a [AnswerRecord],
        costs: &'a [CostRecord],
        words: &'a [u64],
    },
}

impl<'a> Reply<'a> {
    pub fn parse(bytes: &'a [u8]) -> Result<Self, WireError> {
        let (header, rest) = split_header::<ReplyHeader>(bytes)?;
        if header.magic != MAGIC {
            return Err(WireError::Magic(header.magic));
        }
        if header.version != VERSION {
            return Err(WireError::Version(header.version));
        }
        match header.kind {
            READY => {
                only_kind(header)?;
                records::<TreeRecord>(rest, 0).map(|_| Reply::Ready)
            }
            TREE => {
                only_kind(header)?;
                let record = records::<TreeRecord>(rest, 1)?[0];
                zero("reserved word", record.reserved).map(|()| Reply::Tree(record))
            }
            SERVES => {
                only_kind(header)?;
                let bytes = records::<u8>(rest, PeerName::BYTES as u32)?;
                let name = bytes.try_into().expect("as many as a name has");
                Ok(Reply::Serves(PeerName::from_bytes(name)))
            }
            NOT_FETCHED => {
                only_kind(header)?;
                Ok(Reply::NotFetched(records::<SubtreeRecord>(rest, 1)?[0]))
            }
            ANSWERS => parse_answers(header, rest),
            kind => Err(WireError::Kind(kind)),
        }
    }
}

fn only_kind(header: &ReplyHeader) -> Result<(), WireError> {
    if header.task != 0 {
        return Err(WireError::Field { field: "task", value: header.task });
    }
    zero("answer count", header.answers | header.words | header.last | header.costs)
}

fn parse_answers<'a>(header: &ReplyHeader, rest: &'a [u8]) -> Result<Reply<'a>, WireError> {
    let last = flag("last", header.last)?;
    let costs = if flag("costs", header.costs)? { header.answers } else { 0 };
    let (answers, rest) = split_records::<AnswerRecord>(rest, header.answers)?;
    let (costs, words) = split_records::<CostRecord>(rest, costs)?;
    let words = records::<u64>(words, header.words)?;
    ascending(answers.iter().map(|a| a.scenario))?;
    answers.iter().try_for_each(AnswerRecord::validate)?;
    let carried: u64 = answers.iter().map(|a| u64::from(a.words_here)).sum();
    if carried != u64::from(header.words) {
        return Err(WireError::Field { field: "word count", value: u64::from(header.words) });
    }
    Ok(Reply::Answers { task: header.task, last, answers, costs, words })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const WORDS: [u64; 3] = [1, 2, 3];

    fn records() -> [AnswerRecord; 3] {
        let first =
            AnswerRecord { words: 2, words_here: 2, ..AnswerRecord::answered(10, 2, 77, 5) };
        let whole = AnswerRecord::answered(11, 7, 88, 6);
        let part = AnswerRecord { words: 9, first_word: 4, words_here: 1, ..whole };
        [first, part, AnswerRecord::overflow(12, (345, 2), 7)]
    }

    fn message(header: ReplyHeader, answers: &[AnswerRecord], tail: &[u64]) -> Vec<u64> {
        let mut words = bytemuck::cast_slice::<_, u64>(bytemuck::bytes_of(&header)).to_vec();
        words.extend_from_slice(bytemuck::cast_slice(answers));
        words.extend(tail);
        words
    }

    fn good() -> Vec<u64> {
        message(ReplyHeader::answers(42, 3, 3, true), &records(), &WORDS)
    }

    fn costs() -> [CostRecord; 3] {
        let cost =
            |boxes| CostRecord { counts: Counts { boxes, triangles: 3, exact: 1 }, descent_ns: 50 };
        [4, 5, 6].map(cost)
    }

    fn good_with_costs() -> Vec<u64> {
        let header = ReplyHeader::answers(42, 3, 3, true).with_costs(true);
        let mut words = message(header, &records(), &[]);
        words.extend_from_slice(bytemuck::cast_slice(&costs()));
        words.extend(WORDS);
        words
    }

    fn parse(words: &[u64]) -> Result<Reply<'_>, WireError> {
        Reply::parse(bytemuck::cast_slice(words))
    }

    fn with_answer(index: usize, change: impl FnOnce(&mut AnswerRecord)) -> Result<(), WireError> {
        let mut answers = records();
        change(&mut answers[index]);
        parse(&message(ReplyHeader::answers(42, 3, 3, true), &answers, &WORDS)).map(|_| ())
    }

    #[test]
    fn answers_are_read_as_they_were_written() {
        let (answers, costs) = (&records(), &costs());
        let mut expected =
            Reply::Answers { task: 42, last: true, answers, costs: &[], words: &WORDS };
        assert_eq!(parse(&good()), Ok(expected));
        expected = Reply::Answers { task: 42, last: true, answers, costs, words: &WORDS };
        assert_eq!(parse(&good_with_costs()), Ok(expected));
        assert_eq!(records()[2].status(), AnswerStatus::Overflow { triangle: 345, corner: 2 });
    }

    #[test]
    fn ready_is_a_header_alone_and_a_tree_comes_with_its_hash() {
        let words = |header: ReplyHeader, rest: &[u64]| {
            let mut words = bytemuck::cast_slice::<_, u64>(bytemuck::bytes_of(&header)).to_vec();
            words.extend(rest);
            words
        };
        assert_eq!(parse(&words(ReplyHeader::ready(), &[])), Ok(Reply::Ready));
        assert!(parse(&words(ReplyHeader::ready(), &[0])).is_err());
        let tree = words(ReplyHeader::tree(), &[7, 1234]);
        assert_eq!(parse(&tree), Ok(Reply::Tree(TreeRecord::new(7, 1234))));
        assert!(parse(&words(ReplyHeader::tree(), &[7])).is_err());
        assert!(parse(&words(ReplyHeader::tree(), &[7 << 32, 1234])).is_err(), "reserved");
        assert!(parse(&words(ReplyHeader::tree(), &[7, 1234, 0])).is_err());
    }

    #[test]
    fn what_a_worker_says_of_subtrees_is_read_as_it_was_written() {
        let message = |header: ReplyHeader, rest: &[u8]| {
            let bytes = [bytemuck::bytes_of(&header), rest].concat();
            bytes.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect::<Vec<u64>>()
        };
        let name = PeerName::from_bytes(std::array::from_fn(|n| 3 * n as u8));
        let serves = message(ReplyHeader::serves(), &name.to_bytes());
        assert_eq!(parse(&serves), Ok(Reply::Serves(name)));
        let record = SubtreeRecord { tree: 4, root: 99 };
        let failed = message(ReplyHeader::not_fetched(), bytemuck::bytes_of(&record));
        assert_eq!(parse(&failed), Ok(Reply::NotFetched(record)));
        for mut words in [serves, failed] {
            assert!(parse(&words[..words.len() - 1]).is_err());
            words.push(0);
            assert!(parse(&words).is_err());
        }
        let busy = ReplyHeader { task: 1, ..ReplyHeader::not_fetched() };
        assert!(parse(&message(busy, bytemuck::bytes_of(&record))).is_err());
    }

    #[test]
    fn every_truncation_and_every_extra_byte_is_refused() {
        for mut words in [good(), good_with_costs()] {
            for length in 0..words.len() * 8 {
                let bytes = &bytemuck::cast_slice::<_, u8>(&words)[..length];
                assert!(Reply::parse(bytes).is_err(), "{length} bytes");
            }
            words.push(0);
            assert!(matches!(parse(&words), Err(WireError::Length { .. })));
        }
    }

    #[test]
    fn each_damaged_header_field_is_named() {
        let refused = |change: fn(&mut ReplyHeader)| {
            let mut header = ReplyHeader::answers(42, 3, 3, true);
            change(&mut header);
            parse(&message(header, &records(), &WORDS)).unwrap_err()
        };
        assert_eq!(refused(|h| h.magic = 1), WireError::Magic(1));
        assert_eq!(refused(|h| h.version = 9), WireError::Version(9));
        assert_eq!(refused(|h| h.kind = 9), WireError::Kind(9));
        assert!(matches!(refused(|h| h.kind = TREE), WireError::Field { .. }));
        assert!(matches!(refused(|h| h.kind = READY), WireError::Field { .. }));
        assert!(matches!(refused(|h| h.last = 2), WireError::Field { field: "last", .. }));
        assert!(matches!(refused(|h| h.costs = 2), WireError::Field { field: "costs", .. }));
        assert!(matches!(refused(|h| h.costs = 1), WireError::Truncated { .. }));
        assert!(matches!(refused(|h| h.answers = 2), WireError::Length { .. }));
        assert!(matches!(refused(|h| h.answers = 4), WireError::Truncated { .. }));
        assert!(matches!(refused(|h| h.answers = u32::MAX), WireError::Truncated { .. }));
        assert!(matches!(refused(|h| h.words = u32::MAX), WireError::Length { .. }));
    }

    #[test]
    fn each_impossible_answer_is_refused_by_scenario() {
        let is_about = |result, number| matches!(result, Err(WireError::Answer { scenario, .. }) if scenario == number);
        assert_eq!(with_answer(1, |a| a.scenario = 10), Err(WireError::Order(10)));
        assert!(is_about(with_answer(0, |a| a.words_here = 3), 10));
        assert!(is_about(with_answer(1, |a| a.first_word = u32::MAX), 11));
        assert!(is_about(with_answer(0, |a| a.status = 2), 10));
        assert!(is_about(with_answer(0, |a| a.corner = 2), 10));
        assert!(is_about(with_answer(0, |a| a.reserved = 1), 10));
        assert!(is_about(with_answer(2, |a| a.pair_count = 1), 12));
        assert!(is_about(with_answer(2, |a| a.words = 1), 12));
        let fewer = with_answer(0, |a| a.words_here = 1);
        assert_eq!(fewer, Err(WireError::Field { field: "word count", value: 3 }));
    }

    proptest! {
        #[test]
        fn damaged_bytes_never_panic_and_never_yield_words_they_do_not_hold(
            damage in prop::collection::vec((0_usize..37 * 8, any::<u8>()), 1..8),
            length in 0_usize..=37 * 8,
        ) {
            let mut words = good_with_costs();
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut words);
            for (at, value) in damage {
                bytes[at] = value;
            }
            if let Ok(Reply::Answers { answers, costs, words, .. }) = Reply::parse(&bytes[..length]) {
                prop_assert!(costs.is_empty() || costs.len() == answers.len());
                let carried: usize = answers.iter().map(|a| a.words_here as usize).sum();
                prop_assert_eq!(carried, words.len());
                prop_assert!(answers.iter().all(|a| a.first_word + a.words_here <= a.words));
            }
        }
    }
}
