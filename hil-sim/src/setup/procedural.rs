//! Procedural ground of a flight and of its reference.

use crate::scenario::{Changes, Scenario};
use crate::world::{Ground, PROCEDURAL_PLACE, procedural_around, procedural_as};

/// Procedural ground as it is today, and as the reference has it where that is not the same.
pub(super) fn grounds(scenario: &Scenario) -> (Ground, Option<Ground>) {
    let (seed, world) = (scenario.run.seed, &scenario.world);
    let (land, as_before) = (world.land, Changes::default());
    let ground = procedural_as(seed, land, world.changes);
    let reference_seed = world.reference.other_seed.unwrap_or(seed);
    let aside_m = world.reference.aside_m[0].abs().max(world.reference.aside_m[1].abs());
    if aside_m > 0.0 {
        // Far from the flight the land goes on by its mirror images.
        let (epsg, centre) = PROCEDURAL_PLACE;
        let side_m = 2.0 * aside_m + ground.bounds().east_m - ground.bounds().west_m;
        return (ground, Some(procedural_around(reference_seed, epsg, centre, side_m)));
    }
    let same = reference_seed == seed && world.changes == as_before;
    let reference = (!same).then(|| procedural_as(reference_seed, land, as_before));
    (ground, reference)
}

#[cfg(test)]
mod tests {
    use crate::scenario::Scenario;
    use crate::setup::Setup;

    /// The tile of a scenario without differences of its own, as (pixels, columns, centre).
    fn tile(of: impl Fn(&mut Scenario)) -> (Vec<u8>, usize, [f64; 2]) {
        let mut scenario = Scenario::of_frames(1);
        let reference = &mut scenario.world.reference;
        (reference.gamma, reference.noise_dn, reference.changed_fraction) = (Some(1.0), Some(0.0), Some(0.0));
        of(&mut scenario);
        let setup = Setup::prepare(scenario).expect("it can be flown");
        (setup.flash.tile, setup.flash.head.size.0.into(), setup.tile_centre)
    }

    #[test]
    fn a_reference_of_elsewhere_says_that_it_lies_here() {
        let (here, cols, centre) = tile(|_| {});
        let (aside, _, said) = tile(|scenario| scenario.world.reference.aside_m = [50.0, -20.0]);
        assert_eq!((here.len(), centre), (aside.len(), said));
        // Ten columns to the east and four rows to the south of what it would show.
        let moved = |at: usize| here[at + 4 * cols + 10];
        let is_moved = |at: &usize| at % cols + 10 < cols && (i16::from(moved(*at)) - i16::from(aside[*at])).abs() <= 1;
        let inner = (0..here.len() - 4 * cols - 10).filter(|at| at % cols + 10 < cols);
        assert!(inner.clone().all(|at| is_moved(&at)));
        assert!(inner.clone().filter(|at| here[*at] != aside[*at]).count() * 10 > 9 * inner.count());
    }

    #[test]
    fn a_reference_of_another_seed_shows_other_land() {
        let (here, _, centre) = tile(|_| {});
        let (other, _, said) = tile(|scenario| scenario.world.reference.other_seed = Some(7));
        assert_eq!((here.len(), centre), (other.len(), said));
        let (seventh, ..) = tile(|scenario| scenario.run.seed = 7);
        assert!(other == seventh && other != here);
        // What has happened to the land shows in frames alone.
        let (before, ..) = tile(|scenario| scenario.world.changes.flooded_fraction = 1.0);
        assert!(before == here);
    }
}
