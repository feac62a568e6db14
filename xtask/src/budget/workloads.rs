//! The worst of each workload over all poses, as a whole and by its stages.

use super::bench::{Cost, Region};
use crate::Failure;

/// A workload, or a part of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Workload {
    /// Its name.
    pub name: String,
    /// The largest of each figure, not all of the same pose.
    pub worst: Cost,
    /// The pose with the largest serial estimate.
    pub pose: String,
}

/// The pose of a stage that does not depend on it.
const ANY: &str = "any";
/// What stands between a frame's last row and its fix; the name of that part.
const AFTER_LAST_ROW: [&str; 3] = ["situate", "rectify", "register"];
/// See [`AFTER_LAST_ROW`].
pub const LAST_ROW_TO_FIX: &str = "frame, last row to fix";

/// The workloads in the bench's order, each followed by its parts.
pub fn workloads(regions: &[Region]) -> Result<Vec<Workload>, Failure> {
    let mut workloads = Vec::new();
    for name in distinct(regions.iter().map(|region| region.workload.as_str())) {
        let of_it: Vec<&Region> = regions.iter().filter(|region| region.workload == name).collect();
        let stages = distinct(of_it.iter().map(|region| region.stage.as_str()));
        workloads.push(worst(name.to_owned(), &of_it, &stages)?);
        if AFTER_LAST_ROW.iter().all(|stage| stages.contains(stage)) {
            workloads.push(worst(LAST_ROW_TO_FIX.to_owned(), &of_it, &AFTER_LAST_ROW)?);
        }
        for stage in stages.iter().filter(|_| stages.len() > 1) {
            workloads.push(worst(format!("{name}: {stage}"), &of_it, &[stage])?);
        }
    }
    Ok(workloads)
}

/// The worst pose of some stages together.
fn worst(name: String, regions: &[&Region], stages: &[&str]) -> Result<Workload, Failure> {
    let poses = distinct(regions.iter().map(|region| region.pose.as_str()).filter(|&pose| pose != ANY));
    let poses = if poses.is_empty() || stages.iter().all(|stage| is_any(regions, stage)) { vec![ANY] } else { poses };
    let mut workload = Workload { name, worst: Cost::default(), pose: String::new() };
    for pose in poses {
        let mut sum = Cost::default();
        for stage in stages {
            let pose = if is_any(regions, stage) { ANY } else { pose };
            let mut of_pose = regions.iter().filter(|region| region.stage == *stage && region.pose == pose);
            let (Some(region), None) = (of_pose.next(), of_pose.next()) else {
                return Err(format!("the bench did not run {} ({stage}, {pose}) just once", workload.name));
            };
            sum = sum.plus(&region.cost);
        }
        if sum.serial >= workload.worst.serial {
            pose.clone_into(&mut workload.pose);
        }
        workload.worst = workload.worst.max(&sum);
    }
    Ok(workload)
}

fn is_any(regions: &[&Region], stage: &str) -> bool {
    regions.iter().any(|region| region.stage == stage && region.pose == ANY)
}

impl Cost {
    fn plus(&self, other: &Cost) -> Cost {
        self.with(other, |a, b| a + b)
    }

    fn max(&self, other: &Cost) -> Cost {
        self.with(other, u64::max)
    }

    fn with(&self, other: &Cost, both: impl Fn(u64, u64) -> u64) -> Cost {
        Cost {
            instructions: both(self.instructions, other.instructions),
            floor: both(self.floor, other.floor),
            serial: both(self.serial, other.serial),
            lines: both(self.lines, other.lines),
        }
    }
}

/// The different ones, in the order of their first occurrence.
fn distinct<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut all = Vec::new();
    for name in names {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::{LAST_ROW_TO_FIX, workloads};
    use crate::budget::bench::{Cost, Region};

    fn region(workload: &str, stage: &str, pose: &str, serial: u64, instructions: u64) -> Region {
        let cost = Cost { instructions, floor: 0, serial, lines: 0 };
        Region { workload: workload.into(), stage: stage.into(), pose: pose.into(), cost }
    }

    #[test]
    fn the_worst_pose_counts_with_what_all_poses_share() {
        let regions = [
            region("r", "reduce", "any", 100, 10),
            region("r", "rectify", "east", 5, 7),
            region("r", "rectify", "north", 9, 6),
        ];
        let found = workloads(&regions).expect("complete");
        assert_eq!((found[0].name.as_str(), found[0].worst.serial, found[0].pose.as_str()), ("r", 109, "north"));
        assert_eq!(found[0].worst.instructions, 17);
        let stages: Vec<(&str, u64)> = found[1..].iter().map(|w| (w.name.as_str(), w.worst.serial)).collect();
        assert_eq!(stages, [("r: reduce", 100), ("r: rectify", 9)]);
    }

    #[test]
    fn the_end_of_a_frame_is_summed_pose_by_pose() {
        let mut regions = Vec::new();
        for (pose, costs) in [("a", [1, 50, 10, 30, 3]), ("b", [1, 50, 20, 10, 5])] {
            for (stage, cost) in ["begin", "rows", "situate", "rectify", "register"].into_iter().zip(costs) {
                regions.push(region("frame", stage, pose, cost, cost));
            }
        }
        let found = workloads(&regions).expect("complete");
        assert_eq!((found[0].worst.serial, found[1].worst.serial), (94, 43));
        assert_eq!((found[1].name.as_str(), found[1].pose.as_str()), (LAST_ROW_TO_FIX, "a"));
        // A stage that is missing for one pose, or there twice, is no cheap frame.
        let twice = [regions.clone(), vec![regions[9].clone()]].concat();
        assert!(workloads(&regions[..9]).is_err() && workloads(&twice).is_err());
    }
}
