// SPDX-License-Identifier: Apache-2.0
#include "world/network/workers.hpp"

#include <utility>

namespace robotskin::world {

Workers::Workers(std::size_t threads, std::size_t pieces, std::function<void(std::size_t)> work)
    : pieces_(pieces), work_(std::move(work)), next_(pieces) {
  for (std::size_t i = 1; i < threads; ++i) threads_.emplace_back([this] { wait_for_rounds(); });
}

Workers::~Workers() {
  over_.store(true);
  round_.fetch_add(1);
  round_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Workers::wait_for_rounds() {
  std::uint32_t seen = 0;
  for (;;) {
    round_.wait(seen);
    seen = round_.load();
    if (over_.load()) return;
    take();
  }
}

void Workers::take() {
  for (std::size_t piece; (piece = next_.fetch_add(1)) < pieces_;) {
    try {
      work_(piece);
    } catch (...) {
      const std::scoped_lock lock(failed_lock_);
      if (!failed_) failed_ = std::current_exception();
    }
    if (left_.fetch_sub(1) == 1) left_.notify_all();
  }
}

void Workers::run() {
  left_.store(pieces_);
  next_.store(0);
  round_.fetch_add(1);
  round_.notify_all();
  take();
  for (std::size_t left; (left = left_.load()) != 0;) left_.wait(left);
  if (failed_) std::rethrow_exception(std::exchange(failed_, nullptr));
}

}  // namespace robotskin::world
