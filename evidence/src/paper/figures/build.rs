//! Figures 6 and 7: what a remesh consists of.

use std::path::Path;

use dempfv_report::format::{count, three_digits};
use dempfv_report::markdown::{self, NOTHING, cell};
use dempfv_report::plot::Axis;

use super::{Device, UNKNOWNS, by_device};
use crate::Error;
use crate::paper::draw::{self, Curve};
use crate::paper::factored::Factored;
use crate::paper::measured::{Measured, Row};
use crate::paper::timing::Timing;

/// A part of a remesh: phase, its figure, its title, and the same with the BLAS on all cores.
type Part = (&'static str, &'static str, &'static str, fn(Factored) -> f64);

/// Figure 6: ordering and symbolic analysis (a), numeric factorization (b).
pub fn factor_section(measured: &Measured, folder: &Path) -> Result<String, Error> {
    let all = measured.all_cores();
    let blas = format!("CHOLMOD, BLAS on {all}");
    let mut text = "## Figure 6: analyze and factor, by device\n\n".to_owned();
    text += &format!(
        "Analyze is the ordering and the symbolic analysis, factor the numeric factorization. Beside \
         the default solver stands CHOLMOD, with METIS. In our runs its BLAS has one core, \
         whatever the number of threads, because OpenBLAS gives other bits with two; `{blas}` \
         shows what that costs.\n\n"
    );
    let parts: [Part; 2] = [
        ("analyze", "fig-6a", "Analyze", |f| f.analyze_s),
        ("factor", "fig-6b", "Factor", |f| f.factor_s),
    ];
    for (phase, file, title, shared) in parts {
        let mut curves = by_device(measured, |t| t.per_remesh(phase));
        let points = measured.over_unknowns(move |row| row.factored.map(shared));
        curves.push(Curve::new(&blas, points));
        let picture = draw::draw(title, "", Axis::log(UNKNOWNS), Axis::log("Time (s)"), &curves);
        text += &draw::save(folder, file, title, &picture)?;
        let further = |row: &Row| cell(row.factored, |f| three_digits(shared(f)));
        text += &format!("{title} (s):\n\n");
        text +=
            &device_table(measured, |t| three_digits(t.per_remesh(phase)), Some((&blas, &further)));
    }
    Ok(text)
}

/// A further column of a table by device: its title, and its cells.
pub type Column<'a> = (&'a str, &'a dyn Fn(&Row) -> String);

/// A value by size and device; the GPU's place is there even where no run has one.
pub fn device_table(
    measured: &Measured,
    show: impl Fn(&Timing) -> String,
    further: Option<Column>,
) -> String {
    let devices = Device::all(measured);
    let mut header = vec!["spheres".to_owned(), "unknowns".to_owned()];
    header.extend(devices.iter().map(|device| device.name(measured)));
    if measured.gpus().is_empty() {
        header.push("GPU".to_owned());
    }
    let width = header.len();
    header.extend(further.map(|(title, _)| title.to_owned()));
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let rows = measured.rows.iter().map(|row| {
        let mut cells = vec![row.name(), unknowns(row)];
        cells.extend(devices.iter().map(|device| cell(device.timing(row), &show)));
        cells.resize(width, NOTHING.to_owned());
        cells.extend(further.map(|(_, of)| of(row)));
        cells
    });
    markdown::table(&header, rows)
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
    text += &markdown::table(&header, rows);
    Ok(text)
}

/// The number of unknowns as a cell.
pub fn unknowns(row: &Row) -> String {
    cell(row.unknowns(), |n| count(n as u64))
}
