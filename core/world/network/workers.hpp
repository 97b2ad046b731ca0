// SPDX-License-Identifier: Apache-2.0
// Threads that do the same pieces of work again and again, side by side.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace robotskin::world {

class Workers {
 public:
  // `threads` with that of the caller; `work` is given the number of a piece, below `pieces`.
  Workers(std::size_t threads, std::size_t pieces, std::function<void(std::size_t)> work);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  // Each piece once; returns when all are done. Throws again what the first piece that failed has thrown.
  void run();

 private:
  void wait_for_rounds();
  void take();

  const std::size_t pieces_;
  const std::function<void(std::size_t)> work_;
  // A thread that comes late finds no piece left, or one of the next round: it may take either.
  std::atomic<std::size_t> next_, left_ = 0;
  std::atomic<std::uint32_t> round_ = 0;
  std::atomic<bool> over_ = false;
  std::mutex failed_lock_;
  std::exception_ptr failed_;
  std::vector<std::thread> threads_;
};

}  // namespace robotskin::world
