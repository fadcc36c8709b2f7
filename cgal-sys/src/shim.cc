#include "cgal-sys/src/shim.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Regular_triangulation_3.h>
#include <CGAL/Regular_triangulation_cell_base_3.h>
#include <CGAL/Regular_triangulation_vertex_base_3.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

namespace dempfv_cgal {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Id = std::uint32_t;
using Vertex =
    CGAL::Triangulation_vertex_base_with_info_3<Id, Kernel, CGAL::Regular_triangulation_vertex_base_3<Kernel>>;
using Cell =
    CGAL::Triangulation_cell_base_with_info_3<Id, Kernel, CGAL::Regular_triangulation_cell_base_3<Kernel>>;
using Regular = CGAL::Regular_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<Vertex, Cell>>;

constexpr Id none = std::numeric_limits<Id>::max();

}  // namespace

std::unique_ptr<Triangulation> triangulate(rust::Slice<const double> flat) {
    const std::size_t count = flat.size() / 4;
    if (count >= none) throw std::length_error("2^32 points or more");

    std::vector<std::pair<Regular::Weighted_point, Id>> points;
    points.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double *p = flat.data() + 4 * i;
        for (int k = 0; k < 4; ++k)
            if (!std::isfinite(p[k])) throw std::invalid_argument("point " + std::to_string(i) + " is not finite");
        points.emplace_back(Regular::Weighted_point(Kernel::Point_3(p[0], p[1], p[2]), p[3]), static_cast<Id>(i));
    }

    Regular t;
    t.insert(points.begin(), points.end());
    if (t.dimension() < 3) throw std::invalid_argument("all points lie in one plane");

    std::size_t cells = 0;
    for (auto c = t.finite_cells_begin(); c != t.finite_cells_end(); ++c) {
        if (cells >= none) throw std::length_error("2^32 cells or more");
        c->info() = static_cast<Id>(cells++);
    }

    auto out = std::make_unique<Triangulation>();
    out->cells_.reserve(4 * cells);
    out->neighbors_.reserve(4 * cells);
    std::vector<bool> is_vertex(count, false);
    for (auto c = t.finite_cells_begin(); c != t.finite_cells_end(); ++c)
        for (int k = 0; k < 4; ++k) {
            const Id v = c->vertex(k)->info();
            is_vertex[v] = true;
            out->cells_.push_back(v);
            const auto across = c->neighbor(k);
            out->neighbors_.push_back(t.is_infinite(across) ? none : across->info());
        }
    for (std::size_t i = 0; i < count; ++i)
        if (!is_vertex[i]) out->hidden_.push_back(static_cast<Id>(i));
    return out;
}

}  // namespace dempfv_cgal
