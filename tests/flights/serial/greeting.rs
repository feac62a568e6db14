//! A board in flight: it hears the greeting, goes away with its port, and comes back for the simulator.

use super::{flown, in_process, open, setup, small, socket};
use plumbline_firmware::h743::hello::Listener;
use plumbline_sim::link::device::Device;
use plumbline_sim::link::pace::Patience;
use std::io::Read;
use std::os::unix::net::UnixListener;
use std::time::Duration;

#[test]
fn a_board_in_flight_leaves_it_for_the_simulator() {
    let setup = setup(small(3, 3));
    let path = socket("flight");
    let listener = UnixListener::bind(&path).expect("a socket");
    let board = std::thread::spawn({
        let path = path.clone();
        move || {
            let (mut stream, _) = listener.accept().expect("a simulator");
            let (mut heard, mut buffer) = (Listener::default(), [0; 7]);
            loop {
                let count = stream.read(&mut buffer).expect("the simulator stays");
                assert!(count > 0, "the simulator left without a greeting");
                if heard.hear(&buffer[..count]) {
                    break;
                }
            }
            // It restarts: the port is gone for a while.
            drop((stream, listener));
            std::fs::remove_file(&path).expect("it was there");
            std::thread::sleep(Duration::from_millis(300));
            Device::socket(&path).expect("the port again")
        }
    });
    let mut link = open(&setup, &path, Patience::default());
    let flight = flown(&setup, &mut link);
    drop(link);
    drop(board.join().expect("a board"));
    assert_eq!(flight.csv, in_process(&setup).csv);
}
