use crate::topography::HeightMap;

impl HeightMap {
    /// Mean height of the points present, in metres.
    pub fn mean_m(&self) -> f64 {
        let mut present = self.heights_m().iter().filter(|height| !height.is_nan());
        // Sums are relative to one of the heights, so that a constant map has exactly its height as mean.
        let Some(&origin) = present.next() else { return f64::NAN };
        let (mut sum, mut count) = (0.0, 1.0);
        for height in present {
            sum += height - origin;
            count += 1.0;
        }
        origin + sum / count
    }
}
