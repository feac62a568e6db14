//! Figures and their limits.

use super::workloads::{LAST_ROW_TO_FIX, Workload};
use crate::Failure;

/// A number of the table; a limit is always an upper bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// What was measured.
    pub workload: String,
    /// Which of its figures, with the unit.
    pub metric: &'static str,
    /// The figure.
    pub value: f64,
    /// What it may be.
    pub limit: Option<f64>,
}

/// The exact count.
pub const INSTRUCTIONS: &str = "instructions";
/// Cycles of the serial estimate.
pub const SERIAL: &str = "serial estimate, cycles";
/// The serial estimate in milliseconds at 480 MHz.
pub const SERIAL_480: &str = "serial estimate at 480 MHz, ms";
const SERIAL_400: &str = "serial estimate at 400 MHz, ms";
const FLOOR: &str = "floor, cycles";
const LINES: &str = "memory lines";
const SERIAL_AND_MEMORY: &str = "serial estimate and memory at 480 MHz, ms";
const PER_SOURCE_PIXEL: &str = "instructions per source pixel";
const PER_OUTPUT_PIXEL: &str = "instructions per output pixel";
/// Bytes of an image.
pub const FLASH: &str = "flash, bytes";
/// Bytes of static data and stack.
pub const RAM: &str = "RAM, bytes";
/// The part of it that the paper's 25 KB are held against: what the paper's program did, too.
pub const RAM_WITHOUT_NAVIGATION: &str = "RAM without navigation, bytes";
/// The image that flies.
pub const APPLICATION: &str = "application";
/// Its part that rectifies.
pub const STAGE: &str = "rectification stage";

/// Cycles that a line of external memory is taken to cost: an assumption, as no measurement on the chip was found.
pub const CYCLES_PER_LINE: u64 = 50;
/// How much a count may differ from one of the same compiler.
pub const TOLERANCE: f64 = 0.005;

/// The largest whole count within the tolerance of `count`.
pub fn tolerated(count: f64) -> f64 {
    (count + count * TOLERANCE).floor()
}

const TO_64: &str = "rectify 512x512 to 64x64";
const TO_35: &str = "rectify 512x512 to 35x35";
const TO_256: &str = "rectify 512x512 to 256x256";

/// What may not be passed.
const LIMITS: [(&str, &str, f64); 13] = [
    (TO_64, PER_SOURCE_PIXEL, 3.5),
    (TO_64, SERIAL_480, 4.5),
    (TO_35, SERIAL_480, 4.0),
    (TO_256, PER_OUTPUT_PIXEL, 30.0),
    ("frame", SERIAL_480, 6.0),
    (LAST_ROW_TO_FIX, SERIAL_480, 4.5),
    ("frame, another year", SERIAL_480, 7.0),
    ("frame, attitude in doubt", SERIAL_480, 7.0),
    ("re-acquisition", SERIAL_480, 25.0),
    (APPLICATION, RAM, 32.0 * 1024.0),
    (APPLICATION, RAM_WITHOUT_NAVIGATION, 25.0 * 1024.0),
    (APPLICATION, FLASH, 512.0 * 1024.0),
    (STAGE, FLASH, 12.0 * 1024.0),
];

impl Figure {
    /// A figure with the limit it has.
    pub fn new(workload: &str, metric: &'static str, value: f64) -> Self {
        let limit = LIMITS.iter().find(|limit| (limit.0, limit.1) == (workload, metric)).map(|limit| limit.2);
        Figure { workload: workload.to_owned(), metric, value, limit }
    }

    /// This figure among others.
    pub fn of<'f>(&self, others: &'f [Figure]) -> Option<&'f Figure> {
        others.iter().find(|other| other.workload == self.workload && other.metric == self.metric)
    }

    /// Whether it passes its limit, or is no number.
    pub fn fails(&self) -> bool {
        self.limit.is_some_and(|limit| self.value.is_nan() || self.value > limit)
    }
}

/// Figures of all workloads.
pub fn of_workloads(workloads: &[Workload]) -> Vec<Figure> {
    let mut figures = Vec::new();
    for Workload { name, worst, .. } in workloads {
        let mut push = |metric, value| figures.push(Figure::new(name, metric, value));
        let ms = |cycles: u64, mhz: f64| cycles as f64 / (mhz * 1000.0);
        push(INSTRUCTIONS, worst.instructions as f64);
        match name.as_str() {
            TO_64 => push(PER_SOURCE_PIXEL, worst.instructions as f64 / (512.0 * 512.0)),
            TO_256 => push(PER_OUTPUT_PIXEL, worst.instructions as f64 / (256.0 * 256.0)),
            _ => {}
        }
        push(FLOOR, worst.floor as f64);
        push(SERIAL, worst.serial as f64);
        push(SERIAL_480, ms(worst.serial, 480.0));
        push(SERIAL_400, ms(worst.serial, 400.0));
        push(LINES, worst.lines as f64);
        push(SERIAL_AND_MEMORY, ms(worst.serial + CYCLES_PER_LINE * worst.lines, 480.0));
    }
    figures
}

/// A sentence for every limit that does not hold, or has no figure.
pub fn failures(figures: &[Figure]) -> Vec<Failure> {
    let passed = figures.iter().filter(|figure| figure.fails()).map(|figure| {
        let Figure { workload, metric, value, limit } = figure;
        let (what, unit) = metric.split_once(", ").unwrap_or((*metric, ""));
        let with_unit = |value: f64| format!("{} {unit}", number(value)).trim_end().to_owned();
        let source = if *metric == INSTRUCTIONS { " by the table of exact counts" } else { "" };
        let limit = with_unit(limit.unwrap_or(f64::NAN));
        format!("{workload}: {what}: needs {}, the limit is {limit}{source}", with_unit(*value))
    });
    let absent =
        LIMITS.iter().filter(|limit| !figures.iter().any(|f| (f.workload.as_str(), f.metric) == (limit.0, limit.1)));
    passed.chain(absent.map(|(workload, metric, _)| format!("{workload}: {metric}: there is no such figure"))).collect()
}

/// A sentence for everything that has grown since `revision`, where it was `before`.
pub fn grown(figures: &[Figure], before: &[Figure], revision: &str) -> Vec<Failure> {
    let grown = figures.iter().filter(|figure| figure.fails()).filter_map(|figure| {
        let before = figure.of(before)?.value;
        let percent = 100.0 * (figure.value / before - 1.0);
        let (value, before) = (number(figure.value), number(before));
        Some(format!(
            "{}: {}: grown by {percent:.1} % to {value}, from {before} at {revision}; 0.5 % are allowed",
            figure.workload, figure.metric
        ))
    });
    grown.collect()
}

/// A whole number as it is, others to three decimals.
pub fn number(value: f64) -> String {
    if value.fract() == 0.0 { format!("{value:.0}") } else { format!("{value:.3}") }
}

#[cfg(test)]
mod tests {
    use super::{Figure, LIMITS, RAM, SERIAL_480, failures, grown, of_workloads};
    use crate::budget::bench::Cost;
    use crate::budget::workloads::Workload;

    /// A figure at every limit.
    fn at_the_limits() -> Vec<Figure> {
        LIMITS.iter().map(|&(workload, metric, limit)| Figure::new(workload, metric, limit)).collect()
    }

    #[test]
    fn a_gate_fails_just_above_its_limit() {
        let figures = at_the_limits();
        assert_eq!(failures(&figures), Vec::<String>::new());
        for n in 0..figures.len() {
            for bad in [figures[n].value * 1.000_001, f64::NAN] {
                let mut worse = figures.clone();
                worse[n].value = bad;
                let sentences = failures(&worse);
                assert!(sentences.len() == 1 && sentences[0].starts_with(&figures[n].workload), "{sentences:?}");
            }
        }
    }

    #[test]
    fn a_limit_without_a_figure_fails() {
        let mut figures = at_the_limits();
        figures.retain(|figure| figure.metric != RAM);
        assert_eq!(failures(&figures), ["application: RAM, bytes: there is no such figure"]);
        figures.push(Figure::new("application", RAM, 32_769.0));
        assert_eq!(failures(&figures), ["application: RAM: needs 32769 bytes, the limit is 32768 bytes"]);
    }

    #[test]
    fn cycles_become_milliseconds() {
        let worst = Cost { instructions: 7, floor: 5, serial: 480_000, lines: 9600 };
        let figures = of_workloads(&[Workload { name: "frame".into(), worst, pose: String::new() }]);
        let value = |metric: &str| figures.iter().find(|figure| figure.metric == metric).map(|figure| figure.value);
        assert_eq!(value(SERIAL_480), Some(1.0));
        assert_eq!(value("serial estimate at 400 MHz, ms"), Some(1.2));
        assert_eq!(value("serial estimate and memory at 480 MHz, ms"), Some(2.0));
    }

    #[test]
    fn growth_is_told_in_percent() {
        let before = [Figure::new("frame", super::SERIAL, 1000.0)];
        let mut figure = Figure::new("frame", super::SERIAL, 1020.0);
        figure.limit = Some(1005.0);
        let expected = "frame: serial estimate, cycles: grown by 2.0 % to 1020, from 1000 at main; 0.5 % are allowed";
        assert_eq!(grown(&[figure], &before, "main"), [expected]);
    }
}
