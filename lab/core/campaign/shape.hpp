// SPDX-License-Identifier: Apache-2.0
// Skins to try the network on: sheets, sheared sheets, cylinders with holes, chains and rings of patches.
#pragma once

#include <cstdint>
#include <string_view>

#include "world/network/wiring.hpp"
#include "world/random.hpp"

namespace robotskin::campaign {

// clang-format off
#define ROBOTSKIN_SHAPES(X)                                        \
  X(sheet, "a rectangle")                                           \
  X(sheared, "a parallelogram")                                     \
  X(cylinder, "a tube with holes and 12 % of its links missing")    \
  X(patches, "rectangles joined by one to three bridges, in a chain or a ring")
// clang-format on

#define ROBOTSKIN_SHAPE_NAME(name, text) name,
enum class Shape : std::uint8_t { ROBOTSKIN_SHAPES(ROBOTSKIN_SHAPE_NAME) };
#undef ROBOTSKIN_SHAPE_NAME
#define ROBOTSKIN_SHAPE_ONE(name, text) +1
inline constexpr std::size_t shape_count = 0 ROBOTSKIN_SHAPES(ROBOTSKIN_SHAPE_ONE);
#undef ROBOTSKIN_SHAPE_ONE

std::string_view name_of(Shape shape);

// About `cells` of them, joined in one piece, each turned as chance would have it; without section units.
world::Wiring draw_shape(Shape shape, std::int32_t cells, world::RandomStream& draw);

// Plugs `ports` cables of `units` section units into free ports of cells at the border, drawn evenly.
void plug_cables(world::Wiring& wiring, std::int32_t units, std::int32_t ports, world::RandomStream& draw);

}  // namespace robotskin::campaign
