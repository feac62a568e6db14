//! The rules, for every crate.

use crate::circles::{Siblings, siblings};
use crate::modules::Crate;
use crate::sizes::{FILE_LINES, FUNCTION_LINES, functions, is_assembly};
use crate::workspace::{relative, root, sources, targets};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Fails with what breaks a rule.
fn hold(broken: &[String]) {
    assert!(broken.is_empty(), "these break the rule:\n{}", broken.join("\n"));
}

/// Each crate, by its first source file.
fn crates() -> BTreeMap<String, Crate> {
    targets().iter().map(|target| (target.file.display().to_string(), Crate::read(&root(), &target.file))).collect()
}

#[test]
fn no_modules_of_one_folder_use_each_other() {
    let mut broken = Vec::new();
    for (file, modules) in crates() {
        for (folder, siblings) in siblings(&modules) {
            for name in siblings.on_circles() {
                let path: Vec<String> = folder.iter().cloned().chain([name.clone()]).collect();
                let uses = siblings.on_circle_with(&name).join("\n    ");
                broken.push(format!("circle {file} {}\n    {uses}", path.join("::")));
            }
        }
    }
    hold(&broken);
}

#[test]
fn each_module_of_the_core_uses_only_what_is_declared_before_it() {
    let modules = Crate::read(&root(), Path::new("core-nostd/src/lib.rs"));
    let of_folder = |(folder, siblings): (Vec<String>, _)| {
        let against = Siblings::against(&siblings, modules.children(&folder)).into_iter();
        against.map(|sentence| format!("/{} {sentence}", folder.join("::"))).collect::<Vec<_>>()
    };
    hold(&siblings(&modules).into_iter().flat_map(of_folder).collect::<Vec<_>>());
}

/// What reads the sources sees them: a use that is there is found, through an import and through a re-export.
#[test]
fn uses_are_found() {
    let core = Crate::read(&root(), Path::new("core-nostd/src/lib.rs"));
    assert!(core.names().count() > 40, "{}", core.names().count());
    let uses = core.uses();
    let is_found =
        |from: &str, to: &str| uses.iter().any(|found| found.from.join("::") == from && found.to.join("::") == to);
    assert!(is_found("pipeline::register", "fix"));
    assert!(is_found("pipeline::settings", "pose::smooth"), "pipeline::settings uses pose::Smoother");
    assert!(!is_found("fix", "pipeline"));
}

#[test]
fn files_are_short() {
    let lines = |file: &Path| fs::read_to_string(root().join(file)).expect("a source file is text").lines().count();
    let files = sources().into_iter().filter(|file| !is_assembly(file)).map(|file| (lines(&file), file));
    let long = files.filter(|(lines, _)| *lines > FILE_LINES);
    hold(&long.map(|(lines, file)| format!("{}: {lines} lines", file.display())).collect::<Vec<_>>());
}

#[test]
fn functions_are_short() {
    let mut broken = Vec::new();
    for file in sources().iter().filter(|file| !is_assembly(file)) {
        let text = fs::read_to_string(root().join(file)).expect("a source file is text");
        for function in functions(&text).iter().filter(|function| function.lines > FUNCTION_LINES) {
            broken.push(format!("{}, {}: {} lines", file.display(), function.name, function.lines));
        }
    }
    hold(&broken);
}

/// A reader who comes from elsewhere does not know what it is the same as.
#[test]
fn no_documentation_begins_with_the_same() {
    let mut broken = Vec::new();
    for file in sources() {
        let text = fs::read_to_string(root().join(&file)).expect("a source file is text");
        let mut before = "";
        for (number, line) in text.lines().map(str::trim).enumerate() {
            let is_first = !before.starts_with("//");
            if is_first && ["/// The same", "//! The same"].iter().any(|begin| line.starts_with(begin)) {
                broken.push(format!("{}, line {}", file.display(), number + 1));
            }
            before = line;
        }
    }
    hold(&broken);
}

#[test]
fn every_crate_is_read() {
    let named = |name: &str| targets().iter().any(|target| target.file == Path::new(name));
    assert!(named("core-nostd/src/lib.rs") && named("firmware/src/lib.rs"), "{:?}", targets());
    assert!(relative(&root().join("Cargo.toml")).is_some());
}
