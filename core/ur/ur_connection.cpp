// SPDX-License-Identifier: Apache-2.0
#include "ur/ur_connection.hpp"

#include <chrono>
#include <sstream>

#include "ur/ur_error.hpp"

namespace robotskin::ur {
namespace {

using rtde::Kind;

constexpr double send_s = 0.002;  // that a package of 60 bytes may take
constexpr double script_s = 0.2;  // that a script may take
constexpr char output_names[] =
    "actual_q,actual_qd,target_moment,robot_mode,safety_status_bits,runtime_state,target_speed_fraction,"
    "output_int_register_24,output_int_register_25";
constexpr char output_types[] = "VECTOR6D,VECTOR6D,VECTOR6D,INT32,UINT32,UINT32,DOUBLE,INT32,INT32";
constexpr char input_names[] =
    "input_int_register_24,input_int_register_25,input_double_register_24,input_double_register_25,"
    "input_double_register_26,input_double_register_27,input_double_register_28,input_double_register_29";
constexpr char input_types[] = "INT32,INT32,DOUBLE,DOUBLE,DOUBLE,DOUBLE,DOUBLE,DOUBLE";

// Of UR5 and UR5e the same: they differ by generation, which the version tells.
std::string family(std::string model) {
  if (!model.empty() && (model.back() == 'e' || model.back() == 'E')) model.pop_back();
  for (char& one : model)
    if (one >= 'a' && one <= 'z') one = static_cast<char>(one - 'a' + 'A');
  return model;
}

Joints joints(rtde::Reader& body) noexcept {
  Joints values;
  for (double& one : values) one = body.real();
  return values;
}

}  // namespace

std::string UrFacts::version_text() const {
  std::ostringstream text;
  text << version[0] << "." << version[1] << "." << version[2];
  return text.str();
}

UrConnection::UrConnection(const std::string& host, const std::string& model, double within_s) : host_(host) {
  ask_dashboard(model, within_s);
  rtde_ = TcpSocket(host, rtde_port, within_s);
  agree(within_s);
  script_ = TcpSocket(host, script_port, within_s);
}

void UrConnection::ask_dashboard(const std::string& model, double within_s) {
  TcpSocket dashboard(host_, dashboard_port, within_s);
  const std::string greeting = dashboard.line(within_s);
  if (greeting.find("Dashboard Server") == std::string::npos)
    throw UrError("robot " + host_ + ": no UR controller, its port 29999 says '" + greeting.substr(0, 60) + "'");
  const auto ask = [&](const std::string& question) {
    if (!dashboard.send(question + "\n", within_s)) throw UrError("robot " + host_ + ": its dashboard is gone");
    return dashboard.line(within_s);
  };
  facts_.model = ask("get robot model");
  if (!model.empty() && family(facts_.model) != family(model))
    throw UrError("robot " + host_ + ": found a " + facts_.model + ", expected a " + model);
  const std::string remote = ask("is in remote control");
  if (remote == "true" || remote == "false") facts_.remote_control = remote == "true";
  if (facts_.remote_control == false)
    throw UrError("robot " + host_ + ": in local control, expected remote control; switch it at the teach pendant");
}

rtde::Package UrConnection::answer(Kind kind, double within_s) {
  using Clock = std::chrono::steady_clock;
  const auto ends = Clock::now() + std::chrono::duration<double>(within_s);
  for (;;) {
    rtde::Package package;
    while (splitter_.next(package)) {
      if (package.kind == kind) return package;
      if (package.kind != Kind::text && package.kind != Kind::data)
        throw UrError("robot " + host_ + ": answered RTDE '" + std::string(1, static_cast<char>(package.kind)) +
                      "', expected '" + std::string(1, static_cast<char>(kind)) + "'");
    }
    const double left_s = std::chrono::duration<double>(ends - Clock::now()).count();
    int count = -1;
    if (left_s > 0 && rtde_.wait(left_s)) count = rtde_.receive(splitter_.room());
    if (count < 0 || splitter_.broken())
      throw UrError("robot " + host_ + ": port 30004 " +
                    (left_s > 0 ? "speaks no RTDE" : "gives no answer; is RTDE enabled under Security, Services?"));
    splitter_.arrived(static_cast<std::size_t>(count));
  }
}

std::uint8_t UrConnection::recipe(Kind kind, double frequency, const std::string& names, const std::string& types,
                                  double within_s) {
  writer_.begin(kind);
  if (kind == Kind::outputs) writer_.real(frequency);
  if (!rtde_.send(writer_.text(names).bytes(), within_s)) throw UrError("robot " + host_ + ": RTDE is gone");
  rtde::Reader body(answer(kind, within_s).body);
  const auto id = body.number<std::uint8_t>();
  const std::string found(body.rest());
  if (id == 0 || found != types) {
    const bool taken = found.find("IN_USE") != std::string::npos;
    throw UrError("robot " + host_ + ": RTDE offers " + found + " for " + names + ", expected " + types +
                  (taken ? "; another program commands this robot, end it first" : ""));
  }
  return id;
}

void UrConnection::agree(double within_s) {
  const auto sent = [&](std::span<const std::uint8_t> bytes) {
    if (!rtde_.send(bytes, within_s)) throw UrError("robot " + host_ + ": RTDE is gone");
  };
  sent(writer_.begin(Kind::protocol_version).number(rtde::protocol_version).bytes());
  if (rtde::Reader(answer(Kind::protocol_version, within_s).body).number<std::uint8_t>() != 1)
    throw UrError("robot " + host_ + ": speaks RTDE 1 alone, expected 2; update its software to 3.9, 5.3 or newer");
  sent(writer_.begin(Kind::controller_version).bytes());
  rtde::Reader version(answer(Kind::controller_version, within_s).body);
  for (std::uint32_t& one : facts_.version) one = version.number<std::uint32_t>();
  // Below these the registers for other programs do not exist.
  if (facts_.version[0] < 5 ? !facts_.at_least(3, 9) : !facts_.at_least(5, 3))
    throw UrError("robot " + host_ + ": found software " + facts_.version_text() + ", expected 3.9, 5.3 or newer");
  facts_.step_s = facts_.version[0] < 5 ? 0.008 : 0.002;
  output_recipe_ = recipe(Kind::outputs, 1 / facts_.step_s, output_names, output_types, within_s);
  input_recipe_ = recipe(Kind::inputs, 0, input_names, input_types, within_s);
  sent(writer_.begin(Kind::start).bytes());
  if (rtde::Reader(answer(Kind::start, within_s).body).number<std::uint8_t>() != 1)
    throw UrError("robot " + host_ + ": RTDE does not start");
}

bool UrConnection::start(const std::string& script) noexcept {
  if (script_.send(script, script_s)) return true;
  try {
    script_ = TcpSocket(host_, script_port, script_s);
    return script_.send(script, script_s);
  } catch (const UrError&) {
    return false;
  }
}

bool UrConnection::take(const rtde::Package& package) noexcept {
  if (package.kind != Kind::data) return false;
  rtde::Reader body(package.body);
  if (body.number<std::uint8_t>() != output_recipe_) return false;
  UrState state;
  state.position = joints(body);
  state.velocity = joints(body);
  state.moment = joints(body);
  state.robot_mode = body.number<std::int32_t>();
  state.safety_bits = body.number<std::uint32_t>();
  state.runtime_state = body.number<std::uint32_t>();
  state.speed_fraction = body.real();
  state.heard = body.number<std::int32_t>();
  state.program = body.number<std::int32_t>();
  if (!body.ended()) return false;
  state_ = state;
  return true;
}

bool UrConnection::receive(bool& fresh) noexcept {
  // What the script's port tells is of no use here, but it must be taken away.
  std::array<std::uint8_t, 4096> rubbish;
  while (script_.open() && script_.receive(rubbish) > 0) continue;
  for (;;) {
    const std::span<std::uint8_t> room = splitter_.room();
    const int count = rtde_.receive(room);
    if (count < 0) return false;
    if (count == 0) return true;
    splitter_.arrived(static_cast<std::size_t>(count));
    rtde::Package package;
    while (splitter_.next(package)) fresh = take(package) || fresh;
    if (splitter_.broken()) return false;
  }
}

bool UrConnection::send(std::int32_t sequence, Mode mode, const Joints& value) noexcept {
  writer_.begin(Kind::data).number(input_recipe_).number(static_cast<std::uint32_t>(sequence));
  writer_.number(static_cast<std::uint32_t>(mode));
  for (const double one : value) writer_.real(one);
  return rtde_.send(writer_.bytes(), send_s);
}

}  // namespace robotskin::ur
