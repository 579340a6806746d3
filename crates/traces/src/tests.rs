use super::*;
use slipgrid_base::statistics::Noise;

const RADIUS_M: f64 = 0.0381;

/// 45 s at 20 Hz under 150 N: a peak of 0.31 at half a second, then 0.25, with 1 % of noise.
fn good() -> TraceChannels {
    let mut noise = Noise::new(42);
    let time_s: Vec<f64> = (0..=900).map(|i| 100.0 + f64::from(i) * 0.05).collect();
    let normal_force_n: Vec<f64> = time_s.iter().map(|_| 150.0 + 0.5 * noise.normal()).collect();
    let torque = time_s
        .iter()
        .zip(&normal_force_n)
        .map(|(clock, force)| {
            let t = clock - 100.0;
            let mu = if t < 0.5 { 0.31 * t / 0.5 } else { 0.25 + 0.06 * (-(t - 0.5)).exp() };
            (mu + 0.0025 * noise.normal()) * force * RADIUS_M
        })
        .collect();
    TraceChannels { time_s, start_s: 100.0, tangential: Tangential::TorqueNm(torque), normal_force_n }
}

/// At 50 um/s friction falls from its peak within 50 um.
pub(crate) const OPTIONS: TraceOptions = TraceOptions {
    window_s: DEFAULT_WINDOW_S,
    effective_radius_m: RADIUS_M,
    nominal_force_n: Some(150.0),
    speed_m_s: 50e-6,
    static_peak: true,
    stroke_share: None,
    zero_s: None,
};

/// Noise of unit standard deviation whose correlation falls as exp(-t / `memory_s`), sampled every `step_s`; white for
/// `memory_s` = 0.
pub(crate) fn red(noise: &mut Noise, samples: usize, step_s: f64, memory_s: f64) -> Vec<f64> {
    let kept = if memory_s > 0.0 { (-step_s / memory_s).exp() } else { 0.0 };
    let mut value = noise.normal();
    let next = |_| {
        value = kept * value + (1.0 - kept * kept).sqrt() * noise.normal();
        value
    };
    (0..samples).map(next).collect()
}

fn torque(channels: &mut TraceChannels) -> &mut Vec<f64> {
    match &mut channels.tangential {
        Tangential::TorqueNm(values) | Tangential::ForceN(values) | Tangential::Coefficient(values) => values,
    }
}

fn said(flags: &[TraceFlag]) -> Vec<String> {
    flags.iter().map(TraceFlag::to_string).collect()
}

#[test]
fn torque_over_force_and_radius_is_friction() {
    let found = analyse(&good(), &OPTIONS).unwrap();
    assert!((found.window.mu - 0.25).abs() < 4.0 * found.window.stderr && found.window.stderr < 3e-4, "{found:?}");
    let peak = found.static_peak.unwrap();
    assert!((peak.mu - 0.31).abs() < 2.0 * peak.std && (peak.time_s - 0.5).abs() < 0.11, "{peak:?}");
    assert_eq!((found.stick_slip, found.flags.as_slice()), (None, &[][..]));
    assert_eq!(found.samples, 601);
    assert!((found.normal_force_n - 150.0).abs() < 0.2);
    // Recorded as a friction force.
    let mut force = good();
    force.tangential = Tangential::ForceN(torque(&mut force).iter().map(|t| t / RADIUS_M).collect());
    let force = analyse(&force, &TraceOptions { effective_radius_m: f64::NAN, ..OPTIONS }).unwrap();
    assert!((force.window.mu - found.window.mu).abs() < 1e-12);
    // Recorded as the instrument's coefficient, with and without the load.
    let mut divided = good();
    let loads = divided.normal_force_n.clone();
    divided.tangential =
        Tangential::Coefficient(torque(&mut divided).iter().zip(loads).map(|(t, n)| t / n / RADIUS_M).collect());
    let options = TraceOptions { effective_radius_m: f64::NAN, ..OPTIONS };
    assert!((analyse(&divided, &options).unwrap().window.mu - found.window.mu).abs() < 1e-12);
    divided.normal_force_n.clear();
    let alone = analyse(&divided, &options).unwrap();
    assert!((alone.window.mu - found.window.mu).abs() < 1e-12 && alone.flags == [TraceFlag::LoadNotRecorded]);
}

#[test]
fn recorded_signs_are_turned_and_said() {
    let mut both = good();
    torque(&mut both).iter_mut().for_each(|t| *t = -*t);
    let found = analyse(&both, &OPTIONS).unwrap();
    assert_eq!(said(&found.flags), ["friction is recorded as negative and was turned"]);
    both.normal_force_n.iter_mut().for_each(|force| *force = -*force);
    let turned = analyse(&both, &OPTIONS).unwrap();
    assert_eq!(
        said(&turned.flags),
        ["the normal force is recorded as negative and was turned", "friction is recorded as negative and was turned"]
    );
    let straight = analyse(&good(), &OPTIONS).unwrap();
    assert_eq!((turned.window, found.window), (straight.window, straight.window));
}

#[test]
fn what_no_export_holds_is_refused_too() {
    let refused = |spoil: &dyn Fn(&mut TraceChannels), options: TraceOptions| {
        let mut channels = good();
        spoil(&mut channels);
        analyse(&channels, &options).unwrap_err().to_string()
    };
    assert!(refused(&|c| torque(c)[7] = f64::NAN, OPTIONS).contains("sample 8: torque is NaN"));
    assert!(refused(&|c| torque(c).truncate(800), OPTIONS).contains("torque has 800 samples"));
    let armless = TraceOptions { effective_radius_m: 0.0, ..OPTIONS };
    assert!(refused(&|_| (), armless).contains("the effective radius is 0 m"));
    let nothing = Some([2.0, 2.0]);
    for empty in [TraceOptions { window_s: [0.0, f64::NAN], ..OPTIONS }, TraceOptions { zero_s: nothing, ..OPTIONS }] {
        assert!(refused(&|_| (), empty).contains("has no meaning"));
    }
}

#[test]
fn odd_traces_are_read_and_flagged() {
    let flags = |spoil: &dyn Fn(&mut TraceChannels)| {
        let mut channels = good();
        spoil(&mut channels);
        said(&analyse(&channels, &OPTIONS).unwrap().flags)
    };
    let drifting = flags(&|c| {
        let time = c.time_s.clone();
        torque(c).iter_mut().zip(time).for_each(|(t, clock)| *t *= 1.0 + 0.003 * (clock - 100.0));
    });
    // 0.003 per second over 30 s, divided by the mean factor 1.075.
    assert_eq!(drifting.len(), 1, "{drifting:?}");
    let (_, rest) = drifting[0].split_once("friction drifts by +").expect(&drifting[0]);
    let percent: f64 = rest.split_once(' ').unwrap().0.parse().unwrap();
    assert!((percent - 100.0 * 0.09 / 1.075).abs() < 1.0, "{drifting:?}");
    let off = flags(&|c| c.normal_force_n.iter_mut().for_each(|f| *f *= 1.1));
    assert!(off.len() == 1 && off[0].contains("not the nominal 150 N"), "{off:?}");
    let gap = flags(&|c| c.time_s[60..].iter_mut().for_each(|t| *t += 1.0));
    assert!(gap.len() == 1 && gap[0].starts_with("no samples from"), "{gap:?}");
    let clipped = flags(&|c| torque(c).iter_mut().for_each(|t| *t = t.min(1.62)));
    assert!(clipped.len() == 1 && clipped[0].starts_with("the sensor stood at 1.62"), "{clipped:?}");
    let coarse = flags(&|c| torque(c).iter_mut().for_each(|t| *t = (*t * 50.0).round() / 50.0));
    assert!(coarse.iter().any(|flag| flag.contains("different values occur")), "{coarse:?}");
    let uneven = flags(&|c| {
        let forces = c.normal_force_n.iter_mut().zip(0_u32..);
        forces.for_each(|(force, i)| *force *= 1.0 + 0.1 * (0.3 * f64::from(i)).sin());
    });
    assert!(uneven.iter().any(|flag| flag.starts_with("the normal force varies by")), "{uneven:?}");
}

#[test]
fn samples_before_the_load_do_not_count() {
    let mut channels = good();
    channels.normal_force_n[..6].fill(0.01);
    torque(&mut channels)[..6].fill(0.2);
    let found = analyse(&channels, &OPTIONS).unwrap();
    assert_eq!(found.time_s.len(), 895);
    assert!(found.static_peak.unwrap().mu < 0.32);
}

#[test]
fn slips_farther_apart_than_anything_yields_are_no_stick_slip() {
    let mut channels = good();
    let (forces, times) = (channels.normal_force_n.clone(), channels.time_s.clone());
    for ((t, force), clock) in torque(&mut channels).iter_mut().zip(forces).zip(times) {
        let phase = ((clock - 100.0) / 1.9).fract();
        *t = (0.25 + 0.05 * if phase < 0.95 { phase / 0.95 } else { (1.0 - phase) / 0.05 }) * force * RADIUS_M;
    }
    let at = |speed_m_s: f64| analyse(&channels, &TraceOptions { speed_m_s, static_peak: false, ..OPTIONS }).unwrap();
    // 9.5 mm from slip to slip, and 38 mm.
    let slow = at(5e-3);
    let found = slow.stick_slip.unwrap();
    assert!((found.amplitude - 0.05).abs() < 0.003 && (found.period_s - 1.9).abs() < 0.06, "{found:?}");
    assert!(slow.flags.is_empty(), "{:?}", slow.flags);
    let fast = at(20e-3);
    assert_eq!(fast.stick_slip, None);
    let said = fast.flags[0].to_string();
    assert!(
        said.contains("on a way of 38") && said.contains("no stick-slip") && said.contains("10 mm at most"),
        "{said}"
    );
}

#[test]
fn times_in_another_unit_are_asked_about() {
    for (factor, says) in [(60.0, "a sample every"), (1e-3, "with a sample every 0.00005 s")] {
        let mut channels = good();
        channels.time_s.iter_mut().for_each(|t| *t *= factor);
        channels.start_s *= factor;
        let window_s = if factor > 1.0 { [10.0, 60.0] } else { DEFAULT_WINDOW_S };
        let refused = analyse(&channels, &TraceOptions { window_s, ..OPTIONS }).unwrap_err().to_string();
        assert!(refused.contains("unit than its title says"), "{refused}");
        assert!(refused.contains(says) || refused.contains("17 samples, one every 3 s"), "{refused}");
    }
}

#[test]
fn repeats_have_their_mean_and_deviation() {
    let one = analyse(&good(), &OPTIONS).unwrap();
    let with = |mu: f64| {
        let mut found = one.clone();
        found.window.mu = mu;
        found
    };
    let three = average(&[with(0.24), with(0.25), with(0.26)]).unwrap();
    assert!((three.mu_dynamic.mean - 0.25).abs() < 1e-15 && (three.mu_dynamic.std - 0.01).abs() < 1e-12);
    assert_eq!((three.count, three.peaks, three.stick_slips), (3, 3, 0));
    // Equal repeats, and a single one, keep the standard error within a repeat.
    let equal = average(&[one.clone(), one.clone()]).unwrap();
    let single = average(std::slice::from_ref(&one)).unwrap();
    assert!((equal.mu_dynamic.std - one.window.stderr).abs() < 1e-15);
    assert!((single.mu_dynamic.std - one.window.stderr).abs() < 1e-15);
    // Sampling may miss an equal amount of the peak in all repeats: it is added to the scatter. For one repeat it is
    // the only known error.
    let peaks = [0.3695, 0.3681, 0.3721].map(|mu| {
        let mut found = one.clone();
        found.static_peak =
            found.static_peak.map(|peak| TracePeak { mu, noise: 0.0005, missed: 0.05, std: 0.0500025, ..peak });
        found
    });
    let of_peaks = average(&peaks).unwrap();
    assert!((of_peaks.mu_static.unwrap().std - 0.00203).abs() < 1e-5);
    let scatter = 0.00203 * (4.0_f64 / 3.0).sqrt() * 4.302_653 / 1.959_964;
    assert!((of_peaks.mu_static_predictive_std().unwrap() - scatter.hypot(0.05 / 12.0_f64.sqrt())).abs() < 1e-5);
    // Scatter and missed amount are reported separately.
    assert!((average(&peaks).unwrap().mu_static_missed.unwrap() - 0.05 / 12.0_f64.sqrt()).abs() < 1e-12);
    assert_eq!(average(&peaks[..1]).unwrap().mu_static_missed, Some(0.05));
    let of_one = average(&peaks[..1]).unwrap().mu_static_predictive_std().unwrap();
    assert!((of_one - (0.0005 * 2.0_f64.sqrt()).hypot(0.05)).abs() < 1e-9);
    let mut without = one.clone();
    without.static_peak = None;
    assert_eq!(average(&[one, without]).unwrap().mu_static, None);
    assert_eq!(average(&[]), None);
}

#[test]
fn run_in_is_told_and_the_search_for_a_peak_can_be_turned_off() {
    // At 2 mm/s the fall within a second is one within 2 mm.
    let fast = analyse(&good(), &TraceOptions { speed_m_s: 2e-3, ..OPTIONS }).unwrap();
    assert_eq!(fast.static_peak, None);
    assert_eq!(fast.flags.len(), 1, "{:?}", fast.flags);
    assert!(fast.flags[0].to_string().contains("run-in, no static peak"));
    for speed_m_s in [50e-6, 2e-3] {
        let off = analyse(&good(), &TraceOptions { static_peak: false, speed_m_s, ..OPTIONS }).unwrap();
        assert_eq!((off.static_peak, &off.flags[..]), (None, &[][..]));
        assert_eq!(off.window, fast.window);
    }
}

#[test]
fn a_sample_that_does_not_slide_is_refused() {
    let with = |friction: &dyn Fn(f64) -> f64| {
        let mut channels = good();
        let times = channels.time_s.clone();
        let mut noise = Noise::new(9);
        for (torque, clock) in torque(&mut channels).iter_mut().zip(times) {
            *torque = (friction(clock - 100.0) + 1e-6 * noise.normal()) * 150.0 * RADIUS_M;
        }
        analyse(&channels, &OPTIONS).unwrap_err()
    };
    assert!(with(&|_| 2e-5).to_string().starts_with("friction is 0.00002"));
    // Loaded from the first sample on: mean at 25 s, rise over 30 s.
    let sticks = with(&|t| 0.004 * t);
    assert!(sticks.to_string().starts_with("friction changes by +120 % of its mean"), "{sticks}");
}

#[test]
fn a_clock_that_stands_still_between_samples_has_no_gaps() {
    let mut channels = good();
    let times = channels.time_s.clone();
    // Every sample is written twice, as some exports do: half of the pauses are zero.
    let twice = |values: &[f64]| values.iter().flat_map(|value| [*value; 2]).collect::<Vec<f64>>();
    channels.time_s = twice(&times);
    channels.normal_force_n = twice(&channels.normal_force_n);
    *torque(&mut channels) = twice(&torque(&mut channels).clone());
    let found = analyse(&channels, &OPTIONS).unwrap();
    assert!(!said(&found.flags).iter().any(|flag| flag.contains("no samples from")), "{:?}", found.flags);
    // Several short gaps give one flag.
    let mut gaps = good();
    for from in [60, 100, 140] {
        gaps.time_s[from..].iter_mut().for_each(|t| *t += 0.6);
    }
    let found = analyse(&gaps, &TraceOptions { static_peak: false, ..OPTIONS }).unwrap();
    assert!(found.flags.len() == 1 && said(&found.flags)[0].starts_with("3 gaps;"), "{:?}", found.flags);
}
