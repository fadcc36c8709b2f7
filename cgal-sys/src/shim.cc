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

// Hidden points are known by their absence: cells need not keep them.
struct NoPoints {
    using value_type = Kernel::Weighted_point_3;
    using iterator = value_type *;
    using const_iterator = const value_type *;
    iterator begin() { return nullptr; }
    iterator end() { return nullptr; }
    const_iterator begin() const { return nullptr; }
    const_iterator end() const { return nullptr; }
};

using Vertex =
    CGAL::Triangulation_vertex_base_with_info_3<Id, Kernel, CGAL::Regular_triangulation_vertex_base_3<Kernel>>;
using CellBase = CGAL::Regular_triangulation_cell_base_3<Kernel, CGAL::Triangulation_cell_base_3<Kernel>,
                                                         CGAL::Discard_hidden_points, NoPoints>;
using Cell = CGAL::Triangulation_cell_base_with_info_3<Id, Kernel, CellBase>;
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

    auto &all = t.tds().cells();
    if (all.size() >= none) throw std::length_error("2^32 cells or more");
    auto out = std::make_unique<Triangulation>();
    out->cells_.reserve(4 * all.size());
    t.infinite_vertex()->info() = none;
    Id cells = 0;
    for (auto c = all.begin(); c != all.end(); ++c) {
        const Id v[4] = {c->vertex(0)->info(), c->vertex(1)->info(), c->vertex(2)->info(), c->vertex(3)->info()};
        const bool finite = v[0] != none && v[1] != none && v[2] != none && v[3] != none;
        c->info() = finite ? cells++ : none;
        if (finite) out->cells_.insert(out->cells_.end(), v, v + 4);
    }
    out->neighbors_.reserve(out->cells_.size());
    for (auto c = all.begin(); c != all.end(); ++c)
        if (c->info() != none)
            for (int k = 0; k < 4; ++k) out->neighbors_.push_back(c->neighbor(k)->info());
    std::vector<bool> is_vertex(count, false);
    for (const Id v : out->cells_) is_vertex[v] = true;
    for (std::size_t i = 0; i < count; ++i)
        if (!is_vertex[i]) out->hidden_.push_back(static_cast<Id>(i));
    return out;
}

}  // namespace dempfv_cgal
