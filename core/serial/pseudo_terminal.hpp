// SPDX-License-Identifier: Apache-2.0
// A serial line without hardware: another program opens its other end by a name in the file system.
#pragma once

#include <string>

#include "serial/line.hpp"

namespace robotskin::serial {

class PseudoTerminal : public Line {
 public:
  // Makes one and lets `name` lead to its other end. Throws SerialError, also if there is something at `name` already
  // that is no link.
  explicit PseudoTerminal(std::string name);
  ~PseudoTerminal() override;
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  const std::string& name() const { return name_; }
  int descriptor() const override { return own_; }
  std::size_t read(std::span<std::uint8_t> bytes) override;
  bool write(std::span<const std::uint8_t> bytes) override;
  void tend(std::int64_t) override {}
  std::uint64_t pulled() const override { return 0; }

 private:
  std::string name_;
  int own_ = -1, other_ = -1;  // the other end is held open, so that it may come and go
};

}  // namespace robotskin::serial
