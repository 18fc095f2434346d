//! No code: the package stands for its dependencies.
