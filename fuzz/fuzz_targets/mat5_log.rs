//! Any bytes after the header of a MATLAB v5 file.
#![cfg_attr(fuzzing, no_main)]

sinew_fuzz::target!(sinew_fuzz::read_mat5);
