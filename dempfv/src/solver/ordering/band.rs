//! Where a part is cut: the axis, and the band around the median.

/// The band holds this times n^(-1/3) of the vertices: some layers, however
/// large the part.
const BAND_LAYERS: f64 = 5.0;
/// It never holds more than this.
const MAX_BAND_FRACTION: f64 = 0.45;

/// At most so many points stand for all when the axis and its range are chosen.
const SAMPLE_POINTS: usize = 128;
/// Parts of the range in which vertices are counted.
const HISTOGRAM_BINS: usize = 1024;

/// A way to sort the vertices: by a coordinate, or by any other key.
pub(super) struct Range {
    pub low: f32,
    pub high: f32,
}

/// The axis along which most of the points spread furthest, since pores at walls lie
/// far out, and about the range there. `None` where most lie in one place.
pub(super) fn axis(points: &[[f32; 3]], vertices: &[u32]) -> Option<(usize, Range)> {
    let mut best = None;
    let mut longest = 0.0;
    for axis in [0, 1, 2] {
        let (sample, count) = sample(vertices.len(), |k| points[vertices[k] as usize][axis]);
        let length = sample[count - 1 - count / 16] - sample[count / 16];
        if length > longest {
            longest = length;
            best = Some((axis, Range { low: sample[0], high: sample[count - 1] }));
        }
    }
    best
}

/// The smallest and the largest key inside the band around the median, up to the width
/// of a bin. `counts` is any array.
pub(super) fn planes(keys: &[f32], range: &Range, counts: &mut Vec<u32>) -> (f32, f32) {
    let &Range { low, high } = range;
    let scale = HISTOGRAM_BINS as f32 / (high - low);
    counts.clear();
    counts.resize(HISTOGRAM_BINS, 0);
    for &x in keys {
        // The conversion saturates: what lies outside counts at the ends.
        counts[(((x - low) * scale) as usize).min(HISTOGRAM_BINS - 1)] += 1;
    }
    let n = keys.len();
    let share = (BAND_LAYERS * (n as f64).powf(-1.0 / 3.0)).min(MAX_BAND_FRACTION);
    let outside = (n as f64 * (0.5 - 0.5 * share)) as u32;
    let mut sum = 0;
    let (mut first, mut last) = (0, HISTOGRAM_BINS);
    for (bin, &count) in counts.iter().enumerate() {
        if sum <= outside {
            first = bin;
        }
        sum += count;
        if sum >= n as u32 - outside {
            last = bin + 1;
            break;
        }
    }
    (low + first as f32 / scale, low + last as f32 / scale)
}

/// Some of the values, sorted, and how many: at least one.
fn sample(n: usize, value: impl Fn(usize) -> f32) -> ([f32; SAMPLE_POINTS], usize) {
    let count = (n / 16).clamp(16, SAMPLE_POINTS).min(n.max(1));
    let mut sample = [0.0; SAMPLE_POINTS];
    for (k, x) in sample[..count].iter_mut().enumerate() {
        *x = value(k * n / count);
    }
    sample[..count].sort_unstable_by(f32::total_cmp);
    (sample, count)
}
