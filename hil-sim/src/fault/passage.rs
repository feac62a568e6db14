//! What a scenario's timed faults make of the messages to the board, beside what [`FaultInjector`](super::FaultInjector) does to
//! each of them: what is missing, comes twice, late or again.

use crate::noise::{stream, uniform};
use crate::scenario::{FaultList, What};
use rand_chacha::ChaCha12Rng;
use std::collections::VecDeque;

/// The way of one flight's messages. Each fault draws from a stream of its own, while it is there.
#[derive(Debug)]
pub struct Passage {
    faults: FaultList,
    duplicates: ChaCha12Rng,
    reordering: ChaCha12Rng,
    /// A message that lets the next one pass.
    waiting: Option<Vec<u8>>,
    /// What was sent and when, as far back as a replay reaches.
    sent: VecDeque<(u64, Vec<u8>)>,
    reach_us: u64,
}

impl Passage {
    /// Before the first message.
    #[must_use]
    pub fn new(faults: FaultList, seed: u64) -> Self {
        let reach_s = faults.of(What::LinkReplay).map(|fault| fault.value).fold(0.0, f64::max);
        Passage {
            duplicates: stream(seed, "fault.link.duplicates"),
            reordering: stream(seed, "fault.link.reordering"),
            waiting: None,
            sent: VecDeque::new(),
            reach_us: (1e6 * reach_s) as u64,
            faults,
        }
    }

    /// What arrives when `message` is sent at `at_us`, in order.
    #[must_use]
    pub fn pass(&mut self, at_us: u64, message: &[u8]) -> Vec<Vec<u8>> {
        let faults = &self.faults;
        let share =
            |what, rng: &mut ChaCha12Rng| faults.at(what, at_us).any(|fault| uniform(rng) * 100.0 < fault.value);
        let mut arrived = Vec::new();
        let is_late = share(What::LinkReordering, &mut self.reordering) && self.waiting.is_none();
        if faults.is(What::LinkOff, at_us) {
            self.waiting = None;
        } else if is_late {
            self.waiting = Some(message.to_vec());
        } else {
            arrived.push(message.to_vec());
            arrived.extend(self.waiting.take());
        }
        if share(What::LinkDuplicates, &mut self.duplicates) {
            arrived.extend(arrived.first().cloned());
        }
        arrived.extend(self.old(at_us));
        if self.reach_us > 0 {
            self.sent.push_back((at_us, message.to_vec()));
        }
        arrived
    }

    /// What was sent so long ago as a replay goes back.
    fn old(&mut self, at_us: u64) -> Option<Vec<u8>> {
        let kept_us = at_us.saturating_sub(self.reach_us);
        // One older message is kept: the newest that is old enough.
        while self.sent.get(1).is_some_and(|(sent_us, _)| *sent_us <= kept_us) {
            self.sent.pop_front();
        }
        let fault = self.faults.at(What::LinkReplay, at_us).next()?;
        let then_us = at_us.checked_sub((1e6 * fault.value) as u64)?;
        let index = self.sent.partition_point(|(sent_us, _)| *sent_us <= then_us).checked_sub(1)?;
        self.sent.get(index).map(|(_, bytes)| bytes.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message each 10 ms, numbered; what arrives of each. Outside of 2 s to 4 s each is checked to arrive as it was sent.
    fn flown(word: &str) -> Vec<Vec<u32>> {
        let faults = [format!("{word}@2..4").parse().expect(word)].into_iter().collect();
        let mut passage = Passage::new(faults, 1);
        let arrived: Vec<Vec<u32>> = (0_u32..600)
            .map(|index| {
                let arrived = passage.pass(u64::from(index) * 10_000, &index.to_le_bytes());
                arrived.iter().map(|bytes| u32::from_le_bytes(bytes[..].try_into().expect("four bytes"))).collect()
            })
            .collect();
        // One that waits when the fault ends comes after it.
        for index in (0..200).chain(401..600) {
            assert_eq!(arrived[index as usize], [index], "{word}");
        }
        arrived[200..401].to_vec()
    }

    #[test]
    fn nothing_arrives_over_a_link_that_is_off() {
        let arrived = flown("link.off");
        assert!(arrived[..200].iter().all(Vec::is_empty));
        assert_eq!(arrived[200], [400]);
    }

    #[test]
    fn messages_arrive_twice() {
        for (index, arrived) in (200..400).zip(flown("link.duplicates=100")) {
            assert_eq!(arrived, [index, index]);
        }
        let some = flown("link.duplicates=30").iter().filter(|arrived| arrived.len() == 2).count();
        // 60, give or take four of their deviations.
        assert!((34..86).contains(&some), "{some}");
    }

    #[test]
    fn messages_let_the_next_one_pass() {
        let arrived = flown("link.reordering=30");
        let mut all: Vec<u32> = arrived.concat();
        let swapped = all.windows(2).filter(|pair| pair[0] == pair[1] + 1).count();
        assert!((20..80).contains(&swapped), "{swapped}");
        all.sort_unstable();
        assert_eq!(all, (200..=400).collect::<Vec<_>>(), "none is lost, none comes twice");
    }

    #[test]
    fn old_messages_come_again() {
        for (index, arrived) in (200..400).zip(flown("link.replay=0.5")) {
            assert_eq!(arrived, [index, index - 50]);
        }
        // Before there is anything that old.
        let mut passage = Passage::new(["link.replay=3".parse().expect("a fault")].into_iter().collect(), 1);
        assert_eq!(passage.pass(0, &[1]), [[1]]);
        assert_eq!(passage.pass(2_999_999, &[2]), [[2]]);
        assert_eq!(passage.pass(3_000_000, &[3]), [[3], [1]]);
    }
}
