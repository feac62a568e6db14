//! What the test targets share: golden values, seeded random numbers, test pictures, known-wrong equations; and the comparison
//! of kernels, the search for inputs that break a reader and campaigns of flights, which are programs as well.

mod bootstrap;
pub mod campaign;
pub mod compare;
pub mod fuzz;
pub mod mutants;
pub mod seeded;
pub mod textures;
pub mod track;
pub mod vectors;
pub mod years;
