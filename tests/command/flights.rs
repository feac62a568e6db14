//! `plumbline fly`, in-process: the same seed gives the same bytes, and bad links are told.

use crate::command::{Run, plumbline};
use crate::folder::{FLY, Folder};
use crate::refusals::Refusals;
use plumbline_survey::crs::System;
use plumbline_survey::io::picture::read_grey;
use plumbline_survey::io::raster::Raster;
use plumbline_tests::vectors::number;
use serde_json::Value;
use std::process::{Command, Stdio};
use std::time::Duration;

const HEADER: &str = "frame,mid_exposure_us,accepted,reason,d_col,d_row,true_col,true_row,east_m,north_m,sigma_east_m,\
     sigma_north_m,score,second_peak,risk,protection_m";

/// What the contract promises of `report.json`; a dot leads into a table.
const REPORT: [&str; 45] = [
    "schema",
    "epsg",
    "seed",
    "link",
    "firmware_sha256",
    "frames",
    "accepted",
    "match_rate.unrectified",
    "match_rate.rectified",
    "matching_error_px.unrectified_mean",
    "matching_error_px.rectified_integer_mean",
    "matching_error_px.rectified_mean",
    "matching_error_px.rectified_p95",
    "matching_error_px.accepted_max",
    "ground_error_m.mean",
    "ground_error_m.p95",
    "nees_mean",
    "stamps.rms_us",
    "stamps.mean_us",
    "stamps.max_us",
    "stamps.nees_mean",
    "stamps.sources.both_edges",
    "stamps.sources.one_edge",
    "stamps.sources.arrival",
    "stamps.sources.none",
    "poses.tilt_rms_deg",
    "poses.nees_mean",
    "poses.methods.second",
    "poses.methods.third",
    "poses.methods.straight",
    "poses.methods.none",
    "poses.rejected_samples",
    "blur.mean_px",
    "blur.max_px",
    "blur.blurred",
    "blur.beyond_standard",
    "blur.exposure_max_us",
    "instructions_per_frame.mean",
    "instructions_per_frame.max",
    "ram_bytes",
    "protection.held",
    "protection.median_m",
    "protection.rms_m",
    "protection.nees",
    "protection.frames",
];

/// The rows of `fixes.csv` by field. Each has its frame's number, and either a fix and no reason or a reason and no fix.
fn fixes(folder: &Folder, name: &str) -> Vec<Vec<String>> {
    let text = folder.text(name);
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(HEADER), "{name}");
    let rows: Vec<Vec<String>> = lines.map(|line| line.split(',').map(str::to_owned).collect()).collect();
    for (index, row) in rows.iter().enumerate() {
        assert_eq!(row.len(), 16, "{name}: {row:?}");
        assert_eq!(row[0], index.to_string(), "{name}: {row:?}");
        // A fix states at most the risk that a flight takes; without a fix there is none.
        let risk = row[14].parse::<f64>().ok();
        assert_eq!(risk.is_some(), row[2] == "1", "{name}: {row:?}");
        assert!(risk.is_none_or(|risk| risk > 0.0 && risk <= 1e-4), "{name}: {row:?}");
        let is_number = |field: &String| field.parse::<f64>().is_ok_and(f64::is_finite);
        match row[2].as_str() {
            "1" => {
                assert!(row[3].is_empty() && row[4..14].iter().all(is_number) && is_number(&row[15]), "{name}: {row:?}")
            }
            "0" => assert!(!row[3].is_empty() && row[8..12].iter().all(String::is_empty), "{name}: {row:?}"),
            other => panic!("{name}: accepted is {other}: {row:?}"),
        }
    }
    rows
}

fn report(folder: &Folder, name: &str) -> Value {
    serde_json::from_str(&folder.text(name)).expect("report.json is JSON")
}

/// The frames and the accepted ones are counted alike in both files; so are the reasons.
fn agree(rows: &[Vec<String>], report: &Value) {
    let accepted = rows.iter().filter(|row| row[2] == "1").count();
    assert_eq!(
        [number(report, "frames"), number(report, "accepted")],
        [rows.len() as f64, accepted as f64],
        "{report}"
    );
    let refused = report["refused"].as_object().expect("reasons");
    for (reason, count) in refused {
        assert_eq!(
            count.as_u64(),
            Some(rows.iter().filter(|row| row[3] == *reason).count() as u64),
            "{reason}: {report}"
        );
    }
    let sum: u64 = refused.values().filter_map(Value::as_u64).sum();
    assert_eq!(sum as usize, rows.len() - accepted, "{report}");
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let folder = Folder::new("fly-seeds");
    for (seed, out) in [(5, "one"), (5, "two"), (6, "other")] {
        folder.run(&format!("fly --frames 6 --seed {seed} --out {out}")).done();
    }
    for file in ["fixes.csv", "poses.csv", "report.json", "report.html", "fixes.geojson", "track.kml", "tile.tif"] {
        let [one, two, other] = ["one", "two", "other"].map(|out| folder.read(&format!("{out}/{file}")));
        assert!(one == two, "{file} differs with the same seed");
        assert!(one != other, "{file} does not depend on the seed");
    }
    let (rows, report) = (fixes(&folder, "one/fixes.csv"), report(&folder, "one/report.json"));
    assert_eq!(rows.len(), 6);
    agree(&rows, &report);
    assert_eq!(number(&report, "seed"), 5.0);
    on_the_globe(&folder, &rows);
}

/// Each fix is a point in fixes.geojson and in track.kml, near the place that the default scene lies at.
fn on_the_globe(folder: &Folder, rows: &[Vec<String>]) {
    let fixed: Vec<&str> = rows.iter().filter(|row| row[2] == "1").map(|row| row[0].as_str()).collect();
    let points: Value = serde_json::from_str(&folder.text("one/fixes.geojson")).expect("GeoJSON");
    let features = points["features"].as_array().expect("features");
    let frames: Vec<String> = features.iter().map(|point| point["properties"]["frame"].to_string()).collect();
    assert_eq!(frames, fixed);
    for point in features {
        let [lon, lat] = [0, 1].map(|axis| point["geometry"]["coordinates"][axis].as_f64().expect("degrees"));
        assert!((lon - 15.8).abs() < 0.5 && (lat - 48.1).abs() < 1.2, "{point}");
        assert!(number(&point["properties"], "error_m") < 5.0, "{point}");
    }
    let kml = folder.text("one/track.kml");
    assert_eq!(kml.matches("<Point>").count(), fixed.len(), "{kml}");
}

/// The tile that was flown has at each of its places what the orthophoto has there: half a pixel off it would not.
#[test]
fn the_tile_lies_where_it_was_cut_from_the_ground() {
    let folder = Folder::with_ground("fly-tile");
    folder.run(&format!("{FLY} --frames 1 --out out")).done();
    let [ground, tile] = ["ground.tif", "out/tile.tif"].map(|name| Raster::read(&folder.path(name)).expect("a raster"));
    assert_eq!((tile.crs, tile.nodata, tile.bands), (Some(System::Epsg(32633)), None, 1));
    let (mut off, mut count) = (0.0, 0);
    for index in 0..tile.cols * tile.rows {
        let (col, row) = (index % tile.cols, index / tile.cols);
        let (x, y) = tile.geo.world_from_pixel(col as f64, row as f64);
        let (right, down) = ground.geo.pixel_from_world(x, y);
        if !(1.0..254.0).contains(&right) || !(1.0..254.0).contains(&down) {
            continue;
        }
        let at = |col: f64, row: f64| f64::from(ground.sample(col as usize, row as usize, 0).expect("inside"));
        let (west, north) = (right.floor(), down.floor());
        let along = |row: f64| at(west, row) + (right - west) * (at(west + 1.0, row) - at(west, row));
        let expected = along(north) + (down - north) * (along(north + 1.0) - along(north));
        off += (f64::from(tile.data[index]) - expected).abs();
        count += 1;
    }
    // The tile averages over its pixels, which takes 1.6 greys off; lying a quarter of a pixel elsewhere, measured, 3.8.
    assert!(count > 1000 && off / f64::from(count) < 2.5, "{count} pixels, off by {off} greys in all");
}

#[test]
fn the_report_holds_what_is_promised() {
    let folder = Folder::new("fly-report");
    let run = folder.run("fly --frames 3 --out out --json").done();
    let (printed, written) = (run.json(), report(&folder, "out/report.json"));
    assert_eq!(printed, written, "--json and report.json are one document");
    for key in REPORT {
        let table = key.split('.').try_fold(&written, |value, key| value.get(key));
        assert!(table.is_some(), "{key} is not in {written}");
    }
    assert_eq!(written["link"], "inproc");
    let unmeasured = ["firmware_sha256", "ram_bytes"].map(|key| &written[key]);
    let unmeasured = unmeasured.into_iter().chain(["mean", "max"].map(|key| &written["instructions_per_frame"][key]));
    assert!(unmeasured.into_iter().all(Value::is_null), "nothing is measured in-process: {written}");
    let page = folder.text("out/report.html");
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"), "a page, whole");
    for fetched in ["src=\"http", "href=\"http", "src='http", "@import", "url(http"] {
        assert!(!page.contains(fetched), "report.html is not self-contained: {fetched}");
    }
}

#[test]
fn an_existing_folder_is_reused() {
    let folder = Folder::with_ground("fly-reuse");
    folder.make("out");
    folder.write("out/notes.txt", "mine");
    folder.write("out/fixes.csv", "old");
    folder.run(&format!("{FLY} --frames 2 --dump 2 --out out")).done();
    assert_eq!(folder.text("out/notes.txt"), "mine");
    assert_eq!(fixes(&folder, "out/fixes.csv").len(), 2);
    let content = folder.content();
    assert!(!content.keys().any(|path| path.extension().is_some_and(|end| end == "part")), "temporary files are left");
    // Frame, patch, mask and reference, of two frames.
    let pictures: Vec<_> = content.keys().filter(|path| path.extension().is_some_and(|end| end == "png")).collect();
    assert_eq!(pictures.len(), 8, "{pictures:?}");
    for path in pictures {
        read_grey(path).expect("a picture");
    }
}

#[test]
fn without_out_nothing_is_written() {
    let folder = Folder::with_ground("fly-dry");
    let run = folder.run(&format!("{FLY} --frames 1")).done();
    assert_eq!(folder.content().len(), 1, "only the ground lies there");
    assert!(run.stderr.is_empty() && run.stdout.lines().count() > 1, "{run:?}");
}

/// The built-in scenario over a bad link: whatever is lost is counted, and nothing ends the flight.
#[test]
fn a_flight_over_a_bad_link() {
    let folder = Folder::new("fly-faults");
    folder.run("fly --scenario faults --frames 12 --out out").done();
    let (rows, report) = (fixes(&folder, "out/fixes.csv"), report(&folder, "out/report.json"));
    assert_eq!(rows.len(), 12);
    agree(&rows, &report);
    let health = &report["link_health"];
    // Bit errors and cut messages break checksums, the rest of a cut message is skipped, and 2 % have foreign ids.
    for counted in ["messages", "bad_checksum", "unknown_id", "skipped_bytes"] {
        assert!(number(health, counted) > 0.0, "{counted}: {health}");
    }
    // No fix may be wrong: three pixels are far beyond any error of matching.
    assert!(number(&report["matching_error_px"], "accepted_max") < 3.0, "{report}");
}

/// A flight over a good link counts nothing, so the counts above are the faults'.
#[test]
fn a_good_link_counts_no_faults() {
    let folder = Folder::with_ground("fly-good-link");
    let report = folder.run(&format!("{FLY} --frames 3 --json")).json();
    let health = &report["link_health"];
    assert!(number(health, "messages") > 0.0, "{health}");
    for counted in ["bad_checksum", "unknown_id", "skipped_bytes", "backwards", "invalid"] {
        assert_eq!(number(health, counted), 0.0, "{counted}: {health}");
    }
}

/// A worse one: a tenth of the messages cut, as many unknown, most echoes and a third of the frames missing. Some frames have no fix,
/// and each says why.
#[test]
fn a_flight_that_loses_frames() {
    let folder = Folder::with_ground("fly-losses");
    folder.write(
        "losses.toml",
        "frames = 12\n[shutter]\nlost_frame_percent = 30.0\n[range]\ndropout_percent = 60.0\n[link_faults]\n\
         bit_error_percent = 0.2\ncut_percent = 10.0\nunknown_percent = 10.0\n",
    );
    folder.run(&format!("{FLY} --scenario losses.toml --out out")).done();
    let (rows, report) = (fixes(&folder, "out/fixes.csv"), report(&folder, "out/report.json"));
    assert_eq!(rows.len(), 12);
    agree(&rows, &report);
    let accepted = number(&report, "accepted");
    assert!(accepted > 0.0 && accepted < 12.0, "{accepted} of 12 accepted show only one of the two: {report}");
}

/// Nothing lies where `cargo xtask build` puts the image; then, nothing that runs it.
#[test]
fn qemu_without_image_or_emulator() {
    let folder = Folder::with_ground("fly-no-qemu");
    let fly = |variable: &str| {
        let mut command = plumbline(&folder.path(""), &format!("{FLY} --frames 1 --link qemu --out out"));
        command.env(variable, folder.path("nothing"));
        Run::from(command.output().expect("the command starts"))
    };
    let run = fly("CARGO_TARGET_DIR");
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.stderr.lines().count() == 1 && run.stderr.contains("cargo xtask build"), "{run:?}");
    let run = Run::from(fly_by(&folder, "nothing").output().expect("it starts"));
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.stderr.lines().count() == 1 && run.stderr.contains("qemu-system-arm"), "{run:?}");
    assert_eq!(folder.content().len(), 2, "something was written");
}

/// A flight in an emulator that is looked for in `path` alone. Its image is the head of an ELF file for ARM: good enough to be
/// tried.
fn fly_by(folder: &Folder, path: &str) -> std::process::Command {
    folder.write("image.elf", "\x7fELF\x01\x01\x01\0\0\0\0\0\0\0\0\0\x02\0(\0");
    let mut command =
        plumbline(&folder.path(""), &format!("{FLY} --frames 1 --link qemu --firmware image.elf --out out"));
    command.env("PATH", folder.path(path)).env("CARGO_TARGET_DIR", folder.path("nothing"));
    command
}

/// A command that is killed cannot stop its emulator, which would run for ever. Here it is one that tells its number and
/// waits.
#[cfg(target_os = "linux")]
#[test]
fn a_killed_command_leaves_no_emulator() {
    use std::os::unix::fs::PermissionsExt;
    use std::time::{Duration, Instant};
    let folder = Folder::with_ground("fly-killed");
    folder.make("bin");
    folder.write(
        "bin/qemu-system-arm",
        "#!/bin/sh\necho $$ > number.part\n/bin/mv number.part number\nexec /bin/sleep 600\n",
    );
    let started = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(folder.path("bin/qemu-system-arm"), started).expect("a program");
    let mut command = fly_by(&folder, "bin").spawn().expect("it starts");
    let begin = Instant::now();
    let until = |what: &str, is_so: &dyn Fn() -> bool| {
        while !is_so() {
            assert!(begin.elapsed() < Duration::from_secs(60), "{what}");
            std::thread::sleep(Duration::from_millis(10));
        }
    };
    until("no emulator was started", &|| folder.path("number").exists());
    let stat = format!("/proc/{}/stat", folder.text("number").trim());
    // A process that has ended stays a zombie until someone asks for its exit code.
    let runs = || std::fs::read_to_string(&stat).is_ok_and(|stat| !stat.contains(") Z "));
    assert!(runs(), "{stat}");
    command.kill().expect("killed");
    command.wait().expect("ended");
    until("the emulator still runs", &|| !runs());
}

/// An image that is none.
#[test]
fn qemu_with_another_file_as_image() {
    let folder = Folder::with_ground("fly-no-image");
    folder.write("text.elf", "not an image\n");
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&format!("{FLY} --frames 1 --link qemu --firmware text.elf --out out"), &["text.elf"]);
    refusals.done();
}

/// An interrupt: the flight's log is written all the same, and the command says that it was interrupted.
#[test]
fn an_interrupted_flight_leaves_its_log() {
    let folder = Folder::with_ground("fly-interrupted");
    let mut command = plumbline(&folder.path(""), &format!("{FLY} --frames 100000 --log flight.log"));
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the command starts");
    let pid = child.id();
    while !catches_interrupts(pid) {
        std::thread::sleep(Duration::from_millis(20));
    }
    let sent = Command::new("kill").args(["-INT", &pid.to_string()]).status().expect("kill runs");
    assert!(sent.success());
    let run = Run::from(child.wait_with_output().expect("it ends"));
    assert_eq!(run.code, Some(1), "{run:?}");
    assert!(run.stderr.contains("interrupted"), "{run:?}");
    assert!(std::fs::metadata(folder.path("flight.log")).expect("the log is there").len() > 0);
}

/// Whether a process has a handler for SIGINT; it has to be running still.
fn catches_interrupts(pid: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).expect("the flight is still under way");
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).expect("a mask of caught signals");
    // SIGINT is signal 2: the second bit.
    u64::from_str_radix(caught.trim(), 16).expect("hexadecimal digits") & 2 != 0
}
