//! Conductances that the user chooses for each network that is built.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

use dempfv::coupling::{CouplingError, NetworkBuilder, NetworkRequest, StandardBuilder};
use dempfv::pfv::{ConductanceRegion, Flow, Network, PfvError, PoreSelection};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

use crate::arrays::{numbers, read, rows, vectors};
use crate::errors::wrong;
use crate::shared::lock;

/// A function of the pores of a new network, and what it raised last.
pub struct RemeshHook {
    pub function: Py<PyAny>,
    raised: Mutex<Option<PyErr>>,
}

/// Builds networks with the conductances that it says.
pub struct HookedBuilder(pub Arc<RemeshHook>);

impl RemeshHook {
    pub fn new(function: &Bound<'_, PyAny>) -> Arc<RemeshHook> {
        let (function, raised) = (function.clone().unbind(), Mutex::new(None));
        Arc::new(RemeshHook { function, raised })
    }

    /// What the function has raised, once.
    pub fn take_raised(&self) -> Option<PyErr> {
        lock(&self.raised).take()
    }

    /// The factor of each pore.
    fn factors(
        &self,
        py: Python<'_>,
        request: &NetworkRequest,
        network: &Network,
    ) -> PyResult<Vec<f64>> {
        let centroid = network.centroids(&request.position, &request.bounds);
        let centroid = centroid.map_err(|e| crate::errors::raised(py, e))?;
        let keys: Bound<'_, PyDict> = [
            ("center", vectors(py, &network.center).into_any()),
            ("centroid", vectors(py, &centroid).into_any()),
            ("volume", numbers(py, network.volume.clone()).into_any()),
            ("vertices", rows(py, &network.tessellation.cells).into_any()),
        ]
        .into_py_dict(py)?;
        let pores = py.import("types")?.getattr("SimpleNamespace")?.call((), Some(&keys))?;
        let returned = self.function.bind(py).call1((pores,))?;
        if returned.is_none() {
            return Ok(vec![1.0; network.pores()]);
        }
        let (factors, shape) = read(&returned)?;
        if shape != [network.pores()] {
            let what = format!("factors of shape {shape:?} for {} pores", network.pores());
            return Err(wrong(py, what, "return one factor per pore"));
        }
        match factors.iter().position(|f| !(*f >= 0.0 && f.is_finite())) {
            None => Ok(factors),
            Some(k) => {
                let what = format!("the factor of pore {k} is {}", factors[k]);
                Err(wrong(py, what, "return 0 for a pore that is blocked, else a positive number"))
            }
        }
    }

    fn choose(&self, request: &mut NetworkRequest) -> Result<(), CouplingError> {
        let refused = |problem: &str| PfvError::InvalidInput {
            argument: "conductances",
            index: None,
            problem: problem.to_owned(),
        };
        if request.cell.is_some() {
            return Err(refused("cannot be chosen in a periodic cell; put walls around").into());
        }
        let NetworkRequest { position, radius, bounds, fluid, .. } = &*request;
        let (network, _) = Network::new(position, radius, *bounds, fluid)?;
        let said = Python::attach(|py| self.factors(py, request, &network));
        let factors = said.map_err(|error| {
            *lock(&self.raised) = Some(error);
            refused("were not chosen: the function failed")
        })?;
        let mut blocked = vec![];
        let mut regions: BTreeMap<u64, Vec<u32>> = BTreeMap::new();
        for (pore, factor) in (0u32..).zip(&factors).filter(|(_, factor)| **factor != 1.0) {
            match *factor > 0.0 {
                true => regions.entry(factor.to_bits()).or_default().push(pore),
                false => blocked.push(pore),
            }
        }
        let rules = &mut request.effects.conductances;
        if !blocked.is_empty() {
            rules.blocked.push(PoreSelection::Pores(blocked));
        }
        rules.regions.extend(regions.into_iter().map(|(bits, pores)| ConductanceRegion {
            pores: PoreSelection::Pores(pores),
            factor: f64::from_bits(bits),
        }));
        Ok(())
    }
}

impl NetworkBuilder for HookedBuilder {
    fn build(
        &self,
        mut request: NetworkRequest,
        cancelled: &AtomicBool,
    ) -> Result<Option<Flow>, CouplingError> {
        self.0.choose(&mut request)?;
        StandardBuilder.build(request, cancelled)
    }
}
