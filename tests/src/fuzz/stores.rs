//! What is read before a flight: the stores in flash, and the camera file on the ground.

use super::Target;
use plumbline_core::elevation::Posts;
use plumbline_core::exposure::{Exposures, Limits, Planned};
use plumbline_core::pose::position::PositionState;
use plumbline_core::tile::{Geographic, Georeference};
use plumbline_core::units::{Micros, Radians};
use plumbline_firmware::boot;
use plumbline_firmware::stores::framing::{HEADER_BYTES, checksum};
use plumbline_firmware::stores::tiles::TileHead;
use plumbline_firmware::stores::{configuration, plan, tiles};
use plumbline_sim::link::{Flash, Stores, tile_store};
use plumbline_sim::scenario::Scenario;
use plumbline_sim::setup::Setup;
use plumbline_survey::camera_file::CameraFile;

/// What lies in flash for a flight with a small camera.
pub fn flash() -> Flash {
    let mut scenario = Scenario::of_frames(2);
    scenario.camera = plumbline_sim::scenario::Camera::of_size(64, 64);
    Setup::prepare(scenario).expect("the scene can be flown").flash
}

/// The configuration store, beside a tile store that is good.
pub struct Configuration(Stores);
/// The tile store.
pub struct Tiles;
/// The plan store.
pub struct Plan;
/// The camera file.
pub struct Camera;

impl Configuration {
    pub fn new() -> Self {
        Configuration(flash().stores().expect("both are good"))
    }
}

impl Target for Configuration {
    fn name(&self) -> &'static str {
        "configuration"
    }

    fn seeds(&self) -> Vec<Vec<u8>> {
        vec![self.0.configuration.clone()]
    }

    fn seal(&self, input: &mut Vec<u8>) {
        seal(input);
    }

    fn read(&mut self, input: &[u8]) -> Result<(), String> {
        // What it says is checked as at boot, and settings that pass have passed their own check.
        if let Ok(flight) = boot::read(input, &self.0.tiles, &[]) {
            flight.settings.check().map_err(|error| format!("settings that were taken are refused: {error:?}"))?;
        }
        let told = configuration::read(input).is_ok();
        if told && !input.starts_with(b"PLBM") { Err("no configuration store was read".to_owned()) } else { Ok(()) }
    }
}

impl Target for Tiles {
    fn name(&self) -> &'static str {
        "tiles"
    }

    fn seeds(&self) -> Vec<Vec<u8>> {
        let georeference = Georeference {
            epsg: 31256,
            centre: Geographic { lat_e7: 481_850_000, lon_e7: 163_690_000 },
            east: [11.0, 0.1, 0.0, 0.0, 0.0],
            north: [-0.1, 11.1, 0.0, 0.0, 0.0],
            convergence: Radians(0.01),
            point_scale: 1.0,
        };
        let store = |size: (u16, u16)| {
            let pixels: Vec<u8> = (0..u32::from(size.0) * u32::from(size.1)).map(|n| (n * 37) as u8).collect();
            let posts = (size.0 > 1).then_some(Posts {
                size: (10, 20),
                spacing_m: 30.0,
                step_m: 0.1,
                base_m: 300.0,
                vertical_epsg: 5773,
            });
            let heights: Vec<u8> = (0..posts.map_or(0, |posts| posts.bytes())).map(|n| (n * 31) as u8).collect();
            tile_store(&TileHead { size, resolution_m: 5.0, georeference, posts }, &pixels, &heights)
                .expect("a good store")
        };
        vec![store((1, 1)), store((39, 35)), store((50, 100))]
    }

    fn seal(&self, input: &mut Vec<u8>) {
        seal(input);
    }

    fn read(&mut self, input: &[u8]) -> Result<(), String> {
        let Ok(tile) = tiles::read(input) else { return Ok(()) };
        let (cols, rows) = tile.size();
        let last = (f32::from(cols) - 1.0, f32::from(rows) - 1.0);
        if tile.view().window(0, 0, (cols, rows)).is_none() || tile.view().window(1, 0, (cols, rows)).is_some() {
            return Err(format!("a tile of {cols} x {rows} is not so large"));
        }
        // A position is found again from its own place, or is none.
        let local = tile.local(last.0, last.1);
        let _ = tile.georeference().geographic(local);
        if let Some(elevation) = tile.elevation() {
            let high = elevation.height_m(local).is_none_or(f32::is_finite);
            let plane = elevation.plane(tile.local(0.5 * last.0, 0.5 * last.1), 60.0);
            if !high || plane.is_some_and(|plane| !(plane.relief_m.is_finite() && plane.height_m.is_finite())) {
                return Err("a height of an elevation model is no number".to_owned());
            }
        }
        let _ = tile.georeference().local(tile.georeference().centre);
        Ok(())
    }
}

impl Target for Plan {
    fn name(&self) -> &'static str {
        "plan"
    }

    fn seeds(&self) -> Vec<Vec<u8>> {
        let limits = Limits { interval_us: 1_000_000, across_m: 20.0 };
        let store = |strips: u32, each: u32| {
            let of_strips: Vec<u8> =
                (0..strips).flat_map(|n| plan::entry(n * each, (n as f32 - 2.0).to_bits())).collect();
            let of_photos: Vec<u8> =
                (0..strips * each).flat_map(|n| plan::entry(481_850_000 + n * 900, 163_690_000 - n * 70)).collect();
            [&plan::before(limits, &of_strips, &of_photos)[..], &of_strips, &of_photos].concat()
        };
        vec![store(1, 1), store(3, 4), store(5, 40)]
    }

    fn seal(&self, input: &mut Vec<u8>) {
        seal(input);
    }

    /// A plan that was taken has strips that follow each other, and can be flown along from anywhere.
    fn read(&mut self, input: &[u8]) -> Result<(), String> {
        let Ok(Some(plan)) = plan::read(input) else { return Ok(()) };
        let georeference = georeference();
        let on_grid = plan.on(&georeference);
        let mut end = 0;
        for number in 0.. {
            let Some(strip) = on_grid.strip(number) else { break };
            if strip.first != end || strip.end <= strip.first || strip.end > plan.photos() {
                return Err(format!("strip {number} is {strip:?} behind {end}"));
            }
            end = strip.end;
        }
        if end != plan.photos() {
            return Err(format!("the strips end at {end} of {} photos", plan.photos()));
        }
        let mut exposures = Exposures::new(plan.limits());
        for step in 0..40u64 {
            let east_m = 60.0 * step as f32 - 1000.0;
            let place = PositionState { east_m, north_m: 10.0, east_m_per_s: 40.0, north_m_per_s: -(step as f32) };
            let _ = exposures.commit(&on_grid, &place, Micros(1_000_000 + 100_000 * step));
        }
        let counts = exposures.counts();
        let sum =
            [counts.passed, counts.off_line, counts.too_soon].iter().fold(counts.exposed, |a, b| a.saturating_add(*b));
        if sum == exposures.next() { Ok(()) } else { Err(format!("{counts:?} at {}", exposures.next())) }
    }
}

/// A place in Austria.
fn georeference() -> Georeference {
    Georeference {
        epsg: 31256,
        centre: Geographic { lat_e7: 481_850_000, lon_e7: 163_690_000 },
        east: [743.0, 0.1, 0.0, 0.0, 0.0],
        north: [-0.1, 1112.0, 0.0, 0.0, 0.0],
        convergence: Radians(0.01),
        point_scale: 1.0,
    }
}

impl Target for Camera {
    fn name(&self) -> &'static str {
        "camera_file"
    }

    fn seeds(&self) -> Vec<Vec<u8>> {
        let plain =
            "cols = 640\nrows = 480\nfov_h_deg = 40.0\nfov_v_deg = 30.0\noffset_m_px = 0.5\noffset_n_px = -2.0\n";
        let full = format!(
            "{plain}pixel_mm = 0.006\nversion = 3\n\n[distortion]\nk1 = -0.1\nk2 = 0.01\nk3 = 0.0\np1 = 1e-4\np2 = -2e-4\n\n\
             [boresight]\nphi_deg = 0.1\nomega_deg = 0\nkappa_deg = -0.2\n\n[lever_arms]\nantenna_to_camera_m = [0.1, 0.2, -0.3]\n"
        );
        let head =
            "[[heads]]\ncols = 640\nrows = 480\nf_px = 700.0\nrotation_deg = [22.0, 0.0, 0.1]\nd_m = [0.1, 0.0, 0.0]\n";
        let heads = format!(
            "{}\n{head}\n{head}[heads.distortion]\nk1 = -0.1\n\n[covariance]\nhead_sd_arcsec = [1, 2, 3]\n\
             head_arcsec2 = [[1, 0, 0], [0, 4, 0.1], [0, 0.1, 9]]\n",
            plain.replace("0.5", "0").replace("-2.0", "0")
        );
        let written = |text: &str| CameraFile::from_toml_str(text, "seed").expect("a good file").to_toml_string();
        let [one, several] = [written(&full), written(&heads)];
        [plain.to_owned(), full, one, heads, several].map(String::into_bytes).to_vec()
    }

    /// The line of the checksum stands first in what was written.
    fn seal(&self, input: &mut Vec<u8>) {
        let Some(end) = input.iter().position(|&byte| byte == b'\n') else { return };
        if input.starts_with(b"crc32 = ") {
            let line = format!("crc32 = {:#010x}\n", checksum(&input[end + 1..]));
            input.splice(..=end, line.into_bytes());
        }
    }

    fn read(&mut self, input: &[u8]) -> Result<(), String> {
        let text = String::from_utf8_lossy(input);
        match CameraFile::from_toml_str(&text, "camera.toml") {
            Err(error) => {
                let sentence = error.to_string();
                if sentence.is_empty() || !sentence.contains("camera.toml") {
                    return Err(format!("an error without a place: {sentence:?}"));
                }
            }
            Ok(file) => {
                let again = CameraFile::from_toml_str(&file.to_toml_string(), "again");
                if again.as_ref().map(|again| CameraFile { crc32: file.crc32, ..again.clone() }) != Ok(file) {
                    return Err(format!("what was written reads otherwise: {again:?}"));
                }
            }
        }
        Ok(())
    }
}

/// Header and payload of a store made to fit each other.
pub fn seal(input: &mut [u8]) {
    let Some((header, payload)) = input.split_first_chunk_mut::<HEADER_BYTES>() else { return };
    header[8..12].copy_from_slice(&(payload.len() as u32).to_le_bytes());
    header[12..16].copy_from_slice(&checksum(payload).to_le_bytes());
    let own = checksum(&header[..HEADER_BYTES - 4]).to_le_bytes();
    header[HEADER_BYTES - 4..].copy_from_slice(&own);
}
