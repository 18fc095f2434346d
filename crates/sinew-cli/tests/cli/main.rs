//! The `sinew` program as its users meet it: commands in, files, text and exit codes out.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

mod bad_logs;
mod bad_models;
mod bench;
mod calibrate;
mod compensate;
mod determinism;
mod drive;
mod edge;
mod export;
mod json;
mod limits;
mod link;
mod live;
mod machine;
mod map;
#[cfg(target_os = "linux")]
mod mit;
mod period;
mod recording;
mod robots;
mod roles;
mod ros;
mod run;
mod stops;
mod study;
mod tension;
mod text_bus;
#[cfg(target_os = "linux")]
mod truth;
mod twin;
mod verbs;
mod writing;
