//! Damaged inputs for everything that reads bytes from outside: valid ones, mutated from a seed.
//!
//! [`hunt`] draws input after input and hands each to a [`Target`], which says what must hold whatever the bytes are. The
//! same seed makes the same inputs, on every machine. `cargo test` runs 2,000 of each target, its long tests 100,000,
//! `cargo xtask fuzz` ten million, and cargo-fuzz's coverage-guided search starts from [`Target::seeds`] too (`fuzz/`).

mod flight_log;
mod line;
mod log;
mod mavlink;
mod mutate;
mod signing;
mod stores;

use mutate::mutated;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

/// Something that reads bytes.
pub trait Target {
    /// Its name on the command line.
    fn name(&self) -> &'static str;
    /// Valid inputs.
    fn seeds(&self) -> Vec<Vec<u8>>;
    /// Makes the checksums of an input right again, as far as it has any: behind them the interesting mistakes begin.
    fn seal(&self, input: &mut Vec<u8>);
    /// Reads `input`.
    ///
    /// # Errors
    /// What does not hold that must.
    fn read(&mut self, input: &[u8]) -> Result<(), String>;
}

/// All of them.
pub fn targets() -> Vec<Box<dyn Target>> {
    vec![
        Box::new(mavlink::Mavlink::new()),
        Box::new(stores::Configuration::new()),
        Box::new(stores::Tiles),
        Box::new(stores::Plan),
        Box::new(signing::KeyStore),
        Box::new(signing::Signed::new()),
        Box::new(stores::Camera),
        Box::new(log::Log::new()),
        Box::new(flight_log::FlightLog),
        Box::new(line::Device),
        Box::new(line::Host),
    ]
}

/// An input that must not be, and what it did.
#[derive(Debug)]
pub struct Found {
    /// Which one, from 0.
    pub number: u64,
    /// Its bytes.
    pub input: Vec<u8>,
    /// The invariant, or the panic.
    pub what: String,
}

/// What a hunt has to say.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hunted {
    /// Inputs read.
    pub inputs: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Longest time that an input took, of the best of several readings, over the mean time of all.
    pub slowest_over_mean: f64,
}

/// No input may take so many times what they take in the mean: a search that grows with the square of a length would.
pub const SLOWEST_OVER_MEAN: f64 = 2000.0;

/// Readings of an input that seemed slow: on a machine with other things to do the first one says little.
const READINGS: usize = 5;

/// Reads inputs `0..inputs` of `seed`; `progress` is told how many are done.
///
/// # Errors
/// [`Found`], at the first input that must not be.
pub fn hunt(
    target: &mut dyn Target,
    seed: u64,
    inputs: u64,
    progress: &mut dyn FnMut(u64),
) -> Result<Hunted, Box<Found>> {
    let seeds = target.seeds();
    let (mut bytes, mut total, mut slowest) = (0, Duration::ZERO, Duration::ZERO);
    for number in 0..inputs {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(number);
        let mut input = mutated(&seeds, &mut random);
        if random.next_u32().is_multiple_of(2) {
            target.seal(&mut input);
        }
        let read = |target: &mut dyn Target, input: &[u8]| {
            let begin = Instant::now();
            let outcome = catch_unwind(AssertUnwindSafe(|| target.read(input)));
            (outcome.unwrap_or_else(|panic| Err(format!("panicked: {}", words(panic.as_ref())))), begin.elapsed())
        };
        let (outcome, mut took) = read(target, &input);
        total += took;
        for _ in 1..READINGS {
            if took <= slowest || outcome.is_err() {
                break;
            }
            took = took.min(read(target, &input).1);
        }
        slowest = slowest.max(took);
        bytes += input.len() as u64;
        if let Err(what) = outcome {
            return Err(Box::new(Found { number, input, what }));
        }
        progress(number + 1);
    }
    let mean = total.as_secs_f64() / inputs.max(1) as f64;
    Ok(Hunted { inputs, bytes, slowest_over_mean: slowest.as_secs_f64() / mean.max(f64::MIN_POSITIVE) })
}

/// What a panic said.
fn words(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned())).unwrap_or_default()
}
