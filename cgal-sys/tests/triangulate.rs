//! The shim against triangulations known by hand.

use cgal_sys::{NONE, triangulate};

fn volume(points: &[[f64; 4]], cell: [u32; 4]) -> f64 {
    let p = cell.map(|v| points[v as usize]);
    let d = |i: usize| [p[i][0] - p[0][0], p[i][1] - p[0][1], p[i][2] - p[0][2]];
    let [a, b, c] = [d(1), d(2), d(3)];
    (a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0]))
        / 6.0
}

fn grid(n: usize) -> Vec<[f64; 4]> {
    (0..n * n * n).map(|i| [(i % n) as f64, (i / n % n) as f64, (i / n / n) as f64, 0.1]).collect()
}

/// Cospherical points: whatever CGAL picks fills the cube, with cells that are
/// never flat, and neighbours that name each other.
#[test]
fn a_lattice_is_filled_and_adjacency_is_mutual() {
    let points = grid(4);
    let t = triangulate(&points).unwrap();
    let volumes: Vec<f64> = t.cells.iter().map(|&c| volume(&points, c)).collect();
    assert!(volumes.iter().all(|&v| v > 0.1));
    assert!((volumes.iter().sum::<f64>() - 27.0).abs() < 1e-12);
    assert!(t.hidden.is_empty());
    for (i, around) in t.neighbors.iter().enumerate() {
        for (k, &j) in around.iter().enumerate() {
            if j == NONE {
                continue;
            }
            let back =
                t.neighbors[j as usize].iter().position(|&b| b as usize == i).expect("mutual");
            let facet = |cell: [u32; 4], skip: usize| {
                let mut f: Vec<u32> = (0..4).filter(|&m| m != skip).map(|m| cell[m]).collect();
                f.sort_unstable();
                f
            };
            assert_eq!(facet(t.cells[i], k), facet(t.cells[j as usize], back));
        }
    }
}

/// A small weight inside the power cell of large ones is no vertex.
#[test]
fn a_hidden_point_is_named() {
    let mut points = grid(2);
    points.iter_mut().for_each(|p| p[3] = 1.0);
    points.push([0.5, 0.5, 0.5, 0.0]);
    assert_eq!(triangulate(&points).unwrap().hidden, [8]);
}

#[test]
fn bad_points_are_errors_and_not_crashes() {
    let flat = [[0., 0., 0., 0.], [1., 0., 0., 0.], [0., 1., 0., 0.], [1., 1., 0., 0.]];
    assert!(triangulate(&flat).unwrap_err().to_string().contains("one plane"));
    assert!(triangulate(&[]).is_err());
    let mut nan = grid(2);
    nan[5][1] = f64::NAN;
    assert!(triangulate(&nan).unwrap_err().to_string().contains("point 5"));
}
