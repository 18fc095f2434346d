//! Empty. `ethercrab-wire-derive` 0.3.0 lists `criterion`, with which its benches measure, among its
//! dependencies: forty packages that nothing calls. `[patch.crates-io]` puts this one in its place; where the
//! crates are built outside the workspace, the real one is.
