//! Collects answers; sent when filled to capacity and at the end of a task (section 6.4.2).

use crate::tree::descent::Pair;
use crate::wire::{AnswerRecord, ReplyHeader};

/// Answers of one task that have not been sent yet.
pub struct ResultBuffer {
    task: u64,
    /// Longest message, in bytes.
    capacity: usize,
    answers: Vec<AnswerRecord>,
    pairs: Vec<Pair>,
}

impl ResultBuffer {
    pub fn new(task: u64, capacity: usize) -> Self {
        Self { task, capacity, answers: Vec::new(), pairs: Vec::new() }
    }

    /// Adds an answer; its pairs are split over as many messages as they need.
    pub fn push<E>(
        &mut self,
        mut answer: AnswerRecord,
        mut pairs: &[Pair],
        send: &mut impl FnMut(&[&[u8]]) -> Result<(), E>,
    ) -> Result<(), E> {
        loop {
            let room = self.free_bytes().saturating_sub(size_of::<AnswerRecord>());
            let fitting = (room / size_of::<Pair>()).min(pairs.len());
            let fits_anything =
                self.free_bytes() >= size_of::<AnswerRecord>() && (fitting > 0 || pairs.is_empty());
            if fits_anything {
                let (here, rest) = pairs.split_at(fitting);
                answer.pairs_here = fitting as u32;
                self.answers.push(answer);
                self.pairs.extend_from_slice(here);
                answer.first_pair += answer.pairs_here;
                pairs = rest;
                if pairs.is_empty() {
                    return Ok(());
                }
            }
            self.send(false, send)?;
        }
    }

    /// Sends what is left and says that it ends the task.
    pub fn finish<E>(mut self, send: &mut impl FnMut(&[&[u8]]) -> Result<(), E>) -> Result<(), E> {
        self.send(true, send)
    }

    fn free_bytes(&self) -> usize {
        self.capacity
            - size_of::<ReplyHeader>()
            - size_of_val(&self.answers[..])
            - size_of_val(&self.pairs[..])
    }

    fn send<E>(
        &mut self,
        last: bool,
        send: &mut impl FnMut(&[&[u8]]) -> Result<(), E>,
    ) -> Result<(), E> {
        let (answers, pairs) = (self.answers.len() as u32, self.pairs.len() as u32);
        let header = ReplyHeader::answers(self.task, answers, pairs, last);
        send(&[
            bytemuck::bytes_of(&header),
            bytemuck::cast_slice(&self.answers),
            bytemuck::cast_slice(&self.pairs),
        ])?;
        self.answers.clear();
        self.pairs.clear();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::wire::Reply;

    proptest! {
        /// Whatever the sizes: messages within capacity, all valid, and joined they give back
        /// every answer with all its pairs.
        #[test]
        fn messages_keep_to_the_capacity_and_lose_nothing(
            counts in prop::collection::vec(0_u32..40, 0..12),
            capacity in 80_usize..400,
        ) {
            let mut messages = Vec::new();
            let mut send = |parts: &[&[u8]]| {
                messages.push(parts.concat());
                Ok::<_, ()>(())
            };
            let mut buffer = ResultBuffer::new(3, capacity);
            let pairs_of = |scenario: u32, count: u32| (0..count).map(move |n| [scenario, n]);
            for (scenario, &count) in (0..).zip(&counts) {
                let pairs: Vec<_> = pairs_of(scenario, count).collect();
                buffer.push(AnswerRecord::answered(scenario, count, 0, 0), &pairs, &mut send).unwrap();
            }
            buffer.finish(&mut send).unwrap();

            let mut joined = vec![Vec::new(); counts.len()];
            let mut seen = vec![false; counts.len()];
            for (index, message) in messages.iter().enumerate() {
                prop_assert!(message.len() <= capacity);
                let words = message.chunks_exact(8).map(|word| word.try_into().unwrap());
                let words: Vec<u64> = words.map(u64::from_ne_bytes).collect();
                let Reply::Answers { task: 3, last, answers, mut pairs } =
                    Reply::parse(bytemuck::cast_slice(&words)).unwrap() else { panic!() };
                prop_assert_eq!(last, index + 1 == messages.len());
                for answer in answers {
                    let (here, rest) = pairs.split_at(answer.pairs_here as usize);
                    let target: &mut Vec<Pair> = &mut joined[answer.scenario as usize];
                    prop_assert_eq!(target.len(), answer.first_pair as usize);
                    target.extend_from_slice(here);
                    seen[answer.scenario as usize] = true;
                    pairs = rest;
                }
            }
            prop_assert!(seen.iter().all(|&s| s));
            for (scenario, &count) in (0..).zip(&counts) {
                prop_assert!(joined[scenario as usize].iter().copied().eq(pairs_of(scenario, count)));
            }
        }
    }
}
