// SPDX-License-Identifier: Apache-2.0
// Host-built cells on serial lines in real time.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "serial/cell_side.hpp"
#include "serial/frame_line.hpp"
#include "serial/real_time.hpp"

namespace robotskin::serial {

struct CellsReport {
  std::vector<LineCounts> lines;
  std::uint64_t samples = 0;
  std::uint32_t with_parent = 0;  // cells that have a way to a section unit
  std::uint32_t links_lost = 0;   // times that a cell was without any way
  Stalls stalls;
};

class CellRunner : public RealTime, private CellSide::Outward {
 public:
  // `lines` by the numbers that the cells' ends have. `sensors` must live as long.
  CellRunner(std::vector<HostCell> cells, std::optional<CellKey> key, CellSensors& sensors,
             std::vector<std::unique_ptr<Line>> lines);
  ~CellRunner() override { stop(); }

  CellsReport report() const;
  // A line that is pulled carries nothing either way.
  void pull(std::size_t line, bool pulled);
  // As of CellSide.
  std::optional<CellKeys> given_keys(std::size_t cell) const;
  void note_kept(std::size_t cell);

 protected:
  std::int64_t turn(std::int64_t now_ns) override;
  void wait_for(std::vector<pollfd>& descriptors) const override;

 private:
  void frame(std::size_t line, FrameBytes frame, std::int64_t) override {
    if (line < lines_.size() && !pulled_[line]) lines_[line].send(frame);
  }

  std::vector<FrameLine> lines_;
  std::vector<bool> pulled_;
  CellSide cells_;
};

}  // namespace robotskin::serial
