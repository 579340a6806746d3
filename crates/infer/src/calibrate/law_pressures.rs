//! Pressures at which an area law is tabulated, and the reference pressure P0 at which its factor f is 1.

use slipgrid_base::units::{PRESSURE_MPA, significant};

use crate::calibrate::area_law::DEFAULT_PRESSURES_MPA;

/// P / (E* h'rms), pressure over contact modulus and rms slope, that counts as a small load. In Persson's theory the
/// contact area is 1.6 % there, and A / P is 7e-5 below its limit for P = 0.
const SMALL_LOAD: f64 = 0.01;
/// Minimum number of contact points of a map at the reference pressure; the number then scatters by 5 %.
const MIN_CONTACT_POINTS: f64 = 400.0;
/// Maximum of the reference pressure over E* h'rms for maps with few points; the contact area is 16 % there.
const MAX_SMALL_LOAD: f64 = 0.1;
/// Contact area fraction over P / (E* h'rms) at small loads in Persson's theory, sqrt(8 / pi).
const AREA_PER_LOAD: f64 = 1.596;

/// Pressures of a law without a stated threshold, relative to the reference pressure of a large map: from 1.6 % contact
/// to full contact. On maps of eight kinds f between 14 of them was as near to contact as f linear between 32 pressures.
const PRESSURE_RATIOS: [f64; 20] = [
    1.0, 2.0, 4.0, 8.0, 14.0, 22.0, 28.0, 33.0, 40.0, 50.0, 60.0, 72.0, 86.0, 100.0, 125.0, 150.0, 200.0, 300.0, 460.0,
    1000.0,
];

/// Pressures at which the contact area of a surface is computed for its area law.
#[derive(Clone, Debug, PartialEq)]
pub struct LawPressures {
    /// P0, in pascals: the area factor f is A / P, contact area over pressure, relative to its value at P0, and 1
    /// below.
    pub threshold_pa: f64,
    /// Nominal pressures, increasing and including P0, in pascals.
    pub pressures_pa: Vec<f64>,
}

impl LawPressures {
    /// Selects the pressures for a surface with this contact modulus E* and rms slope; `points` is the number of points
    /// of its map.
    ///
    /// A stated threshold is inserted into [`DEFAULT_PRESSURES_MPA`]. Otherwise P0 is [`light_pressure_pa`].
    pub fn new(stated_pa: Option<f64>, contact_modulus_pa: f64, rms_slope: f64, points: Option<usize>) -> Self {
        let threshold_pa = stated_pa.unwrap_or_else(|| light_pressure_pa(contact_modulus_pa, rms_slope, points));
        let mut pressures_pa: Vec<f64> = if stated_pa.is_some() {
            DEFAULT_PRESSURES_MPA.map(|pressure_mpa| PRESSURE_MPA.to_si(pressure_mpa)).to_vec()
        } else {
            let light_pa = SMALL_LOAD * contact_modulus_pa * rms_slope;
            let pressures_pa = PRESSURE_RATIOS.map(|ratio| significant(ratio * light_pa, 3));
            pressures_pa.into_iter().filter(|pressure_pa| *pressure_pa > 1.1 * threshold_pa).collect()
        };
        let place = pressures_pa.partition_point(|&pressure_pa| pressure_pa < threshold_pa);
        if pressures_pa.get(place) != Some(&threshold_pa) {
            pressures_pa.insert(place, threshold_pa);
        }
        Self { threshold_pa, pressures_pa }
    }
}

/// Pressure in pascals, to three digits, at which A / P (contact area over pressure) represents its limit for small
/// loads: P / (E* h'rms) = 0.01, or up to 0.1 if fewer than 400 points of the map would be in contact.
pub fn light_pressure_pa(contact_modulus_pa: f64, rms_slope: f64, points: Option<usize>) -> f64 {
    let enough = points.map_or(0.0, |points| MIN_CONTACT_POINTS / (AREA_PER_LOAD * points as f64));
    significant(enough.clamp(SMALL_LOAD, MAX_SMALL_LOAD) * contact_modulus_pa * rms_slope, 3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::area_law::{area_law, persson_curve};
    use slipgrid_surface::contact::closed_form::persson_area_fraction;

    /// f in Persson's theory at x = P / (E* h'rms): A over its limit for small loads, sqrt(8 / pi) x.
    fn factor(x: f64) -> f64 {
        persson_area_fraction(x, 1.0, 1.0).unwrap() / ((8.0 / std::f64::consts::PI).sqrt() * x)
    }

    #[test]
    fn without_a_threshold_the_law_is_the_limit_at_small_loads_for_soft_and_hard_solids() {
        for (contact_modulus_pa, rms_slope) in [(5e6, 0.2), (54e6, 0.0358), (427.5e6, 0.0137), (236e9, 0.1)] {
            let of = LawPressures::new(None, contact_modulus_pa, rms_slope, None);
            let curve = persson_curve(rms_slope, contact_modulus_pa, &of.pressures_pa).unwrap();
            let law = area_law(&curve, of.threshold_pa).unwrap();
            for step in 0..400 {
                let x = 1e-3 * 1.025_f64.powi(step);
                let found = law.factor(x * contact_modulus_pa * rms_slope);
                assert!((found - factor(x)).abs() < 3e-4, "{contact_modulus_pa} {x}: {found} {}", factor(x));
            }
        }
    }

    #[test]
    fn a_stated_threshold_is_one_of_the_usual_pressures() {
        let stated = |threshold_pa: f64| LawPressures::new(Some(threshold_pa), 427.5e6, 0.0137, Some(1 << 18));
        assert_eq!(stated(0.7e6).pressures_pa.len(), DEFAULT_PRESSURES_MPA.len());
        let beside = stated(0.72e6).pressures_pa;
        assert_eq!(beside.len(), DEFAULT_PRESSURES_MPA.len() + 1);
        assert!(beside.contains(&0.72e6) && beside.is_sorted());
    }

    #[test]
    fn small_maps_take_a_larger_reference_pressure() {
        let over_scale = |points: usize| light_pressure_pa(1e8, 0.1, Some(points)) / 1e7;
        assert_eq!(over_scale(512 * 512), 0.01);
        assert!((over_scale(64 * 64) - 0.0612).abs() < 1e-9);
        assert_eq!(over_scale(12 * 12), 0.1);
        let of = LawPressures::new(None, 1e8, 0.1, Some(64 * 64));
        assert!(of.pressures_pa.is_sorted() && of.pressures_pa[0] == of.threshold_pa);
    }
}
