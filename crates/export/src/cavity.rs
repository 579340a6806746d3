use slipgrid_pattern::Planform;

/// One cavity seen from above, on the specimen's axes x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cavity {
    /// Position of its centre along x, from the specimen's centre, in metres.
    pub centre_x_m: f64,
    /// Position of its centre along y, in metres.
    pub centre_y_m: f64,
    /// Extent along x, or along the pattern's own x axis where that is turned; of a disc its
    /// diameter. In metres.
    pub width_m: f64,
    /// Extent at right angles to the width, in metres; of squares and discs the width.
    pub length_m: f64,
    /// Unit vector of the width's direction: the pattern's own x axis.
    pub orientation: [f64; 2],
    /// Disc or rectangle: a groove laid on a specimen is a rectangle.
    pub planform: Planform,
}

/// The outline of a cavity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Boundary {
    /// A circle.
    Circle {
        /// Centre as `[x, y]`, in metres.
        centre_m: [f64; 2],
        /// Radius, in metres.
        radius_m: f64,
    },
    /// A rectangle: its corners as `[x, y]`, anticlockwise from the least along both own axes, in metres.
    Rectangle {
        /// The corners.
        corners_m: [[f64; 2]; 4],
    },
}

impl Cavity {
    /// Its outline.
    #[must_use]
    pub fn boundary(&self) -> Boundary {
        match self.planform {
            Planform::Disc => {
                Boundary::Circle { centre_m: [self.centre_x_m, self.centre_y_m], radius_m: self.width_m / 2.0 }
            }
            _ => Boundary::Rectangle { corners_m: self.corners_m() },
        }
    }

    /// Corners of the rectangle that it is, or of the square around a disc, as `[x, y]`, anticlockwise
    /// from the least along both own axes, in metres.
    #[must_use]
    pub fn corners_m(&self) -> [[f64; 2]; 4] {
        let (half_width_m, half_length_m) = (self.width_m / 2.0, self.length_m / 2.0);
        let [cosine, sine] = self.orientation;
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[along, across]| {
            let (along_m, across_m) = (along * half_width_m, across * half_length_m);
            [
                self.centre_x_m + (along_m * cosine - across_m * sine),
                self.centre_y_m + (along_m * sine + across_m * cosine),
            ]
        })
    }

    /// Area, in square metres.
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        match self.planform {
            Planform::Disc => std::f64::consts::FRAC_PI_4 * self.width_m * self.width_m,
            _ => self.width_m * self.length_m,
        }
    }

    /// Whether its sides lie along x and y.
    #[must_use]
    pub fn is_aligned(&self) -> bool {
        self.orientation == [1.0, 0.0]
    }
}
