//! A pore: its centre, its volume and how the volume changes when the
//! vertices move.

use nalgebra::Matrix3;

use super::frame::{FACETS, Frame, Vertex};
use crate::{Vec3, WallId};

/// A pore is flat below this ratio of its equations' determinant to their sizes: the motion of a
/// sphere by so much of the pore's size would move its centre by all of it. Any lattice has
/// such pores, between spheres in a square; and where spheres stand in rows, the bulge of the walls in
/// the triangulation lets it find pores that are flat between planes.
pub(super) const FLAT: f64 = 1e-5;
/// Directions that the equations of a flat pore tell less about than this are left open.
const UNKNOWN: f64 = 3.162_277_660_168_379_5e-3;

/// Centre, volume and volume gradient of one pore.
pub(super) struct Pore {
    /// Power centre; for a pore with walls the limit of planes, which lies on
    /// the walls at equal power to the pore's spheres (m).
    pub center: Vec3,
    /// Signed volume (m³).
    pub volume: f64,
    /// Derivative of the volume with respect to each vertex (m²). For a wall
    /// only the component along its axis is not zero.
    pub gradient: [Vec3; 4],
}

/// Where the spheres and walls of a cell stand among its four vertices.
struct Roles {
    spheres: [(usize, Vec3, f64); 4],
    count: usize,
    walls: [(usize, WallId); 3],
    /// Centre of the sphere at each vertex; unused where a wall stands.
    at: [Vec3; 4],
}

impl Pore {
    /// Evaluates a cell. `None` if it has no sphere or two opposite walls.
    pub fn new(frame: &Frame, cell: [u32; 4]) -> Option<Pore> {
        let roles = Roles::new(frame, cell)?;
        let (volume, gradient) = roles.shape(frame);
        Some(Pore { center: power_center(frame, &roles), volume, gradient })
    }

    /// The volume alone (m³), with the same bits; not a number where [`Pore::new`] has none.
    pub fn volume(frame: &Frame, cell: [u32; 4]) -> f64 {
        if frame.are_spheres(&cell) {
            let [a, b, c, d] = cell.map(|v| frame.x[v as usize]);
            return ((c - b).cross(&(d - b)) / -6.0).dot(&(a - b));
        }
        Roles::new(frame, cell).map_or(f64::NAN, |roles| roles.shape(frame).0)
    }
}

impl Roles {
    fn new(frame: &Frame, cell: [u32; 4]) -> Option<Roles> {
        let mut roles = Roles {
            spheres: [(0, Vec3::zeros(), 0.0); 4],
            count: 0,
            walls: [(0, WallId::XMin); 3],
            at: [Vec3::zeros(); 4],
        };
        let mut n_walls = 0;
        for (k, v) in cell.into_iter().enumerate() {
            match frame.vertex(v) {
                Vertex::Sphere { x, r } => {
                    roles.spheres[roles.count] = (k, x, r);
                    roles.at[k] = x;
                    roles.count += 1;
                }
                Vertex::Wall(wall) => {
                    let fits = n_walls < 3
                        && roles.walls[..n_walls].iter().all(|(_, w)| w.axis() != wall.axis());
                    if !fits {
                        return None;
                    }
                    roles.walls[n_walls] = (k, wall);
                    n_walls += 1;
                }
            }
        }
        Some(roles)
    }

    /// Volume and its gradient.
    fn shape(&self, frame: &Frame) -> (f64, [Vec3; 4]) {
        match self.count {
            4 => tetrahedron(self),
            3 => prism(frame, self),
            2 => wedge(frame, self),
            _ => corner(frame, self),
        }
    }
}

/// Equal power to every sphere, on every wall: three linear equations relative to the first
/// sphere.
struct Equations {
    row: [Vec3; 3],
    rhs: [f64; 3],
}

impl Equations {
    fn of(frame: &Frame, roles: &Roles) -> Equations {
        let (_, x0, r0) = roles.spheres[0];
        let mut row = [Vec3::zeros(); 3];
        let mut rhs = [0.0; 3];
        for (i, (_, x, r)) in roles.spheres[1..roles.count].iter().enumerate() {
            row[i] = x - x0;
            rhs[i] = 0.5 * (row[i].norm_squared() + (r0 - r) * (r0 + r));
        }
        for (i, (_, wall)) in (roles.count - 1..3).zip(roles.walls) {
            row[i] = wall.inward_normal();
            rhs[i] = -frame.distance(wall, &x0);
        }
        Equations { row, rhs }
    }

    fn is_flat(&self, determinant: f64) -> bool {
        let [a, b, c] = self.row;
        determinant.abs() <= FLAT * a.norm() * b.norm() * c.norm()
    }

    /// Rows of one size, so that one bound tells flat from not.
    fn unit_rows(&self) -> Matrix3<f64> {
        Matrix3::from_rows(&self.row.map(|r| r.normalize().transpose()))
    }
}

/// By Cramer's rule.
fn power_center(frame: &Frame, roles: &Roles) -> Vec3 {
    let (_, x0, _) = roles.spheres[0];
    let equations = Equations::of(frame, roles);
    let [a, b, c] = equations.row;
    let (bc, ca, ab) = (b.cross(&c), c.cross(&a), a.cross(&b));
    let determinant = a.dot(&bc);
    if equations.is_flat(determinant) {
        return flat_center(roles, x0, &equations);
    }
    let rhs = equations.rhs;
    x0 + (rhs[0] * bc + rhs[1] * ca + rhs[2] * ab) / determinant
}

/// The direction (1) across a flat pore, along which its equations leave its centre open; `None`
/// for other pores, and where more than one direction is open.
pub(super) fn flat_axis(frame: &Frame, cell: [u32; 4]) -> Option<Vec3> {
    let equations = Equations::of(frame, &Roles::new(frame, cell)?);
    let [a, b, c] = equations.row;
    if !equations.is_flat(a.dot(&b.cross(&c))) {
        return None;
    }
    let svd = equations.unit_rows().svd(false, true);
    let open = svd.singular_values.iter().filter(|s| **s <= UNKNOWN).count();
    svd.v_t.filter(|_| open == 1).map(|v_t| v_t.row(2).transpose())
}

/// The point nearest to the middle of a flat pore's spheres that lies on its
/// walls and has equal power as far as the spheres' line or plane tells: across that
/// nothing is known, and round-off would choose. [`FlatPores`](super::flat_pores::FlatPores)
/// then moves it to where its neighbours leave room for it.
fn flat_center(roles: &Roles, x0: Vec3, equations: &Equations) -> Vec3 {
    let Equations { row, rhs, .. } = equations;
    let spheres = &roles.spheres[..roles.count];
    let middle = spheres.iter().map(|(_, x, _)| x - x0).sum::<Vec3>() / roles.count as f64;
    let unit = equations.unit_rows();
    let wanted = Vec3::from_fn(|i, _| rhs[i] / row[i].norm()) - unit * middle;
    let solution = unit.svd(true, true).solve(&wanted, UNKNOWN);
    x0 + middle + solution.unwrap_or_else(|_| Vec3::zeros())
}

fn tetrahedron(roles: &Roles) -> (f64, [Vec3; 4]) {
    let x = &roles.at;
    let gradient = FACETS.map(|[a, b, c]| (x[b] - x[a]).cross(&(x[c] - x[a])) / -6.0);
    (gradient[0].dot(&(x[0] - x[1])), gradient)
}

/// Prism between the triangle of three spheres and one wall: projected area
/// times mean distance.
fn prism(frame: &Frame, roles: &Roles) -> (f64, [Vec3; 4]) {
    let (kw, wall) = roles.walls[0];
    let n = wall.inward_normal();
    let facet = FACETS[kw];
    let x = facet.map(|k| roles.at[k]);
    let area = 0.5 * (x[1] - x[0]).cross(&(x[2] - x[0])).dot(&n);
    let height = x.iter().map(|x| frame.distance(wall, x)).sum::<f64>() / 3.0;
    let mut gradient = [Vec3::zeros(); 4];
    for i in 0..3 {
        let opposite = x[(i + 1) % 3] - x[(i + 2) % 3];
        gradient[facet[i]] = 0.5 * height * opposite.cross(&n) + area / 3.0 * n;
    }
    gradient[kw] = -area * n;
    (area * height, gradient)
}

/// Wedge between the segment of two spheres and two walls: the product of both
/// distances integrated along the walls' edge.
fn wedge(frame: &Frame, roles: &Roles) -> (f64, [Vec3; 4]) {
    let [(ka, a, _), (kb, b, _), ..] = roles.spheres;
    let [(k1, w1), (k2, w2), _] = roles.walls;
    let (n1, n2) = (w1.inward_normal(), w2.inward_normal());
    let (d1a, d1b) = (frame.distance(w1, &a), frame.distance(w1, &b));
    let (d2a, d2b) = (frame.distance(w2, &a), frame.distance(w2, &b));
    // Along the edge, from b to a in the sense of the cell's orientation.
    let facet = FACETS[kb];
    let start = facet.iter().position(|&k| k == ka).unwrap_or(0);
    let first = facet[(start + 1) % 3];
    let along = if first == k1 { n1.cross(&n2) } else { n2.cross(&n1) };
    let length = along.dot(&(a - b));
    let section = (d1a * d2a + d1b * d2b) / 3.0 + (d1a * d2b + d1b * d2a) / 6.0;
    let (s1a, s1b) = (d2a / 3.0 + d2b / 6.0, d2b / 3.0 + d2a / 6.0);
    let (s2a, s2b) = (d1a / 3.0 + d1b / 6.0, d1b / 3.0 + d1a / 6.0);
    let mut gradient = [Vec3::zeros(); 4];
    gradient[ka] = section * along + length * (s1a * n1 + s2a * n2);
    gradient[kb] = -section * along + length * (s1b * n1 + s2b * n2);
    gradient[k1] = -length * (s1a + s1b) * n1;
    gradient[k2] = -length * (s2a + s2b) * n2;
    (length * section, gradient)
}

/// Box between one sphere and three walls.
fn corner(frame: &Frame, roles: &Roles) -> (f64, [Vec3; 4]) {
    let (ka, a, _) = roles.spheres[0];
    let d = roles.walls.map(|(_, w)| frame.distance(w, &a));
    let mut gradient = [Vec3::zeros(); 4];
    for (i, (k, w)) in roles.walls.into_iter().enumerate() {
        let face = d[(i + 1) % 3] * d[(i + 2) % 3] * w.inward_normal();
        gradient[ka] += face;
        gradient[k] = -face;
    }
    (d.iter().product(), gradient)
}
