//! Promises of every transport.

use std::io::Write;
use std::os::fd::AsFd;
use std::time::{Duration, Instant};

use bumper::transport::{MasterEnd, Needs, REPLY_BYTES, Traffic, TransportError, WakeUp};

use crate::roles::{FOREVER, JOB_BYTES, Role, digest, needs};
use crate::transports::Transport;
use crate::{Scene, bytes, worker};

pub fn promise_3_messages_arrive_once_whole_in_order_and_at_one_worker<T: Transport>() {
    let mut scene = Scene::<T>::new();
    let running = [0, 1].map(|slot| scene.start_and_meet(slot, Role::Echo));
    for round in 0..200_usize {
        for slot in [0, 1] {
            let mark = [slot as u8; 3];
            let body = bytes(1 + round * 4);
            scene.master().send(worker(slot), &[&mark, &[], &body]).unwrap();
            let expected = [&mark[..], &body].concat();
            assert!(scene.next(slot) == expected, "round {round}, worker {slot}");
        }
    }
    for slot in [0, 1] {
        scene.master().send(worker(slot), &[]).unwrap();
    }
    running.into_iter().for_each(|running| running.finish());
}

pub fn promise_3_what_is_sent_ahead_arrives_in_order_and_without_what_follows<T: Transport>() {
    let mut scene = Scene::<T>::new();
    let running = scene.start_and_meet(0, Role::Echo);
    for round in 0..50_usize {
        let messages = [1, 5, 9].map(|length| bytes(length + round));
        let [first, second, last] = &messages;
        scene.master().send_ahead(worker(0), &[first]).unwrap();
        scene.master().send_ahead(worker(0), &[second]).unwrap();
        if round % 2 == 0 {
            scene.master().send(worker(0), &[last]).unwrap();
            assert!(scene.collect(0, 3) == messages, "round {round}");
        } else {
            assert!(scene.collect(0, 2) == messages[..2], "round {round}");
        }
    }
    scene.master().send(worker(0), &[]).unwrap();
    running.finish();
}

pub fn promise_3_a_flood_of_replies_loses_none<T: Transport>() {
    let mut scene = Scene::<T>::new();
    let running = scene.start(2, Role::Flood);
    let seen = scene.collect(2, 500);
    let expected: Vec<_> = (0..500_u32).map(|number| number.to_ne_bytes().to_vec()).collect();
    assert_eq!(seen, expected);
    running.finish();
}

/// Longer than any pipe or socket holds.
pub fn promise_3_long_messages_arrive_whole<T: Transport>() {
    let longest = 5 << 20;
    let mut scene = Scene::<T>::with(Needs { job_bytes: longest, ..needs(WakeUp::Block) });
    let running = scene.start_and_meet(0, Role::Digest);
    for length in [1 << 16, (1 << 16) + 1, (1 << 20) - 8, longest] {
        let message = bytes(length);
        scene.send(0, &message);
        assert_eq!(scene.next(0), digest(&message), "of {length} bytes");
    }
    scene.send(0, b"");
    running.finish();
}

pub fn promise_4_messages_ahead_of_a_worker_arrive_or_are_refused_and_nobody_waits<T: Transport>() {
    let mut scene = Scene::<T>::with(Needs { job_bytes: REPLY_BYTES, ..needs(WakeUp::Block) });
    let running = scene.start_and_meet(0, Role::EchoBehindGate);
    // Without a limit, more than streams hold: nobody reads before the gate is open.
    let ahead = T::AHEAD.unwrap_or(50);
    for number in 0..ahead {
        scene.send(0, &vec![number as u8; REPLY_BYTES]);
    }
    if T::AHEAD.is_some() {
        let refused = scene.master().send(worker(0), &[b"one too many"]);
        assert!(matches!(refused, Err(TransportError::NotDelivered(w)) if w == worker(0)));
    }
    scene.gate().open();
    let seen = scene.collect(0, ahead);
    assert_eq!(seen.len(), ahead);
    for (number, seen) in seen.iter().enumerate() {
        assert!(*seen == vec![number as u8; REPLY_BYTES]);
    }
    scene.send(0, b"");
    running.finish();
}

pub fn promise_5_too_long_messages_are_refused<T: Transport>() {
    let mut scene = Scene::<T>::new();
    let running = scene.start(0, Role::TooMuch);
    assert_eq!(scene.next(0).len(), REPLY_BYTES);
    let refused = scene.master().send(worker(0), &[&bytes(JOB_BYTES), b"!"]);
    assert!(matches!(refused, Err(TransportError::TooLong { bytes: 1001, limit: JOB_BYTES })));
    scene.send(0, &bytes(JOB_BYTES));
    assert_eq!(scene.next(0), JOB_BYTES.to_ne_bytes());
    running.finish();
}

pub fn promise_6_wait_ends_for_a_message_a_descriptor_and_the_time<T: Transport>() {
    for wake_up in WakeUp::ALL {
        let mut scene = Scene::<T>::with(needs(wake_up));
        let (reader, mut writer) = std::io::pipe().unwrap();
        let watched = [reader.as_fd()];

        let begin = Instant::now();
        let limit = Duration::from_millis(30);
        scene.master().wait(&watched, limit).unwrap();
        assert!(begin.elapsed() >= limit, "woke without a reason");

        writer.write_all(b"x").unwrap();
        scene.master().wait(&watched, FOREVER).unwrap();

        let running = scene.start(0, Role::Echo);
        scene.master().wait(&[], FOREVER).unwrap();
        // It has come, and is not lost by waiting once more.
        scene.master().wait(&[], FOREVER).unwrap();
        assert_eq!(scene.next(0), b"hello");
        scene.send(0, b"");
        running.finish();
        assert!(begin.elapsed() < FOREVER);
    }
}

pub fn promise_6_nothing_is_missed_however_the_sides_wake<T: Transport>() {
    for wake_up in WakeUp::ALL {
        let mut scene = Scene::<T>::with(needs(wake_up));
        let running = [0, 1].map(|slot| scene.start_and_meet(slot, Role::Echo));
        for round in 0..300_u32 {
            scene.send(round % 2, &round.to_ne_bytes());
            assert_eq!(scene.next(round % 2), round.to_ne_bytes(), "{wake_up:?}");
        }
        (0..2).for_each(|slot| scene.send(slot, b""));
        running.into_iter().for_each(|running| running.finish());
    }
}

pub fn promise_7_what_was_sent_before_the_worker_was_killed_is_handed_over<T: Transport>() {
    let mut scene = Scene::<T>::new();
    let running = scene.start(0, Role::LastWords);
    let begin = Instant::now();
    while !scene.gate().0.exists() {
        assert!(begin.elapsed() < FOREVER, "the worker said nothing");
        std::thread::sleep(Duration::from_millis(1));
    }
    running.kill();
    let mut words = Vec::new();
    scene.master().close(worker(0), &mut |word| words.push(word.to_vec())).unwrap();
    assert_eq!(words, [&b"last"[..], b"words"]);
    let nothing = &mut |_: &[u8]| panic!("handed over before");
    scene.master().close(worker(0), nothing).unwrap();
}

pub fn promise_9_two_runs_do_not_see_each_other<T: Transport>() {
    let [mut first, mut second] = [Scene::<T>::new(), Scene::<T>::new()];
    let running = first.start_and_meet(0, Role::Echo);
    let other = second.start_and_meet(0, Role::Echo);
    second.send(0, b"");
    other.finish();
    second.master = None;

    first.send(0, b"still here?");
    assert_eq!(first.next(0), b"still here?");
    first.send(0, b"");
    running.finish();
}

pub fn promise_10_message_bytes_are_counted<T: Transport>() {
    let mut scene = Scene::<T>::new();
    let running = scene.start_and_meet(0, Role::Echo);
    scene.master().send(worker(0), &[b"1234", b"567"]).unwrap();
    scene.next(0);
    scene.send(0, b"");
    running.finish();
    scene.master().close(worker(0), &mut |_| panic!("all of it was received")).unwrap();
    assert_eq!(scene.master().traffic(worker(0)), Traffic { to_worker: 7, from_worker: 5 + 7 });
    assert_eq!(scene.master().traffic(worker(1)), Traffic::default());
}

pub fn promise_11_a_worker_notices_that_the_master_has_gone<T: Transport>() {
    for wake_up in WakeUp::ALL {
        let mut scene = Scene::<T>::with(needs(wake_up));
        let running = [
            scene.start_and_meet(0, Role::Orphan),
            scene.start(1, Role::SendingOrphan),
            scene.start_and_meet(2, Role::Orphan),
        ];
        // One's channel alone is as good as the master to it.
        scene.master().close(worker(2), &mut |_| panic!("said nothing")).unwrap();
        scene.collect(1, 1);
        scene.master = None;
        running.into_iter().for_each(|running| running.finish());
    }
}

pub fn promise_11_a_dead_worker_does_not_hold_the_master_up<T: Transport>() {
    let longest = 4 << 20;
    let mut scene = Scene::<T>::with(Needs { job_bytes: longest, ..needs(WakeUp::Block) });
    let deaf = scene.start_and_meet(0, Role::Deaf);
    let running = scene.start_and_meet(1, Role::Echo);
    scene.send(0, &bytes(longest));
    if deaf.pid().is_none() {
        scene.gate().open(); // a thread cannot be killed: this one goes by itself
    }
    deaf.kill();
    // Refused or lost, but neither a signal nor a wait.
    for _ in 0..3 {
        let sent = scene.master().send(worker(0), &[b"anybody?"]);
        assert!(matches!(sent, Ok(()) | Err(TransportError::NotDelivered(_))), "{sent:?}");
    }
    scene.send(1, b"ping");
    assert_eq!(scene.next(1), b"ping");
    scene.master().close(worker(0), &mut |_| {}).unwrap();
    scene.send(1, b"pong");
    assert_eq!(scene.next(1), b"pong");
    scene.send(1, b"");
    running.finish();
}
