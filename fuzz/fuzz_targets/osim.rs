//! OpenSim's models.
#![cfg_attr(fuzzing, no_main)]

sinew_fuzz::target!(sinew_fuzz::read_osim);
