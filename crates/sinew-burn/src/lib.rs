//! Burn tensors as numbers of a mechanical formula, and fused autodiff operations
