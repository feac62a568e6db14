//! What lies in flash: that it is read as it was written, that every damage is refused for what it is, and what a vehicle
//! does whose stores were refused.

mod elevation;
mod plans;

use mavlink::dialects::common::{HEARTBEAT_DATA, MavState, STATUSTEXT_DATA};
use mavlink::{MavlinkVersion, MessageData};
use plumbline_core::camera::CameraError;
use plumbline_core::pipeline::SettingsError;
use plumbline_core::stamp;
use plumbline_core::tile::{Geographic, Georeference, TileError};
use plumbline_core::units::Radians;
use plumbline_firmware::boot::{self, BootError};
use plumbline_firmware::stores::framing::{HEADER_BYTES, checksum};
use plumbline_firmware::stores::tiles::{BEFORE_PIXELS, TileHead};
use plumbline_firmware::stores::{StoreError, configuration, plan, tiles};
use plumbline_firmware::wire::decoder::Decoder;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::{Event, Flash, FrameEvent, Link, Stores, tile_store};
use plumbline_sim::scenario::{Camera, Ground, Scenario};
use plumbline_sim::setup::{Setup, orthophoto};
use plumbline_sim::world::reference::Radiometry;
use plumbline_sim::world::tile::{Frame, Tile};
use plumbline_survey::crs::Crs;
use plumbline_survey::io::data;
use proptest::prelude::{any, proptest};
use std::sync::OnceLock;

fn flash() -> &'static Flash {
    static FLASH: OnceLock<Flash> = OnceLock::new();
    FLASH.get_or_init(|| {
        let mut scenario = Scenario::of_frames(1);
        scenario.camera = Camera::of_size(64, 64);
        Setup::prepare(scenario).expect("it can be flown").flash
    })
}

fn stores() -> Stores {
    flash().stores().expect("they can be flown")
}

/// The payload behind a valid header of another format version.
fn framed(magic: &[u8; 4], version: u16, payload: &[u8]) -> Vec<u8> {
    let mut bytes = magic.to_vec();
    bytes.extend(version.to_le_bytes());
    bytes.extend([0; 2]);
    bytes.extend((payload.len() as u32).to_le_bytes());
    bytes.extend(checksum(payload).to_le_bytes());
    bytes.extend([0; 12]);
    bytes.extend(checksum(&bytes).to_le_bytes());
    bytes.extend(payload);
    bytes
}

#[test]
fn a_tile_store_is_these_bytes() {
    // Written down by hand from the table in `stores::tiles`, checksums by zlib's crc32.
    let head = TileHead {
        size: (3, 2),
        resolution_m: 0.5,
        georeference: Georeference {
            epsg: 31256,
            centre: Geographic { lat_e7: 481_850_000, lon_e7: -5 },
            east: [1.0, 0.0, 0.0, 0.0, 0.0],
            north: [0.0, 2.0, 0.0, 0.0, 0.0],
            convergence: Radians(-0.25),
            point_scale: 1.0,
        },
        posts: None,
    };
    let store = tile_store(&head, &[1, 2, 3, 4, 5, 6], &[]).expect("usable");
    let mut payload = vec![3, 0, 2, 0, 0, 0, 0, 0x3f, 0x18, 0x7a, 0, 0, 0x90, 0x72, 0xb8, 0x1c, 0xfb, 0xff, 0xff, 0xff];
    payload.extend([0, 0, 0x80, 0x3f].iter().chain(&[0; 16]));
    payload.extend([0; 4].iter().chain(&[0, 0, 0, 0x40]).chain(&[0; 12]));
    payload.extend([0, 0, 0x80, 0xbe, 0, 0, 0x80, 0x3f]);
    payload.extend([0; 28].iter().chain(&[1, 2, 3, 4, 5, 6]));
    assert_eq!(store[HEADER_BYTES..], payload);
    assert_eq!(store[..12], [b'P', b'L', b'B', b'T', 1, 0, 0, 0, 102, 0, 0, 0]);
    assert_eq!(store, framed(b"PLBT", 1, &payload));
    // The checksum is that of zip: its check value.
    assert_eq!(checksum(b"123456789"), 0xcbf4_3926);
    let tile = tiles::read(&store).expect("it is read");
    assert_eq!((tile.size(), tile.resolution().0, *tile.georeference()), ((3, 2), 0.5, head.georeference));
    assert_eq!(tile.view().run(1, 0, 3), Some(&[4u8, 5, 6][..]));
}

#[test]
fn what_was_written_is_read() {
    let flash = flash();
    let Stores { configuration: bytes, tiles: tile_bytes, .. } = flash.stores().expect("usable");
    // A region of flash is larger than its store, and erased behind it.
    let region = [bytes.as_slice(), &[0xff; 100]].concat();
    assert_eq!(configuration::read(&region).expect("it is read"), flash.configuration);
    let tile = tiles::read(&tile_bytes).expect("it is read");
    assert_eq!(*tile.georeference(), flash.head.georeference);
    assert_eq!(tile_bytes[BEFORE_PIXELS..], flash.tile);
    assert!(boot::read(&region, &tile_bytes, &[]).is_ok());
}

/// Why a configuration, and a tile, of these bytes are refused.
fn refused(configuration: &[u8], tiles: &[u8]) -> BootError {
    boot::read(configuration, tiles, &[]).expect_err("refused")
}

#[test]
fn every_damage_is_refused_for_what_it_is() {
    let Stores { configuration, tiles, .. } = stores();
    for (erased, why) in
        [(vec![0xff; 512], StoreError::Nothing), (vec![0; 512], StoreError::Nothing), (vec![], StoreError::Nothing)]
    {
        assert_eq!(refused(&erased, &tiles), BootError::Configuration(why));
        assert_eq!(refused(&configuration, &erased), BootError::Tiles(why));
    }
    // Each in the other's place.
    assert_eq!(refused(&tiles, &configuration), BootError::Configuration(StoreError::Magic));
    assert_eq!(refused(&configuration, &configuration), BootError::Tiles(StoreError::Magic));
    let payload = &configuration[HEADER_BYTES..];
    assert_eq!(
        framed(b"PLBM", configuration::KIND.version, payload),
        configuration,
        "the test frames as the store does"
    );
    let old = framed(b"PLBM", configuration::KIND.version - 1, payload);
    assert_eq!(refused(&old, &tiles), BootError::Configuration(StoreError::Version));
    let cut = &configuration[..configuration.len() - 1];
    assert_eq!(refused(cut, &tiles), BootError::Configuration(StoreError::Length));
    let more = [payload, &[0]].concat();
    assert_eq!(
        refused(&framed(b"PLBM", configuration::KIND.version, &more), &tiles),
        BootError::Configuration(StoreError::Encoding)
    );
    assert_eq!(
        refused(&framed(b"PLBM", configuration::KIND.version, &payload[..payload.len() - 1]), &tiles),
        BootError::Configuration(StoreError::Encoding)
    );
    let fewer = &tiles[HEADER_BYTES..tiles.len() - 1];
    assert_eq!(refused(&configuration, &framed(b"PLBT", 1, fewer)), BootError::Tiles(StoreError::Encoding));
    assert_eq!(refused(&configuration, &framed(b"PLBT", 1, &fewer[..95])), BootError::Tiles(StoreError::Encoding));
    // A bit anywhere.
    for at in 0..configuration.len() {
        let mut bytes = configuration.clone();
        bytes[at] ^= 0x10;
        let why = match at {
            0..4 => StoreError::Magic,
            4..HEADER_BYTES => StoreError::Header,
            _ => StoreError::Payload,
        };
        assert_eq!(refused(&bytes, &tiles), BootError::Configuration(why), "byte {at}");
    }
}

#[test]
fn whole_stores_with_impossible_content_are_refused() {
    let good = flash();
    let tiles = good.stores().expect("usable").tiles;
    let refused_with = |change: &dyn Fn(&mut configuration::Configuration)| {
        let mut configuration = good.configuration.clone();
        change(&mut configuration);
        let mut buffer = [0; configuration::STORE_MAX];
        refused(configuration.store(&mut buffer).expect("it fits"), &tiles)
    };
    assert_eq!(refused_with(&|m| m.frame.0 = 0), BootError::Configuration(StoreError::Camera(CameraError::Size)));
    assert_eq!(
        refused_with(&|m| m.fov_rad.1 = f32::NAN),
        BootError::Configuration(StoreError::Camera(CameraError::FieldOfView))
    );
    assert_eq!(refused_with(&|m| m.follow_up = 3), BootError::Configuration(StoreError::Encoding));
    assert_eq!(
        refused_with(&|m| m.sigmas[5] = -1.0),
        BootError::Configuration(StoreError::Settings(SettingsError::Sigma))
    );
    assert_eq!(refused_with(&|m| m.stamps.wired = 9), BootError::Configuration(StoreError::Encoding));
    // A data sheet's fields of view, 60 x 46.83 degrees for 640 x 480 pixels, are square to 8e-5; 46.9 is not.
    let sheet = |fov_v_deg: f32| {
        let mut configuration = good.configuration.clone();
        configuration.frame = (640, 480);
        configuration.fov_rad = (60f32.to_radians(), fov_v_deg.to_radians());
        configuration.settings().map(|_| ())
    };
    assert_eq!(sheet(46.83), Ok(()));
    assert_eq!(sheet(46.9), Err(StoreError::Settings(SettingsError::PixelsNotSquare)));
    let bent = TileHead { resolution_m: f32::NAN, ..good.head };
    assert_eq!(tile_store(&bent, &good.tile, &[]), Err(StoreError::Reference(TileError::Georeference)));
    let configuration = good.stores().expect("usable").configuration;
    let payload = [&bent.encode()[..], &good.tile].concat();
    assert_eq!(
        refused(&configuration, &framed(b"PLBT", 1, &payload)),
        BootError::Tiles(StoreError::Reference(TileError::Georeference))
    );
    // Good each, and too small for the search: 16 + 2 x 10 pixels.
    let small = |side: u16| {
        let head = TileHead { size: (side, 100), ..good.head };
        tile_store(&head, &vec![0; usize::from(side) * 100], &[]).expect("usable")
    };
    assert_eq!(refused(&configuration, &small(35)), BootError::Misfit);
    assert!(boot::read(&configuration, &small(36), &[]).is_ok());
}

proptest! {
    /// Any bytes may lie in flash.
    #[test]
    fn no_bytes_make_a_reader_panic(mut bytes: Vec<u8>, size: (u16, u16), floats: [u32; 17], is_framed in any::<bool>()) {
        if is_framed {
            let head: Vec<u8> = floats.iter().flat_map(|f| f.to_le_bytes()).chain([0; 28]).collect();
            let mut payload = [&head[..], &bytes].concat();
            payload[..2].copy_from_slice(&(size.0 % 8).to_le_bytes());
            payload[2..4].copy_from_slice(&(size.1 % 8).to_le_bytes());
            let _ = tiles::read(&framed(b"PLBT", 1, &payload));
            bytes = framed(b"PLBM", configuration::KIND.version, &bytes);
        }
        let _ = (boot::read(&bytes, &bytes, &bytes), plan::read(&bytes));
        if let Ok(configuration) = configuration::read(&bytes) {
            let _ = (configuration.settings(), configuration.stamp_settings());
        }
    }
}

/// Messages in what a firmware sent: id and payload.
fn messages(bytes: &[u8]) -> Vec<(u32, Vec<u8>)> {
    let (mut decoder, mut found) = (Decoder::new(), Vec::new());
    for byte in bytes {
        decoder.free()[0] = *byte;
        decoder.filled(1);
        while let Some(packet) = decoder.next() {
            found.push((packet.id, packet.payload.to_vec()));
        }
    }
    found
}

#[test]
fn a_vehicle_with_refused_stores_says_so_and_nothing_else() {
    let mut bad = stores();
    bad.tiles[BEFORE_PIXELS + 7] ^= 1;
    let mut link = InProcess::boot(&bad, false);
    let mut sent = Vec::new();
    for step in 0..110u32 {
        let frame = FrameEvent { sequence: step, arrival: step * 100_000, size: (64, 64), pixels: &[7; 64 * 64] };
        for event in [Event::Bytes(b"anything"), Event::Edge { tick: step, rising: true }, Event::Frame(frame)] {
            sent.extend(link.step(step * 100_000, event).expect("it lives"));
        }
    }
    let (mut beats, mut texts) = (0, Vec::new());
    for (id, payload) in messages(&sent) {
        match id {
            HEARTBEAT_DATA::ID => {
                let beat = HEARTBEAT_DATA::deser(MavlinkVersion::V2, &payload).expect("a heartbeat");
                assert_eq!(beat.system_status, MavState::MAV_STATE_CRITICAL);
                beats += 1;
            }
            STATUSTEXT_DATA::ID => {
                let text = STATUSTEXT_DATA::deser(MavlinkVersion::V2, &payload).expect("a text");
                texts.push(text.text.to_str().expect("letters").to_owned());
            }
            other => panic!("message {other}"),
        }
    }
    assert_eq!(beats, 11);
    assert_eq!(texts, ["no fixes: tile store: content damaged"; 3]);
}

#[test]
fn every_reason_fits_its_message() {
    let all = [
        StoreError::Nothing,
        StoreError::Magic,
        StoreError::Header,
        StoreError::Version,
        StoreError::Length,
        StoreError::Payload,
        StoreError::Encoding,
        StoreError::Camera(CameraError::Size),
        StoreError::Camera(CameraError::FieldOfView),
        StoreError::Settings(SettingsError::Search),
        StoreError::Settings(SettingsError::PixelsNotSquare),
        StoreError::Settings(SettingsError::FrameMemory),
        StoreError::Stamps(stamp::SettingsError::Delay),
        StoreError::Stamps(stamp::SettingsError::NoExposure),
        StoreError::Reference(TileError::Georeference),
        StoreError::Reference(TileError::Elevation),
        StoreError::Plan,
    ];
    let reasons = all.iter().flat_map(|&e| [BootError::Configuration(e), BootError::Tiles(e), BootError::Plan(e)]);
    let reasons: Vec<_> = reasons.chain([BootError::Misfit, BootError::FrameMemory, BootError::Astray]).collect();
    let mut codes: Vec<_> = reasons.iter().map(|reason| reason.code()).collect();
    codes.sort_unstable();
    codes.dedup();
    assert_eq!(codes.len(), reasons.len());
    // 0 and 1 mean that it is still reading, and that it flies.
    assert!(codes.iter().all(|&code| code > 1));
    assert!(reasons.iter().all(|reason| format!("no fixes: {reason}").len() <= 50));
}

#[test]
fn convergence_and_scale_are_those_of_pyproj() {
    // survey/tests/crs_pyproj.csv, Eisenstadt in EPSG:31256.
    let crs = Crs::from_epsg(31256).expect("known");
    let (east, north) = (14_058.132_563, 301_276.291_782);
    let tile = Tile {
        west_m: east - 50.0,
        north_m: north + 50.0,
        cols: 101,
        rows: 101,
        resolution_m: 1.0,
        pixels: vec![0; 101 * 101],
        unknown: 0,
    };
    let head = tile.head(&crs).expect("it has a place");
    let g = head.georeference;
    assert_eq!((head.size, g.epsg), ((101, 101), 31256));
    assert!((g.centre.lat_e7 - 478_500_000).abs() <= 1 && (g.centre.lon_e7 - 165_200_000).abs() <= 1, "{g:?}");
    assert!((f64::from(g.convergence.0) - 0.002_379_006_959).abs() < 1e-8, "{g:?}");
    assert!((f64::from(g.point_scale) - 1.000_007_016_4).abs() < 1e-7, "{g:?}");
}

#[test]
fn tiles_of_an_orthophoto_are_the_simulators_own() {
    let Some(ortho) = data::for_test("tiles of an orthophoto", "images/vienna_ortho_2023_30cm.tif") else { return };
    let mut scenario = Scenario::of_frames(1);
    scenario.vehicle.resolution_m = 2.0;
    (scenario.camera, scenario.run.flight.height_m) = (Camera::of_size(64, 64), [60.0, 80.0]);
    scenario.world.ground = Ground::Ortho { ortho: ortho.clone(), dem: None, reference: None };
    let setup = Setup::prepare(scenario).expect("it can be flown");
    let ground = orthophoto(&ortho).expect("it is read");
    // The flight reaches to the picture's borders, so its tile is all of it.
    let frame = Frame::within(&ground, &ground.bounds(), 2.0);
    let tile = Tile::lay(&ground, &frame, &Radiometry::SAME);
    let head = tile.head(&Crs::from_epsg(31256).expect("known")).expect("it has a place");
    let store = tile_store(&head, &tile.pixels, &[]).expect("usable");
    assert_eq!(store, setup.flash.stores().expect("usable").tiles);
    assert_eq!(tile.unknown, 0);
}
