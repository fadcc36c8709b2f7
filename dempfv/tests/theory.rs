//! The closed forms against tables, against themselves and against mass.

use dempfv::theory::*;

#[test]
fn consolidation_matches_the_tables() {
    // Time factors of textbooks (for example Craig, Soil Mechanics, and Taylor,
    // Fundamentals of Soil Mechanics), three decimals.
    for (u, t) in [
        (0.1, 0.008),
        (0.2, 0.031),
        (0.3, 0.071),
        (0.4, 0.126),
        (0.5, 0.197),
        (0.6, 0.286),
        (0.7, 0.403),
        (0.8, 0.567),
        (0.9, 0.848),
        (0.95, 1.129),
    ] {
        assert!((time_factor(u) - t).abs() < 6e-4, "U = {u}: T_v = {}", time_factor(u));
        assert!((degree_of_consolidation(t) - u).abs() < 4e-3, "T_v = {t}");
    }
    // Terzaghi's and Taylor's approximations of the two ends.
    for t in [1e-9, 1e-6, 1e-3, 0.02] {
        let parabola = (4.0 * t / std::f64::consts::PI).sqrt();
        assert!((degree_of_consolidation(t) / parabola - 1.0).abs() < 1e-10, "T_v = {t}");
    }
    let tail =
        8.0 / std::f64::consts::PI.powi(2) * (-std::f64::consts::PI.powi(2) / 4.0 * 2.0).exp();
    assert!((1.0 - degree_of_consolidation(2.0) - tail).abs() < 1e-15);
    assert_eq!(degree_of_consolidation(0.0), 0.0);
    assert_eq!(degree_of_consolidation(-1.0), 0.0);
    assert_eq!(degree_of_consolidation(1e9), 1.0);
}

/// Brute force: the textbook series with very many terms.
fn series_degree(t: f64) -> f64 {
    let m = |k: u32| std::f64::consts::FRAC_PI_2 * f64::from(2 * k + 1);
    1.0 - (0..20_000).rev().map(|k| 2.0 / m(k).powi(2) * (-m(k).powi(2) * t).exp()).sum::<f64>()
}

fn series_pressure(z: f64, t: f64) -> f64 {
    let m = |k: u32| std::f64::consts::FRAC_PI_2 * f64::from(2 * k + 1);
    (0..20_000).rev().map(|k| 2.0 / m(k) * (m(k) * z).sin() * (-m(k).powi(2) * t).exp()).sum()
}

#[test]
fn both_series_are_the_same_function_to_rounding() {
    for t in [1e-4, 1e-3, 0.01, 0.05, 0.0999999, 0.1, 0.1000001, 0.2, 1.0, 3.0] {
        let error = (degree_of_consolidation(t) - series_degree(t)).abs();
        assert!(error < 1e-14, "U at T_v = {t}: {error:e}");
        for z in [0.0, 1e-3, 0.1, 0.3, 0.5, 0.77, 1.0] {
            let error = (excess_pressure(z, t) - series_pressure(z, t)).abs();
            assert!(error < 1e-14, "p at z = {z}, T_v = {t}: {error:e}");
        }
    }
}

#[test]
fn what_the_profile_has_lost_is_what_has_settled() {
    // 1 − U is the mean of p/p₀ over the height; Simpson's rule.
    let n = 20_000;
    for t in [0.002, 0.03, 0.0999, 0.1001, 0.5, 1.5] {
        let mean: f64 = (0..=n)
            .map(|i| {
                let weight = if i == 0 || i == n { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
                weight * excess_pressure(f64::from(i) / f64::from(n), t)
            })
            .sum::<f64>()
            / (3.0 * f64::from(n));
        let error = (1.0 - degree_of_consolidation(t) - mean).abs();
        assert!(error < 1e-10, "T_v = {t}: {error:e}");
    }
}

#[test]
fn the_profile_obeys_its_equation_and_its_ends() {
    // ∂p/∂T = ∂²p/∂z² by central differences; sealed at z = 1, dry at z = 0.
    let h = 1e-3;
    for t in [0.02, 0.09, 0.11, 0.6] {
        for z in [0.1, 0.5, 0.9] {
            let p = excess_pressure;
            let rate = (p(z, t + h * h) - p(z, t - h * h)) / (2.0 * h * h);
            let curvature = (p(z + h, t) - 2.0 * p(z, t) + p(z - h, t)) / (h * h);
            let scale = 1.0 + rate.abs();
            assert!((rate - curvature).abs() < 1e-3 * scale, "z = {z}, T_v = {t}");
        }
        assert_eq!(excess_pressure(0.0, t), 0.0);
        assert!((excess_pressure(1.0, t) - excess_pressure(1.0 - 1e-6, t)).abs() < 1e-10);
    }
    assert_eq!(excess_pressure(0.5, 0.0), 1.0);
}

#[test]
fn the_inverse_inverts() {
    for u in [1e-6, 0.01, 0.3, 0.5, 0.9, 0.999, 1.0 - 1e-9] {
        assert!((degree_of_consolidation(time_factor(u)) - u).abs() < 1e-14, "U = {u}");
    }
    assert_eq!(time_factor(0.0), 0.0);
    assert_eq!(time_factor(1.0), f64::INFINITY);
}

/// The drained layer's share of the settlement is there at once, and without one at a sealed wall the
/// rest is Terzaghi's: a line with the specimen's resistance and a share 1 − s of its storage.
#[test]
fn a_drained_layer_settles_at_once_by_its_share() {
    let plain = WallLayers::new(0.0, 0.0);
    for t in [0.0, 1e-4, 0.005, 0.006_999, 0.007_001, 0.05, 0.1, 0.5, 2.0] {
        assert!((plain.degree(t) - degree_of_consolidation(t)).abs() < 1e-13, "T_v = {t}");
        for z in [0.1, 0.5, 1.0] {
            let error = plain.excess_pressure(z, t) - excess_pressure(z, t);
            assert!(error.abs() < 1e-13, "T_v = {t}, z = {z}: {error:e}");
        }
    }
    let layers = WallLayers::new(0.1, 0.0);
    assert_eq!(layers.degree(0.0), 0.1);
    // The rest is half done at T_v = 0.197 (1−s).
    let t = time_factor(0.5) * 0.9;
    assert!((layers.degree(t) - (0.1 + 0.9 * 0.5)).abs() < 1e-14);
}

/// A line of 400 elements between the layers, 0.7 of the storage, and 0.2 of it in the sealed layer at
/// its end: what implicit steps make of it. Their error falls with the step: 3e-4 at first with steps
/// of 1e-5 and the mesh's width together.
#[test]
fn a_sealed_layer_is_a_storage_at_the_end_of_the_line() {
    let (drained, sealed) = (0.1, 0.2);
    let layers = WallLayers::new(drained, sealed);
    let (elements, dt) = (400_usize, 2e-5);
    let throat = elements as f64;
    let mut storage = vec![0.7 / elements as f64; elements];
    storage[0] *= 0.5;
    storage.insert(0, storage[0]);
    // Pressures at the nodes of the mesh: the first is the drained layer's.
    storage[elements] = 0.5 * 0.7 / elements as f64 + sealed;
    let mut pressure = vec![1.0; elements + 1];
    pressure[0] = 0.0;
    let mut step = 0;
    for t in [0.01, 0.05, 0.2, 0.5] {
        while (f64::from(step) + 0.5) * dt < t {
            implicit_step(&mut pressure, &storage, throat, dt);
            step += 1;
        }
        let left: f64 = (1..=elements).map(|i| storage[i] * pressure[i]).sum();
        let error = layers.degree(t) - (1.0 - left);
        assert!(error.abs() < 1e-3, "T_v = {t}: {error:e}");
        for (at, x) in [(elements / 2, 0.5), (elements, 1.0)] {
            let error = layers.excess_pressure(x, t) - pressure[at];
            assert!(error.abs() < 1e-3, "T_v = {t}, x = {x}: {error:e}");
        }
    }
}

/// C (p' − p) = dt K p', K of a line of equal throats whose first node keeps its pressure.
fn implicit_step(pressure: &mut [f64], storage: &[f64], throat: f64, dt: f64) {
    let (last, g) = (pressure.len() - 1, dt * throat);
    let mut upper = vec![0.0; last + 1];
    let mut right = vec![0.0; last + 1];
    right[0] = pressure[0];
    for i in 1..=last {
        let diagonal = storage[i] + if i < last { 2.0 * g } else { g };
        let pivot = diagonal + g * upper[i - 1];
        upper[i] = -g / pivot;
        right[i] = (storage[i] * pressure[i] + g * right[i - 1]) / pivot;
    }
    pressure[last] = right[last];
    for i in (0..last).rev() {
        pressure[i] = right[i] - upper[i] * pressure[i + 1];
    }
}

/// The series of a layer that is open at both ends, Σ 4/(π n) sin(n π z/H) exp(−n² π² c_v t / H²) over
/// odd n (Carslaw and Jaeger, §3.4), with c_v t / H² = T_v / 4.
#[test]
fn both_ends_drained_is_the_series_of_an_open_layer() {
    let pi = std::f64::consts::PI;
    for t in [0.05, 0.3, 1.0] {
        for z in [0.0, 0.1, 0.5, 0.8, 1.0] {
            let term =
                |n: f64| 4.0 / (pi * n) * (n * pi * z).sin() * (-n * n * pi * pi * t / 4.0).exp();
            let series: f64 = (0..200).rev().map(|k| term(f64::from(2 * k + 1))).sum();
            let error = (excess_pressure_both_ends(z, t) - series).abs();
            assert!(error < 1e-14, "z = {z}, T_v = {t}: {error:e}");
        }
    }
}

#[test]
fn permeability_of_a_bed_of_spheres() {
    // ε = 0.4, d = 1 mm: 0.064e-6 / (180 · 0.36) by hand.
    assert!((kozeny_carman(0.4, 1e-3) / 9.876_543_209_876_5e-10 - 1.0).abs() < 1e-12);
    // Sauter: (8 + 1)·2 / (4 + 1) for r = 2, 1.
    assert_eq!(sauter_diameter(&[2.0, 1.0]), 3.6);
    assert_eq!(sauter_diameter(&[0.5; 7]), 1.0);
    assert_eq!(sauter_diameter(&[]), 0.0);
}
