//! Builds, then flies in the emulator unless told otherwise.

use super::process::exit_code;
use super::{Failure, build, places, set_up};
use std::process::{Command, ExitCode};

/// `cargo xtask fly ARGS`: the exit code is that of `plumbline fly`.
pub fn fly(args: &[String]) -> Result<ExitCode, Failure> {
    let link = option(args, "--link");
    if link.is_none_or(|link| link == "qemu") {
        set_up::emulator()?;
    }
    build::build()?;
    let mut command = Command::new(places::plumbline());
    command.arg("fly");
    if link.is_none() {
        command.args(["--link", "qemu"]);
    }
    if link.is_none_or(|link| link == "qemu") && option(args, "--firmware").is_none() {
        command.arg("--firmware").arg(places::image("an500"));
    }
    exit_code(command.args(args))
}

/// The value of an option, as `--name value` or `--name=value`; empty if the value is missing.
pub fn option<'a>(args: &'a [String], name: &str) -> Option<&'a str> {
    args.iter().enumerate().find_map(|(at, arg)| match arg.strip_prefix(name)? {
        "" => Some(args.get(at + 1).map_or("", String::as_str)),
        rest => rest.strip_prefix('='),
    })
}

#[cfg(test)]
mod tests {
    use super::option;

    #[test]
    fn options_are_found_in_both_spellings() {
        let args: Vec<String> = ["--seed", "7", "--link=inproc", "--linker", "x"].map(String::from).to_vec();
        assert_eq!(option(&args, "--link"), Some("inproc"));
        assert_eq!(option(&args, "--seed"), Some("7"));
        assert_eq!(option(&args, "--firmware"), None);
        assert_eq!(option(&args[3..], "--link"), None, "a longer name is another option");
        assert_eq!(option(&["--link".to_owned()], "--link"), Some(""));
    }
}
