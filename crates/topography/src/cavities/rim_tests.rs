use super::*;
use crate::form::Form;
use crate::synthetic::splitmix64;
use crate::{HeightMap, SelfAffine};

/// Cavities 60 um wide and 5.2 um deep, 140 um apart, for maps of 2 um pixels, 1.024 mm wide.
const PATTERN: CutPattern = CutPattern {
    shape: CutShape::Groove,
    width_m: 60e-6,
    spacing_m: 140e-6,
    depth_m: 5.2e-6,
    wall_m: 10e-6,
    width_std_m: 1e-6,
    pitch_std_m: 3e-6,
    depth_std_m: 0.2e-6,
    rim: None,
    seed: 3,
};

fn rim(height_um: f64, width_um: f64, profile: RimProfile, height_std_um: f64) -> Option<CutRim> {
    Some(CutRim { height_m: height_um * 1e-6, width_m: width_um * 1e-6, profile, height_std_m: height_std_um * 1e-6 })
}

/// A map of roughness Sa 0.158 um with `pattern` cut, tilted, with white noise of 20 nm, and 5 % of its points missing:
/// half of those on walls, others anywhere.
fn measured(pattern: &CutPattern, seed: u32) -> (HeightMap, Vec<CutCavity>) {
    let mut map = SelfAffine { side_m: 1.024e-3, seed, ..SelfAffine::STAND_IN }.map().unwrap();
    let cut = map.cut_cavities(pattern).unwrap();
    let (rows, cols) = (map.rows(), map.cols());
    let uniform = |n: usize, of: u64| {
        (splitmix64(splitmix64(u64::from(seed) << 40 | of << 32 | n as u64)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut heights: Vec<f64> = map
        .heights_m()
        .iter()
        .enumerate()
        .map(|(n, &height)| {
            let (x, y) = ((n / cols) as f64 / rows as f64, (n % cols) as f64 / cols as f64);
            // The sum of twelve uniform deviates has the variance 1.
            let noise = (1..=12).map(|of| uniform(n, of)).sum::<f64>() - 6.0;
            height + 15e-6 * x - 8e-6 * y + 20e-9 * noise
        })
        .collect();
    let steep = |n: usize| {
        let at = |other: usize| (map.heights_m()[other.min(rows * cols - 1)] - map.heights_m()[n]).abs();
        at(n + cols).max(at(n.saturating_sub(cols))).max(at(n + 1)).max(at(n.saturating_sub(1))) > 0.5e-6
    };
    let walls: Vec<usize> = (0..rows * cols).filter(|&n| steep(n)).collect();
    let lost_walls = (0.025 * (rows * cols) as f64 / walls.len() as f64).min(0.5);
    for n in walls {
        if uniform(n, 13) < lost_walls {
            heights[n] = f64::NAN;
        }
    }
    for (n, height) in heights.iter_mut().enumerate() {
        if uniform(n, 14) < 0.025 {
            *height = f64::NAN;
        }
    }
    (HeightMap::new(rows, cols, map.dx_m(), map.dy_m(), heights).unwrap(), cut)
}

#[test]
fn explore() {
    for shape in [CutShape::Groove, CutShape::Square, CutShape::Disc] {
        for (h, w, profile, std) in [
            (0.0, 15.0, RimProfile::Round, 0.0),
            (0.1, 15.0, RimProfile::Round, 0.0),
            (0.1, 15.0, RimProfile::Flat, 0.02),
            (0.3, 10.0, RimProfile::Ramp, 0.0),
            (0.3, 20.0, RimProfile::HalfSine, 0.06),
            (1.0, 8.0, RimProfile::Round, 0.2),
            (1.0, 30.0, RimProfile::Round, 0.2),
            (1.0, 30.0, RimProfile::Ramp, 0.2),
            (3.0, 20.0, RimProfile::Flat, 0.6),
            (3.0, 20.0, RimProfile::Round, 0.6),
            (3.0, 5.0, RimProfile::Round, 0.6),
        ] {
            let (mut z, mut rel, mut ers) = (vec![], vec![], vec![]);
            for seed in 1..=8 {
                let pattern = CutPattern { shape, rim: if h > 0.0 { rim(h, w, profile, std) } else { None }, seed: seed.into(), ..PATTERN };
                let (map, cut) = measured(&pattern, seed);
                let found = map.measure_cavities(Form::Plane).unwrap();
                let whole: Vec<_> = cut.iter().filter(|c| {
                    let inn = |a: usize| c.center_m[a] + 0.5 * c.width_m < 1.024e-3;
                    inn(0) && (shape == CutShape::Groove || inn(1)) }).collect();
                let truth = whole.iter().map(|c| c.rim_height_m).sum::<f64>() / whole.len() as f64;
                let tstd = (whole.iter().map(|c| (c.rim_height_m - truth).powi(2)).sum::<f64>() / (whole.len() - 1) as f64).sqrt();
                let dtrue = whole.iter().map(|c| c.depth_m).sum::<f64>() / whole.len() as f64;
                let r = &found.rim;
                let e = |v: &Option<Estimate>, s: f64| v.map_or("-".into(), |v| format!("{:.3}±{:.3}", v.value * s, v.error.unwrap_or(f64::NAN) * s));
                if seed <= 3 {
                println!("{shape:?} {h} {w} {profile} | true {:.3} std {:.3} | h {} std {} side {} w {} {:?} share {} start {:.2} | angle {} res {:.1} floor {} | depth {:.3} true {:.3} width {:.2} n {} {}",
                    truth * 1e6, tstd * 1e6, e(&r.height_m, 1e6), e(&r.height_std_m, 1e6), e(&r.side_std_m, 1e6), e(&r.width_m, 1e6), r.profile.map(|p| p.name()), e(&r.share_of_edge, 1.0), r.start_m * 1e6,
                    e(&found.wall_angle_deg, 1.0), found.wall_resolved_deg.unwrap_or(0.0), e(&found.floor_sq_m, 1e6), found.depth.unwrap().mean_m * 1e6, dtrue * 1e6, found.width[0].unwrap().mean_m * 1e6, found.cavities.len(), whole.len());
                }
                if let Some(x) = r.height_m { z.push((x.value - truth) / x.error.unwrap()); rel.push((x.value - truth) * 1e6); ers.push(x.error.unwrap() * 1e6); }
            }
            let rms = |v: &[f64]| (v.iter().map(|x| x * x).sum::<f64>() / v.len() as f64).sqrt();
            println!("   ==== {shape:?} {h} {w} {profile}: bias {:.4} rms {:.4} err {:.4} rms z {:.2} worst {:.2}  n {}", rel.iter().sum::<f64>() / rel.len() as f64, rms(&rel), rms(&ers), rms(&z), z.iter().fold(0.0_f64, |m, x| m.max(x.abs())), z.len());
        }
    }
}
