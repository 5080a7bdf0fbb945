//! Steps of a descent: Levenberg (1944), Marquardt (1963), within 0 to 1.

/// A step of Levenberg and Marquardt's within 0 to 1. A parameter at an end of its range that would leave it stays.
pub(super) fn stepped(x: &[f64], columns: &[Vec<f64>], r: &[f64], damping: f64) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let gradient: Vec<f64> = columns.iter().map(|column| dot(column, r)).collect();
    let free: Vec<usize> = (0..x.len())
        .filter(|&k| !(x[k] <= 0.0 && gradient[k] > 0.0 || x[k] >= 1.0 && gradient[k] < 0.0))
        .collect();
    let matrix: Vec<Vec<f64>> = free
        .iter()
        .map(|&i| {
            let damp = |j: usize| if i == j { 1.0 + damping } else { 1.0 };
            let row = free
                .iter()
                .map(|&j| damp(j) * dot(&columns[i], &columns[j]) + if i == j { 1e-9 } else { 0.0 });
            row.collect()
        })
        .collect();
    let step = solved(matrix, free.iter().map(|&k| -gradient[k]).collect());
    let mut next = x.to_vec();
    for (&k, step) in free.iter().zip(step) {
        next[k] = (x[k] + step).clamp(0.0, 1.0);
    }
    next
}

/// The solution of a symmetric system with a positive diagonal, by elimination.
fn solved(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let pivot = a[k][k];
        for i in k + 1..n {
            let factor = a[i][k] / pivot;
            if factor != 0.0 {
                for j in k..n {
                    a[i][j] -= factor * a[k][j];
                }
                b[i] -= factor * b[k];
            }
        }
    }
    for k in (0..n).rev() {
        let sum: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        let value = (b[k] - sum) / a[k][k];
        b[k] = if value.abs() < 1e6 { value } else { 0.0 };
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems_are_solved() {
        let a = vec![vec![4.0, 1.0, 0.5], vec![1.0, 3.0, -1.0], vec![0.5, -1.0, 5.0]];
        let expected = [1.0, -2.0, 0.25];
        let b = a.iter().map(|row| row.iter().zip(expected).map(|(a, x)| a * x).sum()).collect();
        for (found, expected) in solved(a, b).into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }
}
