//! The `sinew` program.

#[cfg_attr(
    not(test),
    allow(dead_code, unused_imports, reason = "the verb that writes it is wired separately")
)]
mod report;

fn main() {}
