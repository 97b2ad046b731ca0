// SPDX-License-Identifier: Apache-2.0
#include "ur/ur_port.hpp"

#include <poll.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <random>
#include <thread>

#include "ur/ur_error.hpp"

namespace robotskin::ur {
namespace {

constexpr std::int64_t retry_ns = 200'000'000;         // between two tries to connect
constexpr std::int64_t script_start_ns = 500'000'000;  // that a controller may take to start a program
constexpr double reconnect_s = 0.2;                    // that each step of a further connection may take
constexpr std::int32_t running_mode = 7;               // robot_mode: brakes open
constexpr std::uint32_t playing = 2;                   // runtime_state

std::int64_t clock_ns(clockid_t clock) noexcept {
  timespec time{};
  clock_gettime(clock, &time);
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

void raise_event(int event) noexcept {
  const std::uint64_t one = 1;
  (void)!::write(event, &one, sizeof one);
}

void clear_event(int event) noexcept {
  std::uint64_t count = 0;
  (void)!::read(event, &count, sizeof count);
}

}  // namespace

std::string text_of(UrCondition condition) {
  switch (condition) {
    case UrCondition::ready:
      return "ready";
    case UrCondition::disconnected:
      return "the controller does not answer";
    case UrCondition::starting:
      return "its program does not run yet";
    case UrCondition::protective_stop:
      return "protective stop: unlock it at the teach pendant";
    case UrCondition::safeguard_stop:
      return "safeguard stop: reset the safeguard";
    case UrCondition::emergency_stop:
      return "emergency stop: release it and switch the robot on";
    case UrCondition::fault:
      return "fault of the controller's safety system: see the teach pendant";
    case UrCondition::not_running:
      return "the arm is off: switch it on and release its brakes";
  }
  return "";
}

UrPort::UrPort(const RobotModel& model, UrOptions options) : options_(std::move(options)), dynamics_(model) {
  if (model.joint_count() != ur::joint_count)
    throw UrError("robot " + options_.host + ": a UR has 6 joints, expected " + std::to_string(model.joint_count()) +
                  " of " + model.name());
  connection_ = std::make_unique<UrConnection>(options_.host, options_.model, options_.within_s);
  facts_ = connection_->facts();
  connections_ = 1;
  program_ = static_cast<std::int32_t>(std::random_device{}() & 0x7FFFFFFF);
  heard_ns_ = clock_ns(CLOCK_MONOTONIC);
  command_event_ = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  state_event_ = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (command_event_ < 0 || state_event_ < 0) throw UrError("robot " + options_.host + ": no event left");
  thread_ = std::thread([this] { run(); });
  const auto ends = std::chrono::steady_clock::now() + std::chrono::duration<double>(options_.within_s);
  while (condition() != UrCondition::ready && std::chrono::steady_clock::now() < ends)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  if (condition() == UrCondition::ready) return;
  const std::string why = text_of(condition());
  closing_ = true;
  thread_.join();
  ::close(command_event_);
  ::close(state_event_);
  throw UrError("robot " + options_.host + ": takes no commands: " + why);
}

UrPort::~UrPort() {
  close();
  if (command_event_ >= 0) ::close(command_event_);
  if (state_event_ >= 0) ::close(state_event_);
}

void UrPort::close() noexcept {
  if (!thread_.joinable()) return;
  stop();
  std::this_thread::sleep_for(std::chrono::milliseconds(4));  // the stop leaves before the connection ends
  closing_.store(true, std::memory_order_release);
  raise_event(command_event_);
  thread_.join();
  drop();
}

bool UrPort::offers(CommandMode mode) const noexcept {
  return mode != CommandMode::torque || facts_.takes_torque();
}

// ---- The cycle's thread ----

PortStatus UrPort::read(JointState& state) noexcept {
  if (condition() == UrCondition::disconnected) return PortStatus::disconnected;
  const Measured* newest = measured_.take();
  if (newest == nullptr) return PortStatus::no_new_state;
  read_position_ = newest->position;
  read_velocity_ = newest->velocity;
  read_ns_ = newest->stamp_ns;
  std::ranges::copy(newest->position, state.position.begin());
  std::ranges::copy(newest->velocity, state.velocity.begin());
  std::ranges::copy(newest->moment, state.effort.begin());
  state.stamp_ns = newest->stamp_ns;
  return PortStatus::ok;
}

PortStatus UrPort::write(const JointCommand& command) noexcept {
  const std::optional<CommandMode> mode = command.common_mode();
  if (!mode || !offers(*mode) || command.value.size() != ur::joint_count) return PortStatus::refused;
  if (!std::ranges::all_of(command.value, [](double value) { return std::isfinite(value); }))
    return PortStatus::refused;
  const UrCondition now = condition();
  if (now != UrCondition::ready)
    return now == UrCondition::disconnected ? PortStatus::disconnected : PortStatus::refused;
  Told told;
  std::ranges::copy(command.value, told.value.begin());
  told.mode = *mode == CommandMode::position   ? Mode::position
              : *mode == CommandMode::velocity ? Mode::velocity
                                               : Mode::torque;
  if (told.mode == Mode::torque) {
    // The controller carries the arm's own weight and adds it to what it is told.
    if (!dynamics_.update(read_position_, read_velocity_)) return PortStatus::refused;
    for (std::size_t i = 0; i < ur::joint_count; ++i) told.value[i] -= dynamics_.gravity_torque()[i];
  }
  told.answers_ns = read_ns_;
  tell(told);
  return PortStatus::ok;
}

void UrPort::stop() noexcept {
  tell({});
}

void UrPort::tell(const Told& told) noexcept {
  commands_.put(told);
  raise_event(command_event_);
}

void UrPort::await_state(std::int64_t until_ns) noexcept {
  const std::int64_t left_ns = until_ns - clock_ns(CLOCK_MONOTONIC);
  if (left_ns <= 0) return;
  const timespec left{left_ns / 1'000'000'000, left_ns % 1'000'000'000};
  pollfd one{state_event_, POLLIN, 0};
  if (ppoll(&one, 1, &left, nullptr) > 0) clear_event(state_event_);
}

// ---- The port's thread ----

void UrPort::run() noexcept {
  if (options_.realtime) {
    const sched_param priority{.sched_priority = 20};
    (void)sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &priority);
  }
  while (!closing_.load(std::memory_order_acquire)) {
    pollfd events[2] = {{command_event_, POLLIN, 0}, {connection_ ? connection_->descriptor() : -1, POLLIN, 0}};
    (void)poll(events, 2, 20);
    if ((events[0].revents & POLLIN) != 0) clear_event(command_event_);
    const std::int64_t now_ns = clock_ns(CLOCK_MONOTONIC);
    if (connection_ && events[1].revents != 0) receive(now_ns);
    send_newest();
    tend(now_ns);
  }
}

void UrPort::receive(std::int64_t now_ns) noexcept {
  bool fresh = false;
  if (!connection_->receive(fresh)) return drop();
  if (!fresh) return;
  heard_ns_ = now_ns;
  const UrState& state = connection_->state();
  measured_.put({state.position, state.velocity, state.moment, now_ns});
  speed_fraction_.store(state.speed_fraction, std::memory_order_relaxed);
  const bool took = condition() == UrCondition::ready;
  condition_.store(seen(), std::memory_order_release);
  raise_event(state_event_);
  // SAFETY: a script that goes on after a stop of the controller must not find a command from before it.
  if (took && condition() != UrCondition::ready) return send({});
  thread_seconds_.store(static_cast<double>(clock_ns(CLOCK_THREAD_CPUTIME_ID)) * 1e-9, std::memory_order_relaxed);
}

void UrPort::send_newest() noexcept {
  const Told* told = commands_.take();
  if (told == nullptr || !connection_) return;
  if (told->mode != Mode::stop && condition() != UrCondition::ready) return;
  send(*told);
  if (!connection_) return;
  // The first command after a state is its answer.
  if (told->answers_ns != timed_ns_ && told->answers_ns != never_ns) {
    timed_ns_ = told->answers_ns;
    latency_.add(clock_ns(CLOCK_MONOTONIC) - told->answers_ns);
  }
}

void UrPort::send(const Told& told) noexcept {
  sequence_ = sequence_ == 0x7FFFFFFF ? 1 : sequence_ + 1;
  if (!connection_->send(sequence_, told.mode, told.value)) drop();
}

void UrPort::tend(std::int64_t now_ns) noexcept {
  if (!connection_) return reconnect(now_ns);
  if (now_ns - heard_ns_ > static_cast<std::int64_t>(options_.silent_s * 1e9)) return drop();
  // SAFETY: a script that starts anew holds still until commands come that the robot's user has asked for anew.
  if (condition() == UrCondition::starting && (started_ns_ == never_ns || now_ns - started_ns_ > script_start_ns)) {
    started_ns_ = now_ns;
    const ScriptSettings settings{.step_s = facts_.step_s,
                                  .life_cycles = static_cast<int>(std::lround(command_life_s / facts_.step_s)),
                                  .takes_torque = facts_.takes_torque()};
    try {
      if (!connection_->start(script_text(settings, program_))) drop();
    } catch (...) {
      drop();
    }
  }
}

UrCondition UrPort::seen() const noexcept {
  const UrState& state = connection_->state();
  const auto safety = [&state](unsigned bit) { return (state.safety_bits >> bit & 1) != 0; };
  if (safety(5) || safety(6) || safety(7)) return UrCondition::emergency_stop;
  if (safety(8) || safety(9)) return UrCondition::fault;
  if (safety(2)) return UrCondition::protective_stop;
  if (safety(4) || safety(10)) return UrCondition::safeguard_stop;
  if (state.robot_mode != running_mode) return UrCondition::not_running;
  if (state.program != program_ || state.runtime_state != playing) return UrCondition::starting;
  return UrCondition::ready;
}

void UrPort::drop() noexcept {
  connection_.reset();
  condition_.store(UrCondition::disconnected, std::memory_order_release);
  raise_event(state_event_);
  started_ns_ = never_ns;
}

void UrPort::reconnect(std::int64_t now_ns) noexcept {
  if (tried_ns_ != never_ns && now_ns - tried_ns_ < retry_ns) return;
  tried_ns_ = now_ns;
  try {
    auto found = std::make_unique<UrConnection>(options_.host, facts_.model, reconnect_s);
    // SAFETY: another controller behind the address is not the one that was checked.
    if (found->facts().version != facts_.version) return;
    connection_ = std::move(found);
    program_ = program_ == 0x7FFFFFFF ? 1 : program_ + 1;
    heard_ns_ = clock_ns(CLOCK_MONOTONIC);
    connections_.fetch_add(1, std::memory_order_relaxed);
  } catch (...) {
    // It is not there yet.
  }
}

}  // namespace robotskin::ur
