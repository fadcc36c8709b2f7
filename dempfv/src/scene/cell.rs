//! `[cell]`: a periodic cell in the place of the box and its walls.

use serde::Serialize;

use super::kind::{Kind, Vector};
use super::schema::Schema;
use super::table::Value;
use super::wrong::Wrong;
use crate::dem::DemOptions;
use crate::domain::{Aabb, Cell, CellError, Vec3};
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

pub(super) static SCHEMA: Schema = Schema::table("[cell]", &["size", "edges"]);

const METRES: Vector = Vector("m");
const EDGES: &str = "three edges in m, as in [[1.0, 0.0, 0.0], [0.2, 1.0, 0.0], [0.0, 0.0, 1.0]]";

/// A periodic cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CellShape {
    /// By its edges.
    Edges(Cell),
    /// That of the packing file.
    OfPacking,
}

impl CellShape {
    /// Reads the table.
    pub(super) fn read(value: &Value) -> Result<CellShape> {
        let table = value.table(&SCHEMA)?;
        let made = |value: &Value, cell: std::result::Result<Cell, CellError>| {
            cell.map(CellShape::Edges).map_err(|error| value.wrong(no_cell(error)))
        };
        match (table.get("size"), table.get("edges")) {
            (None, None) => Ok(CellShape::OfPacking),
            (Some(size), None) => made(&size, Cell::of_size(METRES.read(&size)?)),
            (None, Some(edges)) => {
                let items = edges.items(EDGES)?;
                let [a, b, c] = items.as_slice() else {
                    let problem = format!("has {} edges", items.len());
                    return Err(edges.error(&problem, format!("give {EDGES}")));
                };
                made(&edges, Cell::new([METRES.read(a)?, METRES.read(b)?, METRES.read(c)?]))
            }
            (Some(size), Some(edges)) => {
                let later = if size.at > edges.at { size } else { edges };
                Err(later.error("is a second shape of the cell", "keep `size` or `edges`"))
            }
        }
    }

    /// Each key with its value as a scene has it.
    pub(super) fn write(&self) -> Vec<(&'static str, String)> {
        let CellShape::Edges(cell) = self else { return vec![] };
        let edges = cell.edges().map(|edge| METRES.write(&edge).unwrap_or_default());
        vec![("edges", format!("[{}]", edges.join(", ")))]
    }

    /// What is wrong with spheres of these radii (m) in the cell, as far as the scene has it.
    pub(super) fn wrong_with(&self, largest: f64, mean: f64) -> Option<Wrong> {
        let CellShape::Edges(cell) = self else { return None };
        too_small(cell, largest, mean)
    }

    /// A box of the cell's volume, and not much flatter than it: what a cloud finds room in. `None`
    /// where the packing file has the cell.
    pub(super) fn room(&self) -> Option<Aabb> {
        let CellShape::Edges(cell) = self else { return None };
        let heights = Vec3::from(cell.heights());
        let size = heights * (cell.volume() / heights.product()).cbrt();
        Some(Aabb { min: Vec3::zeros(), max: size })
    }
}

/// A cell in which two spheres of these radii (m) might meet twice.
pub(super) fn too_small(cell: &Cell, largest: f64, mean: f64) -> Option<Wrong> {
    let heights = cell.reduced().unwrap_or(*cell).heights();
    let height = heights.into_iter().fold(f64::INFINITY, f64::min);
    let skin = DemOptions::default().skin * mean;
    let least = 2.0 * (2.0 * largest + skin);
    let problem = format!(
        "is {height:.4e} m high between two faces, and spheres of {largest:.4e} m in radius need \
         {least:.4e} m: in less than four of them two may meet twice"
    );
    (height < least)
        .then(|| Wrong::new(problem, "take more spheres, smaller ones, or a larger cell"))
}

fn no_cell(error: CellError) -> Wrong {
    let text = error.to_string();
    let (what, remedy) = text.split_once("; ").unwrap_or((&text, EDGES));
    Wrong::new(format!("gives no cell: {what}"), remedy)
}
