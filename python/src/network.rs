//! `dempfv.Network`.

use std::sync::Mutex;

use dempfv::pfv::{Boundary, Flow, Fluid, Network};
use dempfv::solver::SolverKind;
use dempfv::theory::{kozeny_carman, sauter_diameter};
use dempfv::{Error, InputError, PerWall, WallId};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{numbers, rows, vectors};
use crate::errors::{raised, refused, wrong};
use crate::packing::PyPacking;
use crate::shared::lock;

/// The pore network of a packing, and static flows through it.
///
/// Parameters
/// ----------
/// packing : Packing
/// viscosity : float
///     Dynamic viscosity (Pa s).
/// slip : bool
///     Whether the fluid slips along walls without imposed pressure.
/// clamp : {"none", "relative", "unlimited", "yade"}
///     Bounds on the conductances, as in scenes.
/// solver : str
///     As in scenes.
///
/// Raises
/// ------
/// InputError
///     For an argument that makes no sense.
/// SimulationError
///     Where the packing has no network.
///
/// Notes
/// -----
/// Arrays have a row per pore, throat or sphere; spheres are in the order of the packing. All are
/// copies.
///
/// Examples
/// --------
/// >>> import dempfv as dp
/// >>> network = dp.Network(dp.pack(50, edge=0.01), viscosity=1e-3)
/// >>> pressure = network.solve({"y_min": 1.0, "y_max": 0.0})
/// >>> bool(0.0 <= pressure.min() and pressure.max() <= 1.0)
/// True
/// >>> bool(abs(network.flux["y_min"] + network.flux["y_max"]) < 1e-9 * network.flux["y_min"])
/// True
/// >>> 1e-9 < network.permeability("y") < 1e-7
/// True
#[pyclass(frozen, module = "dempfv", name = "Network")]
pub struct PyNetwork {
    packing: Py<PyPacking>,
    fluid: Fluid,
    solver: SolverKind,
    network: Network,
    /// Of the last solve.
    flow: Mutex<Option<Flow>>,
}

impl PyNetwork {
    /// Solves the static flow under these pressures of walls (Pa).
    fn solved(&self, py: Python<'_>, pressure: PerWall<Option<f64>>) -> PyResult<Flow> {
        let before = lock(&self.flow).take();
        let same_walls = |flow: &Flow| {
            let imposed = |p: &PerWall<Option<f64>>| p.map(Option::is_some);
            imposed(&flow.fluid().boundary.pressure) == imposed(&pressure)
        };
        let usable = before.filter(same_walls);
        let packing = self.packing.get();
        crate::threads::start(py)?;
        let solve = || -> Result<Flow, Error> {
            let boundary = Boundary { pressure, ..self.fluid.boundary };
            let fluid = Fluid { boundary, ..self.fluid };
            let (x, r) = (&packing.position, &packing.radius);
            let mut flow = match usable {
                Some(flow) => flow,
                None => Flow::new(x, r, packing.bounds, &fluid, self.solver)?,
            };
            for (wall, pressure) in pressure.iter() {
                if let Some(pressure) = pressure {
                    flow.set_wall_pressure(wall, *pressure)?;
                }
            }
            flow.solve_static()?;
            Ok(flow)
        };
        py.detach(|| rayon::scope(|_| solve())).map_err(|e| raised(py, e))
    }

    fn of_flow<T>(&self, py: Python<'_>, look: impl FnOnce(&Flow) -> T) -> PyResult<T> {
        let seen = lock(&self.flow).as_ref().map(look);
        let message = "no flow has been solved; call solve with pressures of walls";
        seen.ok_or_else(|| refused(py, message))
    }
}

/// Pressures of walls from a dict of names and numbers.
fn by_wall(pressure: &Bound<'_, PyDict>) -> PyResult<PerWall<Option<f64>>> {
    let py = pressure.py();
    let mut all = PerWall::default();
    for (name, value) in pressure {
        let name: String = name.extract().map_err(|_| {
            wrong(py, "the name of a wall is no text", "the walls are x_min to z_max")
        })?;
        let wall: Result<WallId, _> = name.parse();
        let wall = wall.map_err(|e| wrong(py, e.to_string(), ""))?;
        let value = value.extract::<f64>().ok().filter(|p| p.is_finite());
        let finite = || wrong(py, format!("the pressure of {name} is no finite number"), "give Pa");
        all[wall] = Some(value.ok_or_else(finite)?);
    }
    match all.values().any(Option::is_some) {
        true => Ok(all),
        false => Err(wrong(py, "no pressure is imposed", "give that of a wall, or of several")),
    }
}

#[pymethods]
impl PyNetwork {
    #[new]
    #[pyo3(signature = (packing, *, viscosity=1e-3, slip=true, clamp="none", solver="auto"))]
    fn new(
        py: Python<'_>,
        packing: Py<PyPacking>,
        viscosity: f64,
        slip: bool,
        clamp: &str,
        solver: &str,
    ) -> PyResult<PyNetwork> {
        let named = |e: &dyn std::fmt::Display| raised(py, InputError::new(e.to_string(), ""));
        if !(viscosity > 0.0 && viscosity.is_finite()) {
            let what = format!("the viscosity {viscosity} is not positive");
            return Err(wrong(py, what, "give Pa s; water has 1e-3"));
        }
        let clamp = clamp.parse().map_err(|e: dempfv::pfv::UnknownClamp| named(&e))?;
        let solver = solver.parse().map_err(|e: dempfv::solver::UnknownSolver| named(&e))?;
        let boundary = Boundary::default();
        let fluid = Fluid { viscosity, slip_walls: slip, clamp, boundary };
        crate::threads::start(py)?;
        let built = py.detach(|| {
            let PyPacking { position, radius, bounds } = packing.get();
            rayon::scope(|_| Network::new(position, radius, *bounds, &fluid))
        });
        let (network, _) = built.map_err(|e| raised(py, e))?;
        Ok(PyNetwork { packing, fluid, solver, network, flow: Mutex::new(None) })
    }

    /// Solves the flow of the fluid between spheres and walls at rest.
    ///
    /// Parameters
    /// ----------
    /// pressure : dict
    ///     Pressures (Pa) by wall, ``{"y_max": 0.0, ...}``; walls that are not named let nothing through.
    ///
    /// Returns
    /// -------
    /// array of shape (n,)
    ///     The pressure of each pore (Pa).
    ///
    /// Raises
    /// ------
    /// InputError
    ///     For an unknown wall, no pressure, or one that is not finite.
    /// SimulationError
    ///     Where the solver fails.
    fn solve<'py>(
        &self,
        py: Python<'py>,
        pressure: &Bound<'py, PyDict>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let flow = self.solved(py, by_wall(pressure)?)?;
        let values = flow.pressure().to_vec();
        *lock(&self.flow) = Some(flow);
        Ok(numbers(py, values))
    }

    /// Intrinsic permeability along an axis (m²): by a flow at 1 Pa from the lower wall to the upper one,
    /// nothing through the others.
    ///
    /// Parameters
    /// ----------
    /// axis : {"x", "y", "z"}
    ///
    /// Returns
    /// -------
    /// float
    ///
    /// Raises
    /// ------
    /// InputError
    ///     For another axis, and a packing through which nothing flows.
    fn permeability(&self, py: Python<'_>, axis: &str) -> PyResult<f64> {
        let lower = match axis {
            "x" => WallId::XMin,
            "y" => WallId::YMin,
            "z" => WallId::ZMin,
            _ => return Err(wrong(py, format!("no axis `{axis}`"), "the axes are x, y, z")),
        };
        let mut pressure = PerWall::default();
        pressure[lower] = Some(1.0);
        pressure[lower.opposite()] = Some(0.0);
        let flow = self.solved(py, pressure)?;
        let measured = flow.permeability(lower).map(|k| k.value);
        *lock(&self.flow) = Some(flow);
        measured.ok_or_else(|| wrong(py, "no flow to measure", "give a packing with pores"))
    }

    /// Kozeny and Carman's estimate of the permeability (m²), with the constant 180.
    #[getter]
    fn kozeny_carman(&self) -> f64 {
        let packing = self.packing.get();
        kozeny_carman(packing.porosity(), sauter_diameter(&packing.radius))
    }

    /// The packing.
    #[getter]
    fn packing(&self, py: Python<'_>) -> Py<PyPacking> {
        self.packing.clone_ref(py)
    }

    /// Pressures of the last flow (Pa), shape (n,).
    #[getter]
    fn pressure<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(numbers(py, self.of_flow(py, |flow| flow.pressure().to_vec())?))
    }

    /// Its flux through each wall (m³/s), positive into the box: a dict by wall.
    #[getter]
    fn flux<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let flux = self.of_flow(py, Flow::flux)?;
        let dict = PyDict::new(py);
        WallId::ALL.into_iter().try_for_each(|w| dict.set_item(w.name(), flux[w.index()]))?;
        Ok(dict)
    }

    /// Its force on each sphere (N), shape (spheres, 3).
    #[getter]
    fn force<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        Ok(vectors(py, &self.of_flow(py, |flow| flow.force().to_vec())?))
    }

    /// Power centres of the pores (m), shape (n, 3), where conductances are measured from. They may lie
    /// outside of their pores.
    #[getter]
    fn center<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        vectors(py, &self.network.center)
    }

    /// Middles of the pores' volumes (m), shape (n, 3).
    #[getter]
    fn centroid<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let packing = self.packing.get();
        let centroids = self.network.centroids(&packing.position, &packing.bounds);
        Ok(vectors(py, &centroids.map_err(|e| raised(py, e))?))
    }

    /// Signed volumes of the pores (m³), solids included, shape (n,).
    #[getter]
    fn volume<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        numbers(py, self.network.volume.clone())
    }

    /// Volumes of the void in the pores (m³), shape (n,).
    #[getter]
    fn void_volume<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let PyPacking { position, radius, .. } = self.packing.get();
        let void = self.network.void_volumes(position, radius);
        Ok(numbers(py, void.map_err(|e| raised(py, e))?))
    }

    /// The four vertices of each pore, shape (n, 4): spheres of the packing; a number of m + k, with m
    /// spheres, is a wall, k counting ``x_min`` to ``z_max``.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        rows(py, &self.network.tessellation.cells)
    }

    /// The pore across the facet opposite each vertex, shape (n, 4); ``dempfv.NONE`` where there is none.
    #[getter]
    fn neighbors<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        rows(py, &self.network.tessellation.neighbors)
    }

    /// The two pores of each throat, the smaller number first, shape (m, 2).
    #[getter]
    fn throats<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        rows(py, &self.network.throats.pores)
    }

    /// Conductances of the throats (m³/(Pa s)), shape (m,).
    #[getter]
    fn conductance<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        numbers(py, self.network.throats.conductance.clone())
    }

    /// What is out of the ordinary in the network, a sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.network.remarks.warnings()
    }

    /// The network as a dict with the names of OpenPNM: ``pore.coords`` (centroids), ``pore.center``,
    /// ``pore.volume`` (void), ``throat.conns``, ``throat.conductance``, the same as
    /// ``throat.hydraulic_conductance``, and labels of pores at walls, ``pore.x_min`` to ``pore.z_max``.
    ///
    /// Examples
    /// --------
    /// >>> import dempfv as dp
    /// >>> network = dp.Network(dp.pack(50, edge=0.01)).to_openpnm()
    /// >>> network["throat.conns"].shape[0] == network["throat.conductance"].shape[0]
    /// True
    fn to_openpnm<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("dempfv._network")?.call_method1("to_openpnm", (slf,))
    }

    /// The matrix G of the balance of all pores (m³/(Pa s)), a ``scipy.sparse.csr_array`` of shape (n, n):
    /// G p is what leaves each pore through its throats. Nothing is imposed in it, so that it is singular.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     Where scipy is not installed.
    ///
    /// Examples
    /// --------
    /// >>> import dempfv as dp
    /// >>> g = dp.Network(dp.pack(50, edge=0.01)).to_scipy()
    /// >>> bool(abs(g.sum(axis=1)).max() < 1e-12 * abs(g).max())
    /// True
    fn to_scipy<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("dempfv._network")?.call_method1("to_scipy", (slf,))
    }

    /// The network as a ``networkx.Graph``: nodes have ``center`` and ``volume``, edges ``conductance``.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     Where networkx is not installed.
    fn to_networkx<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("dempfv._network")?.call_method1("to_networkx", (slf,))
    }

    /// The network as a ``pyvista.PolyData``: points are the centroids of the pores, lines the throats,
    /// with ``volume``, ``conductance`` and, of the last flow, ``pressure``.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     Where pyvista is not installed.
    fn to_pyvista<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("dempfv._network")?.call_method1("to_pyvista", (slf,))
    }

    fn __len__(&self) -> usize {
        self.network.pores()
    }

    fn __repr__(&self) -> String {
        let (pores, throats) = (self.network.pores(), self.network.throats.pores.len());
        let spheres = self.packing.get().radius.len();
        format!("<dempfv.Network: {pores} pores and {throats} throats between {spheres} spheres>")
    }
}
