//! `fly --set` and `fly --fault`: keys and faults from the command line.

use crate::folder::Folder;
use crate::refusals::Refusals;
use serde_json::Value;

#[test]
fn bad_keys_and_faults_are_refused() {
    let folder = Folder::new("fly-faults-refused");
    folder.write("good.toml", "frames = 3\n[range]\nsigma_m = 0.2\n");
    let mut refusals = Refusals::new(&folder);
    for (set, names) in [
        ("flihgt=3", &["--set flihgt", "no key of a scenario"][..]),
        ("range.sigma=3", &["--set range.sigma=3", "no key of a scenario"]),
        ("frames=many", &["--set frames", "invalid type"]),
        ("frames=0", &["--set frames", "frames = 0"]),
        ("range.sigma_m=-1", &["good.toml with --set range.sigma_m", "-1"]),
        ("frames", &["--set", "KEY=VALUE"]),
        ("frames=", &["--set", "lacks a value"]),
        ("=3", &["--set", "dotted key"]),
    ] {
        refusals.expect(&format!("fly --scenario good.toml --set {set} --out out"), names);
    }
    for (fault, names) in [
        ("rnge.scale=1.1@30..60", &["--fault", "\"rnge\"", "position, gnss, range"][..]),
        ("range.loud", &["--fault", "\"loud\"", "scale [times]"]),
        ("range.scale@30..60", &["--fault", "needs a value"]),
        ("range.scale=1e9", &["--fault", "between 0 and 100"]),
        ("range.off=3", &["--fault", "no value"]),
        ("range.off@60..30", &["--fault", "range.off@60..30"]),
        ("range.off@30", &["--fault", "@FROM..TO"]),
        ("range", &["--fault", "UNIT.TYPE"]),
        ("encoder.off", &["encoder.off@0..", "follow_up.mode"]),
        ("clock.phase=300", &["clock.phase=300@0..", "timer.pps = true"]),
        ("power.off@5..6 --log a.log", &["power", "--link inproc"]),
        ("power.off@5..6 --link qemu", &["power", "--link inproc"]),
    ] {
        refusals.expect(&format!("fly --frames 1 --fault {fault} --out out"), names);
    }
    folder.write("bad.toml", "[[fault]]\nunit = \"range\"\ntype = \"loud\"\n");
    refusals.expect("fly --scenario bad.toml --out out", &["bad.toml", "line", "\"loud\""]);
    refusals.done();
}

/// Ten seconds, of which two have no attitude.
#[test]
fn the_report_says_what_a_fault_did() {
    let folder = Folder::new("fly-fault-report");
    let fly = "fly --set seed=9 --seed 3 --set frames=40 --set range.sigma_m=0.05 --set name=evening";
    folder.run(&format!("{fly} --out good")).done();
    let run = folder.run(&format!("{fly} --fault attitude.off@6..8 --fault position.jump=5@12.. --out bad"));
    assert!(!run.done().stderr.contains("never happens"));
    // Two frames are over after 3 + 2 x 0.25 + 1 seconds.
    folder.write("late.toml", "frames = 2\n[[fault]]\nunit = \"range\"\ntype = \"off\"\nfrom_s = 4.5\n");
    let late = folder.run("fly --scenario late.toml --fault range.off@4.4.. --fault attitude.off@60..70").done();
    let never = |fault| format!("the fault {fault} never happens: the flight of 2 frames is over after 4.5 s\n");
    assert_eq!(late.stderr, never("range.off@4.5..") + &never("attitude.off@60..70"));
    let report = |name: &str| -> Value { serde_json::from_str(&folder.text(name)).expect("JSON") };
    let (good, bad) = (report("good/report.json"), report("bad/report.json"));
    assert_eq!(good["faults"], Value::Array(Vec::new()));
    assert_eq!((&bad["seed"], &bad["frames"]), (&3.into(), &40.into()));
    assert_eq!((&bad["scenario"]["name"], &bad["scenario"]["seed"]), (&"evening".into(), &3.into()));
    assert_eq!(bad["scenario"]["range"]["sigma_m"], 0.05);
    assert_eq!(bad["scenario"]["fault"][0]["type"], "off");
    let [silent, jumped] = [&bad["faults"][0], &bad["faults"][1]];
    assert_eq!((&silent["spec"], &silent["frames"]), (&"attitude.off@6..8".into(), &8.into()));
    assert_eq!((&jumped["spec"], &jumped["to_s"]), (&"position.jump=5@12..".into(), &Value::Null));
    assert!(silent["recovery_s"].as_f64().is_some_and(|after_s| after_s < 5.0), "{silent}");
    // The rates bridge a gap for a while only.
    assert!(silent["accepted"].as_u64() < silent["frames"].as_u64(), "{silent}");
    assert_eq!(silent["wrong"], 0, "{silent}");
    // Before the fault the flights are one: the first frame is taken in second 3, four a second.
    let rows = |name: &str| -> Vec<String> { folder.text(name).lines().map(str::to_owned).collect() };
    let (good, bad) = (rows("good/fixes.csv"), rows("bad/fixes.csv"));
    assert_eq!(good[..12], bad[..12]);
    assert_ne!(good, bad);
    assert!(folder.text("bad/report.html").contains("attitude.off@6..8"));
}

/// What stops the fixes altogether, and gives them back: the board without power, an autopilot that boots, a link that is gone.
#[test]
fn fixes_come_back_after_a_boot() {
    let folder = Folder::new("fly-fault-boots");
    folder.run("fly --frames 100 --out good").done();
    let good = folder.text("good/fixes.csv");
    for fault in ["power.off@6..8", "clock.reboot@6..8", "link.off@6..8"] {
        let report = folder.run(&format!("fly --frames 100 --fault {fault} --out bad --json")).json();
        let did = &report["faults"][0];
        assert_eq!((&did["accepted"], &did["wrong"], &did["wrong_after"]), (&0.into(), &0.into(), &0.into()), "{did}");
        assert!(did["recovery_s"].as_f64().is_some_and(|after_s| after_s < 10.0), "{did}");
        let bad = folder.text("bad/fixes.csv");
        let rows = |text: &str| text.lines().take(12).map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(rows(&good), rows(&bad), "{fault}");
    }
}
