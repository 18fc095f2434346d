//! Where plant and controller meet: experiments on the twin. Nothing else may know both.

pub mod bench;
