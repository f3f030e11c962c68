//! Lines on standard error.

/// Writes a line to standard error. Where nobody reads that any more it is lost, and the work goes on; `eprintln!` would
/// panic.
#[doc(hidden)]
#[macro_export]
macro_rules! tell_line {
    ($($what:tt)*) => {{
        let line = format!("{}\n", format_args!($($what)*));
        let _ = std::io::Write::write_all(&mut std::io::stderr(), line.as_bytes());
    }};
}

pub use tell_line as line;
