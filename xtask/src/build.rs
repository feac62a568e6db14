//! Builds the images and the command.

use super::process::{cargo, run};
use super::set_up::{self, Compiler};
use super::{Failure, places};

/// Builds everything that flies: all images, and `plumbline` in release. The way the images were compiled.
pub fn build() -> Result<Compiler, Failure> {
    let compiler = set_up::compiler()?;
    images(&compiler)?;
    command()?;
    Ok(compiler)
}

/// Features of the emulated board's images.
pub const AN500: &str = "an500,defmt";

fn images(compiler: &Compiler) -> Result<(), Failure> {
    let mut cargo = cargo();
    cargo.args(["build", "--package", "plumbline-firmware", "--bins", "--features", AN500]);
    cargo.args(["--profile", places::PROFILE]);
    compiler.apply(&mut cargo);
    run(&mut cargo)
}

fn command() -> Result<(), Failure> {
    run(cargo().args(["build", "--release", "--package", "plumbline-sim", "--bin", "plumbline"]))
}
