// Processor and wall seconds of a piece of work.
#pragma once

#include <chrono>
#include <ctime>

namespace recede::bench {

/// From its construction on.
class WorkTimer {
 public:
  /// Seconds of the processor, all threads of this process together.
  double cpu() const { return now() - cpu_; }
  double wall() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_).count();
  }

 private:
  static double now() {
    timespec time{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }
  double cpu_ = now();
  std::chrono::steady_clock::time_point wall_ = std::chrono::steady_clock::now();
};

}  // namespace recede::bench
