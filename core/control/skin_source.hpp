// SPDX-License-Identifier: Apache-2.0
// The skin task's two sources: the host's own sum, and the one that the skin's cells have computed (section IV-B6).
//
// Both are asked for the same thing, so one takes over from the other without a step while the robot runs. What the
// skin has said last and too long ago counts for nothing: then the host's sum is used at once, whatever was asked for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "control/fade.hpp"
#include "skin/torque_reader.hpp"

namespace robotskin::control {

enum class SkinSource : std::uint8_t { host, skin };

// Where to take the torque from: cells know nothing of masks, so while one holds, only the host's sum leaves masked
// cells out.
inline SkinSource unmasked_source(SkinSource wanted, bool all_patches_take_part) noexcept {
  return all_patches_take_part ? wanted : SkinSource::host;
}

class SkinSourceSwitch {
 public:
  SkinSourceSwitch(std::size_t joints, double fade_s) : fade_(fade_s), torque_(joints) {}

  // torque (n) Nm that the skin task contributes. `skin` may be null: nothing is heard of the skin. `scale`: what the
  // task asks for, over what the skin has been told to ask for.
  std::span<const double> step(SkinSource wanted, std::span<const double> host, const skin::SkinTorque* skin,
                               double period_s, double scale = 1) noexcept {
    const bool heard = skin != nullptr && skin->fresh && skin->joint.size() == host.size();
    if (!heard) fade_.set(0);
    share_ = heard ? fade_.step(wanted == SkinSource::skin, period_s) : 0.0;
    for (std::size_t i = 0; i < host.size(); ++i)
      torque_[i] = share_ > 0 ? (1 - share_) * host[i] + share_ * scale * skin->joint[i] : host[i];
    return torque_;
  }

  // 0: all is the host's, 1: all is the skin's own.
  double share() const noexcept { return share_; }
  std::span<const double> torque() const noexcept { return torque_; }  // (n) Nm of the last step

 private:
  Fade fade_;
  double share_ = 0;
  std::vector<double> torque_;  // (n) Nm
};

}  // namespace robotskin::control
