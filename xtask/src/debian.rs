//! Programs of Debian's packages, unpacked under `target/tools` for this workspace alone. Any user may do that, nothing
//! that the machine has is changed, and it works whatever apt thinks of the machine's other packages: only what it would
//! install on an empty machine, and this one lacks, is taken.

use super::{Failure, places};
use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where programs are looked for and unpacked.
#[derive(Clone, Debug)]
pub struct Machine {
    /// The search path of commands.
    pub path: OsString,
    /// The folder of private programs: each package in a folder of its name, how to start them in `bin`.
    pub tools: PathBuf,
}

/// What is wanted of the packages.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    /// Packages, the first of which names the folder.
    pub packages: &'a [&'a str],
    /// Programs by their path in the packages, and arguments that each start begins with; `$root` is where they lie.
    pub programs: &'a [(&'a str, &'a str)],
}

impl Machine {
    /// The machine as it is.
    pub fn here() -> Self {
        Machine { path: env::var_os("PATH").unwrap_or_default(), tools: places::tools() }
    }

    /// A command of this machine.
    pub fn command(&self, program: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new(program);
        command.env("PATH", &self.path).env("LC_ALL", "C").stdin(Stdio::null());
        command
    }

    /// Where a private program is, once [`Machine::unpack`] has been there.
    pub fn private(&self, program: &str) -> PathBuf {
        self.tools.join("bin").join(program)
    }

    /// Unpacks what is wanted, until it `works`: of the machine's package lists, else of fresh ones.
    ///
    /// # Errors
    /// What apt says, where it does not work with either.
    pub fn unpack(&self, wanted: &Wanted<'_>, works: impl Fn() -> bool) -> Result<(), Failure> {
        let name = wanted.packages.first().copied().unwrap_or_default();
        eprintln!("unpacking {name} and what it needs under {}", self.tools.display());
        let lists = self.tools.join("apt");
        let fresh = [format!("Dir::State={}/state", lists.display()), format!("Dir::Cache={}/cache", lists.display())];
        let attempt = |lists: &[String]| {
            self.unpack_of(lists, wanted)?;
            works().then_some(()).ok_or_else(|| "what Debian's packages hold does not do here".to_owned())
        };
        attempt(&[]).or_else(|why| {
            eprintln!("{why}: trying with fresh package lists");
            for folder in ["state/lists/partial", "cache/archives/partial"] {
                fs::create_dir_all(lists.join(folder)).map_err(|error| format!("{}: {error}", lists.display()))?;
            }
            // A list that cannot be had may be of an archive that does not matter here.
            let updated = self.apt(&fresh, &["update"], &lists).err().map_or(String::new(), |why| format!("; {why}"));
            attempt(&fresh).map_err(|again| if again == why { again } else { format!("{why}; then: {again}{updated}") })
        })
    }

    /// One attempt, with apt's package lists where `options` say.
    fn unpack_of(&self, options: &[String], wanted: &Wanted<'_>) -> Result<(), Failure> {
        let name = wanted.packages.first().copied().unwrap_or_default();
        let (root, new) = (self.tools.join(name), self.tools.join(format!("{name}.{}", std::process::id())));
        let failed = |error: std::io::Error| format!("{}: {error}", new.display());
        let _ = fs::remove_dir_all(&new);
        fs::create_dir_all(&new).map_err(failed)?;
        let unpacked = self.download(options, wanted.packages, &new).and_then(|()| {
            for package in files(&new).iter().filter(|file| file.extension().is_some_and(|end| end == "deb")) {
                self.said(self.command("dpkg").arg("-x").arg(package).arg(&new))?;
                fs::remove_file(package).map_err(failed)?;
            }
            let _ = fs::remove_dir_all(&root);
            fs::rename(&new, &root).map_err(failed)
        });
        if unpacked.is_err() {
            let _ = fs::remove_dir_all(&new);
        }
        unpacked?;
        wanted.programs.iter().try_for_each(|(program, arguments)| self.write_start(name, program, arguments))
    }

    /// Downloads packages and all that they depend on, as far as the machine has it not, into `folder`.
    fn download(&self, options: &[String], packages: &[&str], folder: &Path) -> Result<(), Failure> {
        // As for an empty machine: what this one has then stands in nobody's way.
        let empty = [&["Dir::State::status=/dev/null".to_owned()], options].concat();
        let planned =
            self.apt(&empty, &[&["install", "--simulate", "--no-install-recommends"], packages].concat(), folder)?;
        let states =
            self.said(self.command("dpkg-query").args(["--show", "--showformat=${db:Status-Status} ${Package}\n"]))?;
        let installed: Vec<&str> = states.lines().filter_map(|line| line.strip_prefix("installed ")).collect();
        let names = planned.lines().filter_map(|line| line.strip_prefix("Inst ")?.split_whitespace().next());
        let lacking: Vec<&str> = names.filter(|name| packages.contains(name) || !installed.contains(name)).collect();
        self.apt(options, &[&["download"], &lacking[..]].concat(), folder).map(drop)
    }

    /// What `apt-get` says, started in `folder`.
    fn apt(&self, options: &[String], arguments: &[&str], folder: &Path) -> Result<String, Failure> {
        let mut apt = self.command("apt-get");
        // As root it would download as another user, who may not write here.
        apt.args(["-o", "APT::Sandbox::User=root"]);
        for option in options {
            apt.args(["-o", option]);
        }
        self.said(apt.args(arguments).current_dir(folder))
    }

    /// What a command says; where it fails, why: the first line that it marks as an error, else the last.
    pub fn said(&self, command: &mut Command) -> Result<String, Failure> {
        let program = command.get_program().to_string_lossy().into_owned();
        let output = command.output().map_err(|error| format!("{program}: {error}"))?;
        if output.status.success() {
            return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
        }
        let errors = String::from_utf8_lossy(&output.stderr);
        let why = errors
            .lines()
            .find(|line| line.starts_with("E: ") || line.starts_with("ERROR: "))
            .or(errors.lines().last())
            .unwrap_or("no reason");
        Err(format!("{program}: {}", why.trim_start_matches("E: ").trim_start_matches("ERROR: ")))
    }

    /// A script that starts `program` with the libraries unpacked beside it. Shell alone, for an empty search path.
    fn write_start(&self, name: &str, program: &str, arguments: &str) -> Result<(), Failure> {
        let root = self.tools.join(name);
        let folders = ["usr/lib", "lib"].into_iter().flat_map(|parent| {
            let inside =
                files(&root.join(parent)).into_iter().filter_map(|path| path.file_name()?.to_str().map(str::to_owned));
            inside.filter(|folder| folder.contains("-linux-gnu")).map(move |folder| format!("$root/{parent}/{folder}"))
        });
        let script = format!(
            "#!/bin/sh\nroot=$(cd \"${{0%/*}}/../{name}\" && pwd) || exit\n\
             export LD_LIBRARY_PATH=\"{}${{LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}}\"\nexec \"$root/{program}\" {arguments} \"$@\"\n",
            folders.collect::<Vec<_>>().join(":")
        );
        let start = self.private(program.rsplit('/').next().unwrap_or(program));
        let written = fs::create_dir_all(self.tools.join("bin")).and_then(|()| write_program(&start, &script));
        written.map_err(|error| format!("{}: {error}", start.display()))
    }
}

/// Writes a script that can be started at once: a shell of its own writes it, since a file that this process held open would
/// be busy for as long as a command that another thread is starting has a copy of it.
pub fn write_program(path: &Path, script: &str) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    Command::new("/bin/sh").args(["-c", "printf %s \"$1\" > \"$0\""]).arg(path).arg(script).status()?;
    fs::set_permissions(path, fs::Permissions::from_mode(0o755))
}

/// What lies in a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder).into_iter().flatten().flatten().map(|file| file.path()).collect()
}
