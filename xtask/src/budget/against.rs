//! Another revision, counted with the same compiler and the same plugin.

use super::bench::{self, Region};
use super::figures::{Figure, INSTRUCTIONS, SERIAL, tolerated};
use crate::process::{output, run};
use crate::set_up::Compiler;
use crate::{Failure, places};
use std::env;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

/// The commit that `revision` names.
pub fn commit(revision: &str) -> Result<String, Failure> {
    let named = format!("{revision}^{{commit}}");
    output(git().args(["rev-parse", "--verify", "--quiet", &named]))
        .ok_or_else(|| format!("git knows no revision {revision:?}"))
}

/// Regions of a revision, built from its commit in a folder of its own.
pub fn regions((revision, commit): (&str, &str), compiler: &Compiler) -> Result<Vec<Region>, Failure> {
    let tree = Tree::new(commit)?;
    if !tree.0.join("firmware/src/bin/bench.rs").is_file() {
        return Err(format!("{revision} has no bench image: there is nothing to compare with"));
    }
    bench::of(&tree.0, &places::scratch().join("against"), compiler)
}

/// Makes the figures of another revision the limits of ours. What it has not counted is told, not judged.
pub fn limit(figures: &mut [Figure], before: &[Figure]) {
    for figure in figures {
        figure.limit = None;
        if [INSTRUCTIONS, SERIAL].contains(&figure.metric) {
            figure.limit = figure.of(before).map(|other| tolerated(other.value));
            if figure.limit.is_none() {
                eprintln!("{}: {}: not counted at the other revision", figure.workload, figure.metric);
            }
        }
    }
}

fn git() -> Command {
    let mut command = Command::new("git");
    command.current_dir(places::root());
    command
}

/// A second working tree, gone when it is dropped.
struct Tree(PathBuf);

impl Tree {
    fn new(commit: &str) -> Result<Self, Failure> {
        let path = env::temp_dir().join(format!("plumbline-against-{}", std::process::id()));
        let tree = Tree(path);
        // Standard output is for the figures.
        let mut add = git();
        add.args(["worktree", "add", "--quiet", "--force", "--detach"]).arg(&tree.0).arg(commit);
        run(add.stdout(std::io::stderr()))?;
        Ok(tree)
    }
}

impl Drop for Tree {
    fn drop(&mut self) {
        let _ = output(git().args(["worktree", "remove", "--force"]).arg(&self.0));
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::limit;
    use crate::budget::figures::{Figure, INSTRUCTIONS, SERIAL, SERIAL_480};

    #[test]
    fn the_other_revision_is_the_limit_of_counts_alone() {
        let before = [Figure::new("frame", INSTRUCTIONS, 1000.0), Figure::new("frame", SERIAL, 2000.0)];
        let mut now = [
            Figure::new("frame", INSTRUCTIONS, 1005.0),
            Figure::new("frame", SERIAL, 2011.0),
            // Above its own limit, which is none of this comparison's business.
            Figure::new("frame", SERIAL_480, 1e6),
            Figure::new("new", INSTRUCTIONS, 1.0),
        ];
        limit(&mut now, &before);
        assert_eq!(now.each_ref().map(Figure::fails), [false, true, false, false]);
    }
}
