//! The simplex method of Nelder and Mead (Comput. J. 7, 308, 1965), with reflection by 1, expansion by 2, contraction and
//! shrinking by 1/2.

/// A point and its cost.
type Vertex = (Vec<f64>, f64);

/// Moves a simplex of n + 1 `vertices` in n dimensions downhill until its costs scatter by a standard deviation below
/// `collapsed_std` or the least is at most `comfortable`. `cost` is asked for one point at a time and ends the descent at once
/// where it gives `None`. What was found is what `cost` was asked for.
pub(crate) fn descend(
    vertices: Vec<Vec<f64>>,
    (collapsed_std, comfortable): (f64, f64),
    mut cost: impl FnMut(&[f64]) -> Option<f64>,
) -> Option<()> {
    let mut vertex = |point: Vec<f64>| cost(&point).map(|cost| (point, cost));
    let mut simplex = vertices.into_iter().map(&mut vertex).collect::<Option<Vec<Vertex>>>()?;
    simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    while std(&simplex) >= collapsed_std && simplex[0].1 > comfortable {
        let [.., second, (worst, highest)] = simplex.as_slice() else { break };
        let (best, second) = (simplex[0].1, second.1);
        let centre = centre(&simplex[..simplex.len() - 1]);
        let reflected = vertex(between(&centre, worst, -1.0))?;
        let replacement = if reflected.1 < best {
            let expanded = vertex(between(&centre, &reflected.0, 2.0))?;
            Some(if expanded.1 < reflected.1 { expanded } else { reflected })
        } else if reflected.1 < second {
            Some(reflected)
        } else if reflected.1 < *highest {
            Some(vertex(between(&centre, &reflected.0, 0.5))?).filter(|outside| outside.1 <= reflected.1)
        } else {
            Some(vertex(between(&centre, worst, 0.5))?).filter(|inside| inside.1 < *highest)
        };
        if let Some(replacement) = replacement {
            simplex.pop();
            simplex.push(replacement);
        } else {
            let best = simplex[0].0.clone();
            for shrunk in &mut simplex[1..] {
                *shrunk = vertex(between(&best, &shrunk.0, 0.5))?;
            }
        }
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    }
    Some(())
}

/// Standard deviation of the costs.
fn std(simplex: &[Vertex]) -> f64 {
    let n = simplex.len() as f64;
    let mean = simplex.iter().map(|vertex| vertex.1).sum::<f64>() / n;
    (1.0 / (n - 1.0) * simplex.iter().map(|vertex| (vertex.1 - mean).powi(2)).sum::<f64>()).sqrt()
}

fn centre(vertices: &[Vertex]) -> Vec<f64> {
    let share = 1.0 / vertices.len() as f64;
    let mut centre = vertices[0].0.clone();
    for (point, _) in &vertices[1..] {
        centre.iter_mut().zip(point).for_each(|(sum, x)| *sum += x);
    }
    centre.iter().map(|sum| sum * share).collect()
}

/// from + share (to - from)
fn between(from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(from, to)| from + (to - from) * share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_valley_of_rosenbrock_is_followed_to_its_end() {
        let (mut least, mut calls) = ((Vec::new(), f64::INFINITY), 0);
        let start = vec![vec![-1.2, 1.0], vec![-1.0, 1.0], vec![-1.2, 1.2]];
        let ended = descend(start, (1e-12, f64::NEG_INFINITY), |p| {
            let cost = 100.0 * (p[1] - p[0] * p[0]).powi(2) + (1.0 - p[0]).powi(2);
            calls += 1;
            if cost < least.1 {
                least = (p.to_vec(), cost);
            }
            Some(cost)
        });
        assert_eq!(ended, Some(()));
        assert!(least.0.iter().all(|x| (x - 1.0).abs() < 1e-5) && calls < 250, "{least:?} {calls}");
    }

    #[test]
    fn a_descent_ends_where_it_is_told_to() {
        let bowl = |p: &[f64]| p.iter().map(|x| x * x).sum::<f64>();
        let start = || vec![vec![3.0, 4.0], vec![3.5, 4.0], vec![3.0, 4.5]];
        for most in 1..60 {
            let mut calls = 0;
            let ended = descend(start(), (1e-12, f64::NEG_INFINITY), |p| {
                calls += 1;
                (calls < most).then(|| bowl(p))
            });
            assert_eq!((ended, calls), (None, most));
        }
        let mut last = f64::INFINITY;
        let comfortable = descend(start(), (1e-12, 1.0), |p| {
            assert!(last > 1.0);
            last = bowl(p);
            Some(last)
        });
        assert!(comfortable.is_some() && last <= 1.0);
    }
}
