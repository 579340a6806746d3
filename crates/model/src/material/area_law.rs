use crate::material::MaterialError;
use crate::material::error::{increasing, not_negative, positive, same_length};

/// Pressure P0 up to which friction is proportional to load, in pascals: 0.7 MPa as in Balestra et al., J. Tribol. 144,
/// 031704.
pub const THRESHOLD_PRESSURE_PA: f64 = 0.7e6;

/// Area factor f(p) of the friction traction mu f(p) p at the local pressure p: f = [A(p)/A(P0)] / [p/P0] above the
/// threshold pressure P0, with the real contact area fraction A, and 1 up to P0.
///
/// The published "linear from 0.7 MPa" is interpreted as the line through the origin, not as the tangent at P0. f is
/// interpolated linearly between tabulated pressures, and is 1 below the first. Above the last tabulated pressure, the
/// area stays constant, so that f falls as 1/p ([`AreaLaw::is_extrapolated`]).
#[derive(Clone, Debug, PartialEq)]
pub struct AreaLaw {
    pressure_pa: Vec<f64>,
    factor: Vec<f64>,
    /// df/dp in each interval of the table, per pascal.
    slope: Vec<f64>,
    /// Standard errors of the factors, one per tabulated pressure; `None` if unknown.
    factor_std: Option<Vec<f64>>,
}

/// Interval of an [`AreaLaw`] as a polynomial: p f(p) = constant + linear p + quadratic p^2 for local pressures p from
/// `from_pa` to `to_pa`, in pascals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Lower end of the interval, in pascals, included.
    pub from_pa: f64,
    /// Upper end of the interval, in pascals, not included.
    pub to_pa: f64,
    /// Constant term of p f(p), in pascals.
    pub constant_pa: f64,
    /// Coefficient of p, dimensionless.
    pub linear: f64,
    /// Coefficient of p^2, per pascal.
    pub quadratic_per_pa: f64,
}

impl Piece {
    /// Friction proportional to pressure: f = 1.
    pub const PROPORTIONAL: Self =
        Self { from_pa: 0.0, to_pa: f64::INFINITY, constant_pa: 0.0, linear: 1.0, quadratic_per_pa: 0.0 };
}

/// Maximum area factor f of a valid law. The counting error of contact points lets f exceed 1 by 0.07 if only some
/// hundred points touch (a slope of 0.5 on 128 x 128 points). A larger excess comes from a few points that carry most
/// of the load.
pub const MAX_FACTOR: f64 = 1.1;
/// Maximum f whose excess over 1 is attributed to the error of the contact computation.
const ROUNDED_FACTOR: f64 = 1.002;

/// Width of the ramp that replaces a step of f, relative to the pressure of the step. f is then continuous, and a block
/// pushed across the step has an equilibrium on the ramp.
const STEP_WIDTH: f64 = 1e-3;
/// A first factor that deviates from 1 by at most this value does not count as a step.
const STEP_TOLERANCE: f64 = 1e-6;

impl AreaLaw {
    /// Creates a law from a table of factors. f is 1 below the first pressure; a first factor other than 1 is a step,
    /// which is replaced by a ramp of 0.1 % of the first pressure below it.
    ///
    /// # Errors
    /// [`MaterialError`] if the table is empty, its columns differ in length, pressures do not increase from a positive
    /// first pressure, or a factor is negative.
    pub fn new(mut pressure_pa: Vec<f64>, mut factor: Vec<f64>) -> Result<Self, MaterialError> {
        const TABLE: &str = "area law";
        increasing(TABLE, &pressure_pa)?;
        positive("first pressure of the area law", pressure_pa[0])?;
        same_length(TABLE, pressure_pa.len(), factor.len())?;
        for &value in &factor {
            not_negative("factor of the area law", value)?;
        }
        if (factor[0] - 1.0).abs() > STEP_TOLERANCE {
            pressure_pa.insert(0, pressure_pa[0] * (1.0 - STEP_WIDTH));
            factor.insert(0, 1.0);
        }
        let slope = pressure_pa.windows(2).zip(factor.windows(2)).map(|(p, f)| (f[1] - f[0]) / (p[1] - p[0])).collect();
        Ok(Self { pressure_pa, factor, slope, factor_std: None })
    }

    /// Sets the standard errors of the factors, one per tabulated pressure; f is not changed.
    ///
    /// The point that [`AreaLaw::new`] inserts for a step gets the standard error 0.
    ///
    /// # Errors
    /// [`MaterialError`] if the number of standard errors differs from that of the pressures, or a standard error is
    /// negative.
    pub fn with_factor_std(mut self, mut factor_std: Vec<f64>) -> Result<Self, MaterialError> {
        const QUANTITY: &str = "standard error of a factor of the area law";
        let stepped = match self.pressure_pa[..] {
            [before, first, ..] => before == first * (1.0 - STEP_WIDTH),
            _ => false,
        };
        if stepped && factor_std.len() + 1 == self.factor.len() {
            factor_std.insert(0, 0.0);
        }
        same_length(QUANTITY, self.factor.len(), factor_std.len())?;
        for &value in &factor_std {
            not_negative(QUANTITY, value)?;
        }
        self.factor_std = Some(factor_std);
        Ok(self)
    }

    /// Computes the law from a curve of real contact area fraction against pressure. The law is tabulated at the
    /// threshold P0 = `threshold_pa` and at the pressures of the curve above it.
    ///
    /// A(P0) is interpolated linearly if `threshold_pa` is not tabulated.
    ///
    /// # Errors
    /// [`MaterialError`] if the curve does not bracket the threshold, or is not a valid table.
    pub fn from_area_curve(
        pressure_pa: &[f64],
        area_fraction: &[f64],
        threshold_pa: f64,
    ) -> Result<Self, MaterialError> {
        const CURVE: &str = "contact area curve";
        const THRESHOLD: &str = "threshold pressure of the area law";
        increasing(CURVE, pressure_pa)?;
        same_length(CURVE, pressure_pa.len(), area_fraction.len())?;
        positive(THRESHOLD, threshold_pa)?;
        let above = pressure_pa.partition_point(|&p| p < threshold_pa);
        if above == pressure_pa.len() || (above == 0 && pressure_pa[0] > threshold_pa) {
            let expected = "a pressure within the contact area curve";
            return Err(MaterialError::out_of_range(THRESHOLD, threshold_pa, expected));
        }
        let threshold_area = if pressure_pa[above] == threshold_pa {
            area_fraction[above]
        } else {
            interpolate(&pressure_pa[above - 1..=above], &area_fraction[above - 1..=above], threshold_pa)
        };
        positive("contact area at the threshold", threshold_area)?;

        let mut law_pressure_pa = vec![threshold_pa];
        let mut factor = vec![1.0];
        for (&p, &area) in pressure_pa.iter().zip(area_fraction).filter(|&(&p, _)| p > threshold_pa) {
            law_pressure_pa.push(p);
            // f(P) = [A(P)/A(P0)] / [P/P0]
            factor.push((area / threshold_area) / (p / threshold_pa));
        }
        Self::new(law_pressure_pa, factor)
    }

    /// Area factor f at the local pressure `pressure_pa`; 1 for tensile or zero pressure.
    pub fn factor(&self, pressure_pa: f64) -> f64 {
        self.factor_near(pressure_pa, &mut 0)
    }

    /// Like [`AreaLaw::factor`], but first tries `near`, the index of the interval of the previous call, and updates
    /// `near`. This is much faster if pressures change slowly.
    #[inline]
    pub fn factor_near(&self, pressure_pa: f64, near: &mut usize) -> f64 {
        let (p, f) = (&self.pressure_pa, &self.factor);
        let inside = |i: usize| i + 1 < p.len() && p[i] <= pressure_pa && pressure_pa < p[i + 1];
        if !inside(*near) {
            let last = p.len() - 1;
            if pressure_pa < p[0] {
                return 1.0;
            }
            if pressure_pa >= p[last] {
                return f[last] * p[last] / pressure_pa;
            }
            *near = self.interval(pressure_pa);
        }
        f[*near] + self.slope[*near] * (pressure_pa - p[*near])
    }

    /// Index of the interval that contains `pressure_pa`; 0 for NaN, which occurs in diverging runs.
    fn interval(&self, pressure_pa: f64) -> usize {
        self.pressure_pa.partition_point(|&tabulated| tabulated <= pressure_pa).max(1) - 1
    }

    /// Polynomial of p f(p), the friction traction per unit coefficient, on the interval that contains `pressure_pa`.
    pub fn piece(&self, pressure_pa: f64) -> Piece {
        let (p, f) = (&self.pressure_pa, &self.factor);
        let last = p.len() - 1;
        if pressure_pa < p[0] {
            return Piece { from_pa: 0.0, to_pa: p[0], ..Piece::PROPORTIONAL };
        }
        if pressure_pa >= p[last] {
            // The area is constant: so is f p.
            return Piece {
                from_pa: p[last],
                to_pa: f64::INFINITY,
                constant_pa: f[last] * p[last],
                linear: 0.0,
                quadratic_per_pa: 0.0,
            };
        }
        let i = self.interval(pressure_pa);
        Piece {
            from_pa: p[i],
            to_pa: p[i + 1],
            constant_pa: 0.0,
            // p f = p [f_i + s_i (p - p_i)]
            linear: f[i] - self.slope[i] * p[i],
            quadratic_per_pa: self.slope[i],
        }
    }

    /// Whether `pressure_pa` is above the last tabulated pressure.
    pub fn is_extrapolated(&self, pressure_pa: f64) -> bool {
        pressure_pa > self.pressure_pa[self.pressure_pa.len() - 1]
    }

    /// Pressure, in pascals, and value of the largest f; `None` unless it exceeds 1 by more than rounding. At that
    /// pressure the law gives more friction per load than at light loads, which contact area cannot explain.
    pub fn above_one(&self) -> Option<(f64, f64)> {
        let largest =
            self.pressure_pa.iter().copied().zip(self.factor.iter().copied()).max_by(|a, b| a.1.total_cmp(&b.1));
        largest.filter(|&(_, factor)| factor > ROUNDED_FACTOR)
    }

    /// Pressure, in pascals, and factor at the end of the step from f = 1 with which the law begins; `None` if the
    /// first factor given to [`AreaLaw::new`] was 1.
    pub fn step(&self) -> Option<(f64, f64)> {
        match (&self.pressure_pa[..], &self.factor[..]) {
            ([before, first, ..], [one, factor, ..]) if *before == first * (1.0 - STEP_WIDTH) && *one == 1.0 => {
                Some((*first, *factor))
            }
            _ => None,
        }
    }

    /// Tabulated pressures, in pascals, increasing.
    pub fn pressures_pa(&self) -> &[f64] {
        &self.pressure_pa
    }

    /// Tabulated factors, one per pressure.
    pub fn factors(&self) -> &[f64] {
        &self.factor
    }

    /// Standard errors of the tabulated factors, one per pressure; `None` if unknown.
    pub fn factor_std(&self) -> Option<&[f64]> {
        self.factor_std.as_deref()
    }
}

/// Value at `at` of the line through the points (`x[0]`, `y[0]`) and (`x[1]`, `y[1]`).
fn interpolate(x: &[f64], y: &[f64], at: f64) -> f64 {
    let t = (at - x[0]) / (x[1] - x[0]);
    y[0] + t * (y[1] - y[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether the law is refused with a message that contains `words`.
    fn says(law: Result<AreaLaw, MaterialError>, words: &str) -> bool {
        law.is_err_and(|error| error.to_string().contains(words))
    }

    #[test]
    fn factor_follows_the_line_through_the_origin() {
        // Area proportional to pressure up to 1.4 MPa and constant above: f = 1, then falling as 1/p.
        let law = AreaLaw::from_area_curve(&[0.35e6, 1.05e6, 1.4e6, 2.8e6], &[0.1, 0.3, 0.4, 0.4], 0.7e6).unwrap();
        assert_eq!(law.pressures_pa()[0], 0.7e6);
        for (p, f) in [(0.1e6, 1.0), (0.7e6, 1.0), (1.4e6, 1.0), (2.8e6, 0.5), (5.6e6, 0.25), (2.1e6, 0.75)] {
            assert!((law.factor(p) - f).abs() < 1e-12, "{p}");
        }
        assert!(law.is_extrapolated(2.9e6) && !law.is_extrapolated(2.8e6));
    }

    #[test]
    fn the_law_is_continuous_at_every_tabulated_pressure() {
        let law = AreaLaw::new(vec![0.7e6, 1.3e6, 2.6e6, 10e6], vec![1.0, 0.96, 0.9, 0.6]).unwrap();
        for &p in law.pressures_pa() {
            assert!((law.factor(p * (1.0 - 1e-12)) - law.factor(p * (1.0 + 1e-12))).abs() < 1e-9);
        }
    }

    #[test]
    fn a_first_factor_other_than_one_is_a_narrow_step() {
        let law = AreaLaw::new(vec![0.7e6, 2.6e6], vec![0.8, 0.5]).unwrap();
        for (p, f) in [(0.6e6, 1.0), (0.6993e6, 1.0), (0.69965e6, 0.9), (0.7e6, 0.8), (2.6e6, 0.5)] {
            assert!((law.factor(p) - f).abs() < 1e-9, "{p}: {}", law.factor(p));
        }
        assert_eq!(law.step(), Some((0.7e6, 0.8)));
        assert_eq!(AreaLaw::new(vec![0.7e6, 2.6e6], vec![1.0, 0.5]).unwrap().step(), None);
        let nothing = AreaLaw::new(vec![1.0], vec![0.0]).unwrap();
        assert_eq!((nothing.factor(1.0), nothing.factor(1e6)), (0.0, 0.0));
    }

    #[test]
    fn factors_above_one_are_told_with_their_pressure() {
        let law = |factor: [f64; 3]| AreaLaw::new(vec![0.7e6, 1.3e6, 2.6e6], factor.to_vec()).unwrap();
        assert_eq!(law([1.0, 1.001, 0.9]).above_one(), None);
        assert_eq!(law([1.0, 1.2, 1.3]).above_one(), Some((2.6e6, 1.3)));
    }

    #[test]
    fn looking_nearby_finds_the_same_factor() {
        let law = AreaLaw::new(vec![0.7e6, 1.3e6, 2.6e6, 10e6], vec![1.0, 0.96, 0.9, 0.6]).unwrap();
        let mut near = 0;
        for step in 0..2000 {
            let p = 6e6 * (1.0 + (f64::from(step) * 0.37).sin());
            assert_eq!(law.factor_near(p, &mut near), law.factor(p));
        }
    }

    #[test]
    fn pieces_are_the_law_on_their_intervals() {
        let law = AreaLaw::new(vec![0.7e6, 1.3e6, 2.6e6, 10e6], vec![1.0, 0.96, 0.9, 0.6]).unwrap();
        for step in 1..300 {
            let p = 0.05e6 * f64::from(step);
            let piece = law.piece(p);
            assert!(piece.from_pa <= p && p < piece.to_pa);
            let limited_pa = piece.constant_pa + p * (piece.linear + p * piece.quadratic_per_pa);
            assert!((limited_pa / (p * law.factor(p)) - 1.0).abs() < 1e-14, "{p}");
        }
        assert!(law.piece(f64::NAN).linear.is_finite() && law.factor(f64::NAN).is_nan());
    }

    #[test]
    fn standard_errors_follow_the_factors() {
        let law = AreaLaw::new(vec![0.7e6, 2.6e6], vec![1.0, 0.9]).unwrap();
        assert_eq!(law.factor_std(), None);
        let known = law.clone().with_factor_std(vec![0.0, 0.02]).unwrap();
        assert_eq!(known.factor_std(), Some(&[0.0, 0.02][..]));
        assert_eq!(known.factor(1.9e6), law.factor(1.9e6));
        let stepped = AreaLaw::new(vec![0.7e6, 2.6e6], vec![0.8, 0.5]).unwrap();
        let stepped = stepped.with_factor_std(vec![0.01, 0.02]).unwrap();
        assert_eq!(stepped.factor_std(), Some(&[0.0, 0.01, 0.02][..]));
        assert!(says(law.clone().with_factor_std(vec![0.1]), "values"));
        assert!(says(law.with_factor_std(vec![0.1, -0.1]), "expected"));
    }

    #[test]
    fn tables_that_mean_nothing_are_refused() {
        assert!(says(AreaLaw::new(vec![], vec![]), "empty"));
        assert!(says(AreaLaw::new(vec![1e6, 1e6], vec![1.0, 1.0]), "must increase"));
        assert!(says(AreaLaw::new(vec![1e6], vec![1.0, 1.0]), "values"));
        assert!(says(AreaLaw::new(vec![1e6], vec![f64::NAN]), "expected"));
        assert!(AreaLaw::from_area_curve(&[1e6, 2e6], &[0.3, 0.5], 0.7e6).is_err());
        assert!(AreaLaw::from_area_curve(&[0.1e6, 0.2e6], &[0.3, 0.5], 0.7e6).is_err());
    }
}
