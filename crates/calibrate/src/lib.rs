//! Local friction coefficients from measurements on flat samples
