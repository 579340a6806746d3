//! Displacements, forces and unbalanced forces due to the unknowns of an interface.

use super::*;

impl Interface {
    /// Allocates work space and results for [`Self::respond`].
    pub fn response(&self) -> Response {
        let [nx, ny] = self.columns;
        Response {
            fields: vec![0.0; 3 * self.explicit * nx * ny],
            linear: vec![0.0; self.elastic_unknowns()],
            normal: vec![0.0; self.contacts()],
            pressed: vec![0.0; nx * ny],
            workspace: self.layer.workspace((0..3 * self.explicit).map(|field| self.lines(field)).collect()),
        }
    }

    /// Range of lines, indices along y, in which field number `field` (three fields x, y, z per row) carries forces or
    /// is needed.
    fn lines(&self, field: usize) -> Range<usize> {
        let ny = self.columns[1];
        // Row 0 carries friction; other rows carry forces on the needed lines only.
        if field < 3 {
            return 0..ny;
        }
        let wanted = &self.wanted[field * ny..][..ny];
        let first = wanted.iter().position(|wanted| *wanted).unwrap_or(0);
        first..wanted.iter().rposition(|wanted| *wanted).map_or(first, |last| last + 1)
    }

    /// Computes the linear response to `unknowns`, with friction along the unit vector `direction`; displacements only
    /// on the needed lines.
    pub fn respond(&self, unknowns: &[f64], direction: [f64; 2], response: &mut Response) {
        self.load_fields(unknowns, direction, 0.0, &mut response.fields);
        self.layer.respond(&mut response.fields, &self.wanted, &mut response.workspace);
        self.observe(Face::default(), response);
    }

    /// Computes the full response: to `unknowns`, to the face heights scaled by `face`, and to the load, which
    /// compresses the layer uniformly.
    pub fn respond_loaded(&self, unknowns: &[f64], direction: [f64; 2], face: Face, response: &mut Response) {
        let plane = self.columns[0] * self.columns[1];
        self.load_fields(unknowns, direction, face.raise, &mut response.fields);
        self.layer.respond(&mut response.fields, &self.wanted, &mut response.workspace);
        // u_z = -k P l^2 / (3 k) on row k; all columns carry the load of the face columns.
        let compression = self.compression * self.face_columns as f64 / plane as f64;
        for (field, values) in response.fields.chunks_exact_mut(plane).enumerate().skip(2).step_by(3) {
            let sinks = (field / 3) as f64 * compression;
            let lines = self.lines(field);
            values[lines.start * self.columns[0]..lines.end * self.columns[0]].iter_mut().for_each(|z| *z -= sinks);
        }
        self.observe(face, response);
    }

    /// Sets `fields` to the input of the flat layer: forces, and the vertical displacements of row 0.
    fn load_fields(&self, unknowns: &[f64], direction: [f64; 2], raise: f64, fields: &mut [f64]) {
        let [nx, ny] = self.columns;
        let plane = nx * ny;
        // Other lines remain zero.
        for (field, values) in fields.chunks_exact_mut(plane).enumerate() {
            let lines = self.lines(field);
            values[lines.start * nx..lines.end * nx].fill(0.0);
        }
        let (forces, rest) = unknowns.split_at(3 * self.support.len());
        let (heights, friction) = rest.split_at(self.free.len());
        for (place, force) in self.support.iter().zip(forces.chunks_exact(3)) {
            for (component, force) in force.iter().enumerate() {
                // Row 0 is held vertically: the unknown there is a displacement, not a force.
                if component < 2 || *place >= plane {
                    fields[place + component * plane] = *force;
                }
            }
        }
        let column = |surface: &Surface| surface.column[1] * nx + surface.column[0];
        if raise != 0.0 {
            self.surface.iter().for_each(|surface| fields[2 * plane + column(surface)] = raise * surface.relief);
        }
        for (own, height) in self.free.iter().zip(heights) {
            fields[2 * plane + column(&self.surface[*own])] = *height;
        }
        for (axis, along) in direction.into_iter().enumerate().filter(|(_, along)| *along != 0.0) {
            for (place, friction) in self.touching.iter().zip(friction) {
                fields[axis * plane + place] += along * friction;
            }
        }
    }

    /// Computes the forces R u of the missing springs, normal forces and unbalanced forces from the displacements in
    /// `response`.
    fn observe(&self, face: Face, response: &mut Response) {
        let plane = self.columns[0] * self.columns[1];
        let Response { fields, linear, normal, pressed, .. } = response;
        let (forces, imbalances) = linear.split_at_mut(3 * self.support.len());
        forces.fill(0.0);
        for link in &self.weakened {
            let [a, b] = link.places;
            // R = sum (1 - share) k e e^T
            let along: f64 = (0..3).map(|c| link.direction[c] * (fields[a + c * plane] - fields[b + c * plane])).sum();
            let force = link.stiffness * along;
            for (end, force) in [(link.ends[0], force), (link.ends[1], -force)] {
                if end != ABSENT {
                    (0..3).for_each(|c| forces[3 * end + c] += force * link.direction[c]);
                }
            }
        }
        self.press(fields, pressed);
        for (place, force) in self.support.iter().zip(forces.chunks_exact_mut(3)) {
            if *place < plane {
                pressed[*place] -= std::mem::take(&mut force[2]);
            }
        }
        normal.iter_mut().zip(&self.touching).for_each(|(normal, place)| *normal = pressed[*place]);
        for (own, imbalance) in self.free.iter().zip(imbalances) {
            let surface = &self.surface[*own];
            let place = surface.column[1] * self.columns[0] + surface.column[0];
            let yield_force = if surface.yields { face.limit * surface.contact_share } else { 0.0 };
            let above = fields[2 * plane + place] - face.raise * surface.relief;
            *imbalance = (pressed[place] - yield_force + surface.own_tie() * above) / surface.pivot;
            if let Some(number) = surface.contact.filter(|_| surface.lifted) {
                normal[number] = 0.0;
            }
        }
    }

    /// Computes `pressed`, the downward force of the flat layer above on the block of row 0 in each column.
    fn press(&self, fields: &[f64], pressed: &mut [f64]) {
        let [nx, ny] = self.columns;
        let plane = nx * ny;
        let Stencil { rise, vertical: [z, xz, yz], aslant: [x, y] } = self.stencil;
        let line = |field: usize, j: usize| &fields[field * plane + j * nx..][..nx];
        for (j, pressed) in pressed.chunks_exact_mut(nx).enumerate() {
            let (before, after) = (line_before(j, ny), line_after(j, ny));
            let (height, above) = (line(2, j), line(5, j));
            let across = [line(4, before), line(4, after), line(5, before), line(5, after)];
            let along = line(3, j);
            let mut at = |i: usize, left: usize, right: usize| {
                // sum k e_z e.(u_a - u_b): e_x and e_y of opposite springs have opposite signs, and u_a cancels.
                pressed[i] = rise * height[i]
                    - z * above[i]
                    - xz * (above[left] + above[right])
                    - yz * (across[2][i] + across[3][i])
                    - x * (along[right] - along[left])
                    - y * (across[1][i] - across[0][i]);
            };
            for i in 1..nx.max(2) - 1 {
                at(i, i - 1, i + 1);
            }
            at(0, line_before(0, nx), line_after(0, nx));
            at(nx - 1, line_before(nx - 1, nx), line_after(nx - 1, nx));
        }
    }
}

/// Index of the line before `line` among `count` periodic lines.
const fn line_before(line: usize, count: usize) -> usize {
    if line == 0 { count - 1 } else { line - 1 }
}

/// Index of the line after `line` among `count` periodic lines.
const fn line_after(line: usize, count: usize) -> usize {
    if line + 1 == count { 0 } else { line + 1 }
}
