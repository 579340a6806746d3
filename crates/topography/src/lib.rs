//! Altitude maps of measured or synthetic surfaces
