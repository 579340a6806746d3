//! Limits of plausibility of maps.

/// Standard deviations (1.4826 times the median absolute value) of the differences from the surrounding median
/// beyond which a point is a spike; it must also stand as far beyond every surrounding point. Of 67 million
/// normally distributed differences the largest is 5.7; heights of machined surfaces have heavier tails.
pub const SPIKE_DEVIATIONS: f64 = 8.0;
/// Half-width of the square around a point whose median is taken: 5 x 5 points, so that clusters of up to twelve
/// wrong points do not determine the median.
pub const SPIKE_REACH: usize = 2;
/// Largest number of points of a spike: the largest minority of 5 x 5. Larger clusters are features of the surface
/// or debris.
pub const MAX_SPIKE_POINTS: usize = 12;
/// Fewest other points that must be present around a point for it to be judged as a spike: as many as around a corner
/// of the map.
pub const MIN_SPIKE_NEIGHBOURS: usize = 8;
/// Standard deviations (1.4826 times the median absolute deviation) above the median height beyond which a point is
/// debris. Heights of a worn or machined surface reach 4 or 5, those of a normally distributed one of 67 million
/// points 5.7.
pub const RAISED_DEVIATIONS: f64 = 12.0;
/// Largest fraction of the map that can be debris: a larger part is the surface itself (the land between wide
/// cavities).
pub const MAX_RAISED_SHARE: f64 = 0.05;
/// Standard deviations below the median height beyond which a point belongs to a hole.
pub const LOWERED_DEVIATIONS: f64 = 12.0;
/// Range of the fraction of the map that can be a hole: smaller parts are scratches and pits of the surface, larger
/// parts are the surface itself.
pub const LOWERED_SHARE: [f64; 2] = [0.005, 0.5];
/// Relative change of the rms slope by spikes that causes a warning: the smallest error of the slope among windows
/// of a map.
pub const SPIKE_SLOPE: f64 = 0.03;
/// Relative change by spikes of the highest point's height above the median that causes a warning, because the
/// highest point carries load first.
pub const SPIKE_PEAK: f64 = 0.1;
/// Fraction of Sa that a second-order form must explain beyond the plane to cause a warning, as the form of a
/// curved specimen would.
pub const FORM_SHARE: f64 = 1.0 / 3.0;
/// Fraction of missing points that causes a warning: filled points are smooth and lower the slope by up to half
/// this fraction. Instrument manuals recommend repeating the measurement from 5 to 10 %.
pub const WARNED_MISSING_SHARE: f64 = 0.1;
/// Fraction of missing points above which a map is refused.
pub const MAX_MISSING_SHARE: f64 = 0.9;
/// Rms slopes outside which a warning is given. Of sliding surfaces polished metal has 1e-3 to 1e-2, ground or
/// laser-textured surfaces have 0.1 to 0.5. A smaller slope than the lower limit means a wafer or a wrong unit of
/// height (too large); above the upper limit the elastic contact theory of small slopes no longer holds.
pub const WARNED_SLOPE: [f64; 2] = [1e-4, 1.0];
/// Pixel sides, in metres, outside which a warning is given: half the distance of two atoms, and a size visible to the
/// eye.
pub const WARNED_PIXEL_M: [f64; 2] = [1e-10, 1e-3];
/// Ratio of a pixel's sides above which a warning is given: profile scans reach 10; sides that differ by a factor of a
/// thousand are in two units.
pub const WARNED_PIXEL_RATIO: f64 = 12.0;
/// Fraction of points that are exactly zero from which blocks of zeros cause a warning; fewer may be a flat part of the
/// surface.
pub const WARNED_ZEROS_SHARE: f64 = 1e-3;
/// Rms slopes outside which the area law is meaningless: below, contact is full at any load; above, walls are 84
/// degrees steep on average.
pub const POSSIBLE_SLOPE: [f64; 2] = [1e-7, 10.0];
/// Sq, in metres, outside which a warning is given: the size of an atom, and relief visible to the eye.
pub const WARNED_SQ_M: [f64; 2] = [1e-10, 1e-4];
