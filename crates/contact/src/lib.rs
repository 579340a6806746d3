//! Rough normal contact of an elastic half-space
