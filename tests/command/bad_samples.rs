//! Samples and options that cannot be smoothed.

use crate::folder::{with, without};
use crate::refusals::Refusals;
use crate::smooth::{SMOOTH, samples};
use std::fs;

/// A call on a file of one column.
fn on(file: &str) -> String {
    format!("smooth --in {file} --time t --columns y --order 2 --alpha 10 --out fit.csv --json")
}

#[test]
fn the_call_that_tests_spoil_is_good() {
    let (folder, _) = samples("smooth-good");
    folder.run(SMOOTH).done();
    folder.run(&format!("{SMOOTH} --weights p --gap-s 1 --gate 5 --angles short --plot fit.svg")).done();
}

#[test]
fn logs_that_are_none() {
    let (folder, _) = samples("smooth-no-logs");
    folder.make("folder");
    folder.write("empty.csv", "");
    folder.write("header.csv", "t,y\n");
    folder.write("binary.csv", b"\xff\xfe\x00t,y");
    folder.write("short.csv", "t,y\n0,1\n1\n2,0\n");
    folder.write("long.csv", "t,y\n0,1\n1,5,3\n2,0\n");
    folder.write("twice.csv", "t,y,y\n0,1,1\n1,0,0\n2,3,3\n3,1,1\n");
    let wide = |text: &str| -> Vec<u8> { text.encode_utf16().flat_map(u16::to_le_bytes).collect() };
    folder.write("wide.csv", wide("\u{feff}t,y\n0,1\n1,2\n2,0\n"));
    folder.write("comments.csv", "# a logger, 2026\nt,y\n0,1\n1,2\n2,0\n");
    folder.write("numpy.csv", "# t,y\n0,1\n1,2\n2,0\n");
    let mut refusals = Refusals::new(&folder);
    let line = "iconv -f UTF-16 -t UTF-8 wide.csv > wide.utf8.csv";
    refusals.expect(&on("wide.csv"), &["wide.csv: it is text in UTF-16", line]);
    refusals.expect(&format!("{SMOOTH} --at wide.csv"), &["wide.csv: it is text in UTF-16", line]);
    for call in [on("comments.csv"), "smooth --in comments.csv --out fit.csv".to_owned()] {
        refusals.expect(&call, &["comments.csv, line 1", "sed '/^ *#/d' comments.csv > comments.plain.csv"]);
    }
    refusals.expect(&on("numpy.csv"), &["numpy.csv, line 1", "sed '1s/^ *# *//; /^ *#/d' numpy.csv > numpy.plain.csv"]);
    for file in ["none.csv", "none/log.csv", "folder", "empty.csv", "binary.csv"] {
        refusals.expect(&on(file), &[file]);
        refusals.expect(&format!("{SMOOTH} --at {file}"), &[file]);
    }
    refusals.expect(&on("header.csv"), &["header.csv", "0 samples"]);
    refusals.expect(&format!("{SMOOTH} --at header.csv"), &["header.csv", "t_s"]);
    refusals.expect(&on("short.csv"), &["short.csv", "line 3", "1 fields"]);
    refusals.expect(&on("long.csv"), &["long.csv", "line 3", "3 fields"]);
    refusals.expect(&on("twice.csv"), &["twice.csv", "more than one column y"]);
    refusals.done();
}

#[test]
fn columns() {
    let (folder, _) = samples("smooth-columns");
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&with(SMOOTH, "--time", "t"), &["samples.csv", "no column t", "t_s, z, short, p"]);
    refusals.expect(&with(SMOOTH, "--columns", "z,height"), &["samples.csv", "no column height"]);
    refusals.expect(&with(SMOOTH, "--columns", "z,z"), &["--columns", "z"]);
    refusals.expect(&with(SMOOTH, "--columns", "t_s"), &["--columns", "t_s"]);
    refusals.expect(&with(SMOOTH, "--columns", "z,"), &["--columns"]);
    refusals.expect(&format!("{SMOOTH} --angles p"), &["--angles", "p"]);
    folder.write("turns.csv", "t,y\n0,10\n1,350\n2,175\n3,5\n4,6\n");
    refusals.expect(&format!("{} --angles y", on("turns.csv")), &["turns.csv", "column y", "line 4", "-175.0 deg"]);
    refusals.expect(&format!("{SMOOTH} --weights w"), &["no column w"]);
    let several = with(&with(SMOOTH, "--columns", "z,height"), "--time", "t");
    refusals.expect(&format!("{several} --weights w"), &["samples.csv has no columns t, height, w, only t_s, z"]);
    for option in ["--in", "--time", "--columns", "--out"] {
        refusals.expect(&without(SMOOTH, option), &[option]);
    }
    refusals.done();
}

#[test]
fn values_and_times() {
    let (folder, _) = samples("smooth-values");
    let mut refusals = Refusals::new(&folder);
    for (name, rows, names) in [
        ("backwards", "0,1\n2,0\n1,3\n3,1\n4,0\n", &["line 4", "goes back"][..]),
        ("repeated", "0,1\n1,0\n1,3\n3,1\n4,0\n", &["line 4", "repeated"]),
        ("gap", "0,1\n1,0\n2,3\n3,1\n24,0\n25,1\n", &["line 6", "gap", "21.000 s at 3", "20 s"]),
        ("one", "0,1\n", &["1 sample", "3"]),
        ("two", "0,1\n1,0\n", &["2 samples", "3"]),
        ("equal", "0,7\n1,7\n2,7\n3,7\n", &["column y", "equal", "7"]),
        ("nan", "0,1\n1,NaN\n2,7\n3,7\n", &["line 3", "y", "NaN"]),
        ("infinite", "0,1\n1,0\n2,inf\n3,7\n", &["line 4", "y", "inf"]),
        ("empty-field", "0,1\n1,0\n2,\n3,7\n", &["line 4", "y"]),
        ("word", "0,1\n1,high\n2,0\n3,7\n", &["line 3", "high"]),
        ("nan-time", "0,1\nNaN,0\n2,0\n3,7\n", &["line 3", "t", "NaN"]),
        ("infinite-time", "0,1\n1,0\n2,0\ninf,7\n", &["line 5", "t", "inf"]),
        ("comma", "0,1\n1,0,5\n2,0\n3,7\n", &["line 3"]),
    ] {
        let file = format!("{name}.csv");
        folder.write(&file, format!("t,y\n{rows}"));
        let mut names = names.to_vec();
        names.push(&file);
        refusals.expect(&on(&file), &names);
    }
    // Equal samples are refused with GCV too, a straight line with GCV only.
    refusals.expect(&with(&on("equal.csv"), "--alpha", "gcv"), &["equal"]);
    folder.write("line.csv", "t,y\n0,1\n1,2\n2,3\n3,4\n4,5\n");
    refusals.expect(&with(&on("line.csv"), "--alpha", "gcv"), &["line.csv", "column y", "GCV is undefined"]);
    folder.run(&on("line.csv")).done();
    folder.write("three.csv", "t,y\n0,1\n1,0\n2,3\n");
    refusals.expect(&with(&on("three.csv"), "--alpha", "gcv"), &["GCV is undefined", "3 samples"]);
    refusals.expect(&with(&on("three.csv"), "--order", "3"), &["3 samples", "4"]);
    refusals.done();
}

#[test]
fn weights() {
    let (folder, _) = samples("smooth-weights");
    let mut refusals = Refusals::new(&folder);
    for (name, rows, names) in [
        ("few", "0,1,0\n1,0,1\n2,3,0\n3,1,1\n4,1,0\n", &["rank-deficient", "2 samples", "3"][..]),
        ("none", "0,1,0\n1,0,0\n2,3,0\n3,1,0\n", &["rank-deficient", "0 samples"]),
        ("negative", "0,1,1\n1,0,-1\n2,3,1\n3,1,1\n", &["line 3", "-1", "weight"]),
        ("far", "0,1,1\n1,0,1e-9\n2,3,1\n3,1,1\n", &["line 3", "weight"]),
        ("nan", "0,1,1\n1,0,1\n2,3,NaN\n3,1,1\n", &["line 4", "p", "NaN"]),
        ("equal", "0,7,1\n1,0,0\n2,7,1\n3,7,1\n4,7,1\n", &["equal"]),
        ("gap", "0,7,1\n1,0,1\n2,7,1\n3,7,0\n4,7,0\n5,0,1\n", &["gap", "3.000 s at 2"]),
    ] {
        let file = format!("w-{name}.csv");
        folder.write(&file, format!("t,y,p\n{rows}"));
        let call = format!("{} --weights p --gap-s 2.5", on(&file));
        let mut names = names.to_vec();
        names.push(&file);
        refusals.expect(&call, &names);
    }
    refusals.done();
}

#[test]
fn orders_alphas_gaps_and_gates() {
    let (folder, _) = samples("smooth-numbers");
    let mut refusals = Refusals::new(&folder);
    for order in ["1", "4", "0", "-2", "2.0", "two"] {
        refusals.expect(&with(SMOOTH, "--order", order), &["--order", order]);
    }
    for alpha in ["0", "-1", "-0", "NaN", "inf", "1e999", "GCV", "much"] {
        refusals.expect(&with(SMOOTH, "--alpha", alpha), &["--alpha", alpha]);
    }
    refusals.expect(&with(SMOOTH, "--alpha", "1e-12"), &["alpha", "1e-12", "1e-10", "column z"]);
    for alpha in ["1e12", "1e300"] {
        refusals.expect(&with(SMOOTH, "--alpha", alpha), &["alpha", "6.250e11", "column z"]);
    }
    for option in ["--gap-s", "--gate"] {
        for value in ["0", "-1", "NaN", "inf", "long"] {
            refusals.expect(&format!("{SMOOTH} {option} {value}"), &[option, value]);
        }
    }
    refusals.expect(&format!("{SMOOTH} --gap-s 0.1"), &["gap", "line 3", "and 295 more"]);
    refusals.expect(&format!("{SMOOTH} --gate 0.001"), &["column z", "outlier gate"]);
    refusals.done();
}

#[test]
fn instants_outside_the_log() {
    let (folder, _) = samples("smooth-outside");
    folder.write("before.csv", "t_s\n5\n-0.001\n");
    folder.write("after.csv", "t_s\n5\n60.5\n");
    folder.write("nan.csv", "t_s\n5\nNaN\n");
    folder.write("bare.csv", "5\n6\n");
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&format!("{SMOOTH} --at before.csv"), &["before.csv", "-0.001", "outside"]);
    refusals.expect(&format!("{SMOOTH} --at after.csv"), &["after.csv", "60.5", "outside"]);
    refusals.expect(&format!("{SMOOTH} --at nan.csv"), &["nan.csv", "line 3", "NaN"]);
    refusals.expect(&format!("{SMOOTH} --at bare.csv"), &["bare.csv", "t_s"]);
    refusals.done();
}

#[test]
fn places_where_nothing_can_be_written() {
    let (folder, _) = samples("smooth-places");
    folder.make("folder");
    folder.write("locked.csv", "old");
    folder.write("at.csv", "t_s\n5\n");
    let mut permissions = fs::metadata(folder.path("locked.csv")).expect("there").permissions();
    permissions.set_readonly(true);
    fs::set_permissions(folder.path("locked.csv"), permissions).expect("locked");
    let mut refusals = Refusals::new(&folder);
    for place in ["none/fit.csv", "folder", "samples.csv/fit.csv", "locked.csv"] {
        refusals.expect(&with(SMOOTH, "--out", place), &[place]);
        refusals.expect(&format!("{SMOOTH} --plot {place}"), &[place]);
    }
    refusals.expect(&with(SMOOTH, "--out", "samples.csv"), &["--out", "--in", "samples.csv"]);
    refusals.expect(&with(SMOOTH, "--out", "./samples.csv"), &["--out", "--in", "samples.csv"]);
    refusals.expect(&format!("{SMOOTH} --at at.csv --plot at.csv"), &["--plot", "--at", "at.csv"]);
    refusals.expect(&format!("{SMOOTH} --plot fit.csv"), &["--plot", "--out", "fit.csv"]);
    refusals.done();
}
