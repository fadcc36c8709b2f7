//! The section of the report.

use std::fmt::Write;
use std::path::Path;

use dempfv_report::format::{count, three_digits};
use dempfv_report::plot::{self, Axis, Mark, SERIES, Series};

use super::evidence::{Curves, Distance, Evidence};
use super::judge::Quantity;
use super::stat::{Stat, number};
use super::{Compared, Part};
use crate::Error;

/// Name of the figure.
const FIGURE: &str = "conductances";

const HEAD: &str = "\
## Static network

Both programs triangulate the same packing, put 1 Pa on the bottom and 0 on the top, and solve once with nothing \
moving. Pores are matched by their four vertices, throats by their two pores. Where the two differ, a program of its \
own (Python, 50 digits, from the published formulas; it shares no code with either) says which is off: it evaluates \
every throat of packings up to 2,500 spheres and solves for pressures and forces; in larger ones it evaluates the \
throats at the walls, and our solver takes these.
";

/// Writes the section; its figure goes into the folder.
///
/// # Errors
/// When the figure cannot be written.
pub fn section(part: &Part, folder: &Path) -> Result<String, Error> {
    let mut text = HEAD.to_owned();
    let packings = &part.packings;
    text += &overview(packings);
    for (clamp, title) in [(false, "Without a clamp"), (true, "With YADE's clamp")] {
        let _ =
            write!(text, "\n{title}, largest / median difference of slip and no-slip walls:\n\n");
        text += &differences(packings, clamp);
    }
    text += WALLS;
    text += &walls(packings);
    if let Some(curves) = packings.iter().flat_map(|p| &p.evidence).find_map(|e| e.curves.as_ref())
    {
        draw(curves, &packings[0].name, folder)?;
        let _ = write!(text, "\n![Conductances at walls]({FIGURE}.png)\n");
    }
    text += &solver(packings);
    text += CLAMP;
    text += &clamp(part);
    text += CORNERS;
    text += &corners(packings);
    text += &porosity(packings);
    Ok(text)
}

/// Pores, and how near both programs are to the second evaluation.
pub fn headline(packings: &[Compared]) -> Option<String> {
    let all = || packings.iter().flat_map(|p| &p.evidence);
    let worst = |of: fn(&Evidence) -> &Distance, value: fn(&Distance) -> f64| {
        number(all().map(|e| value(of(e))).fold(0.0, f64::max))
    };
    let ours = |value| worst(|e| &e.ours_planes, value);
    let theirs = |value| worst(|e| &e.theirs_planes, value);
    let (p, f, q): (Cell<f64>, Cell<f64>, Cell<f64>) =
        (|d| d.pressure.largest, |d| d.force.largest, |d| d.flux);
    let pores: usize = packings.iter().map(|p| p.pores).sum();
    let differing: usize = packings.iter().map(|p| p.differing.count).sum();
    all().next()?;
    Some(format!(
        "network: {differing} of {} pores differ; of the pressures, forces and fluxes that an evaluation at 50 \
         digits finds, ours are off by {}, {} and {}, YADE's by {}, {} and {}",
        count(pores as u64),
        ours(p),
        ours(f),
        ours(q),
        theirs(p),
        theirs(f),
        theirs(q)
    ))
}

const WALLS: &str = "
### Walls

Ours are planes. YADE's are spheres of radius 50000 H, H being the extent of the spheres along y; it takes the pore centres from them, relative to a pore's first \
vertex, and where that is such a sphere nine digits are lost. Slip walls, no clamp; largest / median:

";

const CLAMP: &str = "
### YADE's clamp

It compares conductances (m³/(Pa·s)) with K = mean length × fluid volume / (8 μ × solid surface), in m²/(Pa·s). So \
what it clamps depends on the unit of length; k/L² of one packing, L its height:

";

const CORNERS: &str = "
### Corner pores

YADE leaves out what the eight corner pores push on their spheres. Forces on these spheres over the mean force, and \
all forces along the flow (YADE's with our forces on walls) over area × pressure difference, which must cancel but for \
the sphere segments that reach past an edge. Slip walls, no clamp:

";

fn table(header: &[String], rows: &[Vec<String>]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let rule = vec!["---".to_owned(); header.len()];
    line(header) + &line(&rule) + &rows.iter().map(|row| line(row)).collect::<String>()
}

fn strings(cells: &[&str]) -> Vec<String> {
    cells.iter().map(|&c| c.to_owned()).collect()
}

fn overview(packings: &[Compared]) -> String {
    let header = [
        "packing",
        "spheres",
        "pores",
        "throats",
        "pores that differ",
        "centres",
        "volumes",
        "imposed differently",
    ];
    let row = |p: &Compared| {
        vec![
            p.name.clone(),
            count(p.spheres as u64),
            count(p.pores as u64),
            count(p.throats as u64),
            count(p.differing.count as u64),
            p.geometry.center.cell(),
            p.geometry.volume.cell(),
            p.geometry.imposed.to_string(),
        ]
    };
    let rows: Vec<_> = packings.iter().map(row).collect();
    let mut text = format!("\n{}", table(&strings(&header), &rows));
    text += "\nCentres (over the box's edge) and volumes are those of pores without walls, largest / median.";
    let exact = packings.iter().map(|p| p.our_volume).filter(|s| s.count > 0);
    if let Some(worst) = exact.max_by(|a, b| a.largest.total_cmp(&b.largest)) {
        let off = number(worst.largest);
        let _ = write!(
            text,
            " All our volumes, those at walls too, are within {off} of the 50 digits."
        );
    }
    text += "\n";
    for p in packings.iter().filter(|p| p.differing.count > 0) {
        let why = p.differing.explanation().unwrap_or_else(|| {
            format!("{} of ours have no fifth vertex near their sphere", p.differing.unexplained)
        });
        let _ = write!(text, "\n{}: {why}. The first ones: {:?}.\n", p.name, p.differing.pores);
    }
    for p in packings.iter().filter(|p| p.doubtful > 0) {
        let _ = write!(
            text,
            "\n{}: in {} throats two spheres reach past an edge, and only the first of them counts.\n",
            p.name, p.doubtful
        );
    }
    text
}

fn differences(packings: &[Compared], clamp: bool) -> String {
    let mut header = strings(&["", "bound"]);
    header.extend(packings.iter().map(|p| p.name.clone()));
    let row = |quantity: Quantity| {
        let mut row = vec![quantity.name().to_owned(), number(quantity.bound())];
        row.extend(packings.iter().map(|p| {
            let flows = p.flows.iter().filter(|f| f.case.clamp == clamp);
            let stats = flows.map(|f| quantity.stat(f));
            let worst = stats.max_by(|a, b| a.largest.total_cmp(&b.largest));
            worst.map_or(String::new(), |s| mark(&s, quantity))
        }));
        row
    };
    table(&header, &Quantity::ALL.map(row))
}

/// A cell, bold where the bound is not kept.
fn mark(stat: &Stat, quantity: Quantity) -> String {
    if stat.largest <= quantity.bound() { stat.cell() } else { format!("**{}**", stat.cell()) }
}

fn walls(packings: &[Compared]) -> String {
    let header = [
        "",
        "",
        "ours − planes",
        "YADE − planes",
        "spheres − planes, exact",
        "YADE − spheres",
        "spheres in double precision − exact",
    ];
    let mut rows = vec![];
    for p in packings {
        let Some(evidence) = p.evidence.iter().find(|e| e.case.slip && !e.case.clamp) else {
            continue;
        };
        for (name, cell) in CELLS {
            let mut row = vec![p.name.clone(), (*name).to_owned()];
            row.extend(columns(evidence).map(cell));
            rows.push(row);
        }
    }
    table(&strings(&header), &rows)
}

/// Something of a distance.
type Cell<T> = fn(&Distance) -> T;
const CELLS: &[(&str, Cell<String>)] = &[
    ("conductances without walls, at a pore with a wall", |d| d.conductance.beside.cell()),
    ("conductances of throats with walls", |d| d.conductance.at_walls.cell()),
    ("pressures", |d| d.pressure.cell()),
    ("forces", |d| d.force.cell()),
    ("flux", |d| number(d.flux)),
];

fn columns(e: &Evidence) -> [&Distance; 5] {
    [&e.ours_planes, &e.theirs_planes, &e.spheres_planes, &e.theirs_spheres, &e.double_spheres]
}

fn solver(packings: &[Compared]) -> String {
    let of = |value: fn(&Evidence) -> f64| {
        packings.iter().flat_map(|p| &p.evidence).map(value).fold(0.0, f64::max)
    };
    let pressure = of(|e| e.theirs_solver.pressure.largest);
    let flux = of(|e| e.theirs_solver.flux);
    format!(
        "\nYADE's solver is not the cause: from YADE's own conductances our solver finds its pressures to {} of the \
         imposed difference and its fluxes to {}.\n",
        number(pressure),
        number(flux)
    )
}

fn clamp(part: &Part) -> String {
    let header = [
        "unit of length",
        "YADE, no clamp",
        "YADE, its clamp",
        "ours, no clamp",
        "ours, relative clamp",
        "ours, YADE's clamp",
    ];
    let row = |scale: &super::Scale| {
        let mut row = vec![format!("H = {}", three_digits(scale.height))];
        let [none, relative, yade] = scale.ours;
        let values = [scale.their_free, scale.their_clamped, none, relative, yade];
        row.extend(values.map(|k| format!("{k:.5e}")));
        row
    };
    let rows: Vec<_> = part.scales.iter().map(row).collect();
    format!("{}\n({})\n", table(&strings(&header), &rows), part.scaled)
}

fn corners(packings: &[Compared]) -> String {
    let header = [
        "",
        "YADE − ours",
        "the same with the push",
        "ours, sum of all",
        "less the segments",
        "YADE's, sum of all",
        "the same with the push",
    ];
    let row = |p: &Compared| {
        let flow = p.flows.iter().find(|f| f.case.slip && !f.case.clamp)?;
        let exact = p.evidence_for(flow).and_then(|e| e.our_balance);
        let b = flow.balance;
        Some(vec![
            p.name.clone(),
            flow.corner_force.cell(),
            flow.corner_force_less_push.cell(),
            number(b.ours),
            exact.map_or_else(|| "–".to_owned(), number),
            number(b.theirs),
            number(b.theirs_with_push),
        ])
    };
    let rows: Vec<_> = packings.iter().filter_map(row).collect();
    table(&strings(&header), &rows)
}

fn porosity(packings: &[Compared]) -> String {
    let mut text = "\n### Porosity\n\nWhat YADE's `flow.porosity` says after the first step, in four runs, one for \
                    each setting: it is not set yet, and whatever was in memory is shown.\n\n"
        .to_owned();
    let header = ["", "1 − solid / box", "YADE"];
    let rows: Vec<_> = (packings.iter())
        .map(|p| {
            let theirs: Vec<&str> = p.flows.iter().map(|f| f.their_porosity.as_str()).collect();
            vec![p.name.clone(), format!("{:.6}", p.porosity), theirs.join(", ")]
        })
        .collect();
    text += &table(&strings(&header), &rows);
    text
}

/// How many of the throats at walls are off by less than what.
fn draw(curves: &Curves, packing: &str, folder: &Path) -> Result<(), Error> {
    let lines = [
        ("ours − planes", &curves.ours_planes),
        ("spheres in double precision − exact", &curves.double_spheres),
        ("YADE − spheres", &curves.theirs_spheres),
        ("spheres − planes, exact", &curves.spheres_planes),
        ("YADE − planes", &curves.theirs_planes),
    ];
    let share: Vec<f64> = (0..=100).map(f64::from).collect();
    let series: Vec<Series> = (lines.iter().zip(SERIES))
        .map(|((name, x), color)| Series {
            name: Some((*name).to_owned()),
            x,
            y: &share[..x.len().min(share.len())],
            color,
            mark: Mark::Line { width: 1.6, dash: None },
        })
        .collect();
    let caption = format!("{packing}, slip walls, no clamp; planes and spheres at 50 digits");
    let x = Axis::log("Relative difference");
    let y = Axis::linear("Throats that are nearer (%)").spanning(0.0, 100.0);
    plot::xy("Conductances at walls", &caption, x, y, &series).save(folder, FIGURE)?;
    Ok(())
}
