// SPDX-License-Identifier: Apache-2.0
// One connection to a UR controller: which robot it is, what it measures, what it is sent. It belongs to one thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "ur/rtde_wire.hpp"
#include "ur/tcp_socket.hpp"
#include "ur/ur_script.hpp"

namespace robotskin::ur {

inline constexpr std::size_t joint_count = 6;
inline constexpr std::uint16_t dashboard_port = 29999, script_port = 30002, rtde_port = 30004;
using Joints = std::array<double, joint_count>;

// What a controller says of itself before anything moves.
struct UrFacts {
  std::string model;                       // as its dashboard says: UR5
  std::array<std::uint32_t, 4> version{};  // of the controller's software
  std::optional<bool> remote_control;      // none: a controller that does not know the question
  double step_s = 0;                       // between two states

  bool at_least(std::uint32_t major, std::uint32_t minor) const noexcept {
    return version[0] != major ? version[0] > major : version[1] >= minor;
  }
  // PolyScope 5.23, and 10.10 of PolyScope X.
  bool takes_torque() const noexcept { return version[0] >= 10 ? at_least(10, 10) : at_least(5, 23); }
  std::string version_text() const;
};

// One package of measurements.
struct UrState {
  Joints position{}, velocity{}, moment{};  // rad, rad/s, Nm that the controller asks of its motors
  std::int32_t robot_mode = 0;
  std::uint32_t safety_bits = 0;
  std::uint32_t runtime_state = 0;
  double speed_fraction = 0;  // of the slider
  std::int32_t heard = 0;     // sequence of the last command that the script saw
  std::int32_t program = 0;   // that runs
};

class UrConnection {
 public:
  // Asks dashboard and RTDE for facts and begins to receive states. `model`: which robot must answer, empty for any.
  // Throws UrError: nothing there, another robot, local control, software too old, registers in use.
  UrConnection(const std::string& host, const std::string& model, double within_s);

  const UrFacts& facts() const noexcept { return facts_; }
  int descriptor() const noexcept { return rtde_.descriptor(); }

  // Hands the program to the controller, which ends the one that ran. False: it was not taken.
  bool start(const std::string& script) noexcept;
  // Takes what has arrived and keeps the newest state; false: the connection is gone.
  bool receive(bool& fresh) noexcept;
  const UrState& state() const noexcept { return state_; }
  // False: the connection is gone.
  bool send(std::int32_t sequence, Mode mode, const Joints& value) noexcept;

 private:
  void ask_dashboard(const std::string& model, double within_s);
  void agree(double within_s);
  rtde::Package answer(rtde::Kind kind, double within_s);
  std::uint8_t recipe(rtde::Kind kind, double frequency, const std::string& names, const std::string& types,
                      double within_s);
  bool take(const rtde::Package& package) noexcept;

  std::string host_;
  UrFacts facts_;
  TcpSocket rtde_, script_;
  rtde::Splitter splitter_;
  rtde::Writer writer_;
  std::uint8_t output_recipe_ = 0, input_recipe_ = 0;
  UrState state_;
};

}  // namespace robotskin::ur
