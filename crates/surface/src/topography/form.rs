//! Form removal: subtracts the shape of a specimen and its tilt under the instrument.

use serde::Deserialize;
use slipgrid_base::monitor::Monitor;
use slipgrid_base::statistics::cholesky::{covariance_factor, is_regular, solve};

use crate::topography::{HeightMap, MapError};

/// Shape fitted by least squares to the points present, and subtracted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// The mean height.
    Mean,
    /// The least-squares plane.
    #[default]
    Plane,
    /// 1, x, y, x^2, xy, y^2: a tilted, curved or saddle-shaped specimen.
    SecondOrder,
}

slipgrid_base::names!(Form { Mean = "mean", Plane = "plane", SecondOrder = "second-order" });

impl Form {
    /// Number of terms of the form, which are the first ones of [`terms`].
    const fn count(self) -> usize {
        match self {
            Self::Mean => 1,
            Self::Plane => 3,
            Self::SecondOrder => TERMS,
        }
    }
}

/// Number of terms of the largest form.
const TERMS: usize = 6;

/// A fitted form, in coordinates that run from -1 to 1 over the map along x and y.
pub(crate) struct FittedForm {
    /// Factors of the first [`terms`], in metres.
    coefficients: Vec<f64>,
}

/// Legendre polynomials of the coordinates u along x and v along y: nearly orthogonal over a full map, which keeps the
/// equations well conditioned.
fn terms(u: f64, v: f64) -> [f64; TERMS] {
    [1.0, u, v, 0.5 * (3.0 * u * u - 1.0), u * v, 0.5 * (3.0 * v * v - 1.0)]
}

/// Coordinate of row or column `index` out of `count`, from -1 to 1.
fn place(index: usize, count: usize) -> f64 {
    2.0 * index as f64 / (count - 1) as f64 - 1.0
}

impl FittedForm {
    /// Subtracts the form from `heights_m`, those of a map of `rows` x `cols` points; ends once `monitor` cancels.
    fn subtract(&self, heights_m: &mut [f64], [rows, cols]: [usize; 2], monitor: &dyn Monitor) -> Result<(), MapError> {
        for (i, row) in heights_m.chunks_exact_mut(cols).enumerate() {
            monitor.heed()?;
            for (j, height) in row.iter_mut().enumerate() {
                let terms = terms(place(i, rows), place(j, cols));
                *height -= terms.iter().zip(&self.coefficients).map(|(term, factor)| term * factor).sum::<f64>();
            }
        }
        Ok(())
    }

    /// Heights of `map` minus the form, in metres; ends once `monitor` cancels.
    pub(crate) fn above_m(&self, map: &HeightMap, monitor: &dyn Monitor) -> Result<Vec<f64>, MapError> {
        let mut above_m = map.heights_m().to_vec();
        self.subtract(&mut above_m, [map.rows(), map.cols()], monitor)?;
        Ok(above_m)
    }
}

impl HeightMap {
    /// Fits `form` by least squares to the points that are present and for which `wanted` is true.
    ///
    /// # Errors
    /// [`MapError::FormUndetermined`] if these points do not determine the form; [`MapError::Cancelled`] once `monitor`
    /// cancels.
    pub(crate) fn fit_form(
        &self,
        form: Form,
        wanted: impl Fn(usize) -> bool,
        monitor: &dyn Monitor,
    ) -> Result<FittedForm, MapError> {
        let count = form.count();
        // Normal equations A c = b with A = sum of terms terms^T and b = sum of terms h; h relative to the first wanted
        // height.
        let (mut a, mut b, mut points) = (vec![0.0; count * count], vec![0.0; count], 0_usize);
        let is_wanted = |n: usize| !self.heights_m()[n].is_nan() && wanted(n);
        let origin = (0..self.heights_m().len()).find(|n| is_wanted(*n)).map_or(0.0, |n| self.heights_m()[n]);
        for (row, heights) in self.heights_m().chunks_exact(self.cols()).enumerate() {
            monitor.heed()?;
            let first = row * self.cols();
            for (col, height) in heights.iter().enumerate().filter(|(col, _)| is_wanted(first + col)) {
                let terms = terms(place(row, self.rows()), place(col, self.cols()));
                for i in 0..count {
                    for j in 0..=i {
                        a[i * count + j] += terms[i] * terms[j];
                    }
                    b[i] += terms[i] * (height - origin);
                }
                points += 1;
            }
        }
        let factor = covariance_factor(&a, count);
        if points < count || !is_regular(&factor, count) {
            return Err(MapError::FormUndetermined { form: form.name(), points });
        }
        solve(&factor, count, &mut b);
        b[0] += origin;
        Ok(FittedForm { coefficients: b })
    }

    /// Subtracts `form`.
    ///
    /// # Errors
    /// [`MapError::FormUndetermined`] if the points present do not determine the form; the map is then unchanged.
    /// [`MapError::Cancelled`] once `monitor` cancels.
    pub fn remove_form(&mut self, form: Form, monitor: &dyn Monitor) -> Result<(), MapError> {
        let fitted = self.fit_form(form, |_| true, monitor)?;
        let sides = [self.rows(), self.cols()];
        fitted.subtract(self.heights_mut(), sides, monitor)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use slipgrid_base::monitor::Unwatched;

    /// c0 + c1 x + c2 y + c3 x^2 + c4 x y + c5 y^2 in micrometres, x and y in pixels.
    fn map(c: [f64; 6], holes: &[usize]) -> HeightMap {
        let height = |n: usize| {
            let (x, y) = ((n / 13) as f64, (n % 13) as f64);
            let h = c[0] + c[1] * x + c[2] * y + c[3] * x * x + c[4] * x * y + c[5] * y * y;
            if holes.contains(&n) { f64::NAN } else { 1e-6 * h }
        };
        HeightMap::new(11, 13, 1e-6, 2e-6, (0..143).map(height).collect()).unwrap()
    }

    fn largest(map: &HeightMap) -> f64 {
        map.heights_m().iter().filter(|height| !height.is_nan()).fold(0.0, |most, height| height.abs().max(most))
    }

    proptest! {
        #[test]
        fn every_form_removes_itself_whole(
            c in proptest::array::uniform6(-5.0..5.0),
            holes in proptest::collection::vec(0..143_usize, 0..40),
        ) {
            for (form, kept) in [(Form::Mean, 1), (Form::Plane, 3), (Form::SecondOrder, 6)] {
                let mut only = [0.0; 6];
                only[..kept].copy_from_slice(&c[..kept]);
                let mut map = map(only, &holes);
                map.remove_form(form, &Unwatched).unwrap();
                prop_assert!(largest(&map) < 1e-17, "{form:?}: {}", largest(&map));
            }
        }
    }

    #[test]
    fn what_is_left_is_orthogonal_to_every_term() {
        for (form, count) in [(Form::Mean, 1), (Form::Plane, 3), (Form::SecondOrder, 6)] {
            let mut map = map([3.0, 0.2, -0.3, 0.05, 0.01, -0.02], &[0, 1, 8, 34, 50]);
            // A form that no term describes.
            map.heights_mut().iter_mut().enumerate().for_each(|(n, height)| *height += 1e-6 * (n as f64).sin());
            map.remove_form(form, &Unwatched).unwrap();
            assert!(map.missing() == 5 && largest(&map) > 1e-7);
            for term in 0..count {
                let of = |(n, height): (usize, &f64)| height * terms(place(n / 13, 11), place(n % 13, 13))[term];
                let known = map.heights_m().iter().enumerate().filter(|(_, height)| !height.is_nan());
                assert!(known.map(of).sum::<f64>().abs() < 1e-18, "{form:?}: {term}");
            }
        }
    }

    #[test]
    fn points_that_determine_no_form_are_refused() {
        let mut heights = vec![f64::NAN; 143];
        for n in [0, 5, 9] {
            heights[n] = 1e-6;
        }
        let mut line = HeightMap::new(11, 13, 1e-6, 1e-6, heights).unwrap();
        assert!(matches!(
            line.remove_form(Form::Plane, &Unwatched),
            Err(MapError::FormUndetermined { form: "plane", points: 3 })
        ));
        assert!(line.remove_form(Form::SecondOrder, &Unwatched).is_err());
        assert!(line.remove_form(Form::Mean, &Unwatched).is_ok());
        let diagonal = |n: usize| if n / 4 == n % 4 { n as f64 * 1e-6 } else { f64::NAN };
        let mut map = HeightMap::new(4, 4, 1e-6, 1e-6, (0..16).map(diagonal).collect()).unwrap();
        let before = map.clone();
        assert!(map.remove_form(Form::Plane, &Unwatched).is_err());
        assert!(map.heights_m().iter().zip(before.heights_m()).all(|(a, b)| a == b || a.is_nan() && b.is_nan()));
    }
}
