//! Graphs of meshes with multiscale virtual nodes
