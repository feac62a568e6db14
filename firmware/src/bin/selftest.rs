//! Proves the emulated board's layer, without the application. `cargo xtask test` is the other half: it shares the
//! window's file, sends bytes that must come back, rings, and compares the exit code.
//!
//! Results are reported on the emulator's standard error, one line each.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod board {
    use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
    use cortex_m_rt::entry;
    use embassy_executor::raw::Executor;
    use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
    use embassy_sync::signal::Signal;
    use embassy_time::{Duration, Instant, Timer};
    use plumbline_core::selftest::{Difference, Kernel};
    use plumbline_firmware::an500::idle::{EmulatedTime, wait_for_interrupt};
    use plumbline_firmware::an500::{self, doorbell, instructions, psram, stack, time_driver, uart};
    use plumbline_firmware::run::{self, Pending};
    use plumbline_firmware::shared_memory::{FRAME, MAGIC, MAGIC_VALUE, STATUS, STEP, STEP_DONE};
    use semihosting::eprintln;
    use static_cell::StaticCell;

    /// Rows of a frame, and what one takes on the sensor, whole microseconds.
    const ROWS: u32 = 512;
    const ROW_US: u64 = 31;
    /// Bytes of the pattern that the host writes at [`FRAME`].
    const PATTERN_BYTES: usize = 4096;
    /// The step that ends the test; others are answered and nothing else.
    const LAST_STEP: u32 = u32::MAX;

    /// The step from which on received bytes are sent back.
    const ECHO_STEP: u32 = u32::MAX - 1;
    /// Word of the window: bytes received up to the step.
    const RECEIVED: usize = 0x88;

    /// What the sleeper sleeps.
    const SLEEP_US: u64 = 500;

    static SLEEP: Signal<CriticalSectionRawMutex, ()> = Signal::new();
    static ECHO: Signal<CriticalSectionRawMutex, ()> = Signal::new();
    static PENDING: Pending = Pending::new();
    static FAILURES: AtomicU32 = AtomicU32::new(0);
    static TIMED: AtomicBool = AtomicBool::new(false);
    /// When the rest was left to the host, microseconds.
    static LEFT_US: AtomicU32 = AtomicU32::new(0);

    fn check(name: &str, good: bool, value: u64) {
        eprintln!("selftest: {} {name}: {value}", if good { "ok" } else { "FAILED" });
        FAILURES.fetch_add(u32::from(!good), Ordering::Relaxed);
    }

    /// Sends back what it receives, from [`ECHO_STEP`] on: until then the ring fills up and the sender is held back.
    #[embassy_executor::task]
    async fn echo() {
        ECHO.wait().await;
        let mut buffer = [0; 64];
        loop {
            let count = uart::read(&mut buffer).await;
            uart::write(buffer.get(..count).unwrap_or(&[]));
        }
    }

    /// Has an alarm set while others work.
    #[embassy_executor::task]
    async fn sleeper() {
        SLEEP.wait().await;
        Timer::after_micros(SLEEP_US).await;
    }

    /// Both versions of every kernel of the core give the same bits.
    fn kernels() {
        for kernel in Kernel::all() {
            match kernel.check() {
                Ok(()) => eprintln!("selftest: ok kernel {}", kernel.name),
                Err(Difference { seed, at, portable, armv7em }) => {
                    let name = kernel.name;
                    eprintln!("selftest: FAILED kernel {name}: seed {seed}, value {at} is {armv7em}, not {portable}");
                    FAILURES.fetch_add(1, Ordering::Relaxed);
                }
            }
        }
    }

    /// What the board does alone.
    #[embassy_executor::task]
    async fn alone() {
        clock();
        rows().await;
        alarms().await;
        let (_, cost) = instructions::counted(|| {
            for _ in 0..1000 {
                cortex_m::asm::nop();
            }
        });
        check("instructions of 1000 times nop and branch", (2000..8000).contains(&cost), u64::from(cost));
        // So far nothing came from the world outside: two runs must agree on every instruction.
        eprintln!("selftest: counts so far: {}", time_driver::counter());
        window();
        LEFT_US.store(Instant::now().as_micros() as u32, Ordering::Relaxed);
        TIMED.store(true, Ordering::Release);
    }

    /// The clock runs, and never backwards.
    fn clock() {
        // The counter wraps within the first millisecond.
        let (mut last, mut backwards, mut longest_us) = (Instant::now(), 0, 0);
        while last < Instant::from_micros(2000) {
            let now = Instant::now();
            backwards += u64::from(now < last);
            longest_us = longest_us.max(now.saturating_duration_since(last).as_micros());
            last = now;
        }
        check("microseconds between two readings at most", longest_us <= 3, longest_us);
        check("readings of the clock that ran backwards", backwards == 0, backwards);
    }

    /// Waits for instants and for delays.
    async fn rows() {
        // Absolute instants, as rows are due: the delays of waking do not add up.
        let begin = Instant::now();
        let mut late_us = 0;
        for row in 1..=u64::from(ROWS) {
            let due = begin + Duration::from_micros(row * ROW_US);
            Timer::at(due).await;
            late_us = late_us.max(Instant::now().saturating_duration_since(due).as_micros());
        }
        let elapsed_us = begin.elapsed().as_micros();
        let wanted_us = u64::from(ROWS) * ROW_US;
        check("microseconds of 512 rows", (wanted_us..=wanted_us + 2).contains(&elapsed_us), elapsed_us);
        check("microseconds a row came late at most", late_us <= 2, late_us);

        let begin = Instant::now();
        for _ in 0..ROWS {
            Timer::after_micros(ROW_US).await;
        }
        // Each wait rounds up to a whole microsecond and takes some instructions to begin.
        let elapsed_us = begin.elapsed().as_micros();
        check(
            "microseconds of 512 delays",
            (wanted_us..wanted_us + 3 * u64::from(ROWS)).contains(&elapsed_us),
            elapsed_us,
        );
    }

    /// Waits far away, and alarms while a task works.
    async fn alarms() {
        // Longer than a timer's period of 171.8 s.
        let begin = Instant::now();
        Timer::after_secs(1000).await;
        let elapsed_us = begin.elapsed().as_micros();
        check("microseconds of 1000 s", (1_000_000_000..1_000_000_010).contains(&elapsed_us), elapsed_us);
        // An alarm that falls due while a task works comes by its interrupt.
        SLEEP.signal(());
        // Long enough for the sleeper to begin.
        Timer::after_micros(20).await;
        let begin = Instant::now();
        let is_early = PENDING.is_set();
        while begin.elapsed() < Duration::from_micros(2 * SLEEP_US) {}
        check("alarm by interrupt", !is_early && PENDING.is_set(), begin.elapsed().as_micros());
    }

    /// The pattern lies there as the host wrote it. Tells the host its sum, for which the host waits before it rings.
    fn window() {
        check(
            "magic word of the window",
            psram::word(MAGIC) == Some(MAGIC_VALUE),
            u64::from(psram::word(MAGIC).unwrap_or(0)),
        );
        // SAFETY: the host writes the pattern before it starts the emulator and leaves it alone.
        let pattern = unsafe { psram::bytes(FRAME, PATTERN_BYTES) }.unwrap_or(&[]);
        let wrong = pattern.iter().enumerate().filter(|&(n, &byte)| byte != (n * 7 % 251) as u8).count();
        check("wrong bytes of the pattern", pattern.len() == PATTERN_BYTES && wrong == 0, wrong as u64);
        let sum = pattern.iter().fold(0u32, |sum, &byte| sum.wrapping_add(u32::from(byte)));
        check("window takes a word", psram::set_word(STATUS, sum), u64::from(sum));
        let refused = psram::word(2).is_none() && psram::word(16 << 20).is_none() && !psram::set_word(usize::MAX, 0);
        check("window refuses what lies outside", refused, u64::from(refused));
    }

    fn finish() -> ! {
        let (fixed, used, whole) = (stack::static_bytes(), stack::high_water_bytes(), stack::room_bytes());
        check("bytes of static RAM", fixed > 0 && fixed < 65536, u64::from(fixed));
        check("bytes of stack at most", used > 64 && used < whole, u64::from(used));
        check("bytes received", uart::received_total() > 0 && !uart::has_unread(), u64::from(uart::received_total()));
        // The clock stands while the host is waited for. Were a timer running, the emulator would skip to its end.
        let host_us = (Instant::now().as_micros() as u32).wrapping_sub(LEFT_US.load(Ordering::Relaxed));
        check("microseconds of work for the host", host_us < 100_000, u64::from(host_us));
        let failures = FAILURES.load(Ordering::Relaxed);
        eprintln!("selftest: {failures} failed");
        an500::exit(failures == 0)
    }

    #[entry]
    fn main() -> ! {
        static EXECUTOR: StaticCell<Executor> = StaticCell::new();
        an500::start();
        let executor: &'static Executor = EXECUTOR.init(run::executor(&PENDING));
        let spawner = executor.spawner();
        let tasks = [
            alone().map(|task| spawner.spawn(task)),
            sleeper().map(|task| spawner.spawn(task)),
            echo().map(|task| spawner.spawn(task)),
        ];
        kernels();
        check("tasks started", tasks.iter().all(Result::is_ok), tasks.len() as u64);
        loop {
            run::until_idle(executor, &PENDING);
            if TIMED.load(Ordering::Acquire) && doorbell::take() {
                let step = psram::word(STEP).unwrap_or(LAST_STEP);
                psram::set_word(STEP_DONE, step);
                psram::set_word(RECEIVED, uart::received_total());
                doorbell::answer();
                match step {
                    LAST_STEP => finish(),
                    ECHO_STEP => ECHO.signal(()),
                    _ => {}
                }
            }
            let rung = || TIMED.load(Ordering::Acquire) && doorbell::has_rung();
            wait_for_interrupt(&PENDING, EmulatedTime::Runs, rung);
        }
    }
}
