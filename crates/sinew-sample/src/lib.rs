//! Markov chains and their diagnostics, shared by calibration and Gaussian processes.
