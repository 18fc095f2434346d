//! Laws of the cable in its sheath and over its pulleys: one law, one file.
