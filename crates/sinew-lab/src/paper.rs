//! The numbers that `yuan2023` reports, active muscle first, over the speeds of [`SPEEDS`].

/// Speeds of the cable on the bench, m/s.
pub const SPEEDS: [f64; 6] = [0.02, 0.04, 0.06, 0.08, 0.10, 0.12];

/// Table I, root mean square error, N.
pub const RMSE_N: [[f64; 6]; 2] =
    [[1.92, 1.25, 1.20, 1.74, 1.99, 2.09], [1.13, 1.01, 1.37, 1.26, 1.32, 1.29]];
/// Table I, Pearson's correlation.
pub const PEARSON: [[f64; 6]; 2] =
    [[0.9953, 0.9996, 0.9992, 0.9966, 0.9941, 0.9938], [0.9992, 0.9997, 0.9993, 0.9995, 0.9994, 0.9990]];

/// Table II, mean of `T_out/T_in`.
pub const EFFICIENCY: [[f64; 6]; 2] =
    [[0.436, 0.406, 0.404, 0.417, 0.387, 0.396], [3.594, 3.564, 4.033, 4.62, 5.607, 4.743]];
/// Table II, its standard deviation.
pub const EFFICIENCY_SD: [[f64; 6]; 2] =
    [[0.048, 0.062, 0.063, 0.078, 0.061, 0.061], [0.94, 0.943, 1.194, 1.549, 2.676, 2.019]];

/// Table III, mean elongation over near tension and length, 1e-3 m/(N m).
pub const ELONGATION: [[f64; 6]; 2] =
    [[0.125, 0.125, 0.142, 0.141, 0.153, 0.16], [0.58, 0.55, 0.583, 0.678, 0.66, 0.643]];
/// Table III, its standard deviation.
pub const ELONGATION_SD: [[f64; 6]; 2] =
    [[0.0123, 0.0097, 0.0139, 0.0195, 0.023, 0.0219], [0.239, 0.224, 0.299, 0.286, 0.266, 0.323]];

/// Mean error without compensation, N (figure 7).
pub const UNCOMPENSATED_N: [f64; 2] = [88.5, 63.9];

/// Disagreements between the text of the paper and its tables; comparisons use the tables.
pub const DISAGREEMENTS: [&str; 5] = [
    "Best passive values: 1.08 N^2, 1.04 N and 0.9998 in the text; 1.02, 1.01 and 0.9997 in Table I.",
    "Worst active values: above 6.5 N^2 and 2.5 N, correlation 0.994 in the text; 4.38, 2.09 and 0.9938 in Table I.",
    "Average errors of the compensated tensions: 3.87 N (active) and 3.51 N (passive) in the abstract, \
        section 4.1 and the conclusion; the root mean square errors of Table I average 1.70 N and 1.23 N, \
        and a mean magnitude cannot exceed the root mean square of the same errors.",
    "Errors without compensation: 88.5 N (active) and 63.9 N (passive) in the text. With the pulling end \
        between 40 and 200 N the mean efficiencies of Table II give 71 N and 92 N, the passive muscle \
        losing more: the two numbers appear to be exchanged.",
    "The standard deviations 3.02 N and 1.53 N of the text's mean errors are the average mean squared \
        errors of Table I.",
];

/// Length of the transmission on the bench, m.
pub const LENGTH_M: f64 = 1.667;

/// Tracking of the arm, mean over six repeats: error of the end point, mm: mean, standard deviation, largest.
pub const END_POINT_ERROR_MM: [f64; 3] = [15.8, 7.1, 39.0];

/// Tracking of the arm: mean length error of the muscles, mm.
pub const MUSCLE_LENGTH_ERROR_MM: f64 = 0.78;
