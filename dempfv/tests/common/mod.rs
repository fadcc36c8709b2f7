//! Packings that several tests start from.
#![allow(dead_code, reason = "every test file uses some of these")]

use dempfv::{Aabb, Vec3};

/// A small generator with a fixed sequence (splitmix64), uniform in [0, 1).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A vector with components in [-1, 1).
    pub fn vector(&mut self) -> Vec3 {
        Vec3::from_fn(|_, _| 2.0 * self.next() - 1.0)
    }
}

pub struct Spheres {
    pub x: Vec<Vec3>,
    pub r: Vec<f64>,
    pub bounds: Aabb,
}

/// The settled packing of 1,000 spheres that the project ships.
pub fn settled() -> Spheres {
    let text = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../packings/oedometer-1000.txt"
    ))
    .unwrap();
    let mut s = Spheres { x: vec![], r: vec![], bounds: unit_box(1.0) };
    for line in text.lines() {
        let numbers =
            |t: &str| t.split_whitespace().map(|w| w.parse().unwrap()).collect::<Vec<f64>>();
        if let Some(edges) = line.strip_prefix("# box") {
            let b = numbers(edges);
            s.bounds = Aabb { min: Vec3::new(b[0], b[1], b[2]), max: Vec3::new(b[3], b[4], b[5]) };
        } else if !line.starts_with('#') {
            let v = numbers(line);
            s.x.push(Vec3::new(v[0], v[1], v[2]));
            s.r.push(v[3]);
        }
    }
    s
}

pub fn unit_box(edge: f64) -> Aabb {
    Aabb { min: Vec3::zeros(), max: Vec3::repeat(edge) }
}

/// `n`³ spheres of radius 0.5 on a simple cubic lattice that fills its box, each
/// moved by up to `jitter`.
pub fn cubic(n: usize, jitter: f64) -> Spheres {
    let mut random = Random(7);
    let x = (0..n * n * n)
        .map(|i| {
            Vec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64).add_scalar(0.5)
                + jitter * random.vector()
        })
        .collect();
    Spheres { x, r: vec![0.5; n * n * n], bounds: unit_box(n as f64) }
}

/// A face-centred lattice of `n`³ cells with edge 1 and touching spheres, the
/// box a little wider than the lattice on all sides.
pub fn face_centred(n: usize, jitter: f64) -> Spheres {
    let mut random = Random(11);
    let r = 0.5f64.sqrt() / 2.0;
    let corners = [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]];
    let x: Vec<Vec3> = (0..n * n * n)
        .flat_map(|i| {
            corners.map(|c| {
                Vec3::from(c) + Vec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64)
            })
        })
        .map(|c| c.add_scalar(r) + jitter * random.vector())
        .collect();
    let edge = n as f64 - 0.5 + 2.0 * r;
    Spheres { r: vec![r; x.len()], x, bounds: unit_box(edge) }
}

/// A loose random packing in a box that is no cube and not at the origin.
pub fn loose() -> Spheres {
    let mut random = Random(3);
    let bounds = Aabb { min: Vec3::new(-1.0, 2.0, 0.5), max: Vec3::new(1.0, 3.0, 2.0) };
    let x = (0..150)
        .map(|_| bounds.center() + 0.42 * random.vector().component_mul(&bounds.size()))
        .collect();
    let r = (0..150).map(|_| 0.02 + 0.04 * random.next()).collect();
    Spheres { x, r, bounds }
}

/// One or two spheres in a unit box.
pub fn few(count: usize) -> Spheres {
    let x = [Vec3::new(0.3, 0.4, 0.6), Vec3::new(0.7, 0.5, 0.4)];
    Spheres { x: x[..count].to_vec(), r: vec![0.2, 0.1][..count].to_vec(), bounds: unit_box(1.0) }
}
