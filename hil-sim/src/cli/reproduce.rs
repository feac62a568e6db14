//! stub
use super::Failure;
#[derive(Debug, clap::Args)]
pub struct Args {}
pub fn run(_: &Args) -> Result<(), Failure> { Ok(()) }
