// SPDX-License-Identifier: Apache-2.0
// A part of the loop that is written in Python: what it raises, or answers amiss, is kept until the tick is over.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/trampoline.h>

#include <string>
#include <utility>

namespace robotskin::bindings {

class PythonPart {
 public:
  virtual ~PythonPart() = default;
  // What went wrong since the last call, empty if nothing.
  std::string take_error() { return std::exchange(error_, {}); }

 protected:
  // Runs `call`, which may raise, under the interpreter's lock; `otherwise` if it did.
  template <typename Answer, typename Trampoline, typename Call>
  Answer guarded(const Trampoline& trampoline, const char* method, Answer otherwise, const Call& call) noexcept {
    const nanobind::gil_scoped_acquire lock;
    try {
      return call();
    } catch (nanobind::python_error& error) {
      keep(trampoline, method,
           nanobind::cast<std::string>(nanobind::str(error.type().attr("__name__"))) + ": " +
               nanobind::cast<std::string>(nanobind::str(error.value())));
    } catch (const std::exception& error) {
      keep(trampoline, method, error.what());
    }
    return otherwise;
  }

  // The answer as a value of an enumeration, else an error that says what it is.
  template <typename Status>
  static Status status_of(const nanobind::object& answer, const char* choices) {
    Status status;
    if (!nanobind::try_cast(answer, status))
      throw std::invalid_argument("it answered " + nanobind::cast<std::string>(nanobind::repr(answer)) +
                                  ", it must answer " + choices);
    return status;
  }

 private:
  template <typename Trampoline>
  void keep(const Trampoline& trampoline, const char* method, const std::string& what) noexcept {
    try {
      if (!error_.empty()) return;  // the first tells the most
      error_ = nanobind::cast<std::string>(trampoline.base().type().attr("__name__")) + "." + method + ": " + what;
    } catch (...) {
      error_ = method;
    }
  }

  std::string error_;
};

}  // namespace robotskin::bindings
