//! Signed messages as another author's program has them: the vectors that the tests of signing go by (`tests/signing/vectors.py`).

use super::process::run;
use super::steps::Outcome;
use super::{places, python};
use std::process::Command;

/// What the script imports.
const MODULES: [python::Module; 1] = [("pymavlink", "pymavlink==2.4.49")];

/// Has pymavlink make the vectors anew and judge them, and compares them with those that are kept.
pub fn check() -> Outcome {
    python::with(&MODULES).map_or_else(Outcome::Skipped, |python| {
        let [script, vectors] =
            ["tests/signing/vectors.py", "tests/vectors/signing.json"].map(|of| places::root().join(of));
        run(Command::new(python).arg(script).arg("--check").arg(vectors)).into()
    })
}
