//! A board as boards are: several things have happened before the firmware looks, its timer goes on while it works, bytes
//! come in portions, and its tasks run in any order. What it logs is what it did, so its replay is its flight too.

use super::flown::{csv, replayed, scenario};
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::{Event, Link, LinkError};
use plumbline_sim::replay::fixes_csv;
use plumbline_sim::run::{Keep, fly};
use plumbline_sim::setup::Setup;

/// Lets things happen, and the firmware work only now and then.
struct Late {
    link: InProcess,
    step: u32,
}

impl Link for Late {
    fn step(&mut self, timer: u32, event: Event<'_>) -> Result<Vec<u8>, LinkError> {
        self.link.happen(timer, event);
        self.step += 1;
        // A frame or a pulse that the next would overwrite is not kept waiting.
        let is_waiting = !self.step.is_multiple_of(4) && matches!(event, Event::Bytes(_) | Event::Edge { .. });
        Ok(if is_waiting { Vec::new() } else { self.link.work() })
    }

    fn annotate(&mut self, bytes: &[u8]) {
        self.link.annotate(bytes);
    }
}

#[test]
fn an_untidy_board_replays_as_it_flew() {
    let mut tidy = String::new();
    let mut scenario = scenario(7, 40);
    (scenario.faults.shutter.extra_edge_percent, scenario.faults.shutter.lost_frame_percent) = (10.0, 40.0);
    let setup = Setup::prepare(scenario).expect("it can be flown");
    for seed in 0..3 {
        let mut late = Late { link: InProcess::logged(&setup.flash).expect("it boots"), step: 0 };
        if seed > 0 {
            late.link.untidy(seed);
        }
        let flight = fly(&setup, &mut late, Keep::default(), &mut ()).expect("it flies");
        let fixes = csv(&setup, &flight);
        if seed == 0 {
            tidy = fixes.clone();
        } else {
            assert_ne!(fixes, tidy, "seed {seed}: the disorder does nothing");
        }
        let (log, replayed) = replayed(&late.link.close_log());
        assert_eq!(replayed.first_difference, None, "seed {seed}");
        assert_eq!(replayed.replayed, replayed.records);
        assert_eq!(fixes_csv(&log, None, &replayed).expect("placed"), fixes, "seed {seed}");
        assert!(replayed.accepted > 10, "seed {seed}: {}", replayed.accepted);
    }
}
