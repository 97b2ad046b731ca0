// SPDX-License-Identifier: Apache-2.0
// What Python calls a driver: the driver and, where it has one, its socket.
#pragma once

#include <memory>
#include <optional>

#include "driver/driver.hpp"
#include "driver/receiver.hpp"

namespace robotskin::bindings {

struct HostDriver {
  HostDriver(const driver::Options& options, const std::optional<driver::Address>& local,
             driver::ReceiverOptions receiver_options);

  // Throws std::logic_error if there is none.
  driver::Receiver& socket();
  // Throws std::logic_error if the receiving thread runs: then it alone may do `what`.
  void demand_no_thread(const char* what) const;

  driver::Driver driver;
  std::unique_ptr<driver::Receiver> receiver;
};

}  // namespace robotskin::bindings
