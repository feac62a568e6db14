//! What lies in tightly coupled instruction memory (ITCM): the modules of the core that see every pixel.

/// Paths in the core, one a line; comments begin with `#`. firmware/build.rs makes the linker's patterns of the same list.
const LIST: &str = include_str!("../../../firmware/hot.txt");

/// The paths as both ways of mangling spell them: a name's length before each name.
fn patterns() -> impl Iterator<Item = String> {
    let paths = LIST.lines().filter(|line| !line.starts_with('#'));
    paths.map(|path| path.split("::").map(|name| format!("{}{name}", name.len())).collect())
}

/// Functions that must be there by name, since they do the work: that a module has some other function there is not enough.
pub const WORKERS: [&str; 8] = [
    "6reduce11prefix_from",
    "7rectify12rectify_into",
    "7rectify8bilinear4Line6follow",
    "7rectify7kernels7armv7em17integrate_borders",
    "8matching6search6images6Images4rank",
    "8matching6search6images6Images5score",
    "8matching6refine6refine",
    "8matching6refine7segment7Segment9residuals",
];

/// Whether a mangled name is a hot function's.
pub fn is_hot(name: &str) -> bool {
    // What the linker adds to reach flash from ITCM, or the other way, belongs where it stands.
    name.split_once("14plumbline_core")
        .is_some_and(|(before, inside)| !is_bridge(before) && patterns().any(|pattern| inside.starts_with(&pattern)))
}

/// Whether a name is a jump over more than 16 MiB, made by the linker.
pub fn is_bridge(name: &str) -> bool {
    name.starts_with("__Thumbv7ABSLongThunk_") || name.starts_with("__ThumbV7ABSLongThunk_")
}

#[cfg(test)]
mod tests {
    use super::{is_bridge, is_hot};

    #[test]
    fn hot_functions_are_told_by_their_modules() {
        assert!(is_hot("_ZN14plumbline_core6reduce11prefix_from17h249818c0dcddd48eE"));
        assert!(is_hot("_ZN14plumbline_core8matching11correlation6locate17h671bf7c4447f2a25E"));
        assert!(is_hot("_RNvNtCs1_14plumbline_core7rectify12rectify_into"));
        assert!(!is_hot("_ZN14plumbline_core8matching9reacquire7ranking6coarse17ha7cd72e7f648c7adE"));
        assert!(!is_hot("_ZN14plumbline_core8matching11correlation10locate_far17h671bf7c4447f2a25E"));
        assert!(!is_hot("_ZN14plumbline_core4pose5noise7Choices2of17h3ae6af76e2e344c7E"));
        assert!(!is_hot("__Thumbv7ABSLongThunk__ZN14plumbline_core8matching6refine6refine17hc3d65b46835f65e4E"));
        assert!(is_bridge("__Thumbv7ABSLongThunk___aeabi_memclr"));
    }
}
