// SPDX-License-Identifier: Apache-2.0
#include "world/network/trial.hpp"

#include <algorithm>

namespace robotskin::world {
namespace {

constexpr rs_sample still = {{0, 0, 0, 0, 0, 0, 256, 60, 960}};  // 30 degrees Celsius, 1 g upwards, nothing near
constexpr std::int64_t settling_ns = 20000000;                   // a sample on its way for longer is lost

double ms(std::int64_t ns) {
  return 1e-6 * static_cast<double>(ns);
}

bool carries_sample(const std::uint8_t* frame) {
  const rs_frame_type type = rs_frame_type_of(frame);
  return type == RS_TYPE_clock || type == RS_TYPE_event;
}

}  // namespace

NetworkOptions NetworkTrial::prepared(NetworkOptions options) {
  options.unasked = true;
  return options;
}

NetworkTrial::NetworkTrial(const Wiring& wiring, NetworkOptions options)
    : cells_(wiring.cell_count()),
      group_of_cell_(wiring.cell_count()),
      latencies_(4096),
      network_(wiring, prepared(std::move(options)), *this, *this),
      paths_(network_) {
  // Every cell's ids are those of the group whose cable is nearest.
  for (const UnitDescription& unit : wiring.units) group_of_unit_.push_back(unit.group);
  std::vector<std::uint16_t> groups = group_of_unit_;
  std::ranges::sort(groups);
  groups.erase(std::ranges::unique(groups).begin(), groups.end());
  for (std::uint16_t& group : group_of_unit_)
    group = static_cast<std::uint16_t>(std::ranges::lower_bound(groups, group) - groups.begin());
  cell_by_id_.assign(groups.size(), std::vector<std::int32_t>(RS_ID_LAST + 1, -1));
  std::vector<std::size_t> next;
  std::vector<bool> seen(cells_.size());
  for (std::size_t u = 0; u < wiring.units.size(); ++u) {
    for (const CellEnd& end : wiring.units[u].ports) {
      if (end.cell < 0 || seen[static_cast<std::size_t>(end.cell)]) continue;
      seen[static_cast<std::size_t>(end.cell)] = true;
      group_of_cell_[static_cast<std::size_t>(end.cell)] = group_of_unit_[u];
      next.push_back(static_cast<std::size_t>(end.cell));
    }
  }
  for (std::size_t i = 0; i < next.size(); ++i) {
    for (const CellEnd& end : wiring.neighbours[next[i]]) {
      if (end.cell < 0 || seen[static_cast<std::size_t>(end.cell)]) continue;
      seen[static_cast<std::size_t>(end.cell)] = true;
      group_of_cell_[static_cast<std::size_t>(end.cell)] = group_of_cell_[next[i]];
      next.push_back(static_cast<std::size_t>(end.cell));
    }
  }
  network_.observe(*this);
}

void NetworkTrial::run_until(std::int64_t end_ns) {
  network_.run_until(end_ns);
}

void NetworkTrial::measure_anew() {
  report_.samples_sent = report_.samples_heard = report_.samples_lost = report_.samples_twice = 0;
  report_.latency_max_ms = 0;
  std::ranges::fill(latencies_, 0);
  for (Listener& cell : cells_) {
    cell.samples.fill({});
    cell.gap_ns = -1;
  }
}

// ---- What the network tells ----

bool NetworkTrial::sample(std::size_t, std::int64_t, rs_sample& sample) {
  sample = still;
  return false;
}

void NetworkTrial::note_id(std::size_t cell, std::uint16_t id) {
  if (cell_by_id_.empty()) return;
  std::vector<std::int32_t>& by_id = cell_by_id_[group_of_cell_[cell]];
  if (by_id[cells_[cell].id] == static_cast<std::int32_t>(cell)) by_id[cells_[cell].id] = -1;
  cells_[cell].id = id;
  if (id != RS_ID_NONE) by_id[id] = static_cast<std::int32_t>(cell);
}

void NetworkTrial::cell_stepped(const Network& network, std::size_t index, const rs_input& input, const rs_output&) {
  Listener& cell = cells_[index];
  const rs_cell& state = network.cell(index);
  if (state.route.parent_port != cell.parent_port) {
    cell.parent_port = state.route.parent_port;
    changed_ = true;
  }
  if (state.id != cell.id && state.id <= RS_ID_LAST) {
    note_id(index, state.id);
    changed_ = true;
  }
  if (input.kind == RS_INPUT_BOOT) {
    cell.sequence = 0;
  } else if (state.sampling.sequence != cell.sequence) {
    if (input.kind == RS_INPUT_SAMPLE && report_.named_ms >= 0) {
      Sample& sample = cell.samples[cell.sequence];
      if (sample.sampled_ns >= 0 && !sample.heard) ++report_.samples_lost;
      sample = {network.time_ns(), false};
      ++report_.samples_sent;
    }
    cell.sequence = state.sampling.sequence;
  }
  if ((changed_ || revision_ != network.topology_revision()) && network.time_ns() >= next_survey_ns_) survey();
}

NetworkTrial::Listener* NetworkTrial::listener_of(std::size_t unit, const std::uint8_t* frame) {
  rs_clock sample;
  rs_clock_unpack(&sample, frame);
  const std::int32_t cell = cell_by_id_[group_of_unit_[unit]][std::min<std::size_t>(sample.source, RS_ID_LAST)];
  return cell < 0 ? nullptr : &cells_[static_cast<std::size_t>(cell)];
}

void NetworkTrial::frame_ended(const Network& network, WireEnd, WireEnd to, const std::uint8_t* frame, FrameFate fate) {
  if (to.at != WireEnd::At::unit || fate != FrameFate::delivered || !carries_sample(frame)) return;
  Listener* cell = listener_of(to.index, frame);
  rs_clock sample;
  rs_clock_unpack(&sample, frame);
  if (cell == nullptr || cell->samples[sample.sequence].sampled_ns < 0 || cell->samples[sample.sequence].heard) return;
  const std::int64_t latency_ns = network.time_ns() - cell->samples[sample.sequence].sampled_ns;
  ++latencies_[std::min(static_cast<std::size_t>(latency_ns / latency_bin_ns), latencies_.size() - 1)];
  report_.latency_max_ms = std::max(report_.latency_max_ms, ms(latency_ns));
}

void NetworkTrial::send(std::size_t unit, std::int64_t, std::span<const std::uint8_t> datagram) {
  rs_datagram_header header;
  const auto length = static_cast<std::uint32_t>(datagram.size());
  if (rs_datagram_header_unpack(&header, datagram.data(), length) != RS_DATAGRAM_OK) return;
  if (header.kind != RS_DATAGRAM_KIND_frames) return;
  for (std::size_t k = 0; k < header.count; ++k) {
    const std::uint8_t* record = datagram.data() + RS_DATAGRAM_HEADER_BYTES + RS_DATAGRAM_RECORD_BYTES * k;
    if (!carries_sample(record)) continue;
    Listener* cell = listener_of(unit, record);
    if (cell == nullptr) continue;
    rs_clock unpacked;
    rs_clock_unpack(&unpacked, record);
    Sample& sample = cell->samples[unpacked.sequence];
    if (sample.sampled_ns >= 0) {
      ++(sample.heard ? report_.samples_twice : report_.samples_heard);
      if (sample.heard) continue;  // nothing new
      sample.heard = true;
    }
    const std::int64_t now_ns = network_.time_ns();
    if (cell->heard_ns >= 0) cell->gap_ns = std::max(cell->gap_ns, now_ns - cell->heard_ns);
    cell->heard_ns = now_ns;
  }
}

void NetworkTrial::fault_applied(const Network& network, const Fault& fault, int phase) {
  changed_ = true;
  if (phase > 0) return;
  if (broken_since_ns_ >= 0) {
    FaultOutcome& before = report_.outcomes.back();
    before.recovery_ms = before.rejoin_ms = ms(network.time_ns() - struck_ns_);
    before.outage_ms = std::max(before.outage_ms, ms(network.time_ns() - broken_since_ns_));
  }
  struck_ns_ = network.time_ns();
  broken_since_ns_ = -1;
  rejoining_ = false;
  for (Listener& cell : cells_) cell.strayed = false;
  report_.outcomes.push_back({fault});
  changed_ = true;
  next_survey_ns_ = struck_ns_;
  survey();
}

// ---- Ways ----

void NetworkTrial::survey() {
  const std::int64_t now_ns = network_.time_ns();
  next_survey_ns_ = now_ns + survey_ns;
  changed_ = false;
  revision_ = network_.topology_revision();
  paths_.update();
  if (report_.formation_ms < 0 && paths_.shortest()) {
    report_.formation_ms = ms(now_ns);
    // Cells that have no power yet are as if they were out of reach; the last one completes the formation.
    for (std::size_t i = 0; i < cells_.size(); ++i)
      if (network_.starting(i)) report_.formation_ms = -1;
  }
  if (report_.named_ms < 0 && report_.formation_ms >= 0) {
    bool named = true;
    for (std::size_t i = 0; i < cells_.size(); ++i) named = named && (paths_.depth()[i] < 0 || cells_[i].id != 0);
    if (named) report_.named_ms = ms(now_ns);
  }

  std::uint32_t cut_off = 0, away = 0;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const bool in_reach = paths_.depth()[i] >= 0;
    const bool ran = network_.alive(i) && network_.booted_ns(i) < std::max<std::int64_t>(struck_ns_, 1);
    if (report_.named_ms >= 0 && (!in_reach || (struck_ns_ >= 0 && !ran))) cells_[i].steady = false;
    if (!in_reach) cells_[i].strayed = true;
    if (!in_reach || paths_.hops()[i] >= 0) continue;
    ++(ran && !cells_[i].strayed ? cut_off : away);
  }
  if (report_.outcomes.empty()) return;
  FaultOutcome& outcome = report_.outcomes.back();
  outcome.cells_cut_off = std::max(outcome.cells_cut_off, cut_off);
  if (broken_since_ns_ >= 0) {
    outcome.recovery_ms = ms(now_ns - struck_ns_);
    outcome.outage_ms = std::max(outcome.outage_ms, ms(now_ns - broken_since_ns_));
  }
  if (cut_off == 0) {
    broken_since_ns_ = -1;
  } else if (broken_since_ns_ < 0) {
    broken_since_ns_ = now_ns;
  }
  if (rejoining_ || broken_since_ns_ >= 0) outcome.rejoin_ms = ms(now_ns - struck_ns_);
  rejoining_ = away + cut_off > 0;
  outcome.healed = !rejoining_;
}

TrialReport NetworkTrial::report() {
  survey();
  TrialReport report = report_;
  const std::int64_t now_ns = network_.time_ns();
  report.seconds = 1e-9 * static_cast<double>(now_ns);
  report.whole = paths_.whole();
  for (const FaultOutcome& outcome : report.outcomes)
    report.recovery_max_ms = std::max(report.recovery_max_ms, outcome.recovery_ms);

  std::int64_t extra = 0, counted = 0;
  for (std::size_t u = 0; u < network_.unit_count(); ++u) report.port_loads.emplace_back(network_.unit(u).config.ports);
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    if (paths_.depth()[i] < 0) continue;
    ++report.cells_in_reach;
    const std::int32_t hops = paths_.hops()[i];
    if (hops < 0) continue;
    report.depth_max = std::max(report.depth_max, hops);
    report.extra_depth_max = std::max(report.extra_depth_max, hops - paths_.depth()[i]);
    extra += hops - paths_.depth()[i];
    ++counted;
    WireEnd at{WireEnd::At::cell, 0, static_cast<std::uint32_t>(i)};
    while (at.at == WireEnd::At::cell) {
      at.port = network_.cell(at.index).route.parent_port;
      at = network_.other_end(at);
    }
    ++report.port_loads[at.index][at.port - 1U];
  }
  if (counted > 0) report.extra_depth_mean = static_cast<double>(extra) / static_cast<double>(counted);

  for (Listener& cell : cells_) {
    std::int64_t gap_ns = cell.gap_ns;
    if (cell.heard_ns >= 0) gap_ns = std::max(gap_ns, now_ns - cell.heard_ns);
    report.cell_gap_ms.push_back(gap_ns < 0 ? -1 : ms(gap_ns));
    report.steady.push_back(cell.steady ? 1 : 0);
    if (cell.steady && gap_ns >= 0) report.host_gap_ms = std::max(report.host_gap_ms, ms(gap_ns));
    for (const Sample& sample : cell.samples)
      if (sample.sampled_ns >= 0 && !sample.heard && now_ns - sample.sampled_ns > settling_ns) ++report.samples_lost;
  }
  std::uint64_t heard = 0, weighted = 0, below = 0;
  for (std::size_t bin = 0; bin < latencies_.size(); ++bin) {
    heard += latencies_[bin];
    weighted += latencies_[bin] * (2 * bin + 1);
  }
  const double bin_ms = ms(latency_bin_ns);
  if (heard > 0) report.latency_mean_ms = 0.5 * bin_ms * static_cast<double>(weighted) / static_cast<double>(heard);
  for (std::size_t bin = 0; bin < latencies_.size() && heard > 0; ++bin) {
    below += latencies_[bin];
    if (100 * below < 99 * heard) continue;
    report.latency_p99_ms = bin_ms * static_cast<double>(bin + 1);
    break;
  }
  report.latency_counts = latencies_;
  report.counts = network_.counts();
  report.frames_lost = report.counts.frames_lost;
  report.frames_dropped = network_.frames_dropped();
  const std::vector<std::uint32_t> peaks = network_.queue_peaks();
  if (!peaks.empty()) report.queue_peak = std::ranges::max(peaks);
  report.log_hash = network_.log_hash();
  return report;
}

}  // namespace robotskin::world
