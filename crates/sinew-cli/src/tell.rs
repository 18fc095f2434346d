//! Lines for people on the standard error.

/// Writes a line; whoever has stopped reading does not stop the program, as `eprintln!` would.
macro_rules! tell {
    ($($words:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($words)*);
    }};
}
