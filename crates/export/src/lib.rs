//! Files that a laser takes
