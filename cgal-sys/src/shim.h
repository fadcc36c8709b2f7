#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "rust/cxx.h"

namespace dempfv_cgal {

// What the Rust side reads: flat arrays, valid as long as this object lives.
class Triangulation {
public:
    const std::vector<std::uint32_t> &cells() const { return cells_; }
    const std::vector<std::uint32_t> &neighbors() const { return neighbors_; }
    const std::vector<std::uint32_t> &hidden() const { return hidden_; }

    std::vector<std::uint32_t> cells_, neighbors_, hidden_;
};

std::unique_ptr<Triangulation> triangulate(rust::Slice<const double> points);

}  // namespace dempfv_cgal
