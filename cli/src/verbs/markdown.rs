//! The command line as a page: every verb with its options, from the definitions that parse them.

use clap::builder::StyledStr;
use clap::{Arg, Command};
use std::fmt::Write;

const HEAD: &str = "\
# Command line

Made by `plumbline markdown` from the definitions that parse the arguments; `plumbline VERB --help` says the same.

Exit codes: 0 done; 2 bad input, one sentence on standard error says what and where; 1 it ran, but the work failed. Results and
`--json` go to standard output, progress to standard error. Negative values follow their option after a space; points come
after `--`.
";

/// The page of `command`.
pub fn page(mut command: Command) -> String {
    command.build();
    let verbs: Vec<&Command> =
        command.get_subcommands().filter(|verb| !verb.is_hide_set() && verb.get_name() != "help").collect();
    let mut page = format!("{HEAD}\n| verb | |\n|---|---|\n");
    for verb in &verbs {
        let name = verb.get_name();
        // Writing to a string cannot fail.
        let _ = writeln!(page, "| [{name}](#{name}) | {} |", words(verb.get_about()));
    }
    for verb in verbs {
        section(&mut page, verb.get_name(), verb.clone());
    }
    page
}

fn section(page: &mut String, name: &str, mut verb: Command) {
    let about = verb.get_long_about().or(verb.get_about()).map(ToString::to_string).unwrap_or_default();
    let usage = verb.render_usage().to_string();
    let usage = usage.trim_start_matches("Usage:").trim();
    let _ = writeln!(page, "\n## {name}\n\n{about}\n\n    {usage}");
    let parts = || verb.get_subcommands().filter(|part| part.get_name() != "help");
    if parts().next().is_some() {
        parts().for_each(|part| section(page, &format!("{name} {}", part.get_name()), part.clone()));
        return;
    }
    let _ = writeln!(page, "\n| argument | |\n|---|---|");
    let (points, options): (Vec<&Arg>, Vec<&Arg>) = verb.get_arguments().partition(|arg| arg.is_positional());
    let shown = points.into_iter().chain(options).filter(|arg| !arg.is_hide_set() && arg.get_id() != "help");
    for arg in shown {
        let _ = writeln!(page, "| `{}` | {} |", typed(arg), meaning(arg));
    }
}

/// As it is typed; a bar would end the cell.
fn typed(arg: &Arg) -> String {
    let values = arg.get_value_names().filter(|_| arg.get_action().takes_values()).unwrap_or_default();
    let values = values.iter().map(|value| format!("<{value}>")).collect::<Vec<_>>().join(" ");
    let long = arg.get_long().map(|long| format!("--{long} ")).unwrap_or_default();
    format!("{long}{values}").trim_end().replace('|', "\\|")
}

/// Its help, its default and its choices, in one line.
fn meaning(arg: &Arg) -> String {
    let mut text = words(arg.get_long_help().or(arg.get_help()));
    let list = |values: Vec<String>| values.iter().map(|value| format!("`{value}`")).collect::<Vec<_>>().join(", ");
    let defaults = arg.get_default_values().iter().map(|value| value.to_string_lossy().into_owned()).collect();
    let choices = arg.get_possible_values().iter().map(|value| value.get_name().to_owned()).collect();
    for (what, values) in [("default", list(defaults)), ("one of", list(choices))] {
        if !values.is_empty() && arg.get_action().takes_values() {
            let _ = write!(text, " ({what}: {values})");
        }
    }
    text
}

/// Help as one line that a cell holds, its paragraphs apart. Names in angle brackets would pass for HTML.
fn words(help: Option<&StyledStr>) -> String {
    let text = help.map(ToString::to_string).unwrap_or_default().replace('|', "\\|").replace('<', "&lt;");
    let paragraphs = text.split("\n\n").map(|paragraph| paragraph.split_whitespace().collect::<Vec<_>>().join(" "));
    paragraphs.collect::<Vec<_>>().join("<br>")
}

#[cfg(test)]
mod tests {
    use super::page;
    use crate::verbs::Cli;
    use clap::CommandFactory;

    #[test]
    fn the_page_in_the_documents_is_that_of_the_command() {
        let page = page(Cli::command());
        let kept = include_str!("../../../docs/command-line.md");
        assert_eq!(page, kept, "cargo run --package plumbline-cli -- markdown > docs/command-line.md");
        for verb in ["fly", "configuration", "reproduce"] {
            assert!(page.contains(&format!("\n## {verb}\n")), "{verb}");
        }
        assert!(page.contains("| `--frames <FRAMES>` | Frames to take |"), "an option of fly");
    }
}
