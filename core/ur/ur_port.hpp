// SPDX-License-Identifier: Apache-2.0
// A UR robot behind the port of any robot. A thread of the port talks to the controller; the cycle meets it in two
// mailboxes and never waits. What moves the robot is a script on the controller, which stops it where commands end.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "model/mailbox.hpp"
#include "model/robot_dynamics.hpp"
#include "model/robot_model.hpp"
#include "model/robot_port.hpp"
#include "ur/latency_counts.hpp"
#include "ur/ur_connection.hpp"

namespace robotskin::ur {

// Why a UR robot takes commands, or does not.
enum class UrCondition : std::uint8_t {
  ready,
  disconnected,     // the controller does not answer; the port goes on trying
  starting,         // its program does not run yet
  protective_stop,  // to be unlocked at the teach pendant
  safeguard_stop,
  emergency_stop,
  fault,        // of the controller's safety system
  not_running,  // motors off or brakes closed
};

struct UrOptions {
  std::string host;
  std::string model;      // which robot must answer, such as UR5; empty: any with six joints
  double within_s = 2;    // for the first connection
  double silent_s = 0.1;  // without a state, after which the connection counts as gone
  bool realtime = false;  // the port's thread runs before all that are not real-time, where the system permits it
};

class UrPort final : public RobotPort {
 public:
  // Connects and starts the script, which holds still. Throws UrError for a robot that is not there, is another one
  // than `model` or `options.model`, or takes no commands within the time.
  UrPort(const RobotModel& model, UrOptions options);
  ~UrPort() override;
  UrPort(const UrPort&) = delete;
  UrPort& operator=(const UrPort&) = delete;

  std::size_t joint_count() const noexcept override { return ur::joint_count; }
  bool offers(CommandMode mode) const noexcept override;
  bool smooths_positions() const noexcept override { return true; }  // servoj looks ahead; a stop is stopj
  [[nodiscard]] PortStatus read(JointState& state) noexcept override;
  [[nodiscard]] PortStatus write(const JointCommand& command) noexcept override;
  void stop() noexcept override;
  double period_s() const noexcept override { return facts_.step_s; }
  void await_state(std::int64_t until_ns) noexcept override;

  // Stops the robot and ends the connection for good.
  void close() noexcept;

  const UrFacts& facts() const noexcept { return facts_; }
  UrCondition condition() const noexcept { return condition_.load(std::memory_order_acquire); }
  double speed_fraction() const noexcept { return speed_fraction_.load(std::memory_order_relaxed); }
  std::uint64_t connections() const noexcept { return connections_.load(std::memory_order_relaxed); }
  double thread_seconds() const noexcept { return thread_seconds_.load(std::memory_order_relaxed); }
  // From the arrival of a state to the command that it led to, as given to the system.
  LatencyCounts& latency() noexcept { return latency_; }

 private:
  struct Measured {
    Joints position{}, velocity{}, moment{};
    std::int64_t stamp_ns = never_ns;
  };
  struct Told {
    Mode mode = Mode::stop;
    Joints value{};
    std::int64_t answers_ns = never_ns;  // stamp of the state that the cycle had read
  };

  void run() noexcept;
  void tend(std::int64_t now_ns) noexcept;
  void reconnect(std::int64_t now_ns) noexcept;
  void receive(std::int64_t now_ns) noexcept;
  void send_newest() noexcept;
  void send(const Told& told) noexcept;
  void drop() noexcept;
  UrCondition seen() const noexcept;
  void tell(const Told& told) noexcept;

  UrOptions options_;
  RobotDynamics dynamics_;  // of the cycle's thread
  Joints read_position_{}, read_velocity_{};
  std::int64_t read_ns_ = never_ns;

  std::unique_ptr<UrConnection> connection_;  // of the port's thread, once it runs
  UrFacts facts_;
  std::int32_t program_ = 0, sequence_ = 0;
  std::int64_t heard_ns_ = 0, started_ns_ = never_ns, tried_ns_ = never_ns, timed_ns_ = never_ns;

  Mailbox<Measured> measured_;
  Mailbox<Told> commands_;
  std::atomic<UrCondition> condition_{UrCondition::starting};
  std::atomic<double> speed_fraction_{1}, thread_seconds_{0};
  std::atomic<std::uint64_t> connections_{0};
  LatencyCounts latency_;
  int command_event_ = -1, state_event_ = -1;
  std::atomic<bool> closing_{false};
  std::thread thread_;
};

// In words that say what to do.
std::string text_of(UrCondition condition);

}  // namespace robotskin::ur
