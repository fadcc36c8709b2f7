//! Figures 6 and 7: what a remesh consists of.

use std::path::Path;

use super::{Device, UNKNOWNS, by_device, device_header};
use crate::commands::Error;
use crate::commands::format::{count, three_digits};
use crate::commands::paper::draw::{self, Curve, NOTHING, cell};
use crate::commands::paper::measured::{Measured, Row};
use crate::commands::paper::timing::Timing;
use crate::report::plot::Axis;

/// Figure 6: ordering and symbolic analysis (a), numeric factorization (b).
pub fn factor_section(measured: &Measured, folder: &Path) -> Result<String, Error> {
    let mut text = "## Figure 6: analyze and factor, by device\n\n".to_owned();
    text += "Analyze is METIS and the symbolic analysis, which CHOLMOD does on one core. Factor is \
             CHOLMOD's supernodal factorization; its BLAS runs on one core, whatever the number of \
             threads, because OpenBLAS gives other bits with two.\n\n";
    for (phase, file, title) in [("analyze", "fig-6a", "Analyze"), ("factor", "fig-6b", "Factor")] {
        let curves = by_device(measured, |t| t.per_remesh(phase));
        let picture = draw::draw(title, "", Axis::log(UNKNOWNS), Axis::log("Time (s)"), &curves);
        text += &draw::save(folder, file, title, &picture)?;
        text += &format!("{title} (s):\n\n");
        text += &device_table(measured, |t| t.per_remesh(phase));
    }
    Ok(text)
}

/// A value by size and device, three digits each.
pub fn device_table(measured: &Measured, value: impl Fn(&Timing) -> f64) -> String {
    let header = device_header(measured);
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let devices = Device::all(measured);
    let rows = measured.rows.iter().map(|row| {
        let mut cells = vec![row.name(), unknowns(row)];
        cells.extend(
            devices.iter().map(|d| cell(d.timing(row), |timing| three_digits(value(timing)))),
        );
        cells.resize(header.len(), NOTHING.to_owned());
        cells
    });
    draw::table(&header, rows)
}

/// Figure 7: allocate and build.
pub fn build_section(measured: &Measured, folder: &Path) -> Result<String, Error> {
    let title = "Network and operators";
    let all = measured.all_cores();
    let curve = |name: String, value: &dyn Fn(&Row) -> Option<f64>| {
        let points: Vec<_> = measured.over_unknowns(value).collect();
        Curve::new(name, points)
    };
    let curves = [
        curve("network, 1 core".into(), &|row| Some(row.built[0]?.network_s)),
        curve(format!("network, {all}"), &|row| Some(row.built[1]?.network_s)),
        curve("operators, 1 core".into(), &|row| Some(row.built[0]?.operators_s)),
        curve(format!("operators, {all}"), &|row| Some(row.built[1]?.operators_s)),
    ];
    let picture = draw::draw(title, "", Axis::log(UNKNOWNS), Axis::log("Time (s)"), &curves);
    let mut text = "## Figure 7: allocate and build\n\n".to_owned();
    text += "The paper times the allocation of a new network and matrix, and their construction. \
             Ours allocates while it builds, so its two parts are cut elsewhere: the network \
             (triangulation, pores, throats, conductances) and the sparse operators G, E and F.\n\n";
    text += &draw::save(folder, "fig-7", title, &picture)?;
    let heads = ["network, 1 core (s)", "operators, 1 core (s)"].map(str::to_owned);
    let header = [
        "spheres".to_owned(),
        "unknowns".to_owned(),
        heads[0].clone(),
        format!("network, {all} (s)"),
        heads[1].clone(),
        format!("operators, {all} (s)"),
    ];
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let rows = measured.rows.iter().map(|row| {
        let [one, many] = row.built;
        vec![
            row.name(),
            unknowns(row),
            cell(one, |b| three_digits(b.network_s)),
            cell(many, |b| three_digits(b.network_s)),
            cell(one, |b| three_digits(b.operators_s)),
            cell(many, |b| three_digits(b.operators_s)),
        ]
    });
    text += &draw::table(&header, rows);
    Ok(text)
}

/// The number of unknowns as a cell.
pub fn unknowns(row: &Row) -> String {
    cell(row.unknowns(), |n| count(n as u64))
}
