//! Numbers a formula of mechanics is evaluated over: f64, second-order jets, 3x3 matrices
