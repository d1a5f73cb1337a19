//! Bodies that differ by a few numbers, drawn independently, of which no user has the like: beams and rings of random shape.

mod beam;
mod checked;
mod ring;

pub(crate) use beam::BeamShape;
pub(crate) use ring::RingShape;
