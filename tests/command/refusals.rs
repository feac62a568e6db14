//! How bad input has to be refused.

use crate::folder::Folder;

/// Collects what is wrong with a test's refusals, so that one run shows all of it.
#[derive(Debug)]
pub struct Refusals<'a> {
    folder: &'a Folder,
    count: usize,
    complaints: Vec<String>,
}

impl<'a> Refusals<'a> {
    pub fn new(folder: &'a Folder) -> Self {
        Refusals { folder, count: 0, complaints: Vec::new() }
    }

    /// `arguments` must be refused with exit code 2 and one line on stderr that holds all of `names`, nothing on stdout,
    /// and no file or folder made, changed or removed.
    pub fn expect(&mut self, arguments: &str, names: &[&str]) {
        self.count += 1;
        let before = self.folder.content();
        let run = self.folder.run(arguments);
        let mut wrong = Vec::new();
        if run.code != Some(2) {
            wrong.push(format!("exit {:?} instead of 2", run.code));
        }
        if !run.stdout.is_empty() {
            wrong.push(format!("stdout is not empty: {:?}", run.stdout));
        }
        if run.stderr.lines().count() != 1 || !run.stderr.starts_with("plumbline: ") {
            wrong.push("stderr is not one sentence".to_owned());
        }
        wrong.extend(
            names.iter().filter(|name| !run.stderr.contains(**name)).map(|name| format!("{name} is not named")),
        );
        wrong.extend(self.folder.restore(&before).iter().map(|path| format!("{} was touched", path.display())));
        if !wrong.is_empty() {
            self.complaints.push(format!(
                "{arguments}\n    {}\n    it said: {}",
                wrong.join("; "),
                run.stderr.trim_end()
            ));
        }
    }

    /// Fails if anything was wrong.
    pub fn done(self) {
        let Refusals { count, complaints, .. } = self;
        assert!(count > 0, "nothing was tried");
        assert!(
            complaints.is_empty(),
            "{} of {count} are refused wrongly:\n  {}",
            complaints.len(),
            complaints.join("\n  ")
        );
    }
}
