//! How far an estimate is from the truth: eqs. 14 to 16.
