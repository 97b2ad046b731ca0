// SPDX-License-Identifier: Apache-2.0
// Binds a mailbox in memory that two processes share: a robot's controller that speaks Python alone stands behind one.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <stdexcept>

#include "bindings/arrays.hpp"
#include "bindings/bindings.hpp"
#include "model/mailbox.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {
namespace {

constexpr std::size_t room = 64;
using Message = std::array<double, room>;
using Box = Mailbox<Message>;
using Memory = nb::ndarray<std::uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

// What lies in the memory is shared; how many numbers a message has is agreed.
class SharedMailbox {
 public:
  SharedMailbox(Memory memory, std::size_t count, bool fresh) : memory_(std::move(memory)), count_(count) {
    if (count > room) throw std::invalid_argument("a message has at most 64 numbers");
    if (memory_.shape(0) < sizeof(Box) || reinterpret_cast<std::uintptr_t>(memory_.data()) % alignof(Box) != 0)
      throw std::invalid_argument("the memory is too small, or lies askew");
    box_ = reinterpret_cast<Box*>(memory_.data());
    if (fresh) std::construct_at(box_);
  }

  void put(const InputArray<double>& values) {
    if (values.shape(0) != count_) throw std::invalid_argument("a message of another count of numbers");
    Message message{};
    std::ranges::copy(span_of(values), message.begin());
    box_->put(message);
  }

  std::optional<nb::ndarray<nb::numpy, double>> take() {
    const Message* message = box_->take();
    if (message == nullptr) return std::nullopt;
    return copy_of(std::span<const double>(message->data(), count_));
  }

 private:
  Memory memory_;
  std::size_t count_;
  Box* box_ = nullptr;
};

}  // namespace

void bind_shared_mailbox(nb::module_& module) {
  module.attr("MAILBOX_BYTES") = sizeof(Box);
  nb::class_<SharedMailbox>(
      module, "SharedMailbox",
      R"(The newest numbers from one process to another: one writes, one reads, neither ever waits.

Both make one over the same shared memory; the first of them with `fresh`.)")
      .def(nb::init<Memory, std::size_t, bool>(), "memory"_a, "count"_a, "fresh"_a = false,
           "memory: (MAILBOX_BYTES or more,) uint8, shared and writable. count: of the numbers in a message, at most "
           "64. Raises "
           "ValueError where it does not fit.")
      .def("put", &SharedMailbox::put, "values"_a, "(count,); what was not taken yet is replaced.")
      .def("take", &SharedMailbox::take, "The newest (count,) numbers, or None if there are none since the last call.");
}

}  // namespace robotskin::bindings
