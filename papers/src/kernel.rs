//! The three kernels that Table 2 of paper 003 compares.

/// A kernel of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// The paper's: eq. 3 and 7 with the measured attitude.
    Automatic,
    /// First-order polynomial on control points.
    Polynomial,
    /// Collinearity with the attitude resected on control points.
    Collinearity,
}

impl Kernel {
    /// In the order of the table.
    pub const ALL: [Kernel; 3] = [Kernel::Automatic, Kernel::Polynomial, Kernel::Collinearity];

    /// What the rows call it.
    pub fn name(self) -> &'static str {
        match self {
            Kernel::Automatic => "automatic",
            Kernel::Polynomial => "polynomial",
            Kernel::Collinearity => "collinearity",
        }
    }

    /// The paper's time in milliseconds, memory in KB and error in metres.
    pub fn paper(self) -> (f64, f64, f64) {
        match self {
            Kernel::Automatic => (38.0, 25.0, 2.7),
            Kernel::Polynomial => (34.0, 32.0, 7.5),
            Kernel::Collinearity => (51.0, 34.0, 2.4),
        }
    }
}
