//! What a sweep found: table, words, picture and page.

use std::fmt::Write as _;

use dempfv_report::format::three_digits;
use dempfv_report::markdown::{cell, table};

use super::choose::{Choice, order};
use super::errors::QUANTITIES;
use super::setting::Setting;
use super::study::Study;
use super::sweep::{Point, Sweep};

/// What the errors are, for every reader of a table.
pub const DEFINITIONS: &str = "Errors are relative: the root of the sum of squares of the differences to the \
reference, over 32 moments evenly spread in the window and all that is seen in each, over the root of the sum \
of squares of the reference itself. Seen are the pressure at up to 1,000 spheres (the mean of the pores around \
each, by volume), the displacement of each wall since the window began, prescribed ones too, what has left through all walls, and \
the stress on each wall; each at the time that it belongs to: pressures half a step before the positions that \
gave them, of which the contacts are; or a permeability. The *own* error is that of pressures (without fluid the larger of displacements and stresses) beside the same \
scene with the finest setting of the same knob, or with a network at each step where the knob is one of \
networks: what this knob alone does. Estimated is the error of pressures that a run with `[accuracy]` states of itself. A dash stands for what is not there, or is so little that two references with different solvers differ in it. Energy is what the balance misses \
over all that was moved, of the run itself. Time is wall time per model time, the median of up to three turns. \
A star: the own error is below what separates two references with different linear solvers.";

/// An error in the form of a table.
fn shown(error: Option<f64>) -> String {
    cell(error.filter(|e| e.is_finite()), |e| format!("{e:.1e}"))
}

fn row(point: &Point) -> Vec<String> {
    let mut cells = vec![format!("{}: {}", point.knob, point.setting)];
    if let Some(failed) = &point.failed {
        cells.push(format!("ended: {failed}"));
        cells.resize(11, String::new());
        return cells;
    }
    let star = if point.under_floor { " *" } else { "" };
    let own = Some(point.own.main());
    cells.push(point.seconds_per_second.show(1.0));
    cells.extend(point.errors.all().map(shown));
    cells.push(format!("{}{star}", shown(own)));
    cells.push(shown(point.estimate));
    cells.push(shown(point.energy));
    cells.push(format!("{} / {}", point.steps, point.networks));
    cells
}

/// The table of all points.
pub fn points_table(sweep: &Sweep, choices: &[Choice]) -> String {
    let [first, second, third, fourth, fifth] = QUANTITIES;
    let header = [
        "setting",
        "s per s",
        first,
        second,
        third,
        fourth,
        fifth,
        "own",
        "estimated",
        "energy",
        "steps / networks",
    ];
    let chosen = choices.iter().map(|choice| &choice.point);
    table(&header, std::iter::once(&sweep.scene).chain(&sweep.points).chain(chosen).map(row))
}

/// What the runs were.
pub fn about(study: &Study, sweep: &Sweep) -> String {
    if study.is_static {
        return format!(
            "{} spheres, stage `{}`: one permeability takes the place of a second. The reference solves to \
             1e-12 and bounds no conductance: {} s. With the other linear solver it is off by {}.\n",
            study.spheres,
            study.stage_name,
            three_digits(sweep.reference_seconds(1.0)),
            shown(Some(sweep.floor.main())),
        );
    }
    let reference = match study.is_wet() {
        true => "builds a network at each step, solves to 1e-12 and takes steps",
        false => "takes steps",
    };
    let whole = match study.whole {
        true => "to its end".to_owned(),
        false => format!(
            "for {} s, a window through which the reference took the time it was given; the rest is not \
             measured",
            three_digits(study.window)
        ),
    };
    let theory = match (sweep.reference.theory, sweep.scene.theory) {
        (Some(reference), Some(scene)) => format!(
            "\nBeside Terzaghi's theory the degree of consolidation is off by {} in the reference and by {} in the \
             scene as it is, at most in this window: what both have is the model's error, and no setting takes it \
             away.\n",
            three_digits(reference),
            three_digits(scene)
        ),
        _ => String::new(),
    };
    format!(
        "{} spheres, stage `{}` from its beginning {whole}: {} stable time steps of {} s. The reference \
         {reference} of {} of the stable one: {} s per \
         second of model time, {} steps. Another reference with the other linear solver is off by {}, one with steps \
         twice as long by {}: about as much is the reference itself off, and no smaller error is known.\n{theory}",
        study.spheres,
        study.stage_name,
        three_digits(study.window / study.limit),
        three_digits(study.limit),
        three_digits(study.reference_share),
        three_digits(sweep.reference_seconds(study.window)),
        sweep.reference.steps,
        shown(Some(sweep.floor.main())),
        shown(Some(sweep.step_floor.main())),
    )
}

/// What is recommended, in words.
pub fn words(choices: &[Choice], known: f64) -> String {
    let mut text = String::new();
    for choice in choices {
        let Choice { target, point, met, elsewhere, .. } = choice;
        let reached = if *met { "" } else { "not reached; the best found: " };
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "- {} %: {reached}{}; error {} %, {} times as fast as the reference, {} times the scene as it is",
            three_digits(100.0 * target),
            point.setting,
            three_digits(100.0 * point.error),
            three_digits(choice.faster_than_reference),
            three_digits(choice.faster_than_scene),
        );
        let _ = match elsewhere {
            Some(error) => writeln!(
                text,
                ". On spheres that were not used for choosing: {} %.",
                three_digits(100.0 * error)
            ),
            None => writeln!(text, "."),
        };
        if let Some(why) = &choice.not_elsewhere {
            let _ = writeln!(text, "- Not tried on other spheres: {why}.");
        }
    }
    if choices.iter().any(|c| c.target < known) {
        let _ = writeln!(
            text,
            "- The reference itself is known to {} % only: what meets a smaller target is as near to it as that, and \
             no nearer to the truth.",
            three_digits(100.0 * known)
        );
    }
    if choices.iter().any(|c| c.point.settings.iter().any(|s| matches!(s, Setting::TimeStep(_)))) {
        text += "- A `dt` chosen here is fixed, from the stable step when the window began: where a packing \
                 stiffens later, give `dt = \"auto\"` a `safety` of that share.\n";
    }
    text
}

/// Orders of convergence, in words.
pub fn orders(sweep: &Sweep) -> String {
    let floor = sweep.floor.main();
    let value = |setting: &Setting| match setting {
        Setting::Interval(steps) => Some(*steps as f64),
        Setting::TimeStep(share) => Some(*share),
        _ => None,
    };
    let of = |knob| order(&sweep.points, knob, floor, value);
    let known = ["remesh interval", "time step"].into_iter().filter_map(|k| Some((k, of(k)?)));
    let orders: Vec<String> =
        known.map(|(knob, order)| format!("with the {knob} to the power {order:.2}")).collect();
    if orders.is_empty() {
        return String::new();
    }
    format!(
        "Own errors grow {} (least squares over the logarithms, points above three times the floor).\n",
        orders.join(" and ")
    )
}

/// One row for each point.
pub fn csv(sweep: &Sweep, choices: &[Choice]) -> String {
    let mut text =
        "knob,setting,seconds_per_second,error,error_pressure,error_displacement,error_drained,\
                    error_stress,error_permeability,own_error,under_floor,estimated_error,energy,steps,networks,failed\n"
            .to_owned();
    let number =
        |v: Option<f64>| v.filter(|v| v.is_finite()).map_or(String::new(), |v| format!("{v:e}"));
    let quoted = |s: &str| format!("\"{}\"", s.replace('"', "\"\""));
    let chosen = choices.iter().map(|choice| &choice.point);
    for p in std::iter::once(&sweep.scene).chain(&sweep.points).chain(chosen) {
        let own = Some(p.own.main());
        let errors: Vec<String> = p.errors.all().map(number).to_vec();
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{},{},{},{},{}",
            p.knob,
            quoted(&p.setting),
            number(Some(p.seconds)),
            number(Some(p.error)),
            errors.join(","),
            number(own),
            p.under_floor,
            number(p.estimate),
            number(p.energy),
            p.steps,
            p.networks,
            quoted(p.failed.as_deref().unwrap_or_default()),
        );
    }
    text
}

/// A page that needs nothing beside itself.
pub fn html(title: &str, svg: &str, parts: &[String], sweep: &Sweep, choices: &[Choice]) -> String {
    let escaped = |s: &str| s.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let title = escaped(title);
    let mut body = format!("<h1>{title}</h1>\n{svg}\n");
    for part in parts {
        let lines: Vec<&str> = part.lines().filter(|line| !line.is_empty()).collect();
        if lines.iter().all(|line| line.starts_with("- ")) {
            let items = lines.iter().map(|l| format!("<li>{}</li>\n", escaped(&l[2..])));
            body += &format!("<ul>\n{}</ul>\n", items.collect::<String>());
        } else {
            body += &format!("<p>{}</p>\n", escaped(&lines.join(" ")));
        }
    }
    let text = points_table(sweep, choices);
    let rows = text.lines().enumerate().filter(|(i, line)| *i != 1 && line.starts_with('|'));
    body += "<table>\n";
    for (i, line) in rows {
        let tag = if i == 0 { "th" } else { "td" };
        let cells = line.trim_matches('|').split('|');
        let cells = cells.map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell.trim())));
        body += &format!("<tr>{}</tr>\n", cells.collect::<String>());
    }
    body += "</table>\n";
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title>\n<style>\
         body{{font:15px/1.5 sans-serif;max-width:70em;margin:2em auto;padding:0 1em;color:#262626}}\
         svg{{max-width:100%;height:auto}}table{{border-collapse:collapse;font-size:13px}}\
         td,th{{border-bottom:1px solid #ddd;padding:.2em .6em;text-align:right}}\
         td:first-child,th:first-child{{text-align:left}}</style></head>\n<body>\n{body}</body></html>\n"
    )
}
