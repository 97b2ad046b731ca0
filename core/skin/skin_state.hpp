// What the skin feels in one control cycle, in SI units.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "skin/cell_array.hpp"

namespace robotskin::skin {

// alive: fresh. stale: not heard of within the freshness bound. stuck: heard of, but its values cannot be true.
// dead: the network reports it gone. never_seen: not heard of since the driver started.
enum class Health : std::uint8_t { alive, stale, stuck, dead, never_seen };

// Struct of arrays, cell axis first, in the order of the SkinModel; sized once, filled every cycle.
// Values of a cell that is not alive are its last ones, of one never seen no touch, nothing near, temperature NaN:
// whoever uses a value looks at its health first.
struct SkinState {
  CellArray<std::array<float, 3>> normal_force;  // (N, 3) newton, >= 0; the touch on the robot is -z times their sum
  CellArray<float> proximity;                    // (N) 0 to 1, share of full scale
  CellArray<float> distance;                     // (N) metres, estimated from proximity; +inf where nothing is near
  CellArray<std::array<float, 3>> acceleration;  // (N, 3) m/s^2, specific force in the cell frame
  CellArray<std::array<float, 2>> temperature;   // (N, 2) degrees Celsius
  CellArray<std::int64_t> stamp_ns;              // (N) host clock at the sample
  CellArray<Health> health;                      // (N)
  CellArray<std::uint8_t> saturated;             // (N) 1 where a channel is at the end of its range
  std::int64_t time_ns = 0;                      // host clock when the driver handed out these samples

  void resize(std::size_t cells) {
    normal_force.assign(cells, {0, 0, 0});
    proximity.assign(cells, 0);
    distance.assign(cells, std::numeric_limits<float>::infinity());
    acceleration.assign(cells, {0, 0, 0});
    constexpr float unknown = std::numeric_limits<float>::quiet_NaN();
    temperature.assign(cells, {unknown, unknown});
    stamp_ns.assign(cells, 0);
    health.assign(cells, Health::never_seen);
    saturated.assign(cells, 0);
  }

  std::size_t size() const { return proximity.size(); }
};

}  // namespace robotskin::skin
