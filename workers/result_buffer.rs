//! Collects answers; sent when filled to capacity and at the end of a task (section 6.4.2).

use crate::wire::{AnswerRecord, CostRecord, ReplyHeader};

/// Answers of one task that have not been sent yet.
pub struct ResultBuffer {
    task: u64,
    /// Longest message, in bytes.
    capacity: usize,
    answers: Vec<AnswerRecord>,
    /// One an answer, or none.
    costs: Vec<CostRecord>,
    words: Vec<u64>,
}

impl ResultBuffer {
    pub fn new(task: u64, capacity: usize) -> Self {
        Self { task, capacity, answers: Vec::new(), costs: Vec::new(), words: Vec::new() }
    }

    /// Adds an answer; its words are split over as many messages as they need. Either all answers
    /// of a task come with their cost, or none.
    pub fn push<E>(
        &mut self,
        mut answer: AnswerRecord,
        cost: Option<CostRecord>,
        mut words: &[u64],
        send: &mut impl FnMut(&[&[u8]]) -> Result<(), E>,
    ) -> Result<(), E> {
        answer.words = u32::try_from(words.len()).expect("fewer than 2^32 words");
        let records = size_of::<AnswerRecord>() + cost.map_or(0, |_| size_of::<CostRecord>());
        loop {
            let room = self.free_bytes().saturating_sub(records);
            let fitting = (room / size_of::<u64>()).min(words.len());
            let fits_anything = self.free_bytes() >= records && (fitting > 0 || words.is_empty());
            if fits_anything {
                let (here, rest) = words.split_at(fitting);
                answer.words_here = fitting as u32;
                self.answers.push(answer);
                self.costs.extend(cost);
                self.words.extend_from_slice(here);
                answer.first_word += answer.words_here;
                words = rest;
                if words.is_empty() {
                    return Ok(());
                }
            }
            self.send(false, send)?;
        }
    }

    /// Sends what there is.
    pub fn flush<E>(&mut self, send: &mut impl FnMut(&[&[u8]]) -> Result<(), E>) -> Result<(), E> {
        self.send(false, send)
    }

    /// Sends what is left and says that it ends the task.
    pub fn finish<E>(mut self, send: &mut impl FnMut(&[&[u8]]) -> Result<(), E>) -> Result<(), E> {
        self.send(true, send)
    }

    fn free_bytes(&self) -> usize {
        self.capacity
            - size_of::<ReplyHeader>()
            - size_of_val(&self.answers[..])
            - size_of_val(&self.costs[..])
            - size_of_val(&self.words[..])
    }

    fn send<E>(
        &mut self,
        last: bool,
        send: &mut impl FnMut(&[&[u8]]) -> Result<(), E>,
    ) -> Result<(), E> {
        let (answers, words) = (self.answers.len() as u32, self.words.len() as u32);
        let header = ReplyHeader::answers(self.task, answers, words, last)
            .with_costs(!self.costs.is_empty());
        send(&[
            bytemuck::bytes_of(&header),
            bytemuck::cast_slice(&self.answers),
            bytemuck::cast_slice(&self.costs),
            bytemuck::cast_slice(&self.words),
        ])?;
        self.answers.clear();
        self.costs.clear();
        self.words.clear();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::wire::Reply;

    fn cost(scenario: u32) -> CostRecord {
        CostRecord { descent_ns: 10 + u64::from(scenario), ..Default::default() }
    }

    proptest! {
        /// Whatever the sizes: messages within capacity, all valid, and joined they give back
        /// every answer with all its words.
        #[test]
        fn messages_keep_to_the_capacity_and_lose_nothing(
            counts in prop::collection::vec(0_u32..40, 0..12),
            capacity in 120_usize..400,
            with_costs: bool,
        ) {
            let mut messages = Vec::new();
            let mut send = |parts: &[&[u8]]| {
                messages.push(parts.concat());
                Ok::<_, ()>(())
            };
            let mut buffer = ResultBuffer::new(3, capacity);
            let words_of = |scenario: u32, count: u32| {
                (0..count).map(move |n| u64::from(scenario) << 32 | u64::from(n))
            };
            for (scenario, &count) in (0..).zip(&counts) {
                let words: Vec<_> = words_of(scenario, count).collect();
                let answer = AnswerRecord::answered(scenario, count, 0, 0);
                buffer.push(answer, with_costs.then(|| cost(scenario)), &words, &mut send).unwrap();
            }
            buffer.finish(&mut send).unwrap();

            let mut joined = vec![Vec::new(); counts.len()];
            let mut seen = vec![false; counts.len()];
            for (index, message) in messages.iter().enumerate() {
                prop_assert!(message.len() <= capacity);
                let aligned = message.chunks_exact(8).map(|word| word.try_into().unwrap());
                let aligned: Vec<u64> = aligned.map(u64::from_ne_bytes).collect();
                let Reply::Answers { task: 3, last, answers, costs, mut words } =
                    Reply::parse(bytemuck::cast_slice(&aligned)).unwrap() else { panic!() };
                prop_assert_eq!(last, index + 1 == messages.len());
                let expected = answers.iter().filter(|_| with_costs).map(|a| cost(a.scenario));
                prop_assert!(costs.iter().copied().eq(expected));
                for answer in answers {
                    let (here, rest) = words.split_at(answer.words_here as usize);
                    let target: &mut Vec<u64> = &mut joined[answer.scenario as usize];
                    prop_assert_eq!(target.len(), answer.first_word as usize);
                    target.extend_from_slice(here);
                    seen[answer.scenario as usize] = true;
                    words = rest;
                }
            }
            prop_assert!(seen.iter().all(|&s| s));
            for (scenario, &count) in (0..).zip(&counts) {
                prop_assert!(joined[scenario as usize].iter().copied().eq(words_of(scenario, count)));
            }
        }
    }
}
