//! The thin wrapper around the level 3 BLAS in single precision (Dongarra, Du Croz, Hammarling and
//! Duff 1990).

use std::ffi::c_int;

use cholmod_sys::blas;

use super::block::Block;

/// C = β C - A Bᵀ over `k` columns of A and B; C has the rows of A, and as many
/// columns as B has rows.
pub fn subtract_product(
    c: &mut [f32],
    stride: usize,
    a: Block<'_>,
    b: Block<'_>,
    k: usize,
    beta: f32,
) {
    let (m, n) = (a.rows, b.rows);
    if m == 0 || n == 0 || k == 0 {
        return;
    }
    let inside = |data: usize, stride: usize, rows: usize, columns: usize| {
        rows <= stride && (columns - 1) * stride + rows <= data
    };
    assert!(inside(c.len(), stride, m, n), "C is too small");
    assert!(inside(a.data.len(), a.stride, m, k), "A is too small");
    assert!(inside(b.data.len(), b.stride, n, k), "B is too small");
    // SAFETY: the three blocks lie inside their slices, as asserted; sizes of
    // tiles fit into an int.
    unsafe {
        blas::cblas_sgemm(
            blas::COLUMNS,
            blas::PLAIN,
            blas::TRANSPOSED,
            m as c_int,
            n as c_int,
            k as c_int,
            -1.0,
            a.data.as_ptr(),
            a.stride as c_int,
            b.data.as_ptr(),
            b.stride as c_int,
            beta,
            c.as_mut_ptr(),
            stride as c_int,
        );
    }
}

/// B = B L⁻ᵀ for the lower triangle L (w by w, packed) and `rows` rows of B.
pub fn solve_right(b: &mut [f32], rows: usize, l: &[f32], w: usize) {
    assert!(b.len() >= rows * w && l.len() >= w * w && rows > 0 && w > 0);
    // SAFETY: both blocks lie inside their slices, as asserted; sizes of tiles
    // fit into an int.
    unsafe {
        blas::cblas_strsm(
            blas::COLUMNS,
            blas::RIGHT,
            blas::LOWER,
            blas::TRANSPOSED,
            blas::NON_UNIT,
            rows as c_int,
            w as c_int,
            1.0,
            l.as_ptr(),
            w as c_int,
            b.as_mut_ptr(),
            rows as c_int,
        );
    }
}
