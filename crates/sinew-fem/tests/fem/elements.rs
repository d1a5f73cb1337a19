//! Every element, load and support of the solver against closed forms, differences and patch tests.

mod derivatives;
mod foundation;
mod incompressible;
mod patch;
mod plane;
mod pressure;
mod scene;
mod supports;
