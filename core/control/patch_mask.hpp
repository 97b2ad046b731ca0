// SPDX-License-Identifier: Apache-2.0
// Which patches take part, as a share per cell that fades when a patch is masked or unmasked.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "control/fade.hpp"
#include "skin/cell_array.hpp"
#include "skin/skin_model.hpp"

namespace robotskin::control {

// Cells without a patch always take part.
class PatchMask {
 public:
  PatchMask(const skin::SkinModel& skin, double fade_s) : patch_(skin.patch), share_(skin.size(), 1.0F) {
    std::int32_t patches = 0;
    for (const std::int32_t patch : patch_) patches = patch >= patches ? patch + 1 : patches;
    fades_.assign(static_cast<std::size_t>(patches), Fade(fade_s, 1.0));
    masked_ = std::vector<std::atomic<bool>>(fades_.size());
  }

  std::size_t patch_count() const noexcept { return fades_.size(); }
  // From any thread; takes effect over the fade time. False if there is no such patch.
  [[nodiscard]] bool request(std::size_t patch, bool masked) noexcept {
    if (patch >= masked_.size()) return false;
    masked_[patch].store(masked, std::memory_order_relaxed);
    return true;
  }

  // Whether every patch takes part in full, as of the last step.
  bool whole() const noexcept { return whole_; }

  // (N) 0 to 1, one period further.
  std::span<const float> step(double period_s) noexcept {
    bool settled = true;
    whole_ = true;
    for (std::size_t patch = 0; patch < fades_.size(); ++patch) {
      const bool on = !masked_[patch].load(std::memory_order_relaxed);
      if (fades_[patch].settled(on)) {
        whole_ = whole_ && on;
        continue;
      }
      whole_ = false;
      settled = false;
      fades_[patch].step(on, period_s);
    }
    if (!settled)
      for (std::size_t cell = 0; cell < share_.size(); ++cell)
        if (patch_[cell] >= 0) share_[cell] = static_cast<float>(fades_[patch_[cell]].value());
    return share_;
  }

 private:
  std::vector<std::int32_t> patch_;  // (N)
  skin::CellArray<float> share_;     // (N)
  std::vector<Fade> fades_;          // (patches)
  std::vector<std::atomic<bool>> masked_;
  bool whole_ = true;
};

}  // namespace robotskin::control
