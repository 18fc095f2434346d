//! Any bytes as a text table.
#![cfg_attr(fuzzing, no_main)]

sinew_fuzz::target!(sinew_fuzz::read_log);
