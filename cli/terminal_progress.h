// Progress on a terminal, and Ctrl-C as a polite request to stop.
#pragma once

#include <recede/geometry/progress.h>

#include <chrono>
#include <string>

namespace recede::cli {

/// After this, Ctrl-C makes `TerminalProgress` ask for cancellation; a second Ctrl-C ends the process at
/// once.
void catch_interrupts();

/// Draws a bar on standard error when that is a terminal; draws nothing otherwise or when `quiet`.
class TerminalProgress final : public Progress {
 public:
  explicit TerminalProgress(bool quiet);
  ~TerminalProgress() override;
  void update(std::string_view stage, double fraction) override;
  bool cancel_requested() const override;
  /// Takes the bar off the screen.
  void clear();

 private:
  bool draws_;
  bool drawn_ = false;
  std::string stage_;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace recede::cli
