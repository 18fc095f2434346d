//! Frames on a line of simulated EtherCAT devices.
#![cfg_attr(fuzzing, no_main)]

sinew_fuzz::target!(sinew_fuzz::play_segment);
