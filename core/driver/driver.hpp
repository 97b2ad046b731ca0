// SPDX-License-Identifier: Apache-2.0
// The driver: datagrams of section units in, the newest checked sample of every cell out.
//
// `handle` takes one datagram; what is malformed, foreign, unauthenticated, replayed or seen before is counted and
// changes nothing. `publish` hands all that has changed to the reading threads, without waiting. `downlink` gives the
// datagrams that are due to the section units. Neither allocates, locks or throws. One thread calls these three; each
// table is read by one other thread. Time is an argument: nanoseconds of the host's monotonic clock, growing.
//
// Sessions. With a key, a datagram must carry a right tag, must answer one of this driver's own last sessions, and its
// sequence number must be new. A unit whose tag is right but that answers no session yet is pending: it gets a
// keep-alive that answers its session, whereupon it answers ours, which proves that it lives now. When a known unit
// comes back with another session, the driver draws itself a new one, so that nothing of before can come back. Without
// a key anyone can send anything: a new session is then taken for a restart at once, and only ended ones are refused.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "driver/cell_index.hpp"
#include "driver/clock_offset.hpp"
#include "driver/downlink.hpp"
#include "driver/keyed_hash.hpp"
#include "driver/ring.hpp"
#include "driver/sample.hpp"
#include "driver/sequence_window.hpp"
#include "driver/snapshot_table.hpp"
#include "driver/statistics.hpp"
#include "driver/topology.hpp"
#include "driver/torque_table.hpp"
#include "driver/witness.hpp"
#include "robotskin/timing.h"

namespace robotskin::driver {

struct Options {
  std::vector<CellKey> keys;       // cells in the order of the snapshot
  std::optional<Key> key;          // pre-shared; none: nothing is authenticated
  std::uint64_t session_seed = 1;  // sessions are drawn from it: take a random one where anyone may listen
  std::size_t spare_cells = 0;     // room for cells that are not in `keys`: they are added when first heard
  std::size_t spare_groups = 0;    // and for their section-unit groups
  // Added to the host clock in what is sent: section units want a clock that grows over restarts of the host.
  std::int64_t calendar_ns = 0;
};

class Driver {
 public:
  static constexpr std::size_t units_max = 256;
  static constexpr std::int64_t epoch_ns = std::int64_t{RS_EPOCH_TICKS} * RS_TICK_US * 1000;  // of torque sums
  static constexpr std::size_t limbs_max = 64;
  static constexpr std::int64_t joints_fresh_ns = 20'000'000;  // older positions are not sent any more
  static constexpr std::int64_t unit_silent_ns = 3 * RS_KEEP_ALIVE_MS * std::int64_t{1'000'000};

  // Throws std::invalid_argument for keys that are no cells or given twice.
  explicit Driver(const Options& options);

  // ---- The driver's thread ----

  Verdict handle(std::span<const std::uint8_t> datagram, std::int64_t now_ns);

  void publish(std::int64_t now_ns);

  // Takes a recorded datagram that a driver has accepted before: its tag and what it answers are not looked at again.
  // For replay alone; no socket leads here.
  Verdict replay(std::span<const std::uint8_t> datagram, std::int64_t now_ns);

  using Sink = std::function<void(const Recipient&, std::span<const std::uint8_t>)>;

  // Hands every datagram that is due to `sink`. Keep-alives are due every 100 ms, and at once after a restart.
  void downlink(std::int64_t now_ns, const Sink& sink);

  // The unit whose datagram was handled last, if it was accepted or came with a right tag from a pending one.
  Recipient last_heard() const { return last_heard_; }

  // All that samples depend on, as bytes: `keyframe_parts` shows where they lie, without a copy; they hold until the
  // next call that changes the driver. `restore` takes them in, so that the next publication is the one of the
  // keyframe; throws std::invalid_argument for bytes that no driver of these cells can have written.
  static constexpr std::size_t keyframe_parts_count = 10;
  using KeyframeParts = std::array<std::span<const std::uint8_t>, keyframe_parts_count>;
  KeyframeParts keyframe_parts() const;
  void restore(std::span<const std::uint8_t> keyframe);

  // ---- Any one other thread ----

  // Lets `witness` look on, or none (null), from one of the driver's next calls on. It must outlive the driver.
  void set_witness(Witness* witness) { witness_.store(witness, std::memory_order_release); }

  // Sends a command as soon as its section units are known; the ticket that its replies carry, or nothing if 256 are
  // waiting already.
  std::optional<std::uint32_t> command(Command command);
  // Commands go on a third of the round ahead: where units and hosts have both been started anew, cells may know a
  // later counter than either. Of three such leaps one is newer than whatever a cell knows.
  void leap_command_counter() { leap_.store(true, std::memory_order_release); }
  bool power(const Power& power) { return powers_.push(power); }
  // Where the joints of a limb are at `set_ns`; the newest positions go out once an epoch. False for a limb, a count or
  // a time that cannot be, or no room for another limb.
  [[nodiscard]] bool joints(const LimbJoints& joints);
  std::optional<Reply> reply() { return replies_.pop(); }

  // The cells that the driver was made with, in the order of the rows.
  const std::vector<CellKey>& keys() const { return keys_; }

  SnapshotTable<Sample>& samples() { return samples_; }
  SnapshotTable<TopologyRow>& topology() { return topology_; }
  SnapshotTable<UnitRow>& units() { return units_; }
  SnapshotTable<LimbTorque>& torques() { return torques_.rows(); }
  Statistics& statistics() { return statistics_; }
  const Statistics& statistics() const { return statistics_; }
  std::uint32_t session() const { return session_; }

 private:
  static bool silent(const UnitRow& unit, std::int64_t now_ns) { return now_ns - unit.heard_ns > unit_silent_ns; }
  // A section unit's clock may say anything: what it calls older than this is no more than this old, and never to come.
  static constexpr std::int64_t oldest_ns = 60'000'000'000;

  struct Link {
    std::uint32_t session = 0;
    SequenceWindow window;
    ClockOffset clock;
    std::array<std::uint32_t, 8> ended{};  // sessions, used without a key
    std::uint8_t next_ended = 0;
    std::uint64_t missing_counted = 0;
    std::uint32_t dropped = 0;
    std::int64_t joints_epoch = -1;  // in which joint positions were last sent
  };

  struct PendingUnit {
    Recipient unit;
    std::uint32_t session = 0;
    bool due = false;
  };

  Verdict take(std::span<const std::uint8_t> datagram, std::int64_t now_ns, bool trusted);
  void prefetch(const rs_datagram_header& header, std::span<const std::uint8_t> datagram);

  // sessions.cpp
  void draw_session();
  bool answers_us(std::uint32_t session) const;
  std::optional<std::size_t> find_unit(std::uint16_t group, std::uint8_t unit);
  void register_unit(const rs_datagram_header& header);
  Verdict check_session(const rs_datagram_header& header, std::int64_t now_ns, bool trusted, std::size_t* unit);

  // records.cpp
  void take_record(const rs_datagram_header& header, CellIndex::Group& group, std::size_t unit_row,
                   const std::uint8_t* record);
  bool is_new(std::size_t row, const rs_clock& frame, std::int64_t arrival_ns);
  void take_sample(CellIndex::Group& group, std::size_t unit_row, const std::uint8_t* record, std::uint64_t unit_ns,
                   std::int64_t arrival_ns);
  void take_further(CellIndex::Group& group, const std::uint8_t* record, std::uint64_t unit_ns,
                    std::int64_t arrival_ns);
  void count_events(const Sample& before, const rs_clock& frame);
  void take_topology(CellIndex::Group& group, UnitRow& unit, const std::uint8_t* record, std::int64_t arrival_ns);
  void reference(CellIndex::Group& group, const ReportedNeighbour& neighbour, int by, std::int64_t now_ns);
  void take_rate_divisor(std::size_t unit_row, const std::uint8_t* record);
  void take_reply(CellIndex::Group& group, UnitRow& unit, const std::uint8_t* record, std::int64_t arrival_ns);

  // downlink.cpp
  void keep_alive(std::int64_t now_ns, const Sink& sink);
  bool ready_to_command(std::int64_t now_ns);
  void send_commands(std::int64_t now_ns, const Sink& sink);
  void send_joints(std::int64_t now_ns, const Sink& sink);
  void send(rs_datagram_kind kind, std::uint16_t count, const Recipient& to, std::uint32_t answering,
            std::int64_t now_ns, const Sink& sink);

  std::vector<CellKey> keys_;
  std::optional<KeyedHash> hash_;
  CellIndex index_;
  SnapshotTable<Sample> samples_;
  SnapshotTable<TopologyRow> topology_;
  SnapshotTable<UnitRow> units_;
  TorqueTable torques_;
  SnapshotTable<LimbJoints> joints_;         // written by the thread that commands
  std::size_t limbs_ = 0;                    // rows of it in use, of that thread
  std::vector<std::uint8_t> references_;     // by row: neighbours that report the cell
  std::vector<std::uint32_t> heard_;         // by row: bit i: the sample i before the newest has been heard
  std::vector<std::uint16_t> arrival_port_;  // by row: unit's row * 16 + port of the newest sample
  std::vector<Link> links_;                  // by row of units_
  std::size_t unit_count_ = 0;
  std::vector<std::uint32_t> unit_names_;  // by row of units_: section-unit group << 8 | unit
  std::vector<PendingUnit> pending_units_;
  Recipient last_heard_;

  std::uint64_t random_;
  std::uint32_t session_ = 0;
  std::array<std::uint32_t, 4> own_sessions_{};
  std::uint32_t sequence_ = 0;
  std::int64_t calendar_ns_;
  std::int32_t command_counter_ = -1;  // of the last command, -1: no section unit has told it yet
  std::int64_t counter_known_ns_ = 0;
  std::atomic<bool> leap_{false};
  struct Sent {
    std::uint32_t ticket = 0;
    std::uint16_t counter = 0;
  };
  std::array<Sent, 1024> sent_{};  // by counter
  std::uint32_t ticket_ = 0;       // of the thread that commands
  std::int64_t keep_alive_ns_ = 0;
  bool keep_alive_due_ = true;
  std::array<std::uint8_t, RS_DATAGRAM_BYTES_MAX> out_{};

  Ring<Command, 256> commands_;
  Ring<Power, 64> powers_;
  Ring<Reply, 4096> replies_;
  mutable std::array<std::uint64_t, 6> keyframe_header_{};  // what keyframe_parts shows first
  Statistics statistics_;
  std::atomic<Witness*> witness_{nullptr};
  Witness* looking_on_ = nullptr;            // during one call of the driver's thread
  std::vector<std::int64_t> departures_ns_;  // of the datagrams since the last publication, host clock
};

}  // namespace robotskin::driver
