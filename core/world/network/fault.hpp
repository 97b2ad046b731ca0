// What can go wrong in a network, when and where: a fault as a value, and as text that can be read again.
//
// One fault is `kind:key=value,key=value@time`, several are joined by `;`: `cut:cell=12,port=3@120ms;
// reboot:cell=7,off=2ms@150ms`. `random:4@100ms` stands for four faults drawn from the run's seed, from that time on.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "world/network/wiring.hpp"

namespace robotskin::world {

// X(name, keys with the values they have if left out or `!` if they must be given, what happens)
// clang-format off
#define ROBOTSKIN_FAULTS(X)                                                                                        \
  X(cut, "cell unit port! for=0", "the wire at a port of a cell or section unit carries nothing")                   \
  X(mend, "cell unit port!", "and everything again")                                                                \
  X(oneway, "cell unit port! way=out for=0", "the wire carries nothing out of that port, or nothing in")            \
  X(flap, "cell unit port! times=5 period=2ms", "the wire is cut and mended, times over, half a period each")       \
  X(noise, "cell unit port rate=0.001 for=20ms", "bits flip before the checksum, on one wire or on all")            \
  X(burst, "cell unit port share=1 for=2ms", "frames vanish, on one wire or on all")                                \
  X(slow, "cell! by=200us for=20ms", "each frame and each wake-up of the cell comes so much later")                 \
  X(zombie, "cell! for=0", "the cell hears nothing and repeats its last advert every millisecond")                  \
  X(crash, "cell!", "the cell falls silent for good")                                                               \
  X(reboot, "cell! off=2ms", "the cell loses power so long, and starts anew")                                       \
  X(ram, "cell! bytes=16 part=route", "so many bytes of the cell's state are overwritten")                          \
  X(stuff, "cell! port=1 frames=100", "so many samples of nobody arrive at once")                                   \
  X(twin, "cell! to! off=1ms", "the cell finds the id of cell `to` in its flash and starts anew")                   \
  X(plug, "cell! port! to! to_port=1 for=0", "the plug at the port is moved to another cell's port; to=-1: to none") \
  X(forge, "cell! port! what=tick times=10 period=1ms", "frames under a wrong tag come in at the port: what=tick, grant, command or joints") \
  X(replay, "cell! port! ago=50ms times=10 period=1ms", "tagged frames that came in at the port so long ago come in again") \
  X(late, "cell! size=1", "the cell and its nearest, `size` in all, are clipped on only at that time")              \
  X(drift, "cell unit ppm! for=0", "a clock goes so much faster or slower")                                         \
  X(skew, "unit! by!", "a section unit's clock jumps")                                                              \
  X(stop, "unit! for=0", "a section unit's processor stops, and starts anew; its ports keep their power")           \
  X(power, "unit! port! for=0", "a port feeds no power")                                                            \
  X(delay, "unit! to by! for=0", "datagrams from the unit to another, or to all, take so much longer")              \
  X(loss, "unit! to share! for=0", "such datagrams get lost")                                                       \
  X(partition, "unit! for=0", "no datagram between this unit and the others arrives")                               \
  X(wrap, "", "the 16-bit tick number wraps at that time: the clocks are set so at the start")
// clang-format on

#define ROBOTSKIN_FAULT_KIND(name, keys, text) name,
enum class FaultKind : std::uint8_t { ROBOTSKIN_FAULTS(ROBOTSKIN_FAULT_KIND) };
#undef ROBOTSKIN_FAULT_KIND

enum class FaultWay : std::uint8_t { out, in };
// `all` is the first three; those behind it are not drawn.
enum class FaultPart : std::uint8_t { route, queues, sampling, all, retention, torque, commands, settings, whole };
enum class FaultFrame : std::uint8_t { tick, grant, command, joints };  // that carry a tag

// Of the targets and parameters, a kind uses those its keys name; the others keep these values.
struct Fault {
  FaultKind kind = FaultKind::cut;
  std::int64_t time_ns = 0;
  std::int32_t cell = -1, unit = -1;  // indices
  std::int32_t port = 0;              // 1 to 4 of a cell, 1 to 15 of a section unit; 0: all
  std::int32_t to = -1;               // cell or unit
  std::int32_t to_port = 0;
  std::int64_t lasts_ns = 0;  // `for`, `off`, `ago`; 0: for good
  std::int64_t by_ns = 0;     // `by`, `period`
  std::int32_t count = 0;     // `times`, `size`, `bytes`, `frames`
  double amount = 0;          // `rate`, `share`, `ppm`
  FaultWay way = FaultWay::out;
  FaultPart part = FaultPart::route;
  FaultFrame what = FaultFrame::tick;

  bool operator==(const Fault&) const = default;
};

// The message names the fault as it was given, the value, and the valid choices.
class FaultError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

// Frames that nobody on the wire has sent come in, `times` over; only tags tell them from true ones.
constexpr bool is_attack(FaultKind kind) {
  return kind == FaultKind::forge || kind == FaultKind::replay;
}

std::string_view name_of(FaultKind kind);
std::span<const std::string_view> fault_names();
std::string fault_help();  // a line a kind

// Reads one fault, and all of a specification in order of time; `random:N` draws by `seed`. Throws FaultError, also for
// targets that `wiring` does not have.
Fault parse_fault(std::string_view text);
std::vector<Fault> parse_faults(std::string_view text, const Wiring& wiring, std::uint64_t seed);

// As text that parse_fault reads as the same fault.
std::string to_string(const Fault& fault);
std::string to_string(std::span<const Fault> faults);

// Throws FaultError if the wiring has no such target.
void check_fault(const Fault& fault, const Wiring& wiring);

// `count` faults of any kind, with targets of `wiring`, from `from_ns` on: half of them within 10 ms of the one before,
// the others within 100 ms.
std::vector<Fault> draw_faults(const Wiring& wiring, std::int32_t count, std::int64_t from_ns, std::uint64_t seed);

}  // namespace robotskin::world
