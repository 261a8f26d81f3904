//! The raw values of a stream gathered into knots: values of nearly the same time become one.

/// Knots with their values and how many raw values each stands for.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    /// Times (s) since the first, strictly increasing.
    pub(crate) x: Vec<f64>,
    /// Averaged values.
    pub(crate) y: Vec<f64>,
    /// Number of raw values.
    pub(crate) count: Vec<f64>,
}

/// Averages times and values over stretches no longer than `near` (s).
pub(crate) fn merge(times: &[f64], values: &[f64], near: f64) -> Points {
    let origin = times[0];
    let mut points = Points { x: Vec::new(), y: Vec::new(), count: Vec::new() };
    let mut start = 0;
    while start < times.len() {
        let mut end = start + 1;
        while end < times.len() && times[end] - times[start] <= near {
            end += 1;
        }
        let count = (end - start) as f64;
        points.x.push(times[start..end].iter().map(|t| t - origin).sum::<f64>() / count);
        points.y.push(values[start..end].iter().sum::<f64>() / count);
        points.count.push(count);
        start = end;
    }
    points
}
