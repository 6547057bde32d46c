//! The contract of `bumper::transport`, promise by promise, held against every transport. Workers
//! are processes wherever the transport is between processes.
//!
//! What only the whole engine can show (a killed master, shared pages) is in `worker_death.rs` and
//! `zero_copy.rs`.

mod in_place;
#[path = "../over_ranks/in_process.rs"]
mod in_process;
mod messages;
mod over_ranks;
mod roles;
mod shared_memory;
mod transports;

use std::time::Instant;

use bumper::transport::{MasterEnd, WakeUp, WorkerId};
use roles::{FOREVER, Gate, Role, needs};
use transports::{Running, Transport};

#[test]
fn worker_process() {
    transports::play_as_process();
}

/// A master, where it has its files, and its workers.
struct Scene<T: Transport> {
    /// Dropped before the directory.
    master: Option<T::Master>,
    directory: tempfile::TempDir,
}

impl<T: Transport> Scene<T> {
    fn new() -> Self {
        Self::with(needs(WakeUp::Block))
    }

    fn with(needs: bumper::transport::Needs) -> Self {
        let directory = tempfile::tempdir().unwrap();
        let master = T::master(directory.path(), &needs).unwrap();
        Self { master: Some(master), directory }
    }

    fn master(&mut self) -> &mut T::Master {
        self.master.as_mut().expect("a master until it is gone")
    }

    fn gate(&self) -> Gate {
        Gate::at(self.directory.path())
    }

    fn start(&mut self, slot: u32, role: Role) -> Running {
        let end = self.master().open(worker(slot)).unwrap();
        T::start(role, &self.gate(), end)
    }

    /// A worker that has greeted.
    fn start_and_meet(&mut self, slot: u32, role: Role) -> Running {
        let running = self.start(slot, role);
        assert_eq!(self.next(slot), b"hello");
        running
    }

    fn send(&mut self, slot: u32, message: &[u8]) {
        self.master().send(worker(slot), &[message]).unwrap();
    }

    /// The next message of a worker.
    fn next(&mut self, slot: u32) -> Vec<u8> {
        let mut all = self.collect(slot, 1);
        assert_eq!(all.len(), 1, "more than one message came");
        all.remove(0)
    }

    fn collect(&mut self, slot: u32, count: usize) -> Vec<Vec<u8>> {
        let mut messages = Vec::new();
        let begin = Instant::now();
        loop {
            let take = &mut |message: &[u8]| messages.push(message.to_vec());
            self.master().receive(worker(slot), take).unwrap();
            if messages.len() >= count {
                return messages;
            }
            let came = messages.len();
            assert!(begin.elapsed() < FOREVER, "only {came} of {count} messages came");
            self.master().wait(&[], FOREVER).unwrap();
        }
    }
}

fn worker(slot: u32) -> WorkerId {
    WorkerId { slot, incarnation: 0 }
}

fn bytes(count: usize) -> Vec<u8> {
    (0..count).map(|i| (i * 7 + i / 251) as u8).collect()
}

macro_rules! conformance {
    ($transport:ident: $($topic:ident: $($promise:ident)*;)*) => {
        $($(#[test] fn $promise() { crate::$topic::$promise::<crate::transports::$transport>() })*)*
    };
}

macro_rules! of_every_transport {
    ($transport:ident $(, $topic:ident: $($promise:ident)*)?) => {
        conformance! { $transport:
            messages:
                promise_3_messages_arrive_once_whole_in_order_and_at_one_worker
                promise_3_what_is_sent_ahead_arrives_in_order_and_without_what_follows
                promise_3_a_flood_of_replies_loses_none
                promise_3_long_messages_arrive_whole
                promise_4_messages_ahead_of_a_worker_arrive_or_are_refused_and_nobody_waits
                promise_5_too_long_messages_are_refused
                promise_6_wait_ends_for_a_message_a_descriptor_and_the_time
                promise_6_nothing_is_missed_however_the_sides_wake
                promise_7_what_was_sent_before_the_worker_was_killed_is_handed_over
                promise_9_two_runs_do_not_see_each_other
                promise_10_message_bytes_are_counted
                promise_11_a_worker_notices_that_the_master_has_gone
                promise_11_a_dead_worker_does_not_hold_the_master_up;
            $($topic: $($promise)*;)?
        }
    };
}

mod over_threads {
    of_every_transport! { OverThreads, in_place:
        promise_1_images_arrive_whole_before_and_after_attaching
        promise_1_a_number_is_published_once
        promise_2_geometry_outlives_the_master
        promise_2_a_withdrawn_mesh_stays_with_who_has_it
        promise_11_who_waits_for_geometry_notices_that_the_master_has_gone
    }
}

mod over_shared_memory {
    of_every_transport! { OverSharedMemory, in_place:
        promise_1_images_arrive_whole_before_and_after_attaching
        promise_1_a_number_is_published_once
        promise_2_geometry_outlives_the_master
        promise_2_a_withdrawn_mesh_stays_with_who_has_it
        promise_11_who_waits_for_geometry_notices_that_the_master_has_gone
    }
}

mod over_pipes {
    of_every_transport! { OverPipes }
}

mod over_sockets {
    of_every_transport! { OverSockets }
}

mod over_ranks_of_a_job {
    of_every_transport! { OverRanks }
}
