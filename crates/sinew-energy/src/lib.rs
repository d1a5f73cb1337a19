//! Hyperelastic strain-energy laws, loads and the total potential energy of a mesh
