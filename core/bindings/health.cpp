// SPDX-License-Identifier: Apache-2.0
// Binds the evidence of the cells' health: windows of statistics, and what accelerometers should feel.
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>

#include "bindings/arrays.hpp"
#include "bindings/bindings.hpp"
#include "health/cell_windows.hpp"
#include "skin/skin_reader.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {
namespace {

using health::CellWindow;
using health::CellWindows;
using health::LinkMotion;
using Forces = nb::ndarray<const float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

template <class Values>
nb::object table(std::span<const CellWindow> rows, Values CellWindow::* member) {
  constexpr std::size_t width = std::tuple_size_v<Values>;
  std::vector<typename Values::value_type> all;
  all.reserve(rows.size() * width);
  for (const CellWindow& row : rows) all.insert(all.end(), (row.*member).begin(), (row.*member).end());
  return nb::cast(copy_of(std::span<const typename Values::value_type>(all), {rows.size(), width}));
}

nb::object column(std::span<const CellWindow> rows, std::uint32_t CellWindow::* member) {
  std::vector<std::uint32_t> all;
  for (const CellWindow& row : rows) all.push_back(row.*member);
  return nb::cast(copy_of(std::span<const std::uint32_t>(all)));
}

nb::dict taken(CellWindows& self) {
  nb::dict out;
  out["begun_ns"] = self.begun_ns();
  out["ended_ns"] = self.newest_ns();
  out["ticks"] = self.ticks();
  const std::span<const CellWindow> rows = self.take();
  out["samples"] = column(rows, &CellWindow::samples);
  out["silent"] = column(rows, &CellWindow::silent);
  out["stuck"] = column(rows, &CellWindow::stuck);
  out["mean"] = table(rows, &CellWindow::mean);
  out["least"] = table(rows, &CellWindow::least);
  out["most"] = table(rows, &CellWindow::most);
  out["noise"] = table(rows, &CellWindow::noise);
  out["at_end"] = table(rows, &CellWindow::at_end);
  out["expected"] = table(rows, &CellWindow::expected);
  out["unchanged"] = table(rows, &CellWindow::unchanged);
  out["unchanged_s"] = table(rows, &CellWindow::unchanged_s);
  return out;
}

}  // namespace

void bind_health(nb::module_ module) {
  nb::class_<LinkMotion>(module, "LinkMotion", "What an accelerometer anywhere on a link should feel.")
      .def(nb::init<const RobotModel&, const std::vector<std::string>&>(), "robot"_a, "links"_a)
      .def(
          "update",
          [](LinkMotion& self, std::int64_t now_ns, const InputArray<double>& position,
             const InputArray<double>& velocity) { return self.update(now_ns, span_of(position), span_of(velocity)); },
          "now_ns"_a, "position"_a, "velocity"_a,
          "Of the joints: (n) rad or m, (n) rad/s or m/s. Whether it is known.");
  nb::class_<CellWindows>(module, "CellWindows",
                          R"(What the nine channels of every cell did during a window of time.

`add` every tick, `take` at a window's end. Channels in the order of `firmware.CHANNELS`, SI units; forces as they were
measured, before a zero is taken.)")
      .def(nb::init<const skin::SkinModel&>(), "skin"_a)
      .def("__len__", &CellWindows::size)
      .def_prop_ro("begun_ns", &CellWindows::begun_ns, "Host clock at the first tick of the window.")
      .def_prop_ro("ticks", &CellWindows::ticks, "In the window so far.")
      .def(
          "add",
          [](CellWindows& self, const skin::SkinState& state, std::int64_t now_ns, const LinkMotion* motion,
             const std::optional<Forces>& measured_force) {
            std::span<const std::array<float, 3>> forces;
            if (measured_force)
              forces = {reinterpret_cast<const std::array<float, 3>*>(measured_force->data()),
                        measured_force->shape(0)};
            self.add(state, forces, motion, now_ns);
          },
          "state"_a, "now_ns"_a, "motion"_a.none() = nb::none(), "measured_force"_a.none() = nb::none(),
          "After a read at `now_ns`. `measured_force` (N, 3) newton before any zero is taken; else those of the state.")
      .def("take", &taken, nb::sig("def take(self) -> dict[str, typing.Any]"),
           R"(Ends the window. By name: begun_ns, ended_ns, ticks; (N) samples that were new, ticks at which a cell was
silent or called stuck; (N, 9) mean, least, most, noise (standard deviation), at_end (share of samples), unchanged
(samples since the last change, over all windows) and unchanged_s (seconds of them); (N, 3) expected, m/s^2.)");
}

}  // namespace robotskin::bindings
