//! Damaged inputs for every reader of bytes; `cargo xtask fuzz` makes ten million of each.

use plumbline_tests::fuzz::{SLOWEST_OVER_MEAN, hunt, targets};

const SEED: u64 = 20_261_122;

fn are_survived(inputs: u64) {
    for mut target in targets() {
        let name = target.name();
        match hunt(target.as_mut(), SEED, inputs, &mut |_| {}) {
            Ok(hunted) => {
                println!("{name}: {hunted:?}");
                assert_eq!(hunted.inputs, inputs);
                assert!(hunted.slowest_over_mean < SLOWEST_OVER_MEAN, "{name}: {hunted:?}");
            }
            Err(found) => panic!("{name}, input {} of seed {SEED}: {}: {:02x?}", found.number, found.what, found.input),
        }
    }
}

#[test]
fn damaged_inputs_are_survived() {
    are_survived(2_000);
}

#[test]
#[ignore = "long: 100,000 damaged inputs for each of eleven readers"]
fn many_damaged_inputs_are_survived() {
    are_survived(100_000);
}

/// Were its checksum made wrong, no mutation would come further than to it.
#[test]
fn sealing_leaves_whole_inputs_as_they_are() {
    for target in targets() {
        for seed in target.seeds() {
            let mut sealed = seed.clone();
            target.seal(&mut sealed);
            assert!(sealed.starts_with(&seed), "{}", target.name());
        }
    }
}
