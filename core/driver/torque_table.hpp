// SPDX-License-Identifier: Apache-2.0
// The limbs' torques as the skin computes them: the vectors of all section units and parts, joined by epoch.
//
// A limb whose trees lead to several section units, or whose chains have more than six joints, comes in several frames
// an epoch. A vector is whole when every source of one of the last epochs is in it; one that stays incomplete is handed
// out as such when the epoch after next begins, and says so. What comes after that counts as late.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "driver/snapshot_table.hpp"
#include "driver/statistics.hpp"
#include "robotskin/torque.h"

namespace robotskin::driver {

inline constexpr std::size_t torque_joints_max = 4 * RS_JOINTS_PER_PART;

// The newest vector of one limb.
struct LimbTorque {
  std::int64_t heard_ns = 0;                            // host clock when its last frame left its unit; 0: unused row
  std::int64_t epoch_ns = 0;                            // host clock when its epoch began
  std::int64_t epoch = -1;                              // section units' time / 4 ms
  std::array<std::int32_t, torque_joints_max> joint{};  // in the limb's step
  std::array<std::uint32_t, 4> cells{};                 // summed, by part
  std::uint32_t active = 0;                             // of those of part 0, in contact
  std::uint16_t group = 0;
  std::uint8_t limb = 0;
  std::uint8_t joints = 0;  // 6 a part
  std::uint8_t age = 0;     // epochs of the oldest joint positions used
  bool saturated = false;
  bool whole = false;  // every source is in it
  std::uint64_t vectors = 0, partial = 0;
};

class TorqueTable {
 public:
  static constexpr std::size_t limbs_max = 64;

  TorqueTable() : rows_(limbs_max), limbs_(limbs_max) {}

  // A frame of section unit `unit` (0 to 15) of a group, of an epoch that is known in full and began at `epoch_ns`.
  void take(std::uint16_t group, std::uint8_t unit, const rs_torque& frame, std::int64_t epoch, std::int64_t epoch_ns,
            std::int64_t heard_ns, Statistics& statistics) {
    const std::size_t at = row_of(group, frame);
    if (at == limbs_max) return statistics.torque_late.add();
    Limb& limb = limbs_[at];
    const std::uint64_t source = std::uint64_t{1} << (4 * (unit & 15U) + (frame.part & 3U));
    if (epoch < limb.finished - leap_epochs) limb = {};  // the section units' time has been set anew
    if (epoch <= limb.finished) {
      // A unit that has just joined is waited for from now on.
      if (epoch == limb.finished) limb.sources[0] |= source;
      return statistics.torque_late.add();
    }
    constexpr auto kept = static_cast<std::int64_t>(pending_max);
    for (std::int64_t old = std::max(limb.finished + 1, epoch - kept + 1); old < epoch - 1; ++old) {
      const Pending& pending = limb.pending[static_cast<std::size_t>(old) % pending_max];
      if (pending.epoch == old) finish(at, pending, statistics);
    }
    Pending& pending = limb.pending[static_cast<std::size_t>(epoch) % pending_max];
    if (pending.epoch != epoch) pending = {.epoch = epoch, .epoch_ns = epoch_ns};
    if ((pending.sources & source) != 0) return statistics.torque_late.add();
    add(pending, source, frame, heard_ns);
    const std::uint64_t expected = limb.sources[0] | limb.sources[1] | limb.sources[2];
    if ((expected & ~pending.sources) == 0) finish(at, pending, statistics);
  }

  SnapshotTable<LimbTorque>& rows() { return rows_; }

 private:
  static constexpr std::size_t pending_max = 4;
  static constexpr std::int64_t leap_epochs = 250;

  struct Pending {
    std::int64_t epoch = -1, epoch_ns = 0, heard_ns = 0;
    std::uint64_t sources = 0;  // bit 4 unit + part
    std::array<std::int32_t, torque_joints_max> joint{};
    std::array<std::uint32_t, 4> cells{};
    std::uint32_t active = 0;
    std::uint8_t age = 0;
    bool saturated = false;
  };
  struct Limb {
    std::int64_t finished = -1;
    std::array<std::uint64_t, 3> sources{};  // of the last epochs that were handed out
    std::array<Pending, pending_max> pending{};
  };

  std::size_t row_of(std::uint16_t group, const rs_torque& frame) {
    std::size_t at = 0;
    for (; at < used_; ++at) {
      if (rows_.row(at).group == group && rows_.row(at).limb == frame.limb) return at;
    }
    if (at < limbs_max) {
      LimbTorque& row = rows_.change(used_++);
      row.group = group;
      row.limb = static_cast<std::uint8_t>(frame.limb);
    }
    return at;
  }

  static void add(Pending& pending, std::uint64_t source, const rs_torque& frame, std::int64_t heard_ns) {
    const std::int32_t joint[RS_JOINTS_PER_PART] = {frame.joint_1, frame.joint_2, frame.joint_3,
                                                    frame.joint_4, frame.joint_5, frame.joint_6};
    pending.sources |= source;
    pending.heard_ns = pending.heard_ns > heard_ns ? pending.heard_ns : heard_ns;
    for (std::size_t i = 0; i < RS_JOINTS_PER_PART; ++i) {
      pending.joint[RS_JOINTS_PER_PART * frame.part + i] += joint[i];
    }
    pending.cells[frame.part] += frame.cells;
    if (frame.part == 0) pending.active += frame.active;
    if (frame.age > pending.age) pending.age = static_cast<std::uint8_t>(frame.age);
    pending.saturated |= frame.saturated != 0;
  }

  void finish(std::size_t at, const Pending& pending, Statistics& statistics) {
    Limb& limb = limbs_[at];
    const std::uint64_t expected = limb.sources[0] | limb.sources[1] | limb.sources[2];
    limb.finished = pending.epoch;
    limb.sources = {pending.sources, limb.sources[0], limb.sources[1]};
    LimbTorque& row = rows_.change(at);
    row.heard_ns = pending.heard_ns;
    row.epoch_ns = pending.epoch_ns;
    row.epoch = pending.epoch;
    row.joint = pending.joint;
    row.cells = pending.cells;
    row.active = pending.active;
    row.age = pending.age;
    row.saturated = pending.saturated;
    row.whole = (expected & ~pending.sources) == 0;
    for (std::uint64_t sources = pending.sources; sources != 0; sources >>= 4) {
      for (std::uint8_t part = 0; part < 4; ++part) {
        const auto joints = static_cast<std::uint8_t>(RS_JOINTS_PER_PART * (part + 1));
        if ((sources >> part & 1U) != 0 && joints > row.joints) row.joints = joints;
      }
    }
    ++row.vectors;
    row.partial += !row.whole;
    statistics.torque_vectors.add();
    if (!row.whole) statistics.torque_partial.add();
    if (row.saturated) statistics.torque_saturated.add();
  }

  SnapshotTable<LimbTorque> rows_;
  std::vector<Limb> limbs_;
  std::size_t used_ = 0;
};

}  // namespace robotskin::driver
