//! Texts as commands of the live page.
#![cfg_attr(fuzzing, no_main)]

sinew_fuzz::target!(sinew_fuzz::read_page_command);
