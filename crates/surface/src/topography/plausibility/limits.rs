//! Limits of plausibility of maps.

/// A point is a spike if it differs from the surrounding median by more than this number of standard deviations of such
/// differences (1.4826 times the median absolute value), and stands as far beyond every surrounding point. Of 67
/// million normally distributed differences the largest is 5.7; heights of machined surfaces have heavier tails.
pub const SPIKE_DEVIATIONS: f64 = 8.0;
/// Half-width, in points, of the square around a point whose median is taken: 5 x 5 points, so that clusters of up to
/// twelve wrong points do not determine the median.
pub const SPIKE_REACH: usize = 2;
/// Largest number of points of a spike: the largest minority of 5 x 5. Larger clusters are features of the surface
/// or debris.
pub const MAX_SPIKE_POINTS: usize = 12;
/// Fewest other points that must be present around a point for it to be judged as a spike: as many as around a corner
/// of the map.
pub const MIN_SPIKE_NEIGHBOURS: usize = 8;
/// A point is debris if it lies more than this number of standard deviations (1.4826 times the median absolute
/// deviation) above the median height. Heights of a worn or machined surface reach 4 or 5, those of a normally
/// distributed one of 67 million points 5.7.
pub const RAISED_DEVIATIONS: f64 = 12.0;
/// Largest fraction of the map that can be debris: a larger part is the surface itself (the land between wide
/// cavities).
pub const MAX_RAISED_SHARE: f64 = 0.05;
/// A point belongs to a hole if it lies more than this number of standard deviations below the median height.
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
/// Range of rms slopes outside which a warning is given. Of sliding surfaces polished metal has 1e-3 to 1e-2, ground or
/// laser-textured surfaces have 0.1 to 0.5. A smaller slope than the lower limit means a wafer or a wrong unit of
/// height (too large); above the upper limit the elastic contact theory of small slopes no longer holds.
pub const WARNED_SLOPE: [f64; 2] = [1e-4, 1.0];
/// Range of pixel sides, in metres, outside which a warning is given: from half the distance of two atoms to a size
/// visible to the eye.
pub const WARNED_PIXEL_M: [f64; 2] = [1e-10, 1e-3];
/// Ratio of a pixel's sides above which a warning is given: profile scans reach 10; sides that differ by a factor of a
/// thousand are in two units.
pub const WARNED_PIXEL_RATIO: f64 = 12.0;
/// Blocks of zeros cause a warning if at least this fraction of all points is exactly zero; fewer zeros may be a flat
/// part of the surface.
pub const WARNED_ZEROS_SHARE: f64 = 1e-3;
/// Range of rms slopes outside which a contact area is meaningless: below the range contact is full at any load, above
/// it walls are 84 degrees steep on average.
pub const POSSIBLE_SLOPE: [f64; 2] = [1e-7, 10.0];
/// Range of Sq, in metres, outside which a warning is given: from the size of an atom to relief visible to the eye.
pub const WARNED_SQ_M: [f64; 2] = [1e-10, 1e-4];
