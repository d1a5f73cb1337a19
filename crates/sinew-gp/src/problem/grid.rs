//! Grids of points, and of other things along axes.

/// All combinations of one entry for each axis; the last axis runs fastest.
pub(crate) fn grid<T: Copy + Default, const D: usize>(axes: &[Vec<T>; D]) -> Vec<[T; D]> {
    let mut all = vec![[T::default(); D]];
    for (d, axis) in axes.iter().enumerate() {
        let extended = all.iter().flat_map(|point| {
            axis.iter().map(move |entry| {
                let mut point = *point;
                point[d] = *entry;
                point
            })
        });
        all = extended.collect();
    }
    all
}
