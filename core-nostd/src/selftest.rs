//! Compares both versions of every kernel on seeded inputs, on a processor that has the instructions.
//!
//! The self-test of the emulated board runs it: `portable` defines what a kernel computes, and `armv7em` must give the same
//! bits for every length, alignment and extreme. Functions are `#[inline]` so that only an image that calls them has them.

mod inputs;
mod arch;
mod reduce;
mod rectify;
mod correlation;
mod gradients;
mod least_squares;

use inputs::{Inputs, SEEDS};

/// A kernel with both versions.
#[derive(Clone, Copy, Debug)]
pub struct Kernel {
    /// Module and function.
    pub name: &'static str,
    compare: fn(&mut Inputs) -> Outcome,
}

/// Where the results of both versions differ first.
#[derive(Clone, Copy, Debug)]
pub struct Difference {
    /// Seed of the inputs.
    pub seed: u32,
    /// Number of the value among the results.
    pub at: usize,
    /// What the portable version gives there.
    pub portable: i64,
    /// What the assembly gives there.
    pub armv7em: i64,
}

/// What a comparison of one seed found: number of the value and both of them where they differ.
type Outcome = Result<(), (usize, i64, i64)>;

impl Kernel {
    /// Every kernel.
    #[inline]
    pub fn all() -> [Kernel; 25] {
        let kernel = |name, compare| Kernel { name, compare };
        [
            kernel("arch::opaque", arch::opaque),
            kernel("arch::sqrt", arch::sqrt),
            kernel("arch::add_bytes", arch::add_bytes),
            kernel("arch::clamp_bytes", arch::clamp_bytes),
            kernel("arch::difference", arch::difference),
            kernel("arch::dot", arch::dot),
            kernel("reduce::prefix_pairs", reduce::prefix_pairs),
            kernel("reduce::prefix_fours", reduce::prefix_fours),
            kernel("rectify::border_integrals", rectify::border_integrals),
            kernel("rectify::cell_means", rectify::cell_means),
            kernel("rectify::blend_along", rectify::blend_along),
            kernel("rectify::blend_steeply", rectify::blend_steeply),
            kernel("matching::rows", correlation::rows),
            kernel("matching::high_pass", correlation::high_pass),
            kernel("matching::gradients", gradients::gradients),
            kernel("matching::directions", gradients::directions),
            kernel("matching::smooth", gradients::smooth),
            kernel("matching::slide", correlation::slide),
            kernel("matching::dot_and_energy", correlation::dot_and_energy),
            kernel("matching::dots_and_energies", correlation::dots_and_energies),
            kernel("matching::moments", correlation::moments),
            kernel("matching::dot4_rows", correlation::dot4_rows),
            kernel("matching::weighed_products and weighed_sums", least_squares::sums),
            kernel("matching::weigh_rows", least_squares::weigh_rows),
            kernel("matching::weigh_residuals", least_squares::weigh_residuals),
        ]
    }

    /// Compares both versions on the inputs of every seed.
    ///
    /// # Errors
    /// The first [`Difference`].
    #[inline]
    pub fn check(&self) -> Result<(), Difference> {
        (0..SEEDS).try_for_each(|seed| {
            let differs = |(at, portable, armv7em)| Difference { seed, at, portable, armv7em };
            (self.compare)(&mut Inputs::new(seed)).map_err(differs)
        })
    }
}

/// Compares results value by value.
#[inline]
fn same<T: Copy + Into<i64>>(portable: &[T], armv7em: &[T]) -> Outcome {
    let pairs = portable.iter().zip(armv7em).map(|(&a, &b)| (a.into(), b.into())).enumerate();
    let mut different = pairs.filter(|(_, (a, b))| a != b).map(|(at, (a, b))| (at, a, b));
    different.next().map_or(Ok(()), Err)
}
