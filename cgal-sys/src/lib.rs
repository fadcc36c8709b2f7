//! CGAL's regular (weighted Delaunay) triangulation behind one call: flat
//! weighted points in, flat cells out. C++ exceptions come back as errors.

#[cxx::bridge(namespace = "dempfv_cgal")]
mod ffi {
    unsafe extern "C++" {
        include!("cgal-sys/src/shim.h");

        /// A finished triangulation, as flat arrays owned by C++.
        type Triangulation;

        /// Triangulates weighted points; see [`triangulate`](crate::triangulate).
        fn triangulate(points: &[f64]) -> Result<UniquePtr<Triangulation>>;

        /// Vertices of the finite cells, four ids each.
        fn cells(self: &Triangulation) -> &CxxVector<u32>;

        /// Cells across the facet opposite each vertex, four each.
        fn neighbors(self: &Triangulation) -> &CxxVector<u32>;

        /// Ids of the points that are no vertex, ascending.
        fn hidden(self: &Triangulation) -> &CxxVector<u32>;
    }
}

/// The version of CGAL that this crate was built with, for example `5.5.1`.
pub const CGAL_VERSION: &str = env!("CGAL_SYS_VERSION");

/// In [`Triangulation::neighbors`]: no finite cell lies there.
pub const NONE: u32 = u32::MAX;

/// A regular triangulation as flat arrays.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Triangulation {
    /// Four point ids per finite cell; the tetrahedron that they span in this
    /// order has a positive volume.
    pub cells: Vec<[u32; 4]>,
    /// Per cell and vertex the cell across the opposite facet, or [`NONE`].
    pub neighbors: Vec<[u32; 4]>,
    /// Points whose power cell is empty, so that they are no vertex; ascending.
    pub hidden: Vec<u32>,
}

/// Why there is no triangulation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error(String);

impl std::fmt::Display for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Error {}

/// Triangulates the weighted points `[x, y, z, weight]`; a sphere's weight is
/// its squared radius. The points are inserted as one range in spatial order.
///
/// # Errors
/// When a number is not finite, when all points lie in one plane, when there
/// are 2³² points or cells, or when CGAL throws.
///
/// ```
/// let corners = [[0., 0., 0., 0.], [1., 0., 0., 0.], [0., 1., 0., 0.], [0., 0., 1., 0.]];
/// let t = cgal_sys::triangulate(&corners).unwrap();
/// assert_eq!(t.cells.len(), 1);
/// assert_eq!(t.neighbors[0], [cgal_sys::NONE; 4]);
/// ```
pub fn triangulate(points: &[[f64; 4]]) -> Result<Triangulation, Error> {
    let native = ffi::triangulate(points.as_flattened()).map_err(|e| Error(e.what().to_owned()))?;
    let rows = |flat: &[u32]| flat.chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect();
    Ok(Triangulation {
        cells: rows(native.cells().as_slice()),
        neighbors: rows(native.neighbors().as_slice()),
        hidden: native.hidden().as_slice().to_vec(),
    })
}
