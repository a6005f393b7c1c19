// A program that runs beside this one.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace recede::cli {

struct ChildResult {
  int code = 0;                 ///< exit code; 128 + signal when a signal ended the process
  std::string output, remarks;  ///< standard output and standard error
  double seconds = 0;           ///< on the clock
  std::size_t peak_bytes = 0;   ///< resident memory at its highest
};

/// Its streams go into files without names, so that no amount of output makes it wait. It ends with this
/// process, however this one ends.
class ChildProcess {
 public:
  /// The program and its arguments. Throws `InputError` when it can't be started.
  explicit ChildProcess(const std::vector<std::string>& words);
  /// Ends the process if it still runs.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Empty while it runs; afterwards, once, what came of it.
  std::optional<ChildResult> poll();
  double seconds() const;  ///< since its start
  void send(int signal) const;

 private:
  using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
  File output_, remarks_;
  std::chrono::steady_clock::time_point start_;
  pid_t process_ = -1;  ///< -1: has ended
};

/// The file of the program that runs here.
std::string own_program();

}  // namespace recede::cli
