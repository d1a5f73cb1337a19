//! Scenes, experiments and reports: emulators against the finite-element solver
