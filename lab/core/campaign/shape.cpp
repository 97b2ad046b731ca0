// SPDX-License-Identifier: Apache-2.0
#include "campaign/shape.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "robotskin/cell.h"

namespace robotskin::campaign {
namespace {

using world::CellEnd;
using world::RandomStream;
using world::Wiring;

constexpr std::array<std::string_view, shape_count> names{
#define ROBOTSKIN_SHAPE_TEXT(name, text) #name,
    ROBOTSKIN_SHAPES(ROBOTSKIN_SHAPE_TEXT)
#undef ROBOTSKIN_SHAPE_TEXT
};

// Cells with four sides: right, up, left, down.
struct Lattice {
  std::vector<std::array<std::int32_t, 4>> beside;  // the cell at each side, -1: none

  std::int32_t add() {
    beside.push_back({-1, -1, -1, -1});
    return static_cast<std::int32_t>(beside.size()) - 1;
  }
  void join(std::int32_t a, int side_of_a, std::int32_t b) {
    beside[static_cast<std::size_t>(a)][static_cast<std::size_t>(side_of_a)] = b;
    beside[static_cast<std::size_t>(b)][static_cast<std::size_t>((side_of_a + 2) % 4)] = a;
  }
  void part(std::int32_t a, std::size_t side) {
    std::int32_t& b = beside[static_cast<std::size_t>(a)][side];
    if (b < 0) return;
    beside[static_cast<std::size_t>(b)][(side + 2) % 4] = -1;
    b = -1;
  }
  // `width` by `height` cells; the first row's left end slides `shear` cells a row; closed to a tube if `round`.
  std::int32_t grid(std::int32_t width, std::int32_t height, std::int32_t shear, bool round) {
    const auto first = static_cast<std::int32_t>(beside.size());
    for (std::int32_t i = 0; i < width * height; ++i) add();
    const auto at = [&](std::int32_t x, std::int32_t y) { return first + y * width + x; };
    for (std::int32_t y = 0; y < height; ++y)
      for (std::int32_t x = 0; x < width; ++x) {
        if (x + 1 < width) join(at(x, y), 0, at(x + 1, y));
        if (x + 1 == width && round && width > 2) join(at(x, y), 0, at(0, y));
        if (y + 1 < height && x - shear >= 0 && x - shear < width) join(at(x, y), 1, at(x - shear, y + 1));
      }
    return first;
  }
};

// A bridge between free sides of two patches, whatever way they face.
struct Bridge {
  std::int32_t a;
  std::size_t side_of_a;
  std::int32_t b;
  std::size_t side_of_b;
};

Wiring wire_up(const Lattice& lattice, const std::vector<Bridge>& bridges, RandomStream& draw) {
  const std::size_t cells = lattice.beside.size();
  std::vector<std::array<std::int32_t, 4>> beside = lattice.beside;
  std::vector<std::array<std::int32_t, 4>> back(cells, {2, 3, 0, 1});
  for (const Bridge& bridge : bridges) {
    beside[static_cast<std::size_t>(bridge.a)][bridge.side_of_a] = bridge.b;
    back[static_cast<std::size_t>(bridge.a)][bridge.side_of_a] = static_cast<std::int32_t>(bridge.side_of_b);
    beside[static_cast<std::size_t>(bridge.b)][bridge.side_of_b] = bridge.a;
    back[static_cast<std::size_t>(bridge.b)][bridge.side_of_b] = static_cast<std::int32_t>(bridge.side_of_a);
  }
  // The largest piece, in the order in which it is walked.
  std::vector<std::int32_t> number(cells, -1), best;
  for (std::size_t start = 0; start < cells; ++start) {
    if (number[start] != -1) continue;
    std::vector<std::int32_t> piece{static_cast<std::int32_t>(start)};
    number[start] = -2;
    for (std::size_t at = 0; at < piece.size(); ++at)
      for (const std::int32_t next : beside[static_cast<std::size_t>(piece[at])])
        if (next >= 0 && number[static_cast<std::size_t>(next)] == -1) {
          number[static_cast<std::size_t>(next)] = -2;
          piece.push_back(next);
        }
    if (piece.size() > best.size()) best = piece;
  }
  std::vector<std::size_t> turn(cells);
  for (std::size_t& t : turn) t = draw.below(4);
  for (std::size_t i = 0; i < best.size(); ++i)
    number[static_cast<std::size_t>(best[i])] = static_cast<std::int32_t>(i);
  Wiring wiring;
  wiring.neighbours.resize(best.size());
  wiring.id.assign(best.size(), RS_ID_NONE);
  for (std::size_t i = 0; i < best.size(); ++i) {
    const auto old = static_cast<std::size_t>(best[i]);
    for (std::size_t side = 0; side < 4; ++side) {
      const std::int32_t next = beside[old][side];
      CellEnd end;
      if (next >= 0) {
        const std::size_t far_side = static_cast<std::size_t>(back[old][side]) + turn[static_cast<std::size_t>(next)];
        end = {number[static_cast<std::size_t>(next)], static_cast<std::uint8_t>(far_side % 4 + 1)};
      }
      wiring.neighbours[i][(side + turn[old]) % 4] = end;
    }
  }
  return wiring;
}

Lattice draw_cylinder(std::int32_t cells, RandomStream& draw) {
  Lattice lattice;
  const auto around = static_cast<std::int32_t>(5 + draw.below(8));
  lattice.grid(around, std::max(2, cells * 10 / 9 / around), 0, true);
  const auto all = static_cast<std::int32_t>(lattice.beside.size());
  for (std::int32_t cell = 0; cell < all; ++cell) {
    const bool hole = draw.below(100) < 5;
    for (std::size_t side = 0; side < 4; ++side)
      if (hole || (side < 2 && draw.below(100) < 12)) lattice.part(cell, side);
  }
  return lattice;
}

}  // namespace

std::string_view name_of(Shape shape) {
  return names[static_cast<std::size_t>(shape)];
}

Wiring draw_shape(Shape shape, std::int32_t cells, RandomStream& draw) {
  Lattice lattice;
  std::vector<Bridge> bridges;
  switch (shape) {
    case Shape::sheet:
    case Shape::sheared: {
      const double stretch = 1 + 0.01 * static_cast<double>(draw.below(200));
      const auto width = static_cast<std::int32_t>(std::max(2.0, std::round(std::sqrt(cells * stretch))));
      lattice.grid(width, std::max(1, (cells + width / 2) / width), shape == Shape::sheared ? 1 : 0, false);
      break;
    }
    case Shape::cylinder:
      lattice = draw_cylinder(cells, draw);
      break;
    case Shape::patches: {
      const auto patches =
          static_cast<std::int32_t>(2 + draw.below(static_cast<std::uint64_t>(std::clamp(cells / 12, 1, 7))));
      const bool ring = patches > 2 && draw.below(2) == 0;
      std::vector<std::int32_t> first;
      for (std::int32_t k = 0; k < patches; ++k) {
        const auto width = static_cast<std::int32_t>(2 + draw.below(5));
        first.push_back(lattice.grid(width, std::max(1, cells / patches / width), draw.below(3) == 0 ? 1 : 0, false));
      }
      first.push_back(static_cast<std::int32_t>(lattice.beside.size()));
      std::vector<std::array<bool, 4>> taken(lattice.beside.size());
      const auto free_side = [&](std::int32_t patch) -> std::pair<std::int32_t, std::size_t> {
        std::vector<std::pair<std::int32_t, std::size_t>> free;
        for (std::int32_t cell = first[static_cast<std::size_t>(patch)];
             cell < first[static_cast<std::size_t>(patch) + 1]; ++cell)
          for (std::size_t side = 0; side < 4; ++side)
            if (lattice.beside[static_cast<std::size_t>(cell)][side] < 0 &&
                !taken[static_cast<std::size_t>(cell)][side])
              free.emplace_back(cell, side);
        const auto chosen = free[draw.below(free.size())];
        taken[static_cast<std::size_t>(chosen.first)][chosen.second] = true;
        return chosen;
      };
      for (std::int32_t k = 0; k + (ring ? 0 : 1) < patches; ++k) {
        const std::uint64_t count = 1 + draw.below(3);
        for (std::uint64_t b = 0; b < count; ++b) {
          const auto [one, side_of_one] = free_side(k);
          const auto [other, side_of_other] = free_side((k + 1) % patches);
          bridges.push_back({one, side_of_one, other, side_of_other});
        }
      }
      break;
    }
  }
  return wire_up(lattice, bridges, draw);
}

void plug_cables(Wiring& wiring, std::int32_t units, std::int32_t ports, RandomStream& draw) {
  struct Free {
    std::int32_t cell;
    std::uint8_t port;
  };
  std::vector<Free> free;
  for (std::size_t cell = 0; cell < wiring.cell_count(); ++cell)
    for (std::uint8_t port = 1; port <= RS_PORTS; ++port)
      if (wiring.neighbours[cell][port - 1].cell < 0) free.push_back({static_cast<std::int32_t>(cell), port});
  for (std::int32_t u = 0; u < units; ++u) wiring.units.push_back({0, static_cast<std::uint8_t>(u), {}});
  for (std::int32_t k = 0; k < ports && !free.empty(); ++k) {
    const std::size_t chosen = draw.below(free.size());
    const Free place = free[chosen];
    wiring.units[static_cast<std::size_t>(k % units)].ports.push_back({place.cell, place.port});
    std::erase_if(free, [&](const Free& other) { return other.cell == place.cell; });
  }
  std::erase_if(wiring.units, [](const world::UnitDescription& unit) { return unit.ports.empty(); });
}

}  // namespace robotskin::campaign
