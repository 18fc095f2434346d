//! Packets at the host of a link.
#![cfg_attr(fuzzing, no_main)]

sinew_fuzz::target!(sinew_fuzz::play_link);
