use super::*;

fn row(static_mu: f64, dynamic_mu: f64) -> ContactRow<'static, 1> {
    let coefficients = [Coefficients { static_mu, dynamic_mu }];
    ContactRow::new([0].into_iter(), &coefficients, LocalLaw::new(None, 1.0))
}

/// A row whose block slides.
fn sliding_row() -> ContactRow<'static, 1> {
    let mut row = row(0.3, 0.27);
    (row.blocks[0].motion, row.blocks[0].has_slipped) = (Motion::Slip, true);
    row
}

fn kick(row: &mut ContactRow<1>, velocity: f64, force: [f64; 2]) -> (f64, ContactSums) {
    let mut v = [velocity];
    let sums = row.kick(&mut v, &[force[0]], &[force[1]], 1.0, &[0.1]);
    (v[0], sums)
}

#[test]
fn a_block_at_rest_is_held_up_to_its_threshold() {
    let mut row = row(0.3, 0.27);
    let (v, sums) = kick(&mut row, 0.0, [0.29, -1.0]);
    assert_eq!((v, sums.friction, sums.normal), (0.0, 0.29, 1.0));
    let (v, sums) = kick(&mut row, 0.0, [-0.31, -1.0]);
    // Half a step at rest, half a step sliding.
    assert!((v + 0.1 * 0.02).abs() < 1e-15 && (sums.friction + 0.29).abs() < 1e-15);
    assert!(!row.all_have_slipped(), "a slip against the drive is no onset");
    let (v, sums) = kick(&mut row, 0.004, [0.31, -1.0]);
    assert!(v > 0.0 && (sums.friction - 0.27).abs() < 1e-15 && row.all_have_slipped());
}

#[test]
fn a_block_that_slides_when_the_drive_begins_counts_as_slipped() {
    let mut row = sliding_row();
    row.begin_drive();
    assert!(!row.all_have_slipped());
    kick(&mut row, 1.0, [0.0, -1.0]);
    assert!(row.all_have_slipped());
}

#[test]
fn a_block_that_draws_less_static_than_dynamic_friction_starts_at_the_dynamic_one() {
    let mut row = row(0.25, 0.27);
    assert_eq!(kick(&mut row, 0.0, [0.26, -1.0]).0, 0.0);
    assert!(kick(&mut row, 0.0, [0.28, -1.0]).0 > 0.0);
}

#[test]
fn a_step_that_would_reverse_ends_at_rest_with_the_friction_it_took() {
    let mut row = sliding_row();
    let (v, sums) = kick(&mut row, 0.02, [0.0, -1.0]);
    // It stops (0.02 - 0.007)^2 / (8 0.027) further on; friction below 0.27 stopped it.
    assert!((v - 0.013_f64.powi(2) / 0.216).abs() < 1e-15 && row.blocks[0].motion == Motion::Rest);
    assert!((sums.friction - (0.02 - v) / 0.1).abs() < 1e-15);
    let (after, sums) = kick(&mut row, v, [0.1, -1.0]);
    assert_eq!((after, row.blocks[0].motion), (0.0, Motion::Rest));
    // Friction balanced the force and stopped the remaining motion.
    assert!((sums.friction - (0.1 + v / 0.1)).abs() < 1e-15);
}

/// Slip of a block on a spring of frequency 1 in steps of `step` when friction drops from 2 to 1: 2 in exact time.
fn slip(step: f64) -> f64 {
    let mut row = row(2.0, 1.0);
    let (mut x, mut v) = (0.0, 0.0);
    loop {
        let factors = [2.0 + 1e-12 - x];
        let mut velocity = [v];
        row.kick(&mut velocity, &factors, &[-1.0], 1.0, &[step * step]);
        v = velocity[0];
        x += v;
        if row.blocks[0].motion == Motion::Rest {
            return x;
        }
    }
}

#[test]
fn a_slip_is_as_long_as_in_exact_time_but_for_the_square_of_the_step() {
    for step in [0.8, 0.6, 0.4, 0.2, 0.1, 0.05] {
        let off = slip(step) - 2.0;
        assert!(off.abs() < 0.01 * step * step, "{step} {off}");
    }
}

#[test]
fn tension_carries_no_friction_and_does_not_count() {
    let mut row = row(0.3, 0.27);
    let (v, sums) = kick(&mut row, 0.0, [0.1, 0.5]);
    assert!((v - 0.01).abs() < 1e-15);
    assert_eq!(sums, ContactSums::default());
}
