//! Balance of work: the work of the drive equals the losses by friction and damping plus the changes of the energy of
//! springs and load and of kinetic energy.
//!
//! With displacements u_n, velocities v between them, and forces at them, sums by the trapezoid rule and the kinetic
//! energy v_- . M v_+ / 2 balance to rounding, for linear springs, any step, and through every transition between rest
//! and slip, if the reported friction is the one that the step used.

use std::array::from_fn;

/// State of a lattice at one instant, in D dimensions.
pub struct Instant<const D: usize> {
    /// Displacements by block.
    pub u: Vec<[f64; D]>,
    /// Displacement of the bulk.
    pub bulk: [f64; D],
    /// Energy of springs and load.
    pub potential: f64,
    /// Force of the drive on the bulk.
    pub drive: [f64; D],
    /// Contact blocks with the friction on them.
    pub friction: Vec<(usize, [f64; D])>,
}

/// An instant with the velocities before and after it.
struct Entry<const D: usize> {
    now: Instant<D>,
    /// Mean of the velocities before and after; zero at the first instant.
    mean_velocity: Vec<[f64; D]>,
    /// Velocity from this instant to the next.
    later: Vec<[f64; D]>,
}

#[derive(Clone, Copy, Default)]
struct Sums {
    drive_work: f64,
    losses: f64,
    energy: f64,
}

/// Balance of work since the second instant; before it the kinetic energy is unknown.
pub struct Account<'a, const D: usize> {
    mass: &'a [f64],
    damping: f64,
    time_step: f64,
    sums: Sums,
    opening: Option<Sums>,
    last: Option<Entry<D>>,
}

impl<'a, const D: usize> Account<'a, D> {
    /// Creates an empty account for blocks of masses `mass`.
    pub const fn new(mass: &'a [f64], damping: f64, time_step: f64) -> Self {
        let sums = Sums { drive_work: 0.0, losses: 0.0, energy: 0.0 };
        Self { mass, damping, time_step, sums, opening: None, last: None }
    }

    /// Adds an instant, with the displacements of the blocks one step later.
    pub fn add(&mut self, now: Instant<D>, next: &[[f64; D]]) {
        let Self { mass, damping, time_step, sums, .. } = self;
        let later: Vec<[f64; D]> =
            next.iter().zip(&now.u).map(|(b, a)| from_fn(|c| (b[c] - a[c]) / *time_step)).collect();
        let mut mean_velocity = vec![[0.0; D]; mass.len()];
        if let Some(Entry { now: earlier, mean_velocity: earlier_velocity, later: velocity }) = self.last.take() {
            for c in 0..D {
                sums.drive_work += 0.5 * (earlier.drive[c] + now.drive[c]) * (now.bulk[c] - earlier.bulk[c]);
                for ((n, before), (_, after)) in earlier.friction.iter().zip(&now.friction) {
                    sums.losses += 0.5 * (before[c] + after[c]) * (now.u[*n][c] - earlier.u[*n][c]);
                }
            }
            sums.energy = now.potential;
            for (n, mass) in mass.iter().enumerate() {
                for c in 0..D {
                    let (v, w) = (velocity[n][c], later[n][c]);
                    sums.energy += 0.5 * mass * v * w;
                    // gamma m times the mean velocity at either end, over the displacement between.
                    mean_velocity[n][c] = 0.5 * (v + w);
                    let mean = 0.5 * (earlier_velocity[n][c] + mean_velocity[n][c]);
                    sums.losses += *damping * mass * mean * v * *time_step;
                }
            }
            self.opening.get_or_insert(*sums);
        }
        self.last = Some(Entry { now, mean_velocity, later });
    }

    /// Error of the balance over the work of the drive.
    pub fn relative_error(&self) -> f64 {
        let opening = self.opening.unwrap_or_default();
        let drive_work = self.sums.drive_work - opening.drive_work;
        (drive_work - (self.sums.losses - opening.losses) - (self.sums.energy - opening.energy)) / drive_work
    }
}
