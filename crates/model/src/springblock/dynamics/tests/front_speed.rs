//! Slip fronts on a chain: u'' = u_E + u_W - 2 u - alpha u' + tau. Every block is at rest until the force on it reaches
//! 1, and the left end is pushed so that the first block is at its threshold.
//!
//! Without damping the front runs at 1/sqrt(1 - tau^2) chain spacings per unit of time; with alpha = 1 it runs at
//! speeds from an independent integration (Amundsen et al., J. Mech. Phys. Solids 2015, study this chain). A step
//! detects a start half a step late on average, so that speeds have an error of first order in the step.

use super::super::contact::{ContactRow, LocalLaw};
use super::super::sweep::Kick;
use crate::springblock::Coefficients;

/// Speed of the front far from the left end, computed with the friction of the contact row and the leapfrog's kick.
fn front_speed(tau: f64, alpha: f64, time_step: f64) -> f64 {
    const BLOCKS: usize = 400;
    // Sliding friction is removed from the chain: a threshold of 1 remains, and no friction in motion.
    let coefficients = vec![Coefficients { static_mu: 1.0 - 1e-9, dynamic_mu: 1e-12 }; BLOCKS];
    let mut contact = ContactRow::new(0..BLOCKS, &coefficients, LocalLaw::new(None, 1.0));
    let Kick { kept, kick } = Kick::new(time_step, alpha);
    let (kick, normal) = (vec![kick; BLOCKS], vec![-1.0; BLOCKS]);
    let (mut u, mut velocity, mut force) = (vec![0.0; BLOCKS], vec![0.0; BLOCKS], vec![0.0; BLOCKS]);
    let mut started = vec![None; BLOCKS];
    let mut step = 0_u32;
    while started[BLOCKS - 2].is_none() {
        assert!(f64::from(step) * time_step < 3.0 * BLOCKS as f64, "the front stops");
        for i in 0..BLOCKS {
            let west = if i == 0 { 1.0 - tau } else { u[i - 1] - u[i] };
            let east = if i + 1 == BLOCKS { 0.0 } else { u[i + 1] - u[i] };
            force[i] = west + east + tau;
        }
        contact.kick(&mut velocity, &force, &normal, kept, &kick);
        for ((u, velocity), (started, block)) in
            u.iter_mut().zip(&velocity).zip(started.iter_mut().zip(&contact.blocks))
        {
            *u += velocity;
            if block.has_slipped {
                started.get_or_insert(step);
            }
        }
        step += 1;
    }
    let (from, to) = (BLOCKS / 2, BLOCKS - 2);
    let steps = f64::from(started[to].unwrap() - started[from].unwrap());
    (to - from) as f64 / (steps * time_step)
}

#[test]
fn fronts_run_at_the_known_speeds() {
    let taus = [0.3_f64, 0.5, 0.7, 0.9];
    let damped = [0.5666, 0.8540, 1.1765, 2.1142];
    for (tau, damped) in taus.into_iter().zip(damped) {
        for (alpha, exact) in [(0.0, 1.0 / (1.0 - tau * tau).sqrt()), (1.0, damped)] {
            let time_step = 0.004;
            let found = front_speed(tau, alpha, time_step);
            // A block starts 1/speed after its neighbour; the step rounds this time.
            assert!((found / exact - 1.0).abs() < time_step * exact, "{tau} {alpha}: {found} {exact}");
        }
    }
}
