//! Cache of model values at the nodes of a lattice, keyed by their inputs, so that another target recomputes nothing.

use std::fmt::Debug;

use slipgrid_base::monitor::{Monitor, cached, memory};

/// Numbers of a node, equally many at each node; `None` if there is no answer.
pub type Node = Option<Vec<f64>>;

/// Returns the values of `ask` at `count` nodes, which depend on `content` alone: loaded if the caller of `monitor`
/// caches them, else computed as the whole work of `monitor`. `None` if `ask` gives none, for example once cancelled.
pub fn kept(
    monitor: &dyn Monitor,
    content: &dyn Debug,
    count: usize,
    ask: impl FnOnce() -> Option<Vec<Node>>,
) -> Option<Vec<Node>> {
    let known = |bytes: &[u8]| {
        let nodes = from_bytes(bytes).filter(|nodes| nodes.len() == count)?;
        monitor.advance(1.0);
        Some(Some(nodes))
    };
    cached(monitor, ("nodes", content), (known, |nodes: &Option<Vec<Node>>| to_bytes(nodes.as_ref()?)), ask)
}

/// Encodes the number of values per node, then the values, all NaN at nodes without an answer; `None` if the values
/// cannot be encoded this way.
fn to_bytes(nodes: &[Node]) -> Option<Vec<u8>> {
    let length = nodes.iter().flatten().map(Vec::len).next()?;
    let is_plain = |node: &Vec<f64>| node.len() == length && node.first().is_some_and(|first| !first.is_nan());
    if !nodes.iter().flatten().all(is_plain) {
        return None;
    }
    let missing = vec![f64::NAN; length];
    let numbers = nodes.iter().flat_map(|node| node.as_ref().unwrap_or(&missing).iter());
    // At most some millions, so the cast is exact.
    Some(memory::to_bytes([length as f64].iter().chain(numbers)))
}

fn from_bytes(bytes: &[u8]) -> Option<Vec<Node>> {
    let all = memory::from_bytes(bytes);
    let (length, numbers) = all.split_first().filter(|_| bytes.len().is_multiple_of(size_of::<f64>()))?;
    let length = Some(*length as usize).filter(|length| *length > 0 && numbers.len() % length == 0)?;
    let node = |numbers: &[f64]| (!numbers[0].is_nan()).then(|| numbers.to_vec());
    Some(numbers.chunks_exact(length).map(node).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_base::monitor::{CachingMonitor, Unwatched};

    #[test]
    fn nodes_are_asked_once_and_come_back_to_the_last_bit() {
        let monitor = CachingMonitor::new(&Unwatched);
        let nodes = vec![Some(vec![1.0 / 3.0, -0.0]), None, Some(vec![f64::MAX, f64::NAN])];
        let first = kept(&monitor, &"a", 3, || Some(nodes.clone())).unwrap();
        let again = kept(&monitor, &"a", 3, || panic!("asked twice")).unwrap();
        let bits = |nodes: &[Node]| -> Vec<Option<Vec<u64>>> {
            nodes
                .iter()
                .map(|node| node.as_ref().map(|own| own.iter().map(|number| number.to_bits()).collect()))
                .collect()
        };
        assert_eq!(bits(&first), bits(&again));
        assert_eq!(bits(&again), bits(&nodes));
        let other = vec![Some(vec![2.0])];
        assert_eq!(kept(&monitor, &"b", 1, || Some(other.clone())), Some(other));
        // Another number of nodes does not match the cache.
        assert_eq!(kept(&monitor, &"a", 2, || None), None);
    }

    #[test]
    fn what_is_cancelled_or_uneven_is_asked_again() {
        let monitor = CachingMonitor::new(&Unwatched);
        assert_eq!(kept(&monitor, &"a", 2, || None), None);
        for nodes in [vec![None, None], vec![Some(vec![1.0]), Some(vec![1.0, 2.0])], vec![Some(vec![])]] {
            assert_eq!(kept(&monitor, &"a", nodes.len(), || Some(nodes.clone())), Some(nodes));
        }
        assert_eq!(kept(&monitor, &"a", 1, || Some(vec![Some(vec![3.0])])), Some(vec![Some(vec![3.0])]));
        assert_eq!(from_bytes(&[1, 2]), None);
        assert_eq!(from_bytes(&[0; 16]), None);
        let whole = memory::to_bytes(&[2.0, 1.0, 3.0]);
        assert!(from_bytes(&whole).is_some());
        for cut in [&whole[..16], &whole[..23], &memory::to_bytes(&[1e300, 1.0])] {
            assert_eq!(from_bytes(cut), None);
        }
    }
}
