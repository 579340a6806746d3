//! Search for the pattern that brings friction to a target
