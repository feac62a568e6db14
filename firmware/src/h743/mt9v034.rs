//! The sensor MT9V034: what to write into which register, computed.
//!
//! Register numbers and meanings by the data sheet (onsemi MT9V034/D, tables 8 to 10); choices that it leaves open as the
//! camera's own public driver has them (clearing the reserved bit 9 of chip control, blanking for this processor).
//! Context A throughout. Frames are taken on demand (snapshot mode): a pulse on EXPOSURE opens the shutter of all pixels,
//! rows come when it has closed.

/// Address on the bus, 7 bits.
pub const ADDRESS: u8 = 0x5c;
/// R0x00 of the MT9V034. The older MT9V032 says 0x1313 and has other registers: it is refused by name.
pub const CHIP_VERSION: u16 = 0x1324;
/// R0x00 of the MT9V032.
pub const CHIP_VERSION_MT9V032: u16 = 0x1313;
/// Pixels of the sensor, (cols, rows).
pub const PIXELS: (u16, u16) = (752, 480);

/// Register numbers.
pub mod register {
    /// Chip version, read only.
    pub const CHIP_VERSION: u8 = 0x00;
    /// First column, from 1.
    pub const COLUMN_START: u8 = 0x01;
    /// First row, from 4.
    pub const ROW_START: u8 = 0x02;
    /// Rows of the sensor in the window.
    pub const WINDOW_HEIGHT: u8 = 0x03;
    /// Columns of the sensor in the window.
    pub const WINDOW_WIDTH: u8 = 0x04;
    /// Pixel clocks between rows.
    pub const HORIZONTAL_BLANKING: u8 = 0x05;
    /// Rows between frames.
    pub const VERTICAL_BLANKING: u8 = 0x06;
    /// Mode, output, context.
    pub const CHIP_CONTROL: u8 = 0x07;
    /// Exposure, whole rows.
    pub const COARSE_SHUTTER: u8 = 0x0b;
    /// Reset.
    pub const RESET: u8 = 0x0c;
    /// Binning and flips.
    pub const READ_MODE: u8 = 0x0d;
    /// High dynamic range and colour.
    pub const PIXEL_OPERATION: u8 = 0x0f;
    /// Companding of the converter.
    pub const COMPANDING: u8 = 0x1c;
    /// Analogue gain, sixteenths.
    pub const ANALOGUE_GAIN: u8 = 0x35;
    /// Row noise correction.
    pub const ROW_NOISE: u8 = 0x70;
    /// Polarity of the pixel clock.
    pub const PIXEL_CLOCK: u8 = 0x72;
    /// Largest gain of the automatic gain control, sixteenths.
    pub const GAIN_MAX: u8 = 0xab;
    /// Automatic exposure and gain.
    pub const AUTOMATIC: u8 = 0xaf;
    /// Pixels that the automatic controls use, eighths of a frame's.
    pub const PIXEL_COUNT: u8 = 0xb0;
    /// Exposure, pixel clocks beyond the whole rows.
    pub const FINE_SHUTTER: u8 = 0xd5;
}

/// Bits of chip control: snapshot mode, outputs on, simultaneous read-out (RM default), context A.
const CHIP_CONTROL_SNAPSHOT: u16 = 3 << 3 | 1 << 7 | 1 << 8;
/// Read mode's reserved bits, which read as one, and both flips: the module sits upside down.
const READ_MODE_BASE: u16 = 0x0300 | 1 << 4 | 1 << 5;
/// Blanking that the data sheet has as default; this processor gets what narrower windows leave of a row besides.
const BLANKING_DEFAULT: u16 = 94;
/// Columns whose missing part is added to the blanking.
const BLANKING_FULL: u16 = 640;
/// Least columns plus blanking, pixel clocks: the converters' own time.
const ROW_MIN: u16 = 690;
/// Rows between two frames. Snapshot mode needs few; the default.
const VERTICAL_BLANKING: u16 = 45;
/// Least and most gain, sixteenths.
pub const GAIN: (u16, u16) = (16, 64);
/// Automatic gain on, automatic exposure off: the stamp needs an exposure that is known.
const AUTOMATIC_GAIN_ONLY: u16 = 1 << 1;

/// What the sensor is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// Frame as it arrives, (cols, rows), in pixels after binning.
    pub frame: (u16, u16),
    /// Exposure, microseconds.
    pub exposure_us: u32,
    /// The sensor's clock, Hz.
    pub clock_hz: u32,
}

/// Why the sensor cannot do it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(target_os = "none", feature = "h743"), derive(defmt::Format))]
pub enum SensorError {
    /// No such window: larger than the sensor, empty, or no multiple of four columns.
    Window,
    /// Shorter than one row or longer than the shutter's counter.
    Exposure,
}

/// A register and its value.
pub type Write = (u8, u16);

/// What the sensor will do, and the writes that make it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Binning both ways: 1, 2 or 4.
    pub binning: u16,
    /// Sensor pixels of the window, (cols, rows).
    pub window: (u16, u16),
    /// First column and row of the window, centred.
    pub start: (u16, u16),
    /// Pixel clocks between rows.
    pub blanking: u16,
    /// Exposure in whole rows and in pixel clocks beyond.
    pub shutter: (u16, u16),
}

impl Setting {
    /// The setting for what is wanted.
    ///
    /// Binning is taken where the whole view fits a half or a quarter of the sensor: the field of view stays. One that is
    /// larger is a window out of the middle.
    ///
    /// # Errors
    /// [`SensorError`].
    pub fn new(wanted: &Wanted) -> Result<Setting, SensorError> {
        let (cols, rows) = wanted.frame;
        if cols == 0 || rows == 0 || !cols.is_multiple_of(4) || cols > PIXELS.0 || rows > PIXELS.1 {
            return Err(SensorError::Window);
        }
        let binning = match () {
            () if cols <= PIXELS.0 / 4 && rows <= PIXELS.1 / 4 => 4,
            () if cols <= PIXELS.0 / 2 && rows <= PIXELS.1 / 2 => 2,
            () => 1,
        };
        let window = (cols * binning, rows * binning);
        let start = ((PIXELS.0 - window.0) / 2 + 1, (PIXELS.1 - window.1) / 2 + 4);
        let blanking = BLANKING_DEFAULT + (PIXELS.0 - window.0.min(BLANKING_FULL));
        let blanking = blanking.max(ROW_MIN.saturating_sub(window.0));
        Setting { binning, window, start, blanking, shutter: (0, 0) }.exposed(wanted.exposure_us, wanted.clock_hz)
    }

    /// This setting with another exposure.
    ///
    /// # Errors
    /// [`SensorError::Exposure`].
    pub fn exposed(self, exposure_us: u32, clock_hz: u32) -> Result<Setting, SensorError> {
        let row = u64::from(self.row_clocks().max(1));
        let clocks = u64::from(exposure_us) * u64::from(clock_hz) / 1_000_000;
        let shutter = (u16::try_from(clocks / row).unwrap_or(u16::MAX), (clocks % row) as u16);
        if shutter.0 == 0 || shutter.0 > 32_767 {
            return Err(SensorError::Exposure);
        }
        Ok(Setting { shutter, ..self })
    }

    /// The writes of the exposure alone, which the sensor takes between two frames.
    pub fn exposure_writes(&self) -> [Write; 2] {
        [(register::COARSE_SHUTTER, self.shutter.0), (register::FINE_SHUTTER, self.shutter.1)]
    }

    /// Pixel clocks from row to row of the sensor; a frame's row takes `binning` of them.
    pub fn row_clocks(&self) -> u32 {
        u32::from(self.window.0 + self.blanking)
    }

    /// From row to row of the frame, nanoseconds.
    pub fn row_time_ns(&self, clock_hz: u32) -> u32 {
        (u64::from(self.row_clocks()) * u64::from(self.binning) * 1_000_000_000 / u64::from(clock_hz.max(1))) as u32
    }

    /// The exposure that the shutter's counters make, nanoseconds.
    pub fn exposure_ns(&self, clock_hz: u32) -> u64 {
        let clocks = u64::from(self.shutter.0) * u64::from(self.row_clocks()) + u64::from(self.shutter.1);
        clocks * 1_000_000_000 / u64::from(clock_hz.max(1))
    }

    /// Writes in their order, after a reset. Mode last: nothing is triggered before it stands.
    pub fn writes(&self) -> [Write; 17] {
        use register as r;
        let bin = self.binning.trailing_zeros() as u16;
        let pixels = u32::from(self.window.0 / self.binning) * u32::from(self.window.1 / self.binning);
        [
            (r::COLUMN_START, self.start.0),
            (r::ROW_START, self.start.1),
            (r::WINDOW_WIDTH, self.window.0),
            (r::WINDOW_HEIGHT, self.window.1),
            (r::HORIZONTAL_BLANKING, self.blanking),
            (r::VERTICAL_BLANKING, VERTICAL_BLANKING),
            (r::READ_MODE, READ_MODE_BASE | bin | bin << 2),
            (r::PIXEL_OPERATION, 0),
            // Linear, 10 bits to 8, in both contexts.
            (r::COMPANDING, 2 | 2 << 8),
            (r::ROW_NOISE, 1 | 1 << 8),
            (r::COARSE_SHUTTER, self.shutter.0),
            (r::FINE_SHUTTER, self.shutter.1),
            (r::ANALOGUE_GAIN, GAIN.0),
            (r::GAIN_MAX, GAIN.1),
            (r::PIXEL_COUNT, (pixels / 8) as u16),
            // At the full rate the clock is inverted, for the time that data need before the edge.
            (r::PIXEL_CLOCK, if self.binning == 1 { 1 << 4 } else { 0 }),
            (r::CHIP_CONTROL, CHIP_CONTROL_SNAPSHOT),
        ]
    }

    /// The write that lets gain alone be automatic; apart, since it wants a frame in between.
    pub fn automatic() -> Write {
        (register::AUTOMATIC, AUTOMATIC_GAIN_ONLY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOCK: u32 = 26_666_667;

    fn setting(frame: (u16, u16), exposure_us: u32) -> Result<Setting, SensorError> {
        Setting::new(&Wanted { frame, exposure_us, clock_hz: CLOCK })
    }

    fn value(setting: &Setting, register: u8) -> u16 {
        setting.writes().iter().find(|(r, _)| *r == register).unwrap().1
    }

    #[test]
    fn the_whole_sensor_is_read_from_its_first_pixel() {
        let all = setting(PIXELS, 2000).unwrap();
        assert_eq!((all.binning, all.start, all.window), (1, (1, 4), PIXELS));
        assert_eq!(value(&all, register::READ_MODE), 0x0330);
        assert_eq!(value(&all, register::CHIP_CONTROL), 0x0198);
        assert_eq!(all.row_clocks(), 752 + 94 + 112);
    }

    #[test]
    fn a_window_lies_in_the_middle() {
        let window = setting((512, 480), 2000).unwrap();
        assert_eq!((window.start, window.blanking), ((121, 4), 94 + 240));
        // 846 clocks: the 31.7 microseconds that the simulator's camera has.
        assert_eq!(window.row_time_ns(CLOCK) / 100, 317);
    }

    #[test]
    fn small_frames_are_binned_and_keep_their_field_of_view() {
        let half = setting((376, 240), 2000).unwrap();
        assert_eq!((half.binning, half.window, half.start), (2, PIXELS, (1, 4)));
        assert_eq!(value(&half, register::READ_MODE) & 0xf, 0b0101);
        let quarter = setting((128, 120), 2000).unwrap();
        assert_eq!((quarter.binning, quarter.window), (4, (512, 480)));
        assert_eq!(value(&quarter, register::READ_MODE) & 0xf, 0b1010);
        assert_eq!(value(&quarter, register::PIXEL_CLOCK), 0);
    }

    #[test]
    fn the_shutter_makes_the_exposure_to_a_pixel_clock() {
        for exposure_us in [37, 100, 1000, 2000, 5000, 20_000] {
            let setting = setting(PIXELS, exposure_us).unwrap();
            let off = setting.exposure_ns(CLOCK) as i64 - i64::from(exposure_us) * 1000;
            assert!((-39..=0).contains(&off), "{exposure_us} us is off by {off} ns");
            assert!(u32::from(setting.shutter.1) < setting.row_clocks());
        }
    }

    #[test]
    fn an_exposure_is_changed_by_the_shutter_alone() {
        let (short, long) = (setting((512, 480), 500).unwrap(), setting((512, 480), 8000).unwrap());
        assert_eq!(short.exposed(8000, CLOCK), Ok(long));
        let changed = short.writes().into_iter().zip(long.writes()).filter(|(a, b)| a != b).map(|(_, b)| b);
        assert!(changed.eq(long.exposure_writes()));
        assert_eq!(short.exposed(10, CLOCK), Err(SensorError::Exposure));
    }

    #[test]
    fn what_the_sensor_cannot_do_is_refused() {
        for frame in [(756, 480), (752, 481), (0, 480), (750, 480), (752, 0)] {
            assert_eq!(setting(frame, 2000), Err(SensorError::Window), "{frame:?}");
        }
        assert_eq!(setting(PIXELS, 10), Err(SensorError::Exposure));
        assert_eq!(setting(PIXELS, 4_000_000_000), Err(SensorError::Exposure));
    }

    #[test]
    fn no_row_is_shorter_than_the_converters_need() {
        for cols in (4..=752).step_by(4) {
            let setting = setting((cols, 480), 2000).unwrap();
            assert!(setting.row_clocks() >= 690 && setting.blanking <= 1023, "{cols}");
        }
    }
}
