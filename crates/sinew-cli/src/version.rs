//! What `--version` says.

/// The cargo features of this build.
const FEATURES: [(&str, bool); 4] = [
    ("parquet", cfg!(feature = "parquet")),
    ("mat73", cfg!(feature = "mat73")),
    ("ros", cfg!(feature = "ros")),
    ("foxglove", cfg!(feature = "foxglove")),
];

/// Version of the program, commit of its sources and cargo features.
pub(crate) fn version() -> &'static str {
    static TEXT: std::sync::LazyLock<String> = std::sync::LazyLock::new(|| {
        let built: Vec<&str> = FEATURES.iter().filter(|(_, on)| *on).map(|(name, _)| *name).collect();
        let features = if built.is_empty() { "none".to_owned() } else { built.join(", ") };
        format!("{} ({}; features: {features})", env!("CARGO_PKG_VERSION"), env!("SINEW_COMMIT"))
    });
    &TEXT
}
