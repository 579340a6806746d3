//! Removed volume as closed solids: binary STL, millimetres, the face at z = 0.
//!
//! Format of 3D Systems: 80 bytes of text, the number of triangles, and for each triangle its normal and corners as
//! single-precision numbers, anticlockwise seen from outside. Each cavity (or part of a cut cavity) is one shell of
//! lid, floor and walls. Round cavities are polygons with [`CHORDS`] corners.

use std::io::{self, Write};

use crate::export::{Boundary, Cavity, ExportError, Heading, Laser, Layout};

/// Number of corners of a round cavity: its area is 0.16 % too small.
pub const CHORDS: u32 = 64;

/// Writes the solids of the cavities of `layout`, with the wall taper of `laser`.
///
/// # Errors
/// Errors of the writer `to`; [`check`] finds layouts that cannot be written.
pub fn stl(layout: &Layout, laser: &Laser, heading: &Heading, to: &mut dyn Write) -> io::Result<()> {
    let inset_m = laser.floor_inset_m(layout.pattern().depth_m());
    let depth_m = layout.pattern().depth_m();
    // 2 (n - 2) of lid and floor, 2 n of walls.
    let triangles: u64 =
        layout.iter().flat_map(|cavity| solids(&cavity, inset_m)).map(|(face, _)| 4 * (face.len() as u64) - 4).sum();
    let count = u32::try_from(triangles).map_err(|_| io::Error::other("more triangles than STL can count"))?;
    let mut to = io::BufWriter::new(to);
    let text = format!("slipgrid {}: removed volume, mm", heading.version);
    to.write_all(&text.bytes().chain(std::iter::repeat(b' ')).take(80).collect::<Vec<u8>>())?;
    to.write_all(&count.to_le_bytes())?;
    for cavity in layout.iter() {
        for (face, floor) in solids(&cavity, inset_m) {
            let at = |[x_m, y_m]: [f64; 2], z_m: f64| [x_m, y_m, z_m];
            for [a, b, c] in triangulate(&face) {
                triangle(&mut to, [at(face[a], 0.0), at(face[b], 0.0), at(face[c], 0.0)])?;
                triangle(&mut to, [at(floor[a], -depth_m), at(floor[c], -depth_m), at(floor[b], -depth_m)])?;
            }
            for i in 0..face.len() {
                let j = (i + 1) % face.len();
                let (below_i, below_j) = (at(floor[i], -depth_m), at(floor[j], -depth_m));
                triangle(&mut to, [at(face[i], 0.0), below_i, below_j])?;
                triangle(&mut to, [at(face[i], 0.0), below_j, at(face[j], 0.0)])?;
            }
        }
    }
    to.flush()
}

/// Checks that STL can hold `layout`: the border cuts no sloping walls, and walls reach the floor before they meet.
///
/// # Errors
/// [`ExportError::Refused`] if the border cuts sloping walls, and for polygons and crossing grooves with a wall that
/// ends above the floor; errors of [`Laser::check`].
pub fn check(layout: &Layout, laser: &Laser) -> Result<(), ExportError> {
    laser.check(layout.pattern())?;
    let inset_m = laser.floor_inset_m(layout.pattern().depth_m());
    if inset_m > 0.0 && layout.iter().any(|cavity| cavity.cut_by.is_some()) {
        let refused = "STL holds no leaning walls that the rim cuts: expected whole cavities, or wall_taper_deg = 0";
        return Err(ExportError::Refused(refused.to_owned()));
    }
    // Each part of a cavity has a floor with as many corners as its lid.
    let corners = |cavity: &Cavity| faces(cavity).iter().map(Vec::len).collect::<Vec<_>>();
    let has_floor = |cavity: Cavity| cavity.inset(inset_m).is_some_and(|floor| corners(&cavity) == corners(&floor));
    let is_plain = layout.iter().all(|cavity| cavity.face.is_none() && cavity.crossed_by.is_none());
    if inset_m == 0.0 || is_plain || layout.iter().all(has_floor) {
        return Ok(());
    }
    let refused = "STL holds no cavity of which a leaning wall ends above the floor: expected longer edges of the outline, or a smaller wall_taper_deg";
    Err(ExportError::Refused(refused.to_owned()))
}

/// Corners of a polygon, anticlockwise, in metres.
type Polygon = Vec<[f64; 2]>;

/// Outlines of the parts of a cavity as polygons.
fn faces(cavity: &Cavity) -> Vec<Polygon> {
    let of = |boundary: &Boundary| match boundary {
        Boundary::Circle { centre_m: [x_m, y_m], radius_m } => {
            let corner = |k: u32| {
                let angle = std::f64::consts::TAU * f64::from(k) / f64::from(CHORDS);
                [x_m + radius_m * libm::cos(angle), y_m + radius_m * libm::sin(angle)]
            };
            (0..CHORDS).map(corner).collect()
        }
        Boundary::Polygon { corners_m } => corners_m.clone(),
    };
    cavity.boundaries().iter().map(of).collect()
}

/// Lid and floor of each part of a cavity, with corresponding corners. `inset_m` is the distance of the floor's edge
/// from the cavity's edge.
fn solids(cavity: &Cavity, inset_m: f64) -> Vec<(Polygon, Polygon)> {
    let lids = faces(cavity);
    let floors = match cavity.inset(inset_m) {
        Some(floor) if inset_m > 0.0 && cavity.cut_by.is_none() => faces(&floor),
        _ => lids.clone(),
    };
    lids.into_iter().zip(floors).collect()
}

/// Triangulates a polygon by ear clipping (Meisters, Am. Math. Monthly 82, 648). Returns the indices of the corners of
/// each triangle, anticlockwise.
fn triangulate(polygon: &[[f64; 2]]) -> Vec<[usize; 3]> {
    let cross = |a: usize, b: usize, c: usize| {
        let ([xa, ya], [xb, yb], [xc, yc]) = (polygon[a], polygon[b], polygon[c]);
        (xb - xa) * (yc - ya) - (xc - xa) * (yb - ya)
    };
    let mut left: Vec<usize> = (0..polygon.len()).collect();
    let mut triangles = Vec::with_capacity(polygon.len().saturating_sub(2));
    let mut start = 0;
    while left.len() > 3 {
        let count = left.len();
        let corner = |k: usize| [left[(k + count - 1) % count], left[k % count], left[(k + 1) % count]];
        let is_ear = |[a, b, c]: [usize; 3]| {
            let holds = |p: usize| cross(a, b, p) >= 0.0 && cross(b, c, p) >= 0.0 && cross(c, a, p) >= 0.0;
            cross(a, b, c) > 0.0 && !left.iter().any(|&p| p != a && p != b && p != c && holds(p))
        };
        // Rounding may leave no ear among collinear corners; then any corner is valid.
        let ear = (start..start + count).find(|&k| is_ear(corner(k))).unwrap_or(start);
        triangles.push(corner(ear));
        left.remove(ear % count);
        start = ear % count;
    }
    if let [a, b, c] = left[..] {
        triangles.push([a, b, c]);
    }
    triangles
}

fn triangle(to: &mut dyn Write, corners_m: [[f64; 3]; 3]) -> io::Result<()> {
    let [a, b, c] = corners_m;
    let (u, v) = ([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]);
    let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let size = normal[0].hypot(normal[1]).hypot(normal[2]);
    let unit = |value: f64| if size > 0.0 { value / size } else { 0.0 };
    for value in normal.map(unit).into_iter().chain(corners_m.into_iter().flatten().map(|at_m| at_m * 1e3)) {
        to.write_all(&(value as f32).to_le_bytes())?;
    }
    to.write_all(&[0, 0])
}
