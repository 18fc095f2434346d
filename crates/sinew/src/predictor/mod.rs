//! From near-side samples to the far end, one sample at a time.
