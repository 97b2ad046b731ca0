// SPDX-License-Identifier: Apache-2.0
// Which patches and cells take part, as a share per cell that fades when one is masked or unmasked.
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
  PatchMask(const skin::SkinModel& skin, double fade_s)
      : patch_(skin.patch),
        share_(skin.size(), 1.0F),
        cell_fades_(skin.size(), Fade(fade_s, 1.0)),
        left_out_(skin.size(), 0) {
    cell_masked_ = std::vector<std::atomic<bool>>(skin.size());
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

  // Leaves one cell out, as an ill one. False if there is no such cell.
  [[nodiscard]] bool request_cell(std::size_t cell, bool masked) noexcept {
    if (cell >= cell_masked_.size()) return false;
    cell_masked_[cell].store(masked, std::memory_order_relaxed);
    asked_.fetch_add(1, std::memory_order_release);
    return true;
  }
  // (N) 1 where a cell is left out, as of the last step; it stays where it is in memory.
  std::span<const std::uint8_t> left_out() const noexcept { return left_out_; }

  // Whether every patch and cell takes part in full, as of the last step.
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
    step_cells(period_s);
    if (!settled || !cells_settled_)
      for (std::size_t cell = 0; cell < share_.size(); ++cell)
        share_[cell] =
            static_cast<float>((patch_[cell] >= 0 ? fades_[patch_[cell]].value() : 1.0) * cell_fades_[cell].value());
    return share_;
  }

 private:
  void step_cells(double period_s) noexcept {
    const std::uint32_t asked = asked_.load(std::memory_order_acquire);
    if (asked != seen_ || !cells_settled_) {
      seen_ = asked;
      cells_settled_ = true;
      any_left_out_ = false;
      for (std::size_t cell = 0; cell < cell_fades_.size(); ++cell) {
        const bool on = !cell_masked_[cell].load(std::memory_order_relaxed);
        left_out_[cell] = on ? 0 : 1;
        any_left_out_ = any_left_out_ || !on;
        if (cell_fades_[cell].settled(on)) continue;
        cells_settled_ = false;
        cell_fades_[cell].step(on, period_s);
      }
    }
    whole_ = whole_ && cells_settled_ && !any_left_out_;
  }

  std::vector<std::int32_t> patch_;  // (N)
  skin::CellArray<float> share_;     // (N)
  std::vector<Fade> fades_;          // (patches)
  std::vector<std::atomic<bool>> masked_;
  std::vector<Fade> cell_fades_;  // (N)
  std::vector<std::atomic<bool>> cell_masked_;
  std::vector<std::uint8_t> left_out_;  // (N)
  std::atomic<std::uint32_t> asked_{0};
  std::uint32_t seen_ = 0;
  bool whole_ = true, cells_settled_ = true, any_left_out_ = false;
};

}  // namespace robotskin::control
