//! Least squares with no negative unknown.

/// The x ≥ 0 that makes |A x − b| smallest, from `gram` `AᵀA`, row by row, and `target` `Aᵀb` (Lawson and Hanson 1974, chapter 23).
///
/// A dozen unknowns at most are asked for, by plain loops: the same bytes on every machine, which no linear-algebra crate
/// that picks its instructions at run time gives.
pub(crate) fn nnls(gram: &[Vec<f64>], target: &[f64]) -> Vec<f64> {
    let n = target.len();
    let mut x = vec![0.0; n];
    let mut free: Vec<usize> = Vec::with_capacity(n);
    let largest = target.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    // Every round frees one unknown; a cycle, which only rounding can make, ends here.
    for _ in 0..10 * n {
        let gradient = |j: usize| target[j] - (0..n).map(|k| gram[j][k] * x[k]).sum::<f64>();
        let steepest = (0..n)
            .filter(|j| !free.contains(j))
            .map(|j| (j, gradient(j)))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        match steepest {
            Some((j, slope)) if slope > 1e-12 * largest => free.push(j),
            _ => break,
        }
        loop {
            let Some(best) = solve(gram, target, &free) else {
                // The newest unknown is a copy of others: without it the answer stands.
                free.pop();
                return x;
            };
            // As far towards the best as all stay positive.
            let step = free
                .iter()
                .zip(&best)
                .filter(|(_, best)| **best <= 0.0)
                .map(|(&j, best)| x[j] / (x[j] - best))
                .fold(1.0, f64::min);
            for (&j, best) in free.iter().zip(&best) {
                x[j] += step * (best - x[j]);
            }
            if step >= 1.0 {
                break;
            }
            free.retain(|&j| {
                let keep = x[j] > 1e-14;
                if !keep {
                    x[j] = 0.0;
                }
                keep
            });
        }
    }
    x
}

/// Solves the chosen rows and columns by Cholesky; `None` if they are not independent.
fn solve(gram: &[Vec<f64>], target: &[f64], chosen: &[usize]) -> Option<Vec<f64>> {
    let n = chosen.len();
    let mut lower = vec![vec![0.0; n]; n];
    let mut x: Vec<f64> = chosen.iter().map(|&j| target[j]).collect();
    for i in 0..n {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
            let rest = gram[chosen[i]][chosen[j]] - dot;
            lower[i][j] = if i > j {
                rest / lower[j][j]
            } else if rest > 1e-13 * gram[chosen[i]][chosen[i]] {
                rest.sqrt()
            } else {
                return None;
            };
        }
    }
    for i in 0..n {
        let dot: f64 = (0..i).map(|k| lower[i][k] * x[k]).sum();
        x[i] = (x[i] - dot) / lower[i][i];
    }
    for i in (0..n).rev() {
        let dot: f64 = (i + 1..n).map(|k| lower[k][i] * x[k]).sum();
        x[i] = (x[i] - dot) / lower[i][i];
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normal_equations(a: &[[f64; 3]], b: &[f64]) -> (Vec<Vec<f64>>, Vec<f64>) {
        let column = |j: usize| a.iter().map(move |row| row[j]);
        let gram = (0..3)
            .map(|i| {
                (0..3)
                    .map(|j| column(i).zip(column(j)).map(|(x, y)| x * y).sum())
                    .collect()
            })
            .collect();
        let target = (0..3)
            .map(|j| column(j).zip(b).map(|(x, y)| x * y).sum())
            .collect();
        (gram, target)
    }

    #[test]
    fn nnls_finds_what_is_positive_and_holds_the_rest_at_zero() {
        let a = [
            [1.0, 0.5, 0.2],
            [0.3, 1.0, 0.4],
            [0.1, 0.6, 1.0],
            [0.7, 0.2, 0.9],
        ];
        let product = |x: &[f64]| -> Vec<f64> {
            a.iter()
                .map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum())
                .collect()
        };
        let (gram, target) = normal_equations(&a, &product(&[0.5, 2.0, 1.0]));
        for (x, expected) in nnls(&gram, &target).iter().zip([0.5, 2.0, 1.0]) {
            assert!((x - expected).abs() < 1e-12, "{x} for {expected}");
        }
        // One wants to be negative: it is 0, its gradient points outwards, and that of the others vanishes (Kuhn and Tucker).
        let (gram, target) = normal_equations(&a, &product(&[0.5, -2.0, 1.0]));
        let x = nnls(&gram, &target);
        assert!(x.iter().all(|&x| x >= 0.0) && x.contains(&0.0), "{x:?}");
        for j in 0..3 {
            let slope = target[j] - (0..3).map(|k| gram[j][k] * x[k]).sum::<f64>();
            assert!(
                if x[j] > 0.0 {
                    slope.abs() < 1e-12
                } else {
                    slope <= 0.0
                },
                "{j}: {slope}"
            );
        }
    }

    #[test]
    fn nnls_of_nothing_and_of_copies() {
        assert_eq!(nnls(&[vec![1.0]], &[-3.0]), [0.0]);
        let x = nnls(&[vec![2.0, 2.0], vec![2.0, 2.0]], &[4.0, 4.0]);
        assert!((x[0] + x[1] - 2.0).abs() < 1e-12, "{x:?}");
    }
}
