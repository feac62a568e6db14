//! The rules, for every crate.

use crate::circles::siblings;
use crate::modules::Crate;
use crate::sizes::{FILE_LINES, FUNCTION_LINES, functions, is_assembly};
use crate::workspace::{relative, root, sources, targets};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// What breaks a rule: its line in `exceptions.txt`, and the details.
type Found = BTreeMap<String, String>;

/// Compares what breaks a rule with the lines of `exceptions.txt` that begin with `kind`.
fn hold(kind: &str, found: &Found) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("exceptions.txt");
    let text = fs::read_to_string(file).expect("exceptions.txt is there");
    let listed: Vec<&str> = text.lines().filter(|line| line.starts_with(kind)).collect();
    let new = found.iter().filter(|(line, _)| !listed.contains(&line.as_str()));
    let new: Vec<String> = new.map(|(line, details)| format!("{line}\n    {details}")).collect();
    let gone: Vec<&&str> = listed.iter().filter(|line| !found.contains_key(**line)).collect();
    assert!(new.is_empty(), "these break the rule:\n{}", new.join("\n"));
    assert!(gone.is_empty(), "these do no longer; take their lines out of exceptions.txt:\n{gone:#?}");
}

/// Each crate, by its first source file.
fn crates() -> BTreeMap<String, Crate> {
    targets().iter().map(|target| (target.file.display().to_string(), Crate::read(&root(), &target.file))).collect()
}

#[test]
fn no_modules_of_one_folder_use_each_other() {
    let mut found = Found::new();
    for (file, modules) in crates() {
        for (folder, siblings) in siblings(&modules) {
            for name in siblings.on_circles() {
                let path: Vec<String> = folder.iter().cloned().chain([name.clone()]).collect();
                found.insert(
                    format!("circle {file} {}", path.join("::")),
                    siblings.on_circle_with(&name).join("\n    "),
                );
            }
        }
    }
    hold("circle ", &found);
}

#[test]
fn each_module_of_the_core_uses_only_what_is_declared_before_it() {
    let file = Path::new("core-nostd/src/lib.rs");
    let modules = Crate::read(&root(), file);
    let mut found = Found::new();
    for (folder, siblings) in siblings(&modules) {
        for sentence in siblings.against(modules.children(&folder)) {
            let (uses, places) = sentence.split_once(", ").unwrap_or((&sentence, ""));
            found.insert(format!("order /{} {uses}", folder.join("::")), places.to_owned());
        }
    }
    hold("order ", &found);
}

/// What reads the sources sees them: a use that is there is found, through an import and through a re-export.
#[test]
fn uses_are_found() {
    let core = Crate::read(&root(), Path::new("core-nostd/src/lib.rs"));
    assert!(core.names().count() > 40, "{}", core.names().count());
    let uses = core.uses();
    let is_found =
        |from: &str, to: &str| uses.iter().any(|found| found.from.join("::") == from && found.to.join("::") == to);
    assert!(is_found("pipeline", "fix"));
    assert!(is_found("pipeline::settings", "pose::smooth"), "pipeline::settings uses pose::Smoother");
    assert!(!is_found("fix", "pipeline"));
}

#[test]
fn files_are_short() {
    let mut found = Found::new();
    for file in sources().iter().filter(|file| !is_assembly(file)) {
        let lines = fs::read_to_string(root().join(file)).expect("a source file is text").lines().count();
        if lines > FILE_LINES {
            found.insert(format!("file {}", file.display()), format!("{lines} lines"));
        }
    }
    hold("file ", &found);
}

#[test]
fn functions_are_short() {
    let mut found = Found::new();
    for file in sources().iter().filter(|file| !is_assembly(file)) {
        let text = fs::read_to_string(root().join(file)).expect("a source file is text");
        for function in functions(&text).iter().filter(|function| function.lines > FUNCTION_LINES) {
            let line = format!("function {} {}", file.display(), function.name);
            found.insert(line, format!("{} lines", function.lines));
        }
    }
    hold("function ", &found);
}

#[test]
fn every_crate_is_read() {
    let named = |name: &str| targets().iter().any(|target| target.file == Path::new(name));
    assert!(named("core-nostd/src/lib.rs") && named("firmware/src/lib.rs"), "{:?}", targets());
    assert!(relative(&root().join("Cargo.toml")).is_some());
}
