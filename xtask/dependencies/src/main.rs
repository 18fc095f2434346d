//! No code: the package stands for its dependencies. A program, because a library would be compiled with the unit tests of others.

fn main() {}
