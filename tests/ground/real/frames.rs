//! The four frames as they were taken: what their metadata say, and their pictures at one common size.
//!
//! `frames.csv` holds a row a frame: position by GPS, height above the place of take-off by the barometer, and the
//! gimbal's roll, pitch and yaw, which turn yaw, then pitch, then roll from north-east-down, the optical axis being the
//! gimbal's forward axis. At pitch −90° the axis points down and the sensor's upper edge points where yaw says; roll
//! then turns about the plumb line. All frames state roll 0.

use plumbline_core::tilt::Attitude;
use plumbline_core::units::Radians;
use plumbline_survey::io::picture::{Picture, read_grey};
use std::path::Path;

/// Size of every picture once it is read: half of what the camera wrote.
pub const COLS: usize = 2000;
/// Rows of the same.
pub const ROWS: usize = 1125;

/// The files in order of flight; two of them are stored as half-size grey pictures.
pub const FILES: [&str; 4] = ["DJI_0026.JPG", "DJI_0027.JPG", "DJI_0028_half_grey.png", "DJI_0029_half_grey.png"];

/// Turn of the stored pixels against the sensor's, degrees. A picture viewer has written the files anew and turned them
/// upside down. The pictures say so twice: what is seen moves towards row 0 though the aircraft flies where yaw points,
/// and shadows point 30° to the right of row 0, where the sun of that hour (azimuth 258°) throws them for yaw + 180°.
pub const STORED_TURN_DEG: f64 = 180.0;

/// What the metadata of one frame say.
#[derive(Clone, Copy, Debug)]
pub struct Exposure {
    /// Latitude, degrees, WGS84.
    pub lat_deg: f64,
    /// Longitude, degrees, WGS84.
    pub lon_deg: f64,
    /// Height above the place of take-off, metres.
    pub rel_alt_m: f64,
    /// Roll, pitch and yaw of the gimbal, degrees.
    pub gimbal_deg: [f64; 3],
}

impl Exposure {
    /// Attitude of the camera's forward-up-right axes as `stored_turn_deg` has the pixels, forward being towards row 0.
    ///
    /// The axis leans by pitch + 90° towards the sensor's upper edge, so by that much the nose is up if the stored
    /// pixels are the sensor's, and down if they are upside down.
    pub fn attitude(&self, stored_turn_deg: f64) -> Attitude {
        let [roll_deg, pitch_deg, yaw_deg] = self.gimbal_deg;
        assert!(roll_deg == 0.0, "a gimbal roll of {roll_deg} degrees is not provided for");
        let lean_deg = (pitch_deg + 90.0) * stored_turn_deg.to_radians().cos();
        let radians = |degrees: f64| Radians(degrees.to_radians() as f32);
        Attitude { heading: radians(yaw_deg + stored_turn_deg), pitch: radians(lean_deg), roll: Radians(0.0) }
    }

    /// Way from this frame's GPS position to that of `next`, metres east and north: differences of the angles by the
    /// radii of curvature of the WGS84 ellipsoid, exact to a millimetre over some metres.
    pub fn gps_offset_m(&self, next: &Exposure) -> [f64; 2] {
        const SEMI_MAJOR_M: f64 = 6_378_137.0;
        const ECCENTRICITY_2: f64 = 0.006_694_379_990_14;
        let (sin, cos) = (0.5 * (self.lat_deg + next.lat_deg)).to_radians().sin_cos();
        let w2 = 1.0 - ECCENTRICITY_2 * sin * sin;
        let prime_vertical_m = SEMI_MAJOR_M / w2.sqrt();
        let meridian_m = prime_vertical_m * (1.0 - ECCENTRICITY_2) / w2;
        let (d_lat, d_lon) = (next.lat_deg - self.lat_deg, next.lon_deg - self.lon_deg);
        [d_lon.to_radians() * prime_vertical_m * cos, d_lat.to_radians() * meridian_m]
    }
}

/// The rows of `frames.csv` that belong to [`FILES`], in their order.
pub fn exposures(folder: &Path) -> Vec<Exposure> {
    let path = folder.join("frames.csv");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let column = |name: &str| names.iter().position(|&other| other == name).unwrap_or_else(|| panic!("no {name}"));
    let exposure = |file: &&str| {
        // DJI_0028_half_grey.png is DJI_0028.JPG there.
        let row = rows.iter().find(|row| row[column("file")][..8] == file[..8]).unwrap_or_else(|| panic!("no {file}"));
        let value = |name: &str| -> f64 { row[column(name)].parse().unwrap_or_else(|_| panic!("{name} of {file}")) };
        Exposure {
            lat_deg: value("lat_deg"),
            lon_deg: value("lon_deg"),
            rel_alt_m: value("rel_alt_m"),
            gimbal_deg: ["gimbal_roll_deg", "gimbal_pitch_deg", "gimbal_yaw_deg"].map(value),
        }
    };
    FILES.iter().map(exposure).collect()
}

/// The picture of a file as grey at [`COLS`] x [`ROWS`]: means of 2 x 2 pixels where it is twice that.
pub fn picture(path: &Path) -> Picture {
    let full = read_grey(path).unwrap_or_else(|error| panic!("{error}"));
    if (full.cols, full.rows) == (COLS, ROWS) {
        return full;
    }
    assert_eq!((full.cols, full.rows), (2 * COLS, 2 * ROWS), "{}", path.display());
    let grey = |at: usize| u32::from(full.pixels[at]);
    let mean = |at: usize| {
        let first = at / COLS * 2 * full.cols + at % COLS * 2;
        ((grey(first) + grey(first + 1) + grey(first + full.cols) + grey(first + full.cols + 1) + 2) / 4) as u8
    };
    Picture { cols: COLS, rows: ROWS, pixels: (0..COLS * ROWS).map(mean).collect() }
}
