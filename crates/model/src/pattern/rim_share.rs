//! Mean height of the rims on a part of the face.

use crate::pattern::{Pattern, Planform, RimProfile};

/// Nodes and weights on [0, 1] of the 8-point Gauss-Legendre rule, first half; the other nodes are 1 - node, with equal
/// weights.
const GAUSS_LEGENDRE: [[f64; 2]; 4] = [
    [0.019_855_071_751_231_9, 0.050_614_268_145_188_1],
    [0.101_666_761_293_186_6, 0.111_190_517_226_687_2],
    [0.237_233_795_041_835_5, 0.156_853_322_938_943_6],
    [0.408_282_678_752_175_1, 0.181_341_891_689_181],
];

impl Pattern {
    /// Maximum height of the rims of the cavities above the land, in metres; 0 without rims.
    pub fn rim_height_m(&self) -> f64 {
        self.texture().rim().map_or(0.0, |rim| rim.height_m(self.depth_m()))
    }

    /// Mean relative height, from 0 to 1, of the rims on the land within the rectangle `[x0_m, x1_m] x [y0_m, y1_m]`,
    /// given as for [`Self::coverage`]; 0 without land. Continuous in the sides of the rectangle and in every dimension
    /// of the pattern.
    ///
    /// A rim is the region of all points within its width of the cavity, by Euclidean distance. It is as wide around a
    /// corner as along an edge, so that the corners of a square's rim are quarter discs.
    pub fn rim_share(&self, x0_m: f64, x1_m: f64, y0_m: f64, y1_m: f64) -> f64 {
        let Some(rim) = self.texture().rim() else { return 0.0 };
        let cavity = self.coverage(x0_m, x1_m, y0_m, y1_m);
        let land = 1.0 - cavity;
        // Limited to half of the narrowest land, where the next rim begins.
        let widest_m = rim.width_m().min(0.5 * self.least_land_m());
        let beyond = |distance_m: f64| self.coverage_within(distance_m, [x0_m, x1_m], [y0_m, y1_m]) - cavity;
        let whole = beyond(widest_m);
        if land <= 0.0 || whole <= 0.0 {
            return 0.0;
        }
        // integral of phi over the land = phi(end) A(end) + integral of -phi'(s) A(s) ds, A(s) the area within s w
        let end = widest_m / rim.width_m();
        let mut mean = rim.profile().height(end * (1.0 - f64::EPSILON)) * whole;
        if rim.profile() != RimProfile::Flat {
            let mut ends_m = self.kinks_m([x0_m, x1_m], [y0_m, y1_m]);
            ends_m.retain(|distance_m| (0.0..widest_m).contains(distance_m));
            ends_m.extend([0.0, widest_m]);
            ends_m.sort_by(f64::total_cmp);
            for piece in ends_m.windows(2).filter(|piece| piece[1] > piece[0]) {
                let length_m = piece[1] - piece[0];
                for (node, weight) in
                    GAUSS_LEGENDRE.iter().flat_map(|[node, weight]| [(*node, weight), (1.0 - node, weight)])
                {
                    let distance_m = piece[0] + length_m * node;
                    let s = distance_m / rim.width_m();
                    mean += length_m / rim.width_m() * weight * rim.profile().fall(s) * beyond(distance_m);
                }
            }
        }
        (mean / land).clamp(0.0, 1.0)
    }

    /// Distances d, in metres, at which the area within d of a cavity, inside the rectangle `x_m` by `y_m`, is not a
    /// smooth function of d: the offset outlines pass sides or corners of the rectangle there.
    fn kinks_m(&self, x_m: [f64; 2], y_m: [f64; 2]) -> Vec<f64> {
        let (cell_m, half_m) = (self.cell_m(), [Some(self.width_m()), self.length_m()].map(|m| m.map(|m| 0.5 * m)));
        let mut kinks_m = Vec::new();
        for centre_m in self.centres_m() {
            // Distances of the sides from the nearest centres before and after.
            let seen = |ends_m: [f64; 2], axis: usize| {
                ends_m
                    .map(|at_m| (at_m - centre_m[axis]).rem_euclid(cell_m[axis]))
                    .map(|m| [m, cell_m[axis] - m])
                    .concat()
            };
            let [x, y] = [seen(x_m, 0), seen(y_m, 1)];
            for (distances_m, half_m) in [(&x, half_m[0]), (&y, half_m[1])] {
                if let Some(half_m) = half_m {
                    kinks_m.extend(distances_m.iter().map(|distance_m| distance_m - half_m));
                }
            }
            // Arcs about the centre of a disc, or about the corners of a square or rectangle.
            let arcs = match (self.planform(), half_m) {
                (Planform::Disc, [Some(radius_m), _]) => Some(([0.0; 2], radius_m)),
                (Planform::Square | Planform::Rectangle, [Some(x_m), Some(y_m)]) => Some(([x_m, y_m], 0.0)),
                _ => None,
            };
            if let Some((about_m, radius_m)) = arcs {
                let corners = x.iter().flat_map(|x| y.iter().map(move |y| (x - about_m[0]).hypot(y - about_m[1])));
                kinks_m.extend(corners.map(|distance_m| distance_m - radius_m));
            }
        }
        kinks_m
    }
}
