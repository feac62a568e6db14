//! What every search does: the reader of that name, kept from input to input, must say that all holds.

use plumbline_tests::fuzz::{Target, targets};
use std::cell::RefCell;

thread_local! {
    static TARGET: RefCell<Option<Box<dyn Target>>> = const { RefCell::new(None) };
}

pub fn read(name: &str, input: &[u8]) {
    TARGET.with_borrow_mut(|target| {
        let target = target.get_or_insert_with(|| {
            targets().into_iter().find(|target| target.name() == name).expect("a reader of that name")
        });
        if let Err(what) = target.read(input) {
            panic!("{what}");
        }
    });
}
