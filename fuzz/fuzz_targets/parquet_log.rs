//! Any bytes that start like a Parquet file.
#![cfg_attr(fuzzing, no_main)]

sinew_fuzz::target!(
    sinew_fuzz::read_parquet,
    // A panic that our reader catches from another is an error as promised; one that reaches us still aborts.
    init: std::panic::set_hook(Box::new(|_| {}))
);
