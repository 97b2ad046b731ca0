// SPDX-License-Identifier: Apache-2.0
#include "serial/cell_runner.hpp"

namespace robotskin::serial {
namespace {

std::vector<FrameLine> framed(std::vector<std::unique_ptr<Line>> lines) {
  std::vector<FrameLine> found;
  for (std::unique_ptr<Line>& line : lines) found.emplace_back(std::move(line));
  return found;
}

}  // namespace

CellRunner::CellRunner(std::vector<HostCell> cells, std::optional<CellKey> key, CellSensors& sensors,
                       std::vector<std::unique_ptr<Line>> lines)
    : lines_(framed(std::move(lines))),
      pulled_(lines_.size(), false),
      cells_(std::move(cells), key, sensors, *this, now_ns()) {}

std::int64_t CellRunner::turn(std::int64_t now_ns) {
  for (std::size_t i = 0; i < lines_.size(); ++i)
    lines_[i].receive(now_ns, [&](FrameBytes frame) {
      if (!pulled_[i]) cells_.frame(i, frame, this->now_ns());
    });
  return cells_.advance(this->now_ns());
}

void CellRunner::wait_for(std::vector<pollfd>& descriptors) const {
  for (const FrameLine& line : lines_)
    if (line.descriptor() >= 0) descriptors.push_back({line.descriptor(), POLLIN, 0});
}

void CellRunner::pull(std::size_t line, bool pulled) {
  const std::lock_guard lock(working_);
  pulled_.at(line) = pulled;
}

std::optional<CellKeys> CellRunner::given_keys(std::size_t cell) const {
  const std::lock_guard lock(working_);
  const CellKeys* given = cells_.given_keys(cell);
  return given != nullptr ? std::optional(*given) : std::nullopt;
}

void CellRunner::note_kept(std::size_t cell) {
  const std::lock_guard lock(working_);
  cells_.note_kept(cell);
}

CellsReport CellRunner::report() const {
  CellsReport found;
  {
    const std::lock_guard lock(working_);
    for (const FrameLine& line : lines_) found.lines.push_back(line.counts());
    found.samples = cells_.samples();
    for (std::size_t i = 0; i < cells_.cell_count(); ++i) {
      found.with_parent += cells_.state(i).route.parent_port != RS_NO_PARENT;
      found.links_lost += cells_.state(i).counts.orphanings;
    }
  }
  found.stalls = stalls();
  return found;
}

}  // namespace robotskin::serial
