// SPDX-License-Identifier: Apache-2.0
// The cells' network in virtual time: links at 4 Mb/s, and the shipping firmware in every cell and section unit.
//
// A discrete-event simulation. A frame occupies its wire for 50 us of the sender's clock; then the receiver gets it and
// the sender is told. A cell wakes when its firmware asks to. Nothing is allocated once the run has settled, and one
// seed gives one run, to the byte (`log_hash`).
//
// Groups of section units that share no wire know nothing of each other. Asked to (`NetworkOptions::threads`), each
// such lane is run by itself, on several threads side by side; the run is the same for any number of them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "driver/keyed_hash.hpp"
#include "robotskin/cell.h"
#include "robotskin/section_unit.h"
#include "robotskin/settings.h"
#include "world/network/event_queue.hpp"
#include "world/network/external_cell.hpp"
#include "world/network/fault.hpp"
#include "world/network/observer.hpp"
#include "world/network/processor.hpp"
#include "world/network/wiring.hpp"
#include "world/network/workers.hpp"

namespace robotskin::world {

// Where cells get their readings.
class SampleSource {
 public:
  virtual ~SampleSource() = default;
  // The reading of `cell` at `time_ns`; true if a channel is missing or at the end of its range. Of a network whose
  // lanes have threads of their own, called by several at once, for different cells.
  virtual bool sample(std::size_t cell, std::int64_t time_ns, rs_sample& sample) = 0;
};

// Where section units send their datagrams.
class DatagramSink {
 public:
  virtual ~DatagramSink() = default;
  // Sent at this virtual time.
  virtual void send(std::size_t unit, std::int64_t time_ns, std::span<const std::uint8_t> datagram) = 0;
};

struct NetworkOptions {
  LineQuality line;
  Processor processor = Processor::none;  // of the cells
  std::uint32_t batch_us = 1000;          // of the section units
  bool unasked = false;                   // section units send without a keep-alive
  bool powered = true;                    // ports are on from the start
  std::size_t threads = 0;                // that run lanes side by side, the caller's among them; 0: all is one lane
  std::int64_t epoch_ns = 0;              // the section units' clock at virtual time 0
  std::uint64_t seed = 1;
  std::uint8_t clock_rate_hz = RS_CLOCK_RATE_DEFAULT_HZ;  // kept in the cells' flash
  std::optional<rs_settings> settings;                    // the same, but for the id; instead of `clock_rate_hz`
  std::vector<Fault> faults;                              // that strike during the run; see `inject`
  std::optional<driver::Key> key;                         // of datagrams; none: not authenticated
  std::optional<std::array<std::uint8_t, RS_CELL_KEY_BYTES>>
      cell_key;  // of ticks and commands; none: not authenticated
};

struct NetworkCounts {
  std::uint64_t frames_sent = 0;       // that began on a wire with something at its end
  std::uint64_t frames_delivered = 0;  // hops
  std::uint64_t frames_lost = 0;       // on a wire: by chance, cut, or to a dead cell
  std::uint64_t frames_damaged = 0;    // by bit errors
  std::uint64_t frames_overrun = 0;    // of those: they came to a cell that was too busy to take them
  std::uint64_t cell_steps = 0;
  std::uint64_t events = 0;
  std::uint64_t datagrams = 0;
  std::uint64_t datagram_bytes = 0;
  std::uint64_t records = 0;  // frames inside datagrams

  NetworkCounts& operator+=(const NetworkCounts& other);
};

class Network {
 public:
  Network(const Wiring& wiring, const NetworkOptions& options, SampleSource& source, DatagramSink& sink);
  ~Network();
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  // Runs all events before `end_ns` of virtual time.
  void run_until(std::int64_t end_ns);
  std::int64_t time_ns() const;

  // A datagram from the host, now.
  void receive(std::size_t unit, std::span<const std::uint8_t> datagram);

  // ---- Faults ----
  // The wire at a cell's port carries nothing any more (mended: again); `out` and `in` name the directions.
  void cut(std::size_t cell, int port, bool out = true, bool in = true);
  void mend(std::size_t cell, int port);
  void kill(std::size_t cell);
  // Starts a cell, after `off_ns` without power if it runs.
  void reboot(std::size_t cell, std::int64_t off_ns);
  // Lets a fault strike at its time, which must not be over. Throws FaultError for a target that does not exist, and
  // for one that had to be known at the start.
  void inject(const Fault& fault);

  // The observer is told of every event from now on, and must live as long.
  void observe(Observer& observer) { observers_.push_back(&observer); }

  // What a cell adds to the torque of its limb, each epoch from the next on, over reboots too.
  void contribute(std::size_t cell, const rs_contribution& contribution);

  // Torque parameters in a cell's flash (torque_parameters.h), which it finds at its next start.
  void set_torque_image(std::size_t cell, std::span<const std::uint8_t, RS_TORQUE_IMAGE_BYTES> image);

  // From now on the external cell lives as this cell; it must live as long. Its first input is the boot, so give it
  // before that.
  void put(std::size_t cell, ExternalCell& external);

  // ---- What is so ----
  const Wiring& wiring() const { return wiring_; }  // as it was built
  // What is at the other end of a wire now.
  WireEnd other_end(WireEnd end) const;
  // Whether frames out of this end arrive somewhere that runs.
  bool carries(WireEnd from) const;
  bool unit_runs(std::size_t unit) const;
  bool port_powered(std::size_t unit, int port) const;
  std::int64_t booted_ns(std::size_t cell) const;  // when it last started, -1: never
  std::uint64_t topology_revision() const;         // counts changes of wires and power
  std::size_t cell_count() const;
  std::size_t unit_count() const;
  const rs_cell& cell(std::size_t index) const;
  bool alive(std::size_t cell) const;
  bool starting(std::size_t cell) const;  // has power, and has not started yet
  const rs_section_unit& unit(std::size_t index) const;
  NetworkCounts counts() const;
  std::size_t lane_count() const;                  // parts that share nothing
  std::uint64_t frames_dropped() const;            // by full queues of cells and section units
  std::vector<std::uint32_t> queue_peaks() const;  // (N) frames waiting in a cell at once, at most
  std::vector<std::int32_t> depths() const;        // (N) hops to the nearest port over wires that work, -1: none
  bool formed() const;                             // every cell that can be reached has a parent and that depth
  std::uint64_t log_hash() const;                  // of all lanes, in their order

  struct RunningFault;  // a fault at work: what faults/ sees of a network

 private:
  struct Cell;
  struct Unit;
  struct InFlightDatagram;
  struct Wire;   // one direction
  struct Board;  // of a cell whose processor takes time

  struct Lane;  // cells, section units and events that share nothing with the rest

  struct Trouble;  // of a wire
  struct Taped;    // a frame for an act to play again

  void boot(std::size_t cell);
  void boot_unit(std::size_t unit);
  void wake(Lane& lane, std::size_t cell);
  void fetch(std::uint32_t what) const;
  void wake_unit_now(Lane& lane, std::size_t unit);
  void supply(Lane& lane);  // gives or takes power after a change of ports, wires or cells
  void step_cell(std::size_t cell, rs_input input);
  void step_unit(std::size_t unit, const rs_unit_input& input);
  void start(std::uint32_t wire, const std::uint8_t* frame, std::int64_t begin_ns);
  void finish(Lane& lane, std::uint32_t wire);
  void wake_cell(std::size_t cell, std::int64_t time_ns);
  // Boards and processors (processing.cpp); wires are those that lead out of the cell.
  bool takes_time() const { return options_.processor != Processor::none; }
  bool idle(std::size_t cell) const;                                 // its processor
  bool has_room(std::size_t wire, const std::uint8_t* frame) const;  // for one that comes
  void arrive(std::size_t wire, const std::uint8_t* frame);
  bool takes_frame(std::size_t wire) const;  // that goes
  void send(std::size_t wire, const std::uint8_t* frame);
  void let_go(std::size_t wire);
  std::uint32_t events_of(std::size_t cell) const;
  void serve(std::size_t cell);
  void plan(std::size_t cell);
  void forget_board(std::size_t cell);
  void wake_unit(std::size_t unit, std::int64_t time_ns);
  const std::uint8_t* cell_key() const;

  // Lanes (lanes.cpp).
  Lane& lane_of_cell(std::size_t cell);
  Lane& lane_of_unit(std::size_t unit);
  Lane& lane_of_wire(std::size_t wire);
  const Lane& lane_of_cell(std::size_t cell) const;
  Lane& lane_of(const Fault& fault);
  void find_lanes();
  void unite(std::size_t kept, std::size_t given_up);
  void run(Lane& lane, std::int64_t end_ns);
  void run_lanes(std::int64_t end_ns);
  bool may_run_side_by_side() const;
  void send_to_host(Lane& lane, std::size_t unit, std::span<const std::uint8_t> datagram);
  void hand_over();

  std::size_t cell_wires() const { return RS_PORTS * wiring_.cell_count(); }
  std::size_t wire_of(WireEnd end) const;
  WireEnd end_of(std::size_t wire) const;
  // Wires of a fault's port, or of all its ports, or all wires; as indices of the wires that lead out of it.
  std::vector<std::size_t> wires_of(const Fault& fault) const;
  void plan_act(std::int64_t time_ns, std::size_t index);
  void act(std::size_t index);
  void sever(std::size_t wire, std::uint8_t why, bool out, bool in);
  void join(std::size_t a, std::size_t b);
  void part(std::size_t wire);
  void post_to_peers(std::size_t from, std::span<const std::uint8_t> datagram);
  void deliver_letter(Lane& lane, std::size_t index);
  void run_zombie(std::size_t cell);
  void report_idle_wires(std::size_t cell);
  template <typename Tell>
  void tell(const Tell& what) {
    for (Observer* observer : observers_) what(*observer);
  }

  Wiring wiring_;
  NetworkOptions options_;
  std::optional<driver::KeyedHash> hash_;
  SampleSource& source_;
  DatagramSink& sink_;
  std::uint64_t wire_keys_;
  std::vector<Lane> lanes_;
  std::vector<std::uint8_t> lane_of_cell_, lane_of_unit_;
  bool lanes_run_ = false;
  std::unique_ptr<Workers> workers_;        // of lanes that are run side by side
  std::int64_t lanes_end_ns_ = 0;           // of the run that they are in
  std::vector<std::size_t> next_outgoing_;  // by lane
  std::vector<Cell> cells_;
  std::vector<Board> boards_;  // by cell, if processors take time
  std::vector<Unit> units_;
  std::vector<Wire> wires_;
  std::vector<Trouble> troubles_;  // by wire, once there are any
  std::vector<RunningFault> acts_;
  std::vector<Event> acts_due_;         // what: of which act; the first one first
  std::vector<Fault> ethernet_faults_;  // in force
  std::vector<Observer*> observers_;
  std::size_t external_index_ = 0;
  ExternalCell* external_ = nullptr;
};

}  // namespace robotskin::world
